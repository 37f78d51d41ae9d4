#!/usr/bin/env bash
# Configures once, then builds what changed (the release preset, into build/): all of it, or a target that is named.
set -euo pipefail
cd "$(dirname "$0")/.."
[ -f build/build.ninja ] || cmake --preset release >/dev/null
cmake --build build ${1:+--target "$1"}
