#!/usr/bin/env bash
# Formats the C++ code and checks the house rules, in half a minute and without a build: run it before each commit. ./test.sh,
# which CI calls, begins with it.
# Usage: scripts/check.sh [--look] [--tidy]
#   --look   changes no file: what is not formatted is an error
#   --tidy   also clang-tidy, over the sources that differ from origin/main (minutes)
set -uo pipefail
cd "$(dirname "$0")/.."
mend=--mend tidy=
for option in "$@"; do
  case $option in
    --look) mend= ;;
    --tidy) tidy=yes ;;
    *) sed -n '2,/^set /{/^#/p}' "$0" >&2; exit 2 ;;
  esac
done
failed=()
check() {  # check NAME COMMAND...: shows what a check prints only where it fails; 77: what it needs is missing.
  local name=$1 said
  shift
  said=$("$@" 2>&1)
  case $? in
    0) echo "ok       $name" ;;
    77) echo "skipped  $name: $said" ;;
    *) echo "FAILED   $name"; printf '%s\n' "$said"; failed+=("$name") ;;
  esac
}
python_compiles() { git ls-files -z '*.py' | xargs -0 python3 -c 'import ast, sys; [ast.parse(open(f).read(), f) for f in sys.argv[1:]]'; }
shell_parses() { local wrong=0; for script in $(git ls-files '*.sh' .ci/run); do bash -n "$script" || wrong=1; done; return $wrong; }
tidy_changed() {
  local files
  mapfile -t files < <({ git diff --name-only --diff-filter=d "$(git merge-base HEAD origin/main)" -- '*.cc'; git ls-files -o --exclude-standard -- '*.cc'; } |
    grep -Ev '_kernels_(avx2|avx512)\.cc$' | sort -u)
  [ ${#files[@]} -eq 0 ] || scripts/tidy.sh "${files[@]}"
}
check "format" python3 tests/format_test.py $mend
check "rooms, lengths, banned calls" python3 tests/layers_test.py
check "names of effects" python3 tests/effect_names_test.py
check "words" python3 tests/words_test.py
check "packages" python3 tests/packages_test.py
check "names of files in pages" python3 tests/tour_test.py
check "links and sizes of pages" python3 tests/pages_test.py
check "tables of evidence" python3 scripts/evidence.py --check
check "proofs of effects" python3 scripts/effect_proofs.py --check
check "Python parses" python_compiles
check "shell parses" shell_parses
[ -z "$tidy" ] || check "clang-tidy" tidy_changed
[ ${#failed[@]} -eq 0 ] || { printf 'check.sh: failed: %s\n' "${failed[*]}" >&2; exit 1; }
