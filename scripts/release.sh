#!/usr/bin/env bash
# Makes a release of the last commit in build/release and tries it: the source archive, the Debian packages that are built
# from the extracted archive, and their checksums.
#
# Usage: scripts/release.sh [--build BUILD] [--bare FOLDER]
#   --build BUILD   take the packages from this build folder of the same commit instead of building the archive
#   --bare FOLDER   also try both on a Debian 12 with nothing but git, made in FOLDER (as root; scripts/bare_machine.sh)
#
# Builds without tests (15 minutes on two cores); run ./test.sh before. Exit code 1 if anything failed.
set -euo pipefail
cd "$(dirname "$0")/.."
bare='' build=''
while [ $# -gt 0 ]; do
  case "$1" in
    --bare) bare=${2:?"release.sh: --bare needs a folder"}; shift ;;
    --build) build=$(realpath "${2:?"release.sh: --build needs a folder"}"); shift ;;
    *) sed -n '2,/^set /{/^#/p}' "$0" >&2; exit 2 ;;
  esac
  shift
done
fail() { echo "release.sh: $*" >&2; exit 1; }
version=$(sed -nE 's/^project\(seam VERSION ([0-9.]+).*/\1/p' CMakeLists.txt)
[ -z "$(git status --porcelain --untracked-files=no)" ] || fail "changes that are not committed; a release is a commit"
grep -q "^## ${version//./\\.}\$" CHANGELOG.md || fail "CHANGELOG.md has no heading '## $version'"

release=$(realpath -m build/release)
source=$release/seam-$version
mkdir -p "$release"
rm -rf "$release"/*.deb "$release"/*.tar.gz "$release/SHA256SUMS" "$source" "$release/tree" "$release/try.mcap"
echo "== source archive"
git archive --format=tar.gz --prefix="seam-$version/" -o "$release/seam-$version.tar.gz" HEAD
tar -xzf "$release/seam-$version.tar.gz" -C "$release"

if [ -z "$build" ]; then
  build=$release/build
  echo "== build of the extracted archive (log: $release/build.log)"
  { cmake -S "$source" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DSEAM_BUILD_TESTS=OFF -DSEAM_BUILD_BENCHMARKS=OFF &&
    cmake --build "$build"; } >"$release/build.log" 2>&1 || { tail -n 20 "$release/build.log" >&2; fail "the archive does not build"; }
fi

echo "== Debian packages"
cpack -G DEB --config "$build/CPackConfig.cmake" -B "$release" >"$release/cpack.log" 2>&1 ||
  { tail -n 20 "$release/cpack.log" >&2; fail "cpack failed"; }
rm -rf "$release/_CPack_Packages"
for package in "$release"/*.deb; do dpkg-deb -x "$package" "$release/tree"; done
found=$("$release/tree/usr/bin/seam" --version)
[[ $found == "seam $version"* ]] || fail "the package's program says '$found', expected 'seam $version'"
"$release/tree/usr/bin/seam" run "$release/tree/usr/share/seam/scenarios/head_swing.yaml" --set duration_s=0.2 --log "$release/try.mcap" >/dev/null
"$release/tree/usr/bin/seam" replay verify "$release/try.mcap"
rm -rf "$release/tree" "$release/try.mcap" "$source"
(cd "$release" && sha256sum ./*.tar.gz ./*.deb >SHA256SUMS)
[ -z "$bare" ] || scripts/bare_machine.sh --release "$release" "$bare"
echo "== release $version"
(cd "$release" && ls -l ./*.tar.gz ./*.deb SHA256SUMS)
