#!/usr/bin/env python3
"""The paper's experiments in their quick forms: experiments_test.py SEAM [unittest arguments]

They give what they promise, resume after an interruption, and give the same bits in any order; the
camera locked to the swing is recognised from its record.
"""
import csv
import json
import math
import pathlib
import statistics
import subprocess
import sys
import tempfile
import unittest

import by_hand

SEAM = by_hand.arguments("seam")
LIMIT_S = 800


def student_quantile_95(freedom):
    """The two-sided 95 % quantile of Student's t: bisection on Simpson's rule over its density."""
    scale = math.gamma((freedom + 1) / 2) / math.gamma(freedom / 2) / math.sqrt(math.pi * freedom)

    def inside(t, parts=2000):
        step = t / parts
        weights = (1 if i in (0, parts) else 4 if i % 2 else 2 for i in range(parts + 1))
        values = ((1 + (i * step) ** 2 / freedom) ** (-(freedom + 1) / 2) for i in range(parts + 1))
        return 2 * scale * step / 3 * sum(weight * value for weight, value in zip(weights, values))

    low, high = 0.0, 30.0
    while high - low > 1e-6:
        middle = (low + high) / 2
        low, high = (middle, high) if inside(middle) < 0.95 else (low, middle)
    return low


class Experiments(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.temporary.name)

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def seam(self, *arguments):
        done = subprocess.run([SEAM, *map(str, arguments)], capture_output=True, text=True, timeout=LIMIT_S, check=False,
                              cwd=self.folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def experiment(self, name, *arguments):
        """The experiment's JSON as it stands in the file."""
        self.seam("experiment", name, "--quick", "--out", name, "--json", f"{name}.json", *arguments)
        return (self.folder / f"{name}.json").read_bytes()

    def check_interval(self, values, mean, ci95):
        """One seed: Student's interval over its runs."""
        half_width = student_quantile_95(len(values) - 1) * statistics.stdev(values) / math.sqrt(len(values))
        self.assertAlmostEqual(mean, statistics.fmean(values), delta=0.001)
        self.assertAlmostEqual(ci95[0], statistics.fmean(values) - half_width, delta=0.01)
        self.assertAlmostEqual(ci95[1], statistics.fmean(values) + half_width, delta=0.01)

    def test_head_swing_bias(self):
        first = self.experiment("head-swing-bias", "--jobs", 2)
        found = json.loads(first)
        # Once more from the table of single runs, whose numbers have three decimals.
        with open(self.folder / "head-swing-bias" / "runs.csv", newline="") as table:
            runs = list(csv.DictReader(table))
        biases = {}
        for mode in ("locked", "scheduled"):
            own = [run for run in runs if run["mode"] == mode]
            biases[mode] = [math.hypot(float(run["dx_mm"]), float(run["dy_mm"])) for run in own]
            self.check_interval(biases[mode], found["modes"][mode]["bias_mm"], found["modes"][mode]["ci95"])
            spread_mm = statistics.fmean(float(run["spread_mm"]) for run in own)
            self.assertAlmostEqual(found["modes"][mode]["spread_mm"], spread_mm, delta=0.001)
        self.assertEqual([run["pose"] for run in runs], 2 * [str(i) for i in range(found["poses"])])
        pairs = [locked - scheduled for locked, scheduled in zip(biases["locked"], biases["scheduled"])]
        self.check_interval(pairs, found["paired"]["difference_mm"], found["paired"]["ci95"])
        self.assertEqual(found["seeds"], 1)
        # A program that takes the head's angle at the stamp errs as the rolling shutter says.
        for mode in found["shutter"]:
            for side in ("left", "right"):
                self.assertLess(abs(mode[f"{side}_mrad"] - mode[f"{side}_theory_mrad"]), 4, mode)
                self.assertGreater(abs(mode[f"{side}_mrad"]), 15)

        # Some runs are lost, are made again, in another order, and nothing changes.
        runs = sorted((self.folder / "head-swing-bias" / "runs").glob("*_s1.mcap"))
        for log in runs[::9]:
            log.unlink()
        kept = {log: log.stat().st_mtime_ns for log in runs if log.exists()}
        self.assertEqual(self.experiment("head-swing-bias", "--jobs", 3), first)
        for log, time in kept.items():
            self.assertEqual(log.stat().st_mtime_ns, time, log)
        self.check_the_record(self.folder / "head-swing-bias" / "measure")

    def check_the_record(self, folder):
        """A camera locked to the swing is measured; the other mode's camera tells what it lacks."""
        record = folder / "record"
        self.seam("measure", "--model", folder / "locked.yaml", "--protocol", folder / "protocol", "--seed", 1, "--out", record)
        self.seam("diagnose", "--model", folder / "scheduled.yaml", "--data", record, "--json", folder / "diagnose.json")
        found = json.loads((folder / "diagnose.json").read_text())
        self.assertEqual(found["verdict"], "missing_effect")
        self.assertEqual(found["candidates"][0]["effect"], "frame_sync")
        self.assertEqual(found["candidates"][0]["parameters"]["period_frames"]["value"], 25)
        self.seam("add", "frame_sync", "--model", folder / "instant.yaml", "--data", record, "--out", folder / "step1.yaml",
                  "--json", folder / "add1.json")
        self.seam("add", "rolling_shutter", "--model", folder / "step1.yaml", "--data", record, "--out", folder / "step2.yaml",
                  "--json", folder / "add2.json")
        first, second = (json.loads((folder / f"add{i}.json").read_text()) for i in (1, 2))
        self.assertLess(first["error_after"], 0.6 * first["error_before"])
        self.assertLess(second["error_after"], 0.1 * second["error_before"])

    def test_ball_distance(self):
        first = json.loads(self.experiment("ball-distance"))
        for point in first["points"]:
            self.assertEqual(point["n"], 100, point)
            self.assertLess(abs(point["mean_mm"] / point["true_mm"] - 1), 0.2, point)
            if point["camera"] == "ideal":
                self.assertEqual(point["deviation_mm"], 0, point)
        self.assertTrue((self.folder / "ball-distance" / "ball_pictures.png").is_file())

    def test_localization(self):
        found = json.loads(self.experiment("localization"))
        self.assertEqual(found["poses"], 4)
        for mode in ("ideal", "locked", "scheduled"):
            self.assertLess(found["modes"][mode]["xy"]["error"], 200)
            self.assertGreater(found["modes"][mode]["x"]["mean_width"], 50)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]], verbosity=2)
