#!/usr/bin/env bash
# The slow matrix of `./test.sh --all`. Each part prints one line; a part that fails does not stop
# the others, and the exit code says so. The last result stands in docs/evidence/matrix.md.
#
# --quick: each part with little of its time, to see that it runs at all; that is no result and writes no page.
set -uo pipefail
cd "$(dirname "$0")/.."
failed=0
results=()
fault_runs=500 fault_mixes=100 kills=50 sweep_kills=20 fuzz_s=600 bits=()
quick=
if [ "${1:-}" = --quick ]; then
  quick=yes fault_runs=5 fault_mixes=0 kills=2 sweep_kills=2 fuzz_s=5 bits=(--quick)
fi
# What only the matrix needs.
for package in clang clang-tidy libclang-rt-14-dev qemu-user python3-opencv mrcal snakemake slurm-wlm munge; do
  [ "$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || missing+=("$package")
done
[ -z "${missing[*]:-}" ] || apt-get install -y -q --no-install-recommends "${missing[@]}"

part() {  # part NAME COMMAND...: runs it, notes the result.
  local name=$1; shift
  echo "== $name"
  "$@"
  case $? in
    0) results+=("| $name | passed |") ;;
    77) results+=("| $name | skipped: what it needs is not installed |") ;;
    *) results+=("| $name | FAILED |"); failed=1 ;;
  esac
}

# Tests that pin bits: golden fingerprints of maths, world, frames and runs.
golden='Golden|golden|Maths|end_to_end'

build_and_test() {  # build_and_test PRESET FILTER
  local folder
  folder=$(python3 -c "import json,sys; print([p['binaryDir'] for p in json.load(open('CMakePresets.json'))['configurePresets'] if p['name']==sys.argv[1]][0].replace('\${sourceDir}/',''))" "$1")
  cmake --preset "$1" >/dev/null && cmake --build "$folder" && ctest --test-dir "$folder" -R "$2" --output-on-failure -j "$(nproc)"
}

without_opengl() {  # What the option leaves out is not missed by the rest, and is asked for by name.
  cmake --preset release -B build-no-opengl -DSEAM_OPENGL=OFF >/dev/null && cmake --build build-no-opengl --target program test_render &&
    ctest --test-dir build-no-opengl -R '^opengl$|GoldenFrames' --output-on-failure -j "$(nproc)"
}

part "clang-tidy" scripts/tidy.sh
part "a build without OpenGL" without_opengl
part "gcc -O0: golden fingerprints" build_and_test dev "$golden"
part "clang -O2: golden fingerprints" build_and_test clang "$golden"
part "AddressSanitizer and UBSan: all tests" build_and_test asan-ubsan .
part "ThreadSanitizer: scheduler and renderer" build_and_test tsan 'Simulation|Server|Render|Hub|Pool'
part "other CPUs and vector widths: same frames" scripts/bits_matrix.sh "${bits[@]}"
part "a bundle rerun on other CPUs" env SEAM_EMULATED_CPUS="Nehalem Haswell EPYC-Rome" python3 tests/bundle_test.py
part "$fault_runs fault runs" env SEAM_FAULT_RUNS=$fault_runs build/tests/test_scheduler --gtest_filter='Faults*'
part "$fault_mixes mixes of all faults, ten simulated minutes each" env SEAM_FAULT_MIXES=$fault_mixes python3 tests/fault_mix_test.py build "$PWD" /usr/bin/python3
part "real recordings, and searches that take minutes" ctest --test-dir build -C all -R '^(real_|made_servos|made_legs|detector_proof|docs.real_lens|outcomes.settings)' --output-on-failure
part "exported models, read by OpenCV and mrcal; the same corners given to them" ctest --test-dir build -R '^(export|camera_peers)$' --output-on-failure
part "the recorded match with its frames" build/seam replay verify replays/match.mcap
part "$kills kills, resumed" env SEAM_KILLS=$kills python3 tests/replay_test.py build/seam tests/mcap_node
part "a sweep killed $sweep_kills times, and by Snakemake" env SEAM_KILLS=$sweep_kills python3 tests/sweep_test.py build .
part "a sweep through Slurm" python3 tests/slurm_test.py build .
part "fuzzing, $fuzz_s s each" scripts/fuzz.sh "$fuzz_s"

if [ -n "$quick" ]; then
  printf '%s\n' "${results[@]}"
  exit "$failed"
fi
{
  echo "# Result of the slow matrix"
  echo
  echo "\`./test.sh --all\` on $(date -u +%F), commit $(git rev-parse --short HEAD)."
  echo
  echo "| Part | Result |"
  echo "|---|---|"
  printf '%s\n' "${results[@]}"
} > docs/evidence/matrix.md
cat docs/evidence/matrix.md
exit "$failed"
