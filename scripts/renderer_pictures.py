#!/usr/bin/env python3
"""The pictures of docs/reference/rendering.md that two renderers and four speeds make.

  scripts/renderer_pictures.py build/seam docs/images

A textured room at the middle of a turning head's swing, at four speeds; the recorded match by both renderers, and how
much they differ, ten times enlarged."""
import csv
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from PIL import Image, ImageDraw

SOURCE = pathlib.Path(__file__).resolve().parent.parent
ENLARGED, MARGIN, TITLE = 2, 6, 16
# Degrees a second, and seconds when a head that swings by 30 degrees passes the middle to the left.
SPEEDS = ((0, 0.4), (100, 1.2), (200, 0.6), (300, 0.4))
# Robots and seconds of the recorded match.
SCENES = (("red1", 5.0), ("blue2", 12.0), ("red4", 20.0))


def seam(*arguments):
    subprocess.run([str(argument) for argument in arguments], check=True, stdout=subprocess.DEVNULL)


def sheet(rows, out):
    """Rows of (title, picture)."""
    width, height = rows[0][0][1].size
    wide, high = ENLARGED * width + MARGIN, ENLARGED * height + MARGIN + TITLE
    canvas = Image.new("RGB", (wide * len(rows[0]) + MARGIN, high * len(rows) + MARGIN), (245, 245, 240))
    draw = ImageDraw.Draw(canvas)
    for j, row in enumerate(rows):
        for i, (title, picture) in enumerate(row):
            at = (MARGIN + i * wide, MARGIN + j * high)
            canvas.paste(picture.resize((ENLARGED * width, ENLARGED * height), Image.NEAREST), at)
            draw.text((at[0], at[1] + ENLARGED * height + 2), title, fill=(20, 20, 20))
    canvas.save(out, optimize=True)


def room(program, rate, time_s, folder):
    behaviour = f'["head_swing", "--rate", "{rate or 1}", "--amplitude", "{30 if rate else 0.001}"]'
    seam(program, "run", SOURCE / "scenarios/room/room.yaml", "--set", "duration_s=1.3", "--set",
         f"robots[0].behaviour.command={behaviour}", "--frames", folder / str(rate))
    with open(folder / str(rate) / "frames.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    # The rows of a frame are read during 40 ms.
    best = min(rows, key=lambda row: abs(1e-9 * int(row["stamp_ns"]) + 0.02 - time_s))
    return f"{rate} degrees a second", Image.open(folder / str(rate) / best["file"]).convert("RGB")


def match(program, robot, time_s, folder):
    pictures = []
    for renderer in ("analytic", "opengl"):
        eyes = folder / f"{robot}-{renderer}"
        seam(program, "replay", "frames", SOURCE / "replays/match.mcap", "--robot", robot, "--from", time_s, "--to", time_s + 0.04,
             "--renderer", renderer, "--out", eyes)
        pictures.append(Image.open(sorted(eyes.glob("*.png"))[0]).convert("RGB"))
    apart = np.abs(np.array(pictures[0]).astype(int) - np.array(pictures[1]))
    difference = Image.fromarray(np.minimum(10 * apart, 255).astype(np.uint8))
    return [(f"{robot}, {time_s:g} s: the ray caster", pictures[0]), ("OpenGL", pictures[1]),
            (f"difference times 10: mean {apart.mean():.2f}, at most {apart.max()} DN", difference)]


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    program, out = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2])
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch)
        sheet([[room(program, *speed, folder) for speed in SPEEDS]], out / "rendering_speeds.png")
        sheet([match(program, *scene, folder) for scene in SCENES], out / "rendering_match.png")


main()
