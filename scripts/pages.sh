#!/usr/bin/env bash
# Renews all pages that the program writes: the commands, the effects, the schemas. Run it after a change of a help
# text, of an effect's record or of a format; tests compare the pages with the program (`ctest -R docs`).
# Usage: scripts/pages.sh [BUILD]     BUILD: a build folder with the program (default: build)
set -euo pipefail
cd "$(dirname "$0")/.."
seam=${1:-build}/seam
[ -x "$seam" ] || { echo "pages.sh: $seam is missing: cmake --build ${1:-build} --target seam" >&2; exit 1; }
changed=0
renew() {  # renew PAGE ARGUMENT...: what the program prints for these arguments.
  local page=docs/reference/$1
  shift
  "$seam" "$@" >"$page.new"
  if cmp -s "$page" "$page.new"; then rm "$page.new"; else mv "$page.new" "$page"; echo "renewed $page"; changed=1; fi
}
renew commands.md help --markdown
renew effects.md effects --markdown
renew joints.md joints models/robot_ers210.yaml scenarios/arm/arm.yaml --markdown
for format in measurement model scenario scene; do renew "schemas/$format.schema.json" schema "$format"; done
[ "$changed" = 1 ] || echo "all pages are as the program writes them"
