#!/usr/bin/env bash
# Installs what is missing, builds, and runs the tests. `--all` adds the slow matrix.
set -euo pipefail
cd "$(dirname "$0")"
scripts/dependencies.sh
[ -f build/build.ninja ] || cmake --preset release >/dev/null
cmake --build build
ctest --test-dir build --output-on-failure -j "$(nproc)"
