#!/usr/bin/env python3
"""What a user sees of behaviours that print, fail, loop or flood: whole lines with robot and simulated time, in the
terminal, in the log and in the results of sweeps.

Usage: behaviour_output_test.py BUILD_DIR SOURCE_DIR PYTHON [unittest arguments]; PYTHON is the interpreter that has gRPC.
"""
import csv
import io
import json
import pathlib
import re
import sqlite3
import subprocess
import sys
import tempfile
import unittest

import by_hand

BUILD, SOURCE, PYTHON = by_hand.arguments("build", "source", "python")
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

    def scenario(self, text, robots=1, duration_s=0.5, more=""):
        program = self.here / "behaviour.py"
        program.write_text(PROLOGUE + text)
        program.chmod(0o755)
        lines = (f"format: seam-scenario/1\nname: printing\nduration_s: {duration_s}\nseed: 5\n"
                 f"field: {SOURCE}/models/field_2002.yaml\n{more}robots:\n")
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

    def test_a_refused_decision_is_told_once_with_its_time_and_counted(self):
        path = self.scenario("for seen in robot.observations():\n    robot.head(pan_rad=math.nan)\n", duration_s=1)
        log = self.here / "run.mcap"
        done = self.seam("run", path, "--log", log, "--json", self.here / "run.json")
        refused = json.loads((self.here / "run.json").read_text())["refused"]["r0"]
        self.assertGreater(refused["decisions"], 10)
        lines = [line for line in done.stderr.splitlines() if "refused" in line]
        self.assertEqual(len(lines), 2, lines)
        self.assertRegex(lines[0], r"r0: the decision at 0\.000 s was refused: head\.pan_rad: found nan")
        self.assertEqual(lines[1], f"r0: {refused['decisions']} of {refused['decisions']} decisions were refused and did "
                         "nothing; the first at 0.000 s: head.pan_rad: found nan, expected a number from -1000000 to 1000000")

    def test_a_target_beyond_the_range_is_clamped_with_one_warning(self):
        """The head goes to the ends of its range, and the run is that of who ordered the ends themselves."""
        swing = ("for seen in robot.observations():\n"
                 "    robot.head(pan_rad={} if seen.sequence % 2 else 0.2, tilt_rad={})\n")
        log = self.here / "run.mcap"
        done = self.seam("run", self.scenario(swing.format(90, -2)), "--log", log)
        warnings = [line for line in done.stderr.splitlines() if "warning" in line]
        self.assertEqual(warnings, [
            "0.000 s r0: warning: tilt: -2 rad is out of its range, -1.431 to 0.7505 rad, and is clamped to it",
            "0.000 s r0: warning: pan: 90 rad is out of its range, -1.564 to 1.564 rad, and is clamped to it; "
            "did you mean degrees? 90 degrees are 1.571 rad"])
        self.assertIn("clamped", self.seam("replay", "show", log, "--kind", "fault", "--all").stdout)
        self.seam("replay", "verify", log)
        poses = []
        for name, text in (("ends", swing.format(1.563815, -1.431170)), ("beyond", swing.format(90, -2))):
            log = self.here / f"{name}.mcap"
            self.seam("run", self.scenario(text), "--log", log)
            self.seam("replay", "show", log, "--at", "0.4", "--json", self.here / "at.json")
            poses.append(json.loads((self.here / "at.json").read_text())["robots"])
        self.assertEqual(poses[0], poses[1])

    def test_contacts_with_the_ball_begin_and_end(self):
        """Two robots that walk against the ball from both sides touch it in turn, many times a second."""
        path = self.scenario("for seen in robot.observations():\n"
                             "    ahead = 0.2 if seen.time_ns < 2e9 else -0.2\n"
                             "    robot.walk(vx_m_s=ahead if robot.name == 'r0' else -ahead)\n",
                             robots=2, duration_s=4, more="ball: {x_m: -0.6, y_m: 0.4}\n")
        log = self.here / "run.mcap"
        self.seam("run", path, "--log", log)
        shown = self.seam("replay", "show", log, "--kind", "world", "--all").stdout
        events = re.findall(r"^ +([\d.]+) (m?)s +world +(\S+) +(ball_\S+)(?: from ([\d.]+) s to ([\d.]+) s)?$", shown, re.M)
        self.assertNotIn("ball_touched", shown)
        self.assertIn("ball_contact_end", {event[3] for event in events})
        self.assertLess(len(events), 20, shown)
        begun = {}
        for time, milli, robot, name, begin, end in events:
            at = float(time) * (1e-3 if milli else 1)
            if name == "ball_contact":
                self.assertNotIn(robot, begun)
                begun[robot] = at
            else:
                self.assertAlmostEqual(begun.pop(robot), float(begin), places=2)
                self.assertAlmostEqual(at, float(end) + 0.2, places=1)
        self.seam("replay", "verify", log)

    def test_a_misspelt_value_ends_the_sweep_at_its_first_run(self):
        text = "for seen in robot.observations():\n    robot.head()\n    robot.log_value('ball_area_px', 3)\n"
        self.scenario(text)
        plan, results = self.here / "plan.yaml", self.here / "results.sqlite"

        def sweep(values, more="", check=0):
            plan.write_text("format: seam-sweep/1\nscenario: scenario.yaml\nseeds: [1, 6]\nkeep:\n"
                            f"  values: [{values}]\n{more}")
            return self.seam("sweep", plan, "--out", results, "--jobs", "1", check=check)

        said = sweep("ball_area_px, ball_are_px", check=1).stderr
        self.assertRegex(said, r"plan\.yaml:5: keep\.values\[1\]: robot 'r0' logged no value 'ball_are_px' in run 0, did you mean "
                         r"'ball_area_px'\? Where only some runs log it, write \{name: ball_are_px, optional: true\}")
        # The plan is mended, and the same results go on.
        done = sweep("ball_area_px, {name: goal_s, optional: true}").stdout
        self.assertIn("6 of 6 runs are finished", done)
        # What can be known before any run is an error of the check.
        for expression, error in (("ball_are_px * 2", "unknown name 'ball_are_px', did you mean 'ball_area_px'?"),
                                  ("red_score + 1", "reads 'red_score', but the scenario has no referee")):
            plan.write_text("format: seam-sweep/1\nscenario: scenario.yaml\nseeds: [1, 6]\nkeep:\n"
                            f"  values: [ball_area_px]\n  expressions: {{x: {expression}}}\n")
            said = self.seam("check", plan, check=1).stderr
            self.assertIn(f"plan.yaml:6: keep.expressions.x: {error}", said)

    def test_a_failed_run_has_nothing_that_is_averaged(self):
        results = self.sweep("for seen in robot.observations():\n    robot.log_value('x', 5)\n"
                             "    if seen.sequence == 4: raise ValueError()\n", "keep: {values: [x]}\n")
        header, *rows = csv.reader(io.StringIO(self.seam("sweep", "table", results).stdout))
        for row in rows:
            cells = dict(zip(header, row))
            self.assertTrue(cells.pop("error") and cells.pop("run") and cells.pop("seed") and cells.pop("end"))
            self.assertEqual(set(cells.values()), {""}, row)
        with sqlite3.connect(results) as database:
            self.assertEqual(database.execute("SELECT avg(x), avg(sim_s), avg(frames), avg(decisions) FROM runs").fetchone(),
                             (None,) * 4)
        self.seam("sweep", "status", results)

    def test_positions_of_errors_are_lines_of_a_file_or_none(self):
        path = self.scenario(QUIET)
        plan = self.here / "plan.yaml"
        plan.write_text("format: seam-sweep/1\nscenario: scenario.yaml\nvary:\n"
                        '  - {path: "robots[0].pose.x_m", values: [1, abc]}\n')
        self.assertIn("plan.yaml: run 1: scenario.yaml: robots[0].pose.x_m: found 'abc', expected a number",
                      self.seam("check", plan, check=1).stderr)
        said = self.seam("run", path, "--set", "robots[0].body.mass_kg=-1", check=1).stderr
        self.assertIn("seam: printing: robots[0].body.mass_kg: found -1", said)

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
