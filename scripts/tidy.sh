#!/usr/bin/env bash
# clang-tidy by .clang-tidy over all sources, or over those named; part of `./test.sh --all`.
set -euo pipefail
cd "$(dirname "$0")/.."
cmake --preset dev >/dev/null
# What the sources include of generated code.
cmake --build build-dev --target seam_proto seam_grpc >/dev/null
files=("$@")
[ ${#files[@]} -gt 0 ] || mapfile -t files < <(git ls-files '*.cc' | grep -Ev '_kernels_(avx2|avx512)\.cc$')
printf '%s\n' "${files[@]}" | xargs -P "$(nproc)" -n 4 clang-tidy -p build-dev --quiet --warnings-as-errors='*'
