#!/usr/bin/env bash
# Installs the packages of the independent MCAP reader (tests/mcap_node), once. Without npm or its
# registry the tests that need them are skipped.
set -uo pipefail
cd "$(dirname "$0")/../tests/mcap_node"
cmp -s package-lock.json node_modules/.installed-lock && exit 0
if npm ci --ignore-scripts --no-audit --no-fund --fetch-retries=1 >/dev/null 2>&1; then
  cp package-lock.json node_modules/.installed-lock
else
  echo "tests/mcap_node: npm ci failed; tests with the independent MCAP reader are skipped" >&2
fi
