#!/usr/bin/env bash
# Makes a release: the source archive and the Debian packages of the last commit, in build/release, and tries both.
#
# Usage: scripts/release.sh [--try-archive] [BUILD]
#   BUILD           a build folder with the program (default: build)
#   --try-archive   also build the extracted archive, and run its first example (./run.sh; minutes)
#
# The packages are extracted to a new folder and their program is run there. On a machine of its own both are tried by
# scripts/bare_machine.sh. Exit code 1 if anything failed.
set -euo pipefail
cd "$(dirname "$0")/.."
try_archive='' build=build
for argument in "$@"; do
  case "$argument" in
    --try-archive) try_archive=yes ;;
    -*) sed -n '2,/^set /{/^#/p}' "$0" >&2; exit 2 ;;
    *) build=$argument ;;
  esac
done
fail() { echo "release.sh: $*" >&2; exit 1; }
version=$(sed -nE 's/^project\(seam VERSION ([0-9.]+).*/\1/p' CMakeLists.txt)
[ -x "$build/seam" ] || fail "$build/seam is missing: cmake --build $build"
[ -z "$(git status --porcelain --untracked-files=no)" ] || fail "changes that are not committed; a release is a commit"
grep -q "^## $version\b" CHANGELOG.md || fail "CHANGELOG.md has no heading '## $version'"
grep -q "^seam $version " <<<"$("$build/seam" --version) " || fail "$build/seam is of another version; build it again"

release=$(realpath -m build/release)
rm -rf "$release"
mkdir -p "$release"
echo "== source archive"
git archive --format=tar.gz --prefix="seam-$version/" -o "$release/seam-$version.tar.gz" HEAD
echo "== Debian packages"
cmake -DCPACK_PACKAGE_DIRECTORY="$release" "$build" >/dev/null
(cd "$build" && cpack -G DEB -B "$release" >"$release/cpack.log" 2>&1) || { tail -n 20 "$release/cpack.log" >&2; fail "cpack failed"; }
rm -rf "$release/_CPack_Packages"

echo "== the packages, extracted"
packages=("$release"/*.deb)
for package in "${packages[@]}"; do dpkg-deb --extract "$package" "$release/tree"; done
found=$("$release/tree/usr/bin/seam" --version)
[[ $found == "seam $version"* ]] || fail "the package's program says '$found', expected 'seam $version ...'"
"$release/tree/usr/bin/seam" run "$release/tree/usr/share/seam/scenarios/head_swing.yaml" --set duration_s=0.2 \
  --log "$release/try.mcap" >/dev/null
"$release/tree/usr/bin/seam" replay verify "$release/try.mcap"

echo "== the archive, extracted"
tar -xzf "$release/seam-$version.tar.gz" -C "$release"
source=$release/seam-$version
for file in run.sh test.sh LICENSE README.md CHANGELOG.md CITATION.cff docs/index.md; do
  [ -e "$source/$file" ] || fail "the archive lacks $file"
done
if [ -n "$try_archive" ]; then (cd "$source" && ./run.sh) || fail "./run.sh of the archive failed"; fi
rm -rf "$release/tree" "$release/try.mcap" "$source"
(cd "$release" && sha256sum ./*.tar.gz ./*.deb >SHA256SUMS)
echo "release $version: $release"
ls -l "$release"
