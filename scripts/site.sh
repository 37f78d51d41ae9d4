#!/usr/bin/env bash
# Builds the site of the pages, with search, and the C++ and Python API, into build/site/html. Needs Debian's mkdocs,
# mkdocs-material and doxygen, which nothing else of SEAM needs.
# Usage: scripts/site.sh [--without-api]     then: python3 -m http.server -d build/site/html
set -euo pipefail
cd "$(dirname "$0")/.."
[ $# -eq 0 ] || [ "$*" = --without-api ] || { sed -n '2,/^set /{/^#/p}' "$0" >&2; exit 2; }
packages=(mkdocs mkdocs-material doxygen)
missing=()
for package in "${packages[@]}"; do
  [ "$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || missing+=("$package")
done
[ ${#missing[@]} -eq 0 ] || { echo "site.sh: missing; run: apt-get install --no-install-recommends ${missing[*]}" >&2; exit 1; }
site=build/site
rm -rf "$site"
mkdir -p "$site"
scripts/site/pages.py "$site/pages"
cp scripts/site/mkdocs.yml "$site/mkdocs.yml"
mkdocs build --quiet --strict --config-file "$site/mkdocs.yml"
if [ "$*" != --without-api ]; then
  version=$(sed -nE 's/^project\(seam VERSION ([0-9.]+).*/\1/p' CMakeLists.txt)
  { cat scripts/site/Doxyfile; echo "PROJECT_NUMBER = $version"; echo "OUTPUT_DIRECTORY = $site/html"; } | doxygen - >"$site/doxygen.log" 2>&1
fi
echo "site: $site/html/index.html"
