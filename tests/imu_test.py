#!/usr/bin/env python3
"""Sets of inertial sensors, made by numpy alone: what is hidden is found with its values, and nothing where nothing is;
import and exports: imu_test.py SEAM"""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

import by_hand

try:
    import numpy as np
except ImportError:
    sys.exit(77)

SEAM = by_hand.arguments("seam")
ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "benchmark"))

import imu  # noqa: E402


def run(*arguments, code=0):
    done = subprocess.run([SEAM, *map(str, arguments)], capture_output=True, text=True, timeout=600)
    assert done.returncode == code, (arguments, done.returncode, done.stdout, done.stderr)
    return done.stdout + done.stderr


def discovered(folder):
    out = folder / "found.json"
    run("discover", "--model", folder / "nominal.yaml", "--data", folder, "--out", folder / "found.yaml", "--json", out)
    return json.loads(out.read_text())


class Sets(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))

    def found(self, effect, number=1):
        folder = self.folder / f"{effect}-{number}"
        return imu.make(folder, effect, number), discovered(folder), folder

    def is_found(self, effect, unit, names=None):
        values, found, folder = self.found(effect)
        self.assertEqual([step["effect"] for step in found["steps"]], [effect], found["headline"])
        self.assertEqual(found["verdict"], "adequate")
        for axis, value in values.items():
            seen = found["steps"][0]["parameters"][(names or {}).get(axis, axis) + f"_{unit}"]
            self.assertLess(abs(seen["value"] - value), 5 * seen["sigma"] + 0.03 * abs(value), (axis, value, seen))
        return found, folder

    def test_nothing_where_nothing_is(self):
        _, found, _ = self.found("nothing")
        self.assertEqual([step["effect"] for step in found["steps"]], [], found["headline"])

    def test_steps_walks_and_warmth(self):
        for effect, unit in (("gyro_quantisation", "rad"), ("accel_quantisation", "mps"), ("accel_random_walk", "mps3_rthz"),
                             ("accel_temperature", "mps2_k")):
            with self.subTest(effect):
                self.is_found(effect, unit)

    def test_axes_that_mix_and_ends_of_ranges(self):
        for effect, unit, names in (("gyro_misalignment", "rad", {"x": "yx", "y": "zx", "z": "zy"}),
                                    ("gyro_saturation", "radps", {"x": "most"}), ("accel_saturation", "mps2", {"x": "most"})):
            with self.subTest(effect):
                self.is_found(effect, unit, names)

    def test_random_walk(self):
        found, folder = self.is_found("gyro_random_walk", "radps2_rthz")
        curves = {curve["of"]: curve for curve in found["curves"]}
        for point in curves["wx_radps"]["points"]:
            # The model found follows the measured curve, within its errors, which are larger for a walk.
            self.assertLess(abs(point["value"] - point["expected"]), 6 * point["sigma"] + 0.05 * point["expected"])
        run("export", folder / "found.yaml", "--to", "kalibr-imu", "--data", folder, "--out", folder / "imu.yaml")
        text = (folder / "imu.yaml").read_text()
        largest = max(step["value"] for step in found["steps"][0]["parameters"].values())
        self.assertIn(f"gyroscope_random_walk: {largest:.3g}"[:-1], text)
        self.assertIn("gyroscope_noise_density: 0.0015\n", text)
        self.assertIn("update_rate: 50\n", text)

    def test_bias_instability_and_its_export(self):
        _, folder = self.is_found("accel_bias_instability", "mps2")
        args = ("export", folder / "found.yaml", "--to", "vins-imu", "--data", folder, "--out", folder / "vins.yaml")
        self.assertIn("accel_bias_instability", run(*args, code=1))
        self.assertIn("times as much as the file says", run(*args, "--drop", "accel_bias_instability"))
        # White noise of a sample: density times the root of the rate.
        self.assertIn(f"gyr_n: {0.0015 * 50 ** 0.5:.9g}\n", (folder / "vins.yaml").read_text())

    def test_scale(self):
        self.is_found("gyro_scale", "scale")

    def test_bias_by_gravity_in_attitudes(self):
        self.is_found("accel_bias", "mps2")

    def test_temperature(self):
        self.is_found("gyro_temperature", "radps_k")


class Import(unittest.TestCase):
    def test_units_and_names(self):
        with tempfile.TemporaryDirectory() as temporary:
            folder = pathlib.Path(temporary)
            rng = np.random.default_rng(5)
            with (folder / "log.csv").open("w") as file:
                file.write("stamp_ms,gyr_x [deg/s],gyr_y [deg/s],gyr_z [deg/s],acc_x,acc_y,acc_z,temp\n")
                for k in range(4000):
                    gyro, accel = rng.normal(size=3), 0.01 * rng.normal(size=3) + [0, 0, 1]
                    file.write(f"{5 * k}," + ",".join(f"{v:.9g}" for v in (*gyro, *accel)) + ",25\n")
            said = run("import", "imu", folder / "log.csv", "--map", "time=stamp_ms", "--unit", "deg", "--out", folder / "set")
            self.assertIn("from g to m/s^2", said)
            run("compare", "--model", folder / "set/nominal.yaml", "--data", folder / "set", "--json", folder / "c.json")
            self.assertLess(json.loads((folder / "c.json").read_text())["error"], 1.2)
            rows = (folder / "set/imu.csv").read_text().splitlines()
            self.assertEqual(rows[0], "run,time_s,wx_radps,wy_radps,wz_radps,ax_mps2,ay_mps2,az_mps2,temperature_c")
            refused = run("import", "imu", folder / "log.csv", "--map", "time=nowhere", "--out", folder / "no", code=1)
            self.assertIn("nowhere", refused)
            self.assertFalse((folder / "no").exists())


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]], verbosity=2)
