#!/usr/bin/env bash
# Installs what is missing, builds, and runs the tests: all units, and a journey through each program.
#   --slow  the slow ones, too: every test of the build, as CI runs them
#   --all   these and the slow matrix: compilers, optimisation levels, sanitizers, emulated CPUs, long fuzzing, studies
#           (scripts/matrix.sh)
# One test by its name: ctest --test-dir build -R NAME --output-on-failure
set -euo pipefail
cd "$(dirname "$0")"
which=(-LE slow)
case "${1:-}" in
  '') ;;
  --slow|--all) which=() ;;
  *) sed -n '2,/^set /{/^#/p}' "$0" >&2; exit 2 ;;
esac
scripts/dependencies.sh
scripts/node_packages.sh
scripts/check.sh --look
scripts/build.sh
ctest --test-dir build --output-on-failure -j "$(nproc)" "${which[@]}"
echo "one test by its name: ctest --test-dir build -R NAME --output-on-failure"
if [ "${1:-}" = --all ]; then scripts/matrix.sh; fi
