#!/usr/bin/env python3
"""Two cameras on one rig, from the command line: a set is made by `seam measure`, `compare` finds what its nominal model
misses, and `discover` finds where the second camera is and which of the two lenses is bent.

Usage: two_cameras_test.py SEAM [unittest arguments]
"""
import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import by_hand

SEAM = by_hand.arguments("seam")
NOISE_PX = 0.2
FRAMES = 12
K1 = -0.25
# Of the right camera in the left one's axes: metres, then radians about x, y, z.
PLACE = {"x_m": 0.12, "y_m": 0.005, "z_m": -0.01, "rx_rad": 0.02, "ry_rad": -0.2, "rz_rad": 0.01}


def pinhole(name, f, cx, cy, free):
    values = zip(("fx_px", "fy_px", "cx_px", "cy_px"), (f, f, cx, cy))
    return f"  pinhole@{name}: {{{', '.join(f'{k}: {{value: {v}, free: {free}}}' for k, v in values)}}}\n"


def place(values, free):
    return f"  camera_pose@right: {{{', '.join(f'{k}: {{value: {v}, free: {free}}}' for k, v in values.items())}}}\n"


HEAD = "format: seam-model/1\neffects:\n"
TRUTH = (HEAD + pinhole("left", 520, 322, 236, "false") + pinhole("right", 610, 315, 244, "false") +
         place(PLACE, "false") + f"  radial_polynomial@right: {{k1: {K1}}}\n")
NOMINAL = (HEAD + pinhole("left", 560, 319.5, 239.5, "true") + pinhole("right", 560, 319.5, 239.5, "true") +
           place({key: 0 for key in PLACE}, "true"))


def write_protocol(folder):
    """A board of 8 x 6 corners half a metre before the rig, another tilt in each frame."""
    poses = "time_s,x_m,y_m,z_m,qw,qx,qy,qz\n"
    points = "frame,time_s,camera,point,x_m,y_m,z_m\n"
    for frame in range(FRAMES):
        tilt, around = 0.25 + 0.04 * frame, 2.4 * frame
        axis = (math.cos(around), math.sin(around), 0.0)
        half = 0.5 * tilt
        # The camera stands on a sphere about the board's middle and looks at it, beside the right one's view.
        forward = (math.sin(tilt) * axis[1], -math.sin(tilt) * axis[0], math.cos(tilt))
        away = 0.34 + 0.015 * (frame % 5)
        right = (math.cos(half) ** 2 + (axis[0] ** 2 - axis[1] ** 2) * math.sin(half) ** 2,
                 2 * axis[0] * axis[1] * math.sin(half) ** 2)
        eye = (-away * forward[0] - 0.04 * right[0], -away * forward[1] - 0.04 * right[1], -away * forward[2])
        q = (math.cos(half), *(math.sin(half) * a for a in axis))
        poses += f"{frame}," + ",".join(f"{x:.9f}" for x in (*eye, *q)) + "\n"
        for camera in ("left", "right"):
            for point in range(48):
                points += f"{frame},{frame},{camera},{point},{0.03 * (point % 8 - 3.5):.4f},{0.03 * (point // 8 - 2.5):.4f},0\n"
    (folder / "poses.csv").write_text(poses)
    (folder / "points.csv").write_text(points)
    (folder / "measurement.yaml").write_text(
        "format: seam-measurement/1\nkind: points\ntitle: Two cameras\ncamera: {width_px: 640, height_px: 480}\n"
        f"noise: {{u_px: {NOISE_PX}, v_px: {NOISE_PX}}}\ngroup: frame\n"
        "files: {points: points.csv, poses: poses.csv}\nrig: {pose: unknown}\n")


def seam(*arguments):
    done = subprocess.run([SEAM, *map(str, arguments)], capture_output=True, text=True, timeout=200)
    assert done.returncode == 0, done.stderr
    return done.stdout + done.stderr


