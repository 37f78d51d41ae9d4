#!/usr/bin/env python3
"""What hides in a moving camera is found through a real detector: boards drawn from a hand-held path and from a swinging head,
with rolling shutter, exposure and distortion; their corners as OpenCV and AprilTag see them; `discover` on these alone.
Prints the table of docs/evidence/detectors.md.

Usage: detector_proof_test.py SEAM [unittest arguments]
"""
import csv
import json
import math
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from target_pictures import AprilGrid, Chessboard, quaternion, rotation, tag_bits  # noqa: E402

import by_hand

SEAM = by_hand.arguments("seam")
WIDTH, HEIGHT, FOCAL, PERIOD_S = 480, 360, 450, 0.04
PINHOLE = f"  pinhole: {{fx_px: {FOCAL}, fy_px: {FOCAL}, cx_px: {(WIDTH - 1) / 2}, cy_px: {(HEIGHT - 1) / 2}}}\n"
EXPOSURE = "  exposure: {exposure_s: 0.001}\n"
INK_M = 1e-5  # The dark parts of the targets lie so high above the light ones: a head's camera is found to see it.
HIDDEN = {"rolling_shutter": {"line_delay_s": 4.5e-5}, "radial_distortion": {"kappa": -0.1}}
MOST_TARGET_SCATTER_M = 2e-5  # What a detector of tags sees of the squares at their corners.
LENS = "  lens_blur: {sigma_px: 0.7}\n"
SENSOR = "  linear_response: {gain_dn: 255}\n  read_noise: {sigma_dn: 2}\n"


def run(*arguments):
    done = subprocess.run([SEAM, *map(str, arguments)], capture_output=True, text=True, timeout=500)
    assert done.returncode == 0, (arguments, done.returncode, done.stdout, done.stderr)
    return done.stdout + done.stderr


def effects(hidden):
    return "".join(f"  {name}: {{{', '.join(f'{k}: {v}' for k, v in values.items())}}}\n" for name, values in hidden.items())


def board(name):
    """The target and what a user says of it to the detector."""
    if name == "chessboard":
        return Chessboard(9, 6, 0.03), ["--board", "9x6", "--spacing", "0.03"]
    return AprilGrid(4, 3, 0.06, 0.3, tag_bits), ["target.yaml"]


def table(path, head, rows):
    path.write_text(head + "\n" + "".join(",".join(f"{v:.12g}" if isinstance(v, float) else str(v) for v in row) + "\n"
                                          for row in rows))


class Hand:
    """A camera that a hand moves before the board: turned by up to 1.5 rad/s, shifted by up to 0.3 m/s."""
    frames = 40
    nominal = PINHOLE + EXPOSURE

    def rig(self, folder, target):
        w, h = target.size
        xs, ys = ([p[k] for p in target.points.values()] for k in (0, 1))
        middle = np.array([(min(xs) + max(xs)) / 2, -(min(ys) + max(ys)) / 2, 0])
        far = 1.15 * FOCAL / 0.6 * max(w / WIDTH, h / HEIGHT)
        rows = []
        for i in range(int(self.frames * PERIOD_S / 0.002) + 100):
            t = 0.002 * i - 0.1
            tilt = 0.3 + 0.16 * math.sin(5.1 * t + 0.4)
            turn = rotation(tilt, 0.7 + 0.5 * math.sin(2.3 * t), 0.15 * math.sin(6.7 * t) + 0.05 * math.sin(11 * t))
            aim = middle + np.array([0.02 * math.sin(7.3 * t), 0.02 * math.cos(5.9 * t), 0])
            rows.append((t, *(aim - far * (1 + 0.08 * math.sin(3.7 * t)) * turn[:, 2]), *quaternion(turn)))
        table(folder / "poses.csv", "time_s,x_m,y_m,z_m,qw,qx,qy,qz", rows)
        return "rig: {poses: poses.csv}\n", ""

    def seen_by_detector(self, found, *_):
        """Nothing but the corners: the path is not known."""
        text = (found / "measurement.yaml").read_text()
        assert "pose: unknown" in text, text
        (found / "measurement.yaml").write_text(text.replace("pose: unknown", "pose: unknown, motion: spline"))
        return found


