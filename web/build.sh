#!/usr/bin/env bash
# build.sh OUT STAMP: builds the pages into OUT and touches STAMP. Where npm or its registry is out of
# reach this says so and succeeds: the commands then write plain tables, and `seam view` says what is
# missing. The next build tries again.
set -uo pipefail
cd "$(dirname "$0")"
out=$1
stamp=$2
without() {
  echo "web: $1; built without the report page, the viewer and the workbench" >&2
  exit 0
}
command -v npm >/dev/null || without "npm is not installed"
log=$out/web-build.log
mkdir -p "$out"
# The installed packages belong to one lock file; a changed one installs them again. `npm ci` of npm
# 11 refuses a lock without rollup's builds for other systems, which not every registry holds;
# `npm install --no-save` installs the same locked versions.
if ! cmp -s package-lock.json node_modules/.installed-lock; then
  options=(--ignore-scripts --no-audit --no-fund --fetch-retries=1 --fetch-timeout=60000)
  npm ci "${options[@]}" >"$log" 2>&1 || npm install --no-save "${options[@]}" >>"$log" 2>&1 ||
    without "npm could not install the packages, see $log"
  cp package-lock.json node_modules/.installed-lock
fi
rm -f "$stamp"
for page in report viewer workbench; do
  SEAM_WEB_OUT=$out npx --no-install vite build --mode "$page" --logLevel warn >"$log" 2>&1 ||
    { cat "$log" >&2; exit 1; }
done
for page in viewer workbench; do mv "$out/$page/$page.html" "$out/$page/index.html"; done
touch "$stamp"
