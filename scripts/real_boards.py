#!/usr/bin/env python3
"""Boards that others took pictures of, by the way a user goes: `seam import images`, `seam discover`; beside it OpenCV.

  scripts/real_boards.py [--seam build/seam] [--keep FOLDER]

The pictures are those of two packages of Debian 12: opencv-doc (13 of a chessboard, each by two cameras side by side)
and visp-images-data (4 of a grid of dots). Where one is not installed its part is left out with a line that says so.
The chessboard was before both cameras: what each finds of its corners is compared with the other, and both are taken
together as a rig. Needs Debian's python3-opencv. How far apart the corners are the pictures do not say: 25 and 30 mm
are taken, which scale all lengths alike."""
import argparse
import csv
import json
import math
import pathlib
import resource
import subprocess
import sys
import tempfile

import numpy as np

from camera_peers import CAMERA, Corners, compare, figure, print_table

PAIRS = pathlib.Path("/usr/share/doc/opencv-doc/examples/data")
DOTS = pathlib.Path("/usr/share/visp-images-data/ViSP-images/calibration")


def seconds(program, *arguments):
    """What the program said, and its time of the processor."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    run = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True)
    if run.returncode != 0:
        raise RuntimeError(f"seam {arguments[0]}: {run.stderr[-300:]}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return run.stdout, sum(getattr(after, n) - getattr(before, n) for n in ("ru_utime", "ru_stime"))


def discover(program, folder):
    said, took = seconds(program, "discover", "--model", folder / "nominal.yaml", "--data", folder, "--out",
                         folder / "found.yaml", "--json", folder / "found.json")
    found = json.loads((folder / "found.json").read_text(encoding="utf-8"))
    print(f"\n{said.splitlines()[0]}\n\n`seam discover`: {found['verdict']}, error {found['baseline']['error']:.2f} to "
          f"{found['error']:.2f}, {took:.1f} s of the processor")
    for step in found["steps"]:
        values = ", ".join(f"{name} {figure(v['value'], v.get('sigma'))}" for name, v in step["parameters"].items())
        ties = f"; or {', '.join(step['indistinguishable_from'])}" if step.get("indistinguishable_from") else ""
        print(f"- `{step['effect']}`: {values}; error {step['error_before']:.2f} to {step['error_after']:.2f}{ties}")
    camera = {name: figure(*value) for name, value in values_of(folder / "found.yaml", "pinhole").items()}
    if camera:
        print("- the camera: " + ", ".join(f"{name} {camera[name]}" for name in CAMERA))
    return found


def values_of(model, effect):
    """Values and sigmas of an effect in a model's file; empty where it has none."""
    import yaml
    values = yaml.safe_load(model.read_text(encoding="utf-8"))["effects"].get(effect, {})
    return {name: (v["value"], v.get("sigma")) if isinstance(v, dict) else (v, None) for name, v in values.items()}


def one_camera(program, title, pictures, words, folder):
    print(f"\n## {title}\n")
    said, took = seconds(program, "import", "images", *pictures, *words, "--out", folder)
    print(f"{next(line for line in said.splitlines() if 'scatter' in line).strip()}; {took:.1f} s of the processor\n")
    corners = Corners(folder)
    print_table(corners, "opencv5", compare(corners, "opencv5", program))
    return discover(program, folder)


def agreement(left, right):
    """Of the corners' displacements, what two cameras say that found them each for itself."""
    keys = ["dx_m", "dy_m", "dz_m"]
    sides = []
    for found in (left, right):
        points = sorted(found.get("target", {}).get("points", []), key=lambda p: int(p["point"]))
        sides.append(np.array([[p[k] for k in keys + [f"sigma_{k}" for k in keys]] for p in points]))
    if len(sides[0]) == 0 or sides[0].shape != sides[1].shape:
        return
    print("\n## What both cameras say of the board\n\n| | left, um | right, um | correlation | difference over its sigma |")
    print("|---|---|---|---|---|")
    for k, name in enumerate(("along x", "along y", "out of the plane")):
        a, b = sides[0][:, k], sides[1][:, k]
        off = (a - b) / np.hypot(sides[0][:, 3 + k], sides[1][:, 3 + k])
        print(f"| {name} | {1e6 * a.std():.0f} | {1e6 * b.std():.0f} | {np.corrcoef(a, b)[0, 1]:.2f} | "
              f"{math.sqrt((off ** 2).mean()):.1f} |")


