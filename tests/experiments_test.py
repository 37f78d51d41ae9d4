#!/usr/bin/env python3
"""The paper's experiments in their quick forms: experiments_test.py SEAM [unittest arguments]

They give what they promise, resume after an interruption, and give the same bits in any order; the
camera locked to the swing is recognised from its record.
"""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

SEAM = pathlib.Path(sys.argv[1]).resolve()
LIMIT_S = 800


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

    def test_head_swing_bias(self):
        first = self.experiment("head-swing-bias", "--jobs", 2)
        found = json.loads(first)
        for mode in ("locked", "scheduled"):
            result = found["modes"][mode]
            self.assertGreater(result["bias_mm"], 0)
            self.assertGreater(result["spread_mm"], 0)
            self.assertLess(result["ci95"][0], result["bias_mm"])
            self.assertGreater(result["ci95"][1], result["bias_mm"])
        difference = found["modes"]["locked"]["bias_mm"] - found["modes"]["scheduled"]["bias_mm"]
        self.assertAlmostEqual(found["paired"]["difference_mm"], difference, places=6)
        self.assertLess(found["paired"]["ci95"][0], difference)
        self.assertGreater(found["paired"]["ci95"][1], difference)
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
