#!/usr/bin/env bash
# Frames have the same bits with 1 and 2 threads, 128-, 256- and 512-bit vectors, on other CPU models
# (qemu-user), with gcc and clang, at -O0 to -O3; those that OpenGL draws, which belong to a version of Mesa, are
# compared with this machine's own. Slow: part of `./test.sh --all`.
# Usage: scripts/bits_matrix.sh [--quick]   (--quick: without other compilers)
set -euo pipefail
cd "$(dirname "$0")/.."
golden=render/golden/golden_frames.txt
failures=0
check() {  # NAME COMMAND...
  local name=$1
  shift
  if diff -u "$golden" <("$@"); then
    echo "same bits: $name"
  else
    echo "OTHER BITS: $name"
    failures=$((failures + 1))
  fi
}
cmake --preset release >/dev/null
cmake --build build --target golden_frames
program=build/render/golden_frames
for threads in 1 2 3; do check "$threads threads" "$program" "$threads"; done
for bits in 128 256 512; do check "$bits-bit vectors" env SEAM_VECTOR_BITS=$bits "$program"; done
if command -v qemu-x86_64 >/dev/null; then
  for cpu in Nehalem Haswell EPYC-Rome; do check "qemu $cpu" qemu-x86_64 -cpu "$cpu" "$program"; done
  if "$program" opengl >build/opengl_frames.txt; then
    golden=build/opengl_frames.txt
    for cpu in Nehalem SandyBridge Haswell Skylake-Client EPYC; do
      check "OpenGL, qemu $cpu" qemu-x86_64 -cpu "$cpu" "$program" opengl
    done
    golden=render/golden/golden_frames.txt
  else
    echo "skipped: this build draws nothing by OpenGL"
  fi
else
  echo "skipped: qemu-x86_64 is not installed (package qemu-user)"
fi
if [ "${1:-}" != --quick ]; then
  # Warnings are the business of the ordinary builds (gcc -O3 sees one in a header of fmt).
  for compiler in g++ clang++; do
    command -v "$compiler" >/dev/null || { echo "skipped: no $compiler"; continue; }
    for level in 0 1 2 3; do
      folder=build-bits/$compiler-O$level
      cmake -S . -B "$folder" -G Ninja -DCMAKE_BUILD_TYPE=None -DCMAKE_CXX_COMPILER="$compiler" \
        -DCMAKE_CXX_FLAGS="-O$level -w" -DSEAM_BUILD_TESTS=OFF -DSEAM_BUILD_BENCHMARKS=OFF >/dev/null
      cmake --build "$folder" --target golden_frames >/dev/null
      check "$compiler -O$level" "$folder/render/golden_frames"
    done
  done
fi
[ "$failures" = 0 ] || { echo "$failures differences"; exit 1; }
echo "all the same"