def write_rig(sides, folder):
    """One set of both cameras: a frame is a pair of pictures."""
    folder.mkdir()
    rows = []
    for side in ("left", "right"):
        with open(sides[side] / "points.csv", encoding="utf-8") as file:
            for row in csv.DictReader(file):
                row["frame"] = row["time_s"] = "".join(c for c in row["frame"] if c.isdigit())
                rows.append(row | {"camera": side})
    with open(folder / "points.csv", "w", encoding="utf-8", newline="") as file:
        table = csv.DictWriter(file, list(rows[0]))
        table.writeheader()
        table.writerows(rows)
    (folder / "measurement.yaml").write_text(
        "format: seam-measurement/1\nkind: points\ntitle: Both cameras\ncamera: {width_px: 640, height_px: 480}\n"
        "group: frame\nfiles: {points: points.csv}\nrig: {pose: unknown}\n", encoding="utf-8")
    lines = [(sides[side] / "nominal.yaml").read_text(encoding="utf-8").split("pinhole:")[1].splitlines()[0]
             for side in ("left", "right")]
    place = ", ".join(f"{k}: {{value: 0, free: true}}" for k in ("x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad"))
    (folder / "nominal.yaml").write_text(
        f"format: seam-model/1\nname: rig\neffects:\n  pinhole@left:{lines[0]}\n  pinhole@right:{lines[1]}\n"
        f"  camera_pose@right: {{{place}}}\n", encoding="utf-8")


def by_opencv(folder):
    """Where the right camera is beside the left one, by stereoCalibrate with each camera's own calibration."""
    import cv2
    views = {}
    with open(folder / "points.csv", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            views.setdefault(row["frame"], {}).setdefault(row["camera"], []).append(row)
    pairs = [v for v in views.values() if len(v) == 2]
    take = lambda v, side, names: np.array([[r[n] for n in names] for r in v[side]], np.float32)  # noqa: E731
    board = [take(v, "left", ("x_m", "y_m", "z_m")) for v in pairs]
    seen = {side: [take(v, side, ("u_px", "v_px")) for v in pairs] for side in ("left", "right")}
    ends = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 300, 1e-12)
    own = [cv2.calibrateCamera(board, seen[s], (640, 480), None, None, criteria=ends)[1:3] for s in ("left", "right")]
    turn, shift = cv2.stereoCalibrate(board, seen["left"], seen["right"], *own[0], *own[1], (640, 480),
                                      flags=cv2.CALIB_FIX_INTRINSIC, criteria=ends)[5:7]
    # p_right = R p_left + t there, p_left = R p_right + t here.
    return [*(-turn.T @ shift).ravel(), *cv2.Rodrigues(turn.T)[0].ravel()]


def both_cameras(program, sides, folder):
    print("\n## Both cameras as a rig")
    write_rig(sides, folder)
    discover(program, folder)
    print("\n| the right camera | SEAM | OpenCV |\n|---|---|---|")
    for (name, value), other in zip(values_of(folder / "found.yaml", "camera_pose@right").items(), by_opencv(folder)):
        print(f"| `{name}` | {figure(*value)} | {other:.5f} |")


def run(program, keep):
    if PAIRS.joinpath("left01.jpg").exists():
        sides, found = {}, {}
        for side in ("left", "right"):
            sides[side] = keep / side
            found[side] = one_camera(program, f"A chessboard, the {side} camera", sorted(PAIRS.glob(f"{side}[01]*.jpg")),
                                     ["--board", "9x6", "--spacing", "0.025"], sides[side])
        agreement(found["left"], found["right"])
        both_cameras(program, sides, keep / "rig")
    else:
        print("left out: opencv-doc is not installed")
    if DOTS.joinpath("grid36-01.pgm").exists():
        one_camera(program, "Four views of dots", sorted(DOTS.glob("grid36-0?.pgm")),
                   ["--target", "circles", "--board", "6x6", "--spacing", "0.03"], keep / "dots")
    else:
        print("left out: visp-images-data is not installed")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seam", default="build/seam")
    parser.add_argument("--keep", type=pathlib.Path)
    given = parser.parse_args()
    if given.keep:
        given.keep.mkdir()
        run(given.seam, given.keep)
        return 0
    with tempfile.TemporaryDirectory() as name:
        run(given.seam, pathlib.Path(name))
    return 0


if __name__ == "__main__":
    sys.exit(main())
