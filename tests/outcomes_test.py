#!/usr/bin/env python3
"""Sets of outcomes with the whole simulator: a ball's distance as the robot's program measures it, hidden effects of the
camera and of the scenario found again, and sets of strangers that start nothing and name nothing outside.

Usage: outcomes_test.py SEAM SOURCE_DIR [Outcomes | Settings]: Settings is a search by some 500 runs, of the slow matrix
"""
import csv
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

import by_hand

SEAM, SOURCE = by_hand.arguments("seam", "source")
SEAM = str(SEAM)

PLAN = """format: seam-sweep/1
scenario: {scenario}
set: {{duration_s: 0.25}}
vary:
  - {{path: "robots[0].pose.x_m", name: x_m, values: {places}}}
seeds: [1, 2]
keep:
  values: [{{name: distance_m, statistic: mean, as: distance_m}}]
  expressions: {{error_m: distance_m + x_m}}
"""
SET = """format: seam-measurement/1
kind: outcomes
title: a ball at some distances
files: {files}
scenarios: {scenarios}
most_runs: {most_runs}
candidates: {candidates}
"""
SETTING = """effects:
  ball_away:
    stage: scenario
    help: The ball lies farther away than the program assumes.
    parameters: {metres: {neutral: 0, min: -0.2, max: 0.2, scale: 0.02}}
    set: {"ball.x_m": metres}
"""


def seam(*arguments):
    return subprocess.run([SEAM, *map(str, arguments)], capture_output=True, text=True, timeout=500, check=False)


class Sets(unittest.TestCase):
    def setUp(self):
        self.scratch = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self.scratch.name)
        self.protocol = self.folder / "protocol"
        self.protocol.mkdir()
        self.nominal = self.write("nominal.yaml", "format: seam-model/1\nname: nominal\neffects:\n"
                                  "  pinhole: {fx_px: 161.9, fy_px: 162.5, cx_px: 88.5, cy_px: 71.5}\n"
                                  "  read_noise: {sigma_dn: 3}\n  lens_blur: {sigma_px: 1}\n")
        rows = ["scenario,value,statistic,measured,sigma"]
        for name in ("near", "far"):
            rows += [f"{name},error_m,{statistic},," for statistic in ("mean", "min", "max")]
        self.write("protocol/outcomes.csv", "\n".join(rows) + "\n")
        self.describe()

    def tearDown(self):
        self.scratch.cleanup()

    def write(self, name, text):
        (self.folder / name).write_text(text)
        return self.folder / name

    def describe(self, scenario=SOURCE / "scenarios/ball_distance.yaml", most_runs=3000):
        self.write("protocol/near.yaml", PLAN.format(scenario=scenario, places=[-0.55, -0.62]))
        self.write("protocol/far.yaml", PLAN.format(scenario=scenario, places=[-0.8, -0.92]))
        self.write("protocol/measurement.yaml",
                   SET.format(files="{outcomes: outcomes.csv}", scenarios="{near: near.yaml, far: far.yaml}",
                              most_runs=most_runs, candidates="{focal_length_error: {fy_scale: [-0.2, 0.2]}}"))

    def measured(self, model, name="made"):
        done = seam("measure", "--model", model, "--protocol", self.protocol, "--seed", 3, "--out", self.folder / name)
        self.assertEqual(done.returncode, 0, done.stderr)
        return self.folder / name


