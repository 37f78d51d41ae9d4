#!/usr/bin/env bash
# Configures once, then builds what changed (the release preset, into build/): all of it, or a target that is named.
set -euo pipefail
cd "$(dirname "$0")/.."
if [ ! -f build/build.ninja ]; then
  echo "configuring build/ ..."
  cmake --preset release >/dev/null
fi
cmake --build build ${1:+--target "$1"}