class TwoCameras(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.held = tempfile.TemporaryDirectory()
        cls.at = pathlib.Path(cls.held.name)
        (cls.at / "protocol").mkdir()
        write_protocol(cls.at / "protocol")
        (cls.at / "truth.yaml").write_text(TRUTH)
        (cls.at / "nominal.yaml").write_text(NOMINAL)
        seam("measure", "--model", cls.at / "truth.yaml", "--protocol", cls.at / "protocol", "--seed", 5, "--out",
             cls.at / "set")

    @classmethod
    def tearDownClass(cls):
        cls.held.cleanup()

    def test_both_cameras_are_measured(self):
        lines = (self.at / "set" / "points.csv").read_text().splitlines()
        column = lines[0].split(",").index("camera")
        names = [line.split(",")[column] for line in lines[1:]]
        for camera in ("left", "right"):
            self.assertGreater(names.count(camera), 40 * FRAMES)

    def test_compare_says_what_the_nominal_model_misses(self):
        out = self.at / "compare.json"
        seam("compare", "--model", self.at / "nominal.yaml", "--data", self.at / "set", "--json", out)
        result = json.loads(out.read_text())
        self.assertGreater(result["error"], 1.5)
        self.assertEqual(result["noise"], {"u_px": NOISE_PX, "v_px": NOISE_PX})

    def differences(self, first, second):
        """By camera: the half of the image above which two models differ, and where they differ most, in pixels."""
        out = self.at / "models.json"
        text = seam("compare", "--models", first, second, "--data", self.at / "set", "--json", out)
        result = json.loads(out.read_text())
        maps = [result, *result["other_cameras"]]
        for one in maps:
            self.assertIn(f"camera {one['camera']}: ", text)
            self.assertEqual(len(one["du_px"]), one["columns"] * one["rows"])
        return {one["camera"]: (one["median_px"], one["largest_px"]) for one in maps}

    def test_models_differ_in_the_camera_whose_lens_does(self):
        other = self.at / "other.yaml"
        other.write_text(TRUTH.replace(f"k1: {K1}", f"k1: {K1 + 0.05}"))
        differ = self.differences(self.at / "truth.yaml", other)
        self.assertEqual(set(differ), {"left", "right"})
        self.assertLess(differ["left"][1], 1e-6)
        # In the corner of 0.05 r^3 times the focal length, less what a turn of the camera hides.
        r = math.hypot(315, 244) / 610
        self.assertGreater(differ["right"][1], 0.3 * 0.05 * r ** 3 * 610)
        self.assertLess(differ["right"][1], 2 * 0.05 * r ** 3 * 610)

    def assert_lenses_are_known(self, model):
        for camera, (middle, _) in self.differences(self.at / "truth.yaml", model).items():
            self.assertLess(middle, 0.5, camera)
        page = self.at / "page.html"
        seam("compare", "--model", model, "--data", self.at / "set", "--report", page)
        text = page.read_text()
        start = text.index('"lens_error":') + len('"lens_error":')
        maps, _ = json.JSONDecoder().raw_decode(text[start:])
        self.assertEqual([one["camera"] for one in maps], ["left", "right"])
        for one in maps:
            known = sorted(value for value in one["values"] if value is not None)
            self.assertLess(known[len(known) // 2], 0.5, one["camera"])
            self.assertGreater(known[0], 0, one["camera"])

    def test_a_rig_whose_poses_are_measured(self):
        """The rig names its table of poses by its file alone, which `measure` copies."""
        protocol = self.at / "posed-protocol"
        protocol.mkdir()
        write_protocol(protocol)
        facts = protocol / "measurement.yaml"
        facts.write_text(facts.read_text().replace(", poses: poses.csv}", "}").replace(
            "{pose: unknown}", "{poses: poses.csv}"))
        posed, model = self.at / "posed", self.at / "posed.yaml"
        seam("measure", "--model", self.at / "truth.yaml", "--protocol", protocol, "--seed", 5, "--out", posed)
        text = seam("fit", "--model", self.at / "nominal.yaml", "--data", posed, "--out", model)
        self.assertRegex(text, r"camera_pose@right\.ry_rad = -0\.[12]")
        text = seam("compare", "--model", self.at / "truth.yaml", "--data", posed)
        self.assertLess(abs(float(re.search(r"error on held-out groups ([.\d]+)", text).group(1)) - 1), 0.1, text)

    def test_discover_finds_the_bent_lens_and_the_place(self):
        out, model = self.at / "discover.json", self.at / "found.yaml"
        text = seam("discover", "--model", self.at / "nominal.yaml", "--data", self.at / "set", "--json", out, "--out",
                    model)
        result = json.loads(out.read_text())
        self.assertEqual(result["verdict"], "adequate", text)
        self.assertNotIn("anew", text)  # A corner that two cameras see is not measured twice.
        self.assertEqual(len(result["steps"]), 1, text)
        # One number bends as much as three here; whichever it is, it is the right camera's.
        self.assertIn(result["steps"][0]["effect"],
                      ("radial_distortion@right", "radial_polynomial@right", "rational_lens@right"), text)
        self.assertLess(abs(result["error"] - 1), 0.1, text)
        self.assert_lenses_are_known(model)
        found = model.read_text()
        where = found[found.index("camera_pose@right"):].splitlines()[0]
        for key, true in PLACE.items():
            said = re.search(rf"{key}: {{value: ([-+.e\d]+).*?sigma: ([-+.e\d]+)", where)
            self.assertIsNotNone(said, where)
            value, sigma = map(float, said.groups())
            self.assertLess(abs(value - true), 4 * sigma + 1e-9, f"{key}: {where}")
            self.assertLess(sigma, 0.01, f"{key}: {where}")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
