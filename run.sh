#!/usr/bin/env bash
# Installs what is missing, builds, and runs SEAM's first example: a head swings past a beacon at
# several speeds, seen with rows sampled at their own times and with an instantaneous shutter.
# With arguments: ./run.sh SCENARIO... runs those instead.
set -euo pipefail
cd "$(dirname "$0")"
scripts/dependencies.sh
scripts/build.sh program
out=out
mkdir -p "$out"
if [ $# -gt 0 ]; then
  for scenario in "$@"; do
    name=$(basename "$scenario" .yaml)
    build/seam run "$scenario" --log "$out/$name.mcap" --frames "$out/$name" --json "$out/$name.json" --force
  done
  exit 0
fi
build/seam run scenarios/head_swing.yaml --log "$out/head_swing.mcap" --frames "$out/head_swing" --json "$out/head_swing.json" --force
build/seam replay verify "$out/head_swing.mcap"
build/seam run scenarios/head_swing_speeds.yaml --log "$out/head_swing_speeds.mcap" --frames "$out/head_swing_speeds" --force
build/seam contact-sheet "$out/head_swing_speeds" --by-robot --count 4 --out "$out/head_swing_speeds.png"
echo
echo "picture: $out/head_swing_speeds.png   above, with all rows at one instant, a beacon stands upright; below, row by row, it slants as the head turns faster"
echo "frames:  $out/head_swing/   $out/head_swing_speeds/"
echo "log:     $out/head_swing.mcap   (look at it: build/seam view $out/head_swing.mcap)"
echo "your own measurements, or samples, in a browser: build/seam workbench"
