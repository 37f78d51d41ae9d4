#!/usr/bin/env bash
# Installs what is missing, builds, and runs the tests. `--all` adds the slow matrix: compilers,
# optimisation levels, sanitizers, emulated CPUs, long fuzzing, studies (scripts/matrix.sh).
set -euo pipefail
cd "$(dirname "$0")"
scripts/dependencies.sh
scripts/node_packages.sh
scripts/check.sh --look
scripts/build.sh
ctest --test-dir build --output-on-failure -j "$(nproc)"
if [ "${1:-}" = --all ]; then scripts/matrix.sh; fi
