#!/usr/bin/env python3
"""What a user sees of behaviours that print, fail, loop or flood: whole lines with robot and simulated time, in the
terminal, in the log and in the results of sweeps.

Usage: behaviour_output_test.py BUILD_DIR SOURCE_DIR PYTHON [unittest arguments]; PYTHON is the interpreter that has gRPC.
"""
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

BUILD = pathlib.Path(sys.argv[1]).resolve()
SOURCE = pathlib.Path(sys.argv[2]).resolve()
PYTHON = sys.argv[3]
SEAM = BUILD / "seam"
LIMIT_S = 120

PROLOGUE = f"""#!{PYTHON}
import math, os, sys, time
sys.path.insert(0, {str(BUILD / "python")!r})
import seam_sdk
robot = seam_sdk.Robot()
"""
QUIET = "for seen in robot.observations():\n    robot.head(pan_rad=0.1)\n"


class BehaviourOutput(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.here = pathlib.Path(folder.name)

    def scenario(self, text, robots=1, duration_s=0.5):
        program = self.here / "behaviour.py"
        program.write_text(PROLOGUE + text)
        program.chmod(0o755)
        lines = (f"format: seam-scenario/1\nname: printing\nduration_s: {duration_s}\nseed: 5\n"
                 f"field: {SOURCE}/models/field_2002.yaml\nrobots:\n")
        for i in range(robots):
            lines += (f"  - id: r{i}\n    team: red\n    pose: {{x_m: {-0.9 + 0.6 * i}, y_m: 0.4, theta_rad: 0}}\n"
                      f"    body: {SOURCE}/models/robot_ers210.yaml\n    behaviour: {{command: [{program}]}}\n")
        path = self.here / "scenario.yaml"
        path.write_text(lines)
        return path

    def seam(self, *arguments, check=0):
        done = subprocess.run([SEAM, *map(str, arguments)], capture_output=True, text=True, timeout=LIMIT_S)
        self.assertEqual(done.returncode, check, done.stdout + done.stderr)
        return done

    def fingerprint(self, path, *arguments):
        self.seam("run", path, "--json", self.here / "run.json", *arguments)
        return json.loads((self.here / "run.json").read_text())["fingerprint"]

    def printed(self, log, *arguments):
        shown = self.seam("replay", "show", log, "--kind", "printed", "--all", *arguments).stdout
        return re.findall(r"^ +([\d.]+) m?s +printed +(\S+) +(.*)$", shown, re.MULTILINE)

    def test_an_exception_is_told_in_whole_lines_with_robot_and_time(self):
        """Three robots that fail at the same instant."""
        path = self.scenario("for seen in robot.observations():\n"
                             "    robot.head(pan_rad={'tilt': 0.1}['pan' if seen.sequence == 5 else 'tilt'])\n", robots=3)
        log = self.here / "run.mcap"
        done = self.seam("run", path, "--log", log, check=1)
        for name in ("r0", "r1", "r2"):
            self.assertRegex(done.stderr, rf"(?m)^0\.\d+ s {name}: KeyError: 'pan'$")
        self.assertNotIn("KeyErrorKeyError", done.stderr)
        lines = self.printed(log)
        self.assertEqual(sorted(robot for _, robot, text in lines if text == "KeyError: 'pan'"), ["r0", "r1", "r2"])
        self.assertTrue(self.printed(log, "--robot", "r1"))
        self.assertTrue(all(robot == "r1" for _, robot, _ in self.printed(log, "--robot", "r1")))

    def test_lines_have_the_time_of_the_observation_and_change_no_run(self):
        quiet = self.fingerprint(self.scenario(QUIET))
        path = self.scenario("for seen in robot.observations():\n    robot.head(pan_rad=0.1)\n"
                             "    print('seen', seen.sequence, 'at', seen.time_ns)\n"
                             "    print('half', end=' '); print('whole', file=sys.stderr)\n")
        logs = [self.here / "a.mcap", self.here / "b.mcap"]
        for log in logs:
            self.assertEqual(self.fingerprint(path, "--log", log), quiet)
        self.assertEqual(logs[0].read_bytes(), logs[1].read_bytes())
        verified = self.seam("replay", "verify", logs[0]).stdout
        self.assertRegex(verified, r"not compared: \d+ lines that behaviours printed")
        told = [text.split() for _, _, text in self.printed(logs[0]) if text.startswith(("seen", "half seen"))]
        self.assertGreater(len(told), 10)
        for (time, _, text) in self.printed(logs[0]):
            words = text.split()
            if "at" in words:
                self.assertAlmostEqual(float(time), 1e-9 * int(words[-1]), delta=1e-3)

    def test_a_flood_is_bounded_and_said(self):
        path = self.scenario("for seen in robot.observations():\n    robot.head(pan_rad=0.1)\n"
                             "    for i in range(2000): print('x' * 100)\n")
        log = self.here / "run.mcap"
        done = self.seam("run", path, "--log", log)
        self.assertLess(len(done.stderr), 60_000)
        self.assertRegex(done.stderr, r"\(\d+ lines left out: more than 16384 bytes a simulated second\)")
        self.assertLess(log.stat().st_size, 120_000)

    def test_bytes_that_are_no_text_are_shown(self):
        path = self.scenario("print('\\x1b[31mred')\nsys.stdout.buffer.write(b'\\xff\\n')\n" + QUIET)
        done = self.seam("run", path)
        self.assertIn(r"r0: \x1b[31mred", done.stderr)
        self.assertIn(r"r0: \xff", done.stderr)

    def sweep(self, text, plan_lines="", check=1):
        self.scenario(text)
        plan = self.here / "plan.yaml"
        plan.write_text("format: seam-sweep/1\nscenario: scenario.yaml\nseeds: [1, 3]\n" + plan_lines)
        results = self.here / "results.sqlite"
        self.seam("sweep", plan, "--out", results, "--jobs", "1", check=check)
        return results

    def test_a_sweep_keeps_what_failed_runs_printed_last(self):
        results = self.sweep("import random\nfor seen in robot.observations():\n    print('seen', seen.sequence)\n"
                             "    if seen.sequence == 8: raise ValueError('no ball')\n")
        self.seam("sweep", "status", results, "--json", self.here / "status.json")
        failures = json.loads((self.here / "status.json").read_text())["failures"]
        self.assertEqual(len(failures), 3)
        for failure in failures:
            first, *lines = failure["error"].splitlines()
            self.assertIn("its behaviour ended with exit code 1", first)
            self.assertRegex("\n".join(lines), r"0\.\d+ s r0: seen 8\n.*(?s:.*)ValueError: no ball")
        self.assertIn("ValueError: no ball", self.seam("sweep", "status", results).stdout)
        again = self.seam("sweep", "rerun", results, "--run", "1", "--run-programs")
        self.assertIn("run 1: failed again", again.stdout)
        self.assertIn("ValueError: no ball", again.stdout)
        self.assertEqual(self.seam("sweep", "table", results).stdout.count("ValueError"), 0)  # A cell is one line.

    def test_a_behaviour_that_loops_for_ever_ends_at_the_limit(self):
        results = self.sweep("for seen in robot.observations():\n    while seen.sequence == 3: pass\n",
                             "limits: {wall_s: 1.5}\n")
        status = self.seam("sweep", "status", results).stdout
        self.assertRegex(status, r"the limit of 1\.5 s on the wall passed at 0\.\d+ s, waiting for r0")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]])