class Head:
    """A head that swings in pan and tilt above the board, at up to 2.5 rad/s; its encoders are read every 8 ms."""
    frames = 40
    nominal = PINHOLE + EXPOSURE

    def rig(self, folder, target):
        xs, ys = ([p[k] for p in target.points.values()] for k in (0, 1))
        w, h = target.size
        height = 1.5 * FOCAL / 0.6 * max(w / WIDTH, h / HEIGHT)
        table(folder / "joints.csv", "time_s,tilt_rad,pan_rad", (
            (0.008 * i - 0.16, 0.11 * math.sin(9 * (0.008 * i)), 0.16 * math.sin(14 * (0.008 * i) + 0.5))
            for i in range(int(self.frames * PERIOD_S / 0.008) + 60)))
        # +x of the last link looks down on the board, the image's right is the target's x.
        chain = (f"rig:\n  chain:\n    - {{translate_m: [{(min(xs) + max(xs)) / 2:.6f}, {-(min(ys) + max(ys)) / 2:.6f}, {height:.6f}]}}\n"
                 "    - {rotate_rad: [0, 0, 1.5707963267948966]}\n    - {rotate_rad: [0, 1.5707963267948966, 0]}\n"
                 "    - {joint: tilt, axis: [0, 1, 0]}\n    - {translate_m: [0.0, 0.0, 0.048]}\n"
                 "    - {joint: pan, axis: [0, 0, 1]}\n    - {translate_m: [0.0666, 0.0, 0.0]}\n")
        return chain, ", joints: joints.csv"

    def seen_by_detector(self, found, protocol, target):
        """The corners in the rig's world, and the encoders."""
        seen = found.parent / f"{found.name}-head"
        seen.mkdir()
        shutil.copy(protocol / "joints.csv", seen)
        text = (protocol / "measurement.yaml").read_text()
        (seen / "measurement.yaml").write_text(text)
        with (found / "points.csv").open() as table_in, (seen / "points.csv").open("w") as out:
            rows = csv.DictReader(table_in)
            out.write(",".join(rows.fieldnames) + "\n")
            for row in rows:
                x, y = target.points[int(row["point"])]
                row.update(x_m=f"{x:.9g}", y_m=f"{-y:.9g}", z_m=INK_M)
                out.write(",".join(str(row[name]) for name in rows.fieldnames) + "\n")
        return seen