class Outcomes(Sets):
    def test_a_hidden_effect_of_the_camera_is_found_and_runs_are_kept(self):
        truth = self.write("truth.yaml", self.nominal.read_text() + "  focal_length_error: {fy_scale: 0.04}\n")
        made = self.measured(truth)
        with open(made / "outcomes.csv", newline="") as table:
            rows = list(csv.DictReader(table))
        self.assertTrue(all(float(row["sigma"]) > 0 for row in rows))
        # A ball is put down by hand, to some millimetres; the simulator's lies where it is stated.
        for row in rows:
            row["sigma"] = max(float(row["sigma"]), 3e-3)
        with open(made / "outcomes.csv", "w", newline="") as table:
            writer = csv.DictWriter(table, rows[0].keys())
            writer.writeheader()
            writer.writerows(rows)
        kept = self.folder / "kept"
        command = ["diagnose", "--model", self.nominal, "--data", made, "--runs", kept, "--json"]
        first = seam(*command, self.folder / "first.json")
        self.assertEqual(first.returncode, 0, first.stderr)
        told = json.loads((self.folder / "first.json").read_text())
        self.assertEqual(told["verdict"], "missing_effect", first.stdout)
        self.assertEqual(told["candidates"][0]["effect"], "focal_length_error")
        self.assertIn("runs were made, of at most 3000", first.stdout)
        results = sorted(kept.iterdir())
        self.assertGreater(len(results), 4)
        changed = [result.stat().st_mtime_ns for result in results]
        again = seam(*command, self.folder / "again.json")
        self.assertEqual(again.stdout, first.stdout)
        self.assertEqual((self.folder / "again.json").read_text(), (self.folder / "first.json").read_text())
        self.assertEqual(len(list(kept.iterdir())), len(changed))

    def test_programs_of_strangers_wait_for_consent(self):
        marker = self.folder / "started"
        program = self.write("protocol/stranger", f"#!/bin/sh\ntouch {marker}\n")
        program.chmod(0o755)
        done = seam("run", SOURCE / "scenarios/ball_distance.yaml", "--set", "duration_s=0.1")
        self.assertEqual(done.returncode, 0, done.stderr)
        text = PLAN.format(scenario=SOURCE / "scenarios/ball_distance.yaml", places=[-0.55]).replace(
            "set: {duration_s: 0.25}", f'set: {{duration_s: 0.25, "robots[0].behaviour.command": ["{program}"]}}')
        self.write("protocol/near.yaml", text)
        self.write("protocol/outcomes.csv", "scenario,value,statistic,measured,sigma\nnear,error_m,mean,0,1\n")
        done = seam("compare", "--model", self.nominal, "--data", self.protocol)
        self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
        self.assertIn("--run-programs", done.stderr)
        self.assertFalse(marker.exists())

    def test_a_set_that_cannot_be_made_leaves_nothing(self):
        plan = (self.protocol / "near.yaml").read_text()
        self.write("protocol/near.yaml", plan.replace("seeds: [1, 2]\n", ""))
        out = self.folder / "made"
        command = ["measure", "--model", self.nominal, "--protocol", self.protocol, "--out", out]
        done = seam(*command)
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        self.assertIn("seeds: [first, last]", done.stderr)
        self.assertFalse(out.exists())
        out.mkdir()
        self.write("made/of_mine.txt", "mine\n")
        self.assertEqual(seam(*command).returncode, 1)
        self.assertEqual([file.name for file in out.iterdir()], ["of_mine.txt"])

    def test_names_stay_in_the_folder(self):
        self.write("elsewhere.yaml", (SOURCE / "scenarios/ball_distance.yaml").read_text())
        self.describe(scenario="../elsewhere.yaml")
        done = seam("compare", "--model", self.nominal, "--data", self.protocol)
        self.assertEqual(done.returncode, 1)
        self.assertIn("near.yaml:2", done.stderr)
        self.assertIn("leads out of the folder", done.stderr)

    def test_the_papers_table_can_be_read(self):
        done = seam("check", SOURCE / "scenarios/outcomes/paper_table1")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("0 errors", done.stdout)


class Settings(Sets):
    def test_a_setting_of_the_scenario_is_a_candidate(self):
        settings = self.write("settings.yaml", SETTING)
        truth = self.write("truth.yaml", self.nominal.read_text() + SETTING.replace("effects:\n", "").replace(
            "{neutral: 0,", "{value: 0.03, neutral: 0,"))
        made = self.measured(truth)
        self.write("made/measurement.yaml", (made / "measurement.yaml").read_text().replace(
            "focal_length_error: {fy_scale: [-0.2, 0.2]}", "response_gamma:"))
        out = self.folder / "found.yaml"
        done = seam("discover", "--model", self.nominal, "--data", made, "--candidates", settings, "--out", out)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("ball_away", out.read_text(), done.stdout)
        value = float(out.read_text().split("metres: ")[1].split("value: ")[1].split(",")[0])
        self.assertAlmostEqual(value, 0.03, delta=0.004)
        # The model can be compared with the set again, and is none that a robot can have.
        self.assertEqual(seam("compare", "--model", out, "--data", made).returncode, 0)
        run = seam("run", SOURCE / "scenarios/ball_distance.yaml", "--model", out)
        self.assertEqual(run.returncode, 1)
        self.assertIn("changes the scenario", run.stderr)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=2)
