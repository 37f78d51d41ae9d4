#!/usr/bin/env bash
# fuzz.sh SECONDS [NAME...]: builds the fuzz targets with libFuzzer, AddressSanitizer and UBSan (clang, a build of its own) and
# runs each for so long from its corpus. A finding ends it with the input's place. New inputs are not kept: a corpus
# grows only by what somebody looked at (fuzz/corpus). `./test.sh` runs the same targets without clang (fuzz/driver.cc).
set -euo pipefail
cd "$(dirname "$0")/.."
seconds=${1:?usage: scripts/fuzz.sh SECONDS [NAME...]}
shift
names=("$@")
[ ${#names[@]} -gt 0 ] || mapfile -t names < <(git ls-files '*.fuzz.cc' | sed 's|.*/||; s|\.fuzz\.cc$||' | sort)
if ! command -v clang++ >/dev/null || ! compgen -G "$(clang++ -print-resource-dir)/lib/linux/libclang_rt.fuzzer-*.a" >/dev/null; then
  echo "fuzz.sh: clang++ with libFuzzer is not installed (apt-get install clang libclang-rt-14-dev)" >&2
  exit 1
fi
[ -f build-fuzz/build.ninja ] || cmake --preset fuzz >/dev/null
cmake --build build-fuzz --target "${names[@]/#/fuzz_}"
for name in "${names[@]}"; do
  echo "fuzz: $name for $seconds s"
  corpus=("fuzz/corpus/$name")
  [ "$name" != log ] || corpus=(replays/corpus)
  work=$(mktemp -d)
  build-fuzz/fuzz/fuzz_"$name" -max_total_time="$seconds" -timeout=25 -rss_limit_mb=2048 -malloc_limit_mb=1024 \
    -max_len=200000 -artifact_prefix=build-fuzz/ -print_final_stats=0 -verbosity=0 "$work" "${corpus[@]}"
  rm -rf "$work"
done
