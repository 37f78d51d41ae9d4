#!/usr/bin/env python3
"""`seam camera-calibrate`: its sets are valid, and a truth that is hidden in them is found again.

Usage: camera_calibrate_test.py SEAM [unittest arguments]
"""
import json
import math
import pathlib
import subprocess
import sys
import tempfile
import unittest

import by_hand

SEAM = by_hand.arguments("seam")
LIMIT_S = 200
PINHOLE = "  pinhole: {fx_px: 161.9, fy_px: 162.5, cx_px: 88.5, cy_px: 71.5}\n"
SENSOR = "  linear_response: {gain_dn: 220, black_dn: 8}\n  read_noise: {sigma_dn: 1.4}\n"
TRUTH = PINHOLE + SENSOR + "  rolling_shutter: {line_delay_s: 2.4e-4}\n  vignetting: {a2: 0.35, a4: 0.1}\n"


class CameraCalibrate(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.here = pathlib.Path(self.folder.name)

    def model(self, name, effects):
        path = self.here / f"{name}.yaml"
        path.write_text(f"format: seam-model/1\nname: {name}\neffects:\n{effects}")
        return path

    def seam(self, *arguments, code=0):
        done = subprocess.run([SEAM, *map(str, arguments)], capture_output=True, text=True, timeout=LIMIT_S)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done.stderr

    def result(self, command, model, data):
        out = self.here / f"{command}.json"
        self.seam(command, "--model", model, "--data", data, "--json", out)
        return json.loads(out.read_text())

    def make(self, out, *arguments):
        self.seam("camera-calibrate", "--model", self.model("truth", TRUTH), "--out", out, "--frames", 60, "--points", 80,
                  "--levels", 3, "--repeats", 6, *arguments)

    def test_the_truth_fits_and_what_a_model_lacks_is_named(self):
        data = self.here / "sets"
        self.make(data)
        truth = self.model("truth", TRUTH)
        points = len((data / "room" / "points.csv").read_text().splitlines()) - 1
        self.assertGreater(points, 1000)
        # Three tenths of the residuals, u and v, are held out: four standard deviations of their error.
        room = 4 / math.sqrt(2 * 0.3 * 2 * points)
        for name, lacking, effect, allowed in (("room", PINHOLE, "rolling_shutter", room),
                                               ("flat_fields", SENSOR, "vignetting", 0.02)):
            with self.subTest(name):
                self.assertAlmostEqual(self.result("compare", truth, data / name)["error"], 1, delta=allowed)
                found = self.result("diagnose", self.model("lacking", lacking), data / name)
                self.assertEqual(found["verdict"], "missing_effect")
                best = found["candidates"][0]
                self.assertEqual(best["effect"], effect)
                if effect == "rolling_shutter":
                    delay = best["parameters"]["line_delay_s"]
                    self.assertAlmostEqual(delay["value"], 2.4e-4, delta=4 * delay["sigma"])

    def test_the_same_seed_gives_the_same_files_and_another_seed_others(self):
        for name, seed in (("a", 1), ("b", 1), ("c", 2)):
            self.make(self.here / name, "--seed", seed)
        files = sorted(p.relative_to(self.here / "a") for p in (self.here / "a").rglob("*.*"))
        self.assertGreater(len(files), 30)
        for file in files:
            self.assertEqual((self.here / "a" / file).read_bytes(), (self.here / "b" / file).read_bytes(), file)
        for file in ("room/points.csv", "flat_fields/frames/0000.png"):
            self.assertNotEqual((self.here / "a" / file).read_bytes(), (self.here / "c" / file).read_bytes(), file)

    def test_wrong_use_and_bad_models_are_refused(self):
        self.seam("camera-calibrate", "--out", self.here / "x", code=2)
        self.seam("camera-calibrate", "--model", self.here / "none.yaml", "--out", self.here / "x", code=1)
        bad = self.model("bad", PINHOLE + "  vigneting: {a2: 0.1}\n")
        error = self.seam("camera-calibrate", "--model", bad, "--out", self.here / "x", code=1)
        self.assertIn("bad.yaml", error)
        self.assertIn("did you mean 'vignetting'", error)
        self.assertFalse((self.here / "x").exists())

    def test_a_model_that_gives_one_set_only_leaves_nothing_behind(self):
        for name, lacking in (("blind", SENSOR), ("dark", PINHOLE)):
            with self.subTest(name):
                self.seam("camera-calibrate", "--model", self.model(name, lacking), "--out", self.here / name, code=1)
                self.assertFalse((self.here / name).exists())
        # Nor does it touch what is there.
        (self.here / "kept" / "room").mkdir(parents=True)
        self.seam("camera-calibrate", "--model", self.model("dark", PINHOLE), "--out", self.here / "kept", code=1)
        self.assertEqual([p.name for p in (self.here / "kept").rglob("*")], ["room"])


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]], verbosity=2)
