#!/usr/bin/env python3
"""The yaml examples of pages are what they say: page_examples_test.py SEAM PAGE.md FEWEST

Models (and files of candidates, as the effects of a model) are read by `seam check`. Of a measurement set or a scene, a
protocol of one frame is made, and `seam measure` makes the set.
"""
import pathlib
import re
import subprocess
import sys
import tempfile

import by_hand

SEAM = by_hand.arguments("seam", "models", "fewest")[0]
CAMERA = "format: seam-model/1\neffects:\n  pinhole: {fx_px: 161.9, fy_px: 162.5, cx_px: 88.5, cy_px: 71.5}\n"
SET_OF_SCENE = """format: seam-measurement/1
kind: frames
camera: {width_px: 32, height_px: 24}
files: {frames: frames.csv}
scene: scene.yaml
rig: {chain: [{translate_m: [-1, 0, 0.2]}]}
"""


def check_model(block, folder):
    (folder / "model.yaml").write_text(block if block.startswith("format:") else "format: seam-model/1\n" + block, encoding="utf-8")
    return [SEAM, "check", "model.yaml"]


def measure(folder):
    (folder / "camera.yaml").write_text(CAMERA, encoding="utf-8")
    return [SEAM, "measure", "--model", "camera.yaml", "--protocol", "protocol", "--out", "made"]


def measure_points(block, folder):
    (folder / "protocol").mkdir()
    (folder / "protocol/measurement.yaml").write_text(block, encoding="utf-8")
    (folder / "protocol/joints.csv").write_text("time_s,tilt_rad,pan_rad\n0,0,0\n0.1,0.01,0.02\n", encoding="utf-8")
    (folder / "protocol/points.csv").write_text("frame,time_s,point,x_m,y_m,z_m\n0,0.05,a,2,0.1,0.3\n", encoding="utf-8")
    return measure(folder)


def measure_scene(block, folder):
    (folder / "protocol").mkdir()
    (folder / "protocol/scene.yaml").write_text(block, encoding="utf-8")
    (folder / "protocol/measurement.yaml").write_text(SET_OF_SCENE, encoding="utf-8")
    (folder / "protocol/frames.csv").write_text("frame,file,time_s\n0,0.png,0\n", encoding="utf-8")
    return measure(folder)


USES = {"format: seam-measurement/1\nkind: points": measure_points, "format: seam-scene/1": measure_scene,
        "format: seam-model/1": check_model, "effects:": check_model}


def main():
    page, fewest = pathlib.Path(sys.argv[2]), int(sys.argv[3])
    blocks = re.findall(r"^```yaml\n(.*?)^```$", page.read_text(encoding="utf-8"), re.M | re.S)
    if len(blocks) < fewest:
        return f"{page}: {len(blocks)} examples, expected {fewest} or more"
    for block in blocks:
        use = next((use for start, use in USES.items() if block.startswith(start)), None)
        if use is None:
            return f"{page}: nobody knows what to do with\n{block}"
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run(use(block, pathlib.Path(folder)), cwd=folder, capture_output=True, text=True)
        if done.returncode != 0:
            return f"{page}:\n{block}\n{done.stderr}"
    print(f"{page}: {len(blocks)} examples read")
    return 0


if __name__ == "__main__":
    sys.exit(main())
