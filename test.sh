#!/usr/bin/env bash
# Installs what is missing, builds, and runs the tests: units, and a journey through each program.
#   --slow  the slow ones, too: every test of the build, as CI runs them
#   --all   these and the slow matrix: compilers, optimisation levels, sanitizers, emulated CPUs, long fuzzing, studies
#           (scripts/matrix.sh)
set -euo pipefail
cd "$(dirname "$0")"
which=(-LE 'slow|look')  # scripts/check.sh has looked at what has the label `look`.
case "${1:-}" in
  '') ;;
  --slow|--all) which=() ;;
  *) sed -n '2,/^set /{/^#/p}' "$0" >&2; exit 2 ;;
esac
scripts/dependencies.sh
scripts/node_packages.sh
scripts/check.sh --look
scripts/build.sh
[ -z "${1:-}" ] || scripts/build.sh benchmarks
ctest --test-dir build --output-on-failure -j "$(nproc)" "${which[@]}"
cat <<'END'
one test:        ctest --test-dir build -R NAME --output-on-failure
part of it:      build/tests/test_ROOM --gtest_filter='NAME*', or python3 tests/NAME_test.py CLASS.test_NAME
the slow tests:  ctest --test-dir build -L slow --output-on-failure -j "$(nproc)"; ./test.sh --slow runs all
END
if [ "${1:-}" = --all ]; then scripts/matrix.sh; fi