class Proof(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))

    def model(self, name, text):
        path = self.folder / f"{name}.yaml"
        path.write_text(f"format: seam-model/1\nname: {name}\neffects:\n{text}")
        return path

    def protocol(self, kind, rig, target, more):
        folder = self.folder / f"{kind}-protocol"
        folder.mkdir()
        says, files = rig.rig(folder, target)
        times = [PERIOD_S * i for i in range(rig.frames)]
        (folder / "measurement.yaml").write_text(
            f"format: seam-measurement/1\nkind: {kind}\n"
            f"camera: {{width_px: {WIDTH}, height_px: {HEIGHT}, frame_period_s: {PERIOD_S}}}\ngroup: frame\n"
            f"files: {{{kind}: {kind}.csv{files}}}\n{more}{says}")
        if kind == "frames":
            (folder / "scene.yaml").write_text(
                "format: seam-scene/1\nbackground_rgb: [0.3, 0.3, 0.3]\nshading: flat\nobjects:\n" + target.scene)
            table(folder / "frames.csv", "frame,file,time_s", ((i, f"frames/{i:04d}.png", t) for i, t in enumerate(times)))
        else:
            table(folder / "points.csv", "frame,time_s,point,x_m,y_m,z_m,u_px,v_px",
                  ((i, t, p, float(x), float(-y), INK_M, 0, 0) for i, t in enumerate(times)
                   for p, (x, y) in target.points.items()))
        return folder

    def detector_error(self, found, exact):
        """Of each corner, against where it is exactly seen."""
        def rows(folder):
            with (folder / "points.csv").open() as file:
                return list(csv.DictReader(file))
        truth = {(int(r["frame"]), int(r["point"])): (float(r["u_px"]), float(r["v_px"])) for r in rows(exact)}
        off = [(float(r["u_px"]) - truth[key][0], float(r["v_px"]) - truth[key][1])
               for r in rows(found) for key in [(int(pathlib.Path(r["frame"]).stem), int(r["point"]))]]
        return np.array(off)

    def seen(self, rig, name, hidden):
        """(the set of what the detector saw, its error, the truth)"""
        target, words = board(name)
        camera = self.model("camera", PINHOLE + EXPOSURE + effects(hidden) + LENS + SENSOR)
        geometry = self.model("geometry", PINHOLE + EXPOSURE + effects(hidden))
        pictures = self.folder / "pictures"
        run("measure", "--model", camera, "--protocol", self.protocol("frames", rig, target, "scene: scene.yaml\n"), "--seed", 5,
            "--out", pictures)
        points = self.protocol("points", rig, target, "")
        run("measure", "--model", geometry, "--protocol", points, "--noise", "off", "--out", self.folder / "exact")
        (self.folder / "times.csv").write_text("file,time_s\n" + "".join(
            f"{i:04d}.png,{PERIOD_S * i:.6f}\n" for i in range(rig.frames)))
        (self.folder / "target.yaml").write_text(
            "target_type: aprilgrid\ntagCols: 4\ntagRows: 3\ntagSize: 0.06\ntagSpacing: 0.3\n")
        found = self.folder / "found"
        says = [self.folder / word if word.endswith(".yaml") else word for word in words]
        run("import", "images", pictures / "frames", *says, self.folder / "times.csv", "--out", found)
        off = self.detector_error(found, self.folder / "exact")
        return rig.seen_by_detector(found, points, target), off

    def check(self, rig, name, hidden, most_target_scatter_m=0):
        seen, off = self.seen(rig, name, hidden)
        # A detector sees nearly all of it, and where it is; the noise is the data's to tell.
        self.assertGreater(len(off), 0.7 * rig.frames * len(board(name)[0].points))
        bias, scatter = np.abs(off.mean(0)).max(), off.std(0).max()
        out = self.folder / "out.yaml"
        run("discover", "--model", self.model("nominal", rig.nominal), "--data", seen, "--out", out, "--json",
            self.folder / "out.json")
        result = json.loads((self.folder / "out.json").read_text())
        steps = [step["effect"] for step in result["steps"]]
        values = {step["effect"]: step["parameters"] for step in result["steps"]}
        told = "; ".join(f"{p} {v['value']:.4g} +- {v['sigma']:.1g}" for step in values.values() for p, v in step.items()
                         if v.get("sigma"))
        print(f"| {type(rig).__name__.lower()} | {name} | {', '.join(hidden) or 'nothing'} | {len(off)} | {bias:.3f} | {scatter:.3f} "
              f"| {', '.join(steps) or 'nothing'} | {told} | {result.get('error', float('nan')):.3f} |", flush=True)
        self.assertLess(bias, 0.03)
        self.assertLess(scatter, 0.15)
        # Where the detector sees each corner a little off in the same way in all pictures, the result is an uneven target.
        if most_target_scatter_m > 0 and "target_scatter" in values:
            self.assertLess(values["target_scatter"]["sigma_m"]["value"], most_target_scatter_m)
            steps.remove("target_scatter")
        self.assertEqual(set(steps), set(hidden))
        for effect, parameters in hidden.items():
            for parameter, truth in parameters.items():
                told = values[effect][parameter]
                self.assertLess(abs(told["value"] - truth), 4 * told["sigma"] + 0.002 * abs(truth), (effect, parameter))

    def test_hand_chessboard(self):
        self.check(Hand(), "chessboard", HIDDEN)

    def test_hand_tags(self):
        self.check(Hand(), "aprilgrid", HIDDEN, MOST_TARGET_SCATTER_M)

    def test_hand_nothing_hidden(self):
        self.check(Hand(), "chessboard", {})

    def test_head_chessboard(self):
        self.check(Head(), "chessboard", {**HIDDEN, "frame_latency": {"latency_s": 0.006}})

    def test_head_tags(self):
        self.check(Head(), "aprilgrid", {**HIDDEN, "frame_latency": {"latency_s": 0.006}}, most_target_scatter_m=MOST_TARGET_SCATTER_M)

    def test_head_nothing_hidden(self):
        self.check(Head(), "chessboard", {})


if __name__ == "__main__":
    sys.argv = sys.argv[:1] + sys.argv[2:]
    unittest.main()
