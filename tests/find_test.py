#!/usr/bin/env python3
"""`seam replay find` and the address that it names, with a behaviour whose values are known.

Usage: find_test.py BUILD_DIR SOURCE_DIR PYTHON [unittest arguments]; PYTHON is the interpreter that has gRPC.
"""
import json
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import unittest
import urllib.error

from viewing import viewer

import by_hand

BUILD, SOURCE, PYTHON = by_hand.arguments("build", "source", "python")
SEAM = BUILD / "seam"

# "area" is 0 from 1 s to 1.6 s and for 0.1 s from 2 s on; "seldom" is logged in the first second alone.
BEHAVIOUR = f"""#!{PYTHON}
import sys
sys.path.insert(0, {str(BUILD / "python")!r})
import seam_sdk
robot = seam_sdk.Robot()
for seen in robot.observations():
    t = seen.time_s
    robot.head(pan_rad=0.5 if t > 1.5 else 0.0)
    if t > 0.2:
        robot.log_value("area", 0 if 1 <= t < 1.6 or 2 <= t < 2.1 else 7)
    if t < 1:
        robot.log_value("seldom seen", 1)
    if 0.49 < t < 0.52:
        robot.log_text("note", "half a second")
    if 1.2 < t < 1.25:
        robot.kick(seam_sdk.Kick.LEG_FORWARD)
        print("kicks")
"""


class Find(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        here = pathlib.Path(cls.folder.name)
        program = here / "behaviour.py"
        program.write_text(BEHAVIOUR)
        program.chmod(0o755)
        lines = f"format: seam-scenario/1\nname: find\nduration_s: 3\nseed: 5\nfield: {SOURCE}/models/field_2002.yaml\n"
        lines += "ball: {x_m: -0.75, y_m: 0.4}\nrobots:\n"
        for name in ("red-1", "red2"):
            lines += (f"  - id: {name}\n    team: red\n    pose: {{x_m: {-0.9 if name == 'red2' else 0.9}, y_m: 0.4}}\n"
                      f"    body: {SOURCE}/models/robot_ers210.yaml\n    behaviour: {{command: [{program}]}}\n")
        (here / "scenario.yaml").write_text(lines)
        cls.log = here / "run.mcap"
        run = subprocess.run([SEAM, "run", here / "scenario.yaml", "--log", cls.log], capture_output=True, text=True)
        if run.returncode != 0:
            raise AssertionError(run.stdout + run.stderr)
        cls.here = here

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def seam(self, *arguments, check=0):
        done = subprocess.run([SEAM, "replay", "find", self.log, *arguments], capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, check, done.stdout + done.stderr)
        return done

    def hits(self, when, *options, check=0):
        out = self.here / "find.json"
        self.seam("--when", when, "--json", out, *options, check=check)
        found = json.loads(out.read_text())
        self.assertEqual((found["format"], found["when"], found["count"]), ("seam-find/1", when, len(found["hits"])))
        return found["hits"]

    def test_values_hold_until_the_next_and_so_long(self):
        both = self.hits("red_1.area == 0")
        self.assertEqual(len(both), 2)
        self.assertAlmostEqual(both[0]["begin_s"], 1.0, delta=0.04)
        self.assertAlmostEqual(both[0]["end_s"], 1.6, delta=0.04)
        self.assertEqual(both[0]["begin_ns"], round(both[0]["begin_s"] * 1e9))
        long = self.hits("red_1.area == 0 for 0.5 s")
        self.assertEqual(long, both[:1])
        self.assertEqual(self.hits("red_1.area == 0 for 50 ms", "--first"), both[:1])
        self.assertEqual(self.seam("--when", "red_1.area == 0", "--count").stdout, "2\n")
        self.assertEqual(self.seam("--when", "red_1.area == 9", "--count", check=1).stdout, "0\n")
        self.assertTrue(self.hits("time_s > 2.5")[0]["until_end_of_log"])

    def test_before_its_first_value_nothing_holds(self):
        self.assertGreater(self.hits("red_1.area != 0")[0]["begin_s"], 0.2)

    def test_truth_commands_events_and_ages(self):
        self.assertAlmostEqual(self.hits("red2.command.pan_rad > 0.4")[0]["begin_s"], 1.5, delta=0.04)
        turned = self.hits("truth.red2.pan_rad > 0.4")[0]["begin_s"]
        self.assertGreater(turned, 1.5)
        self.assertAlmostEqual(self.hits("truth.red2.x_m < 0")[0]["begin_s"], 0, delta=0.04)
        self.assertTrue(self.hits("truth.red2.left_front_knee_rad < 9"))
        kicks = self.hits("red2.event.kick")
        self.assertEqual(kicks[0]["begin_ns"], kicks[0]["end_ns"])
        self.assertEqual(self.hits("event.kick && truth.red2.x_m < 0")[0], dict(kicks[0], view="?t=%.3f&robot=red2"
                                                                               % kicks[0]["begin_s"]))
        self.assertAlmostEqual(self.hits("red2.event.printed")[0]["begin_s"], 1.2, delta=0.05)
        self.assertAlmostEqual(self.hits("red_1.seldom_seen.age_s > 0.5")[0]["begin_s"], 1.5, delta=0.06)
        self.assertEqual(self.hits("event.goal", check=1), [])

    def test_wrong_conditions_say_what_was_expected(self):
        wrong = {"red_1.aera == 0": "no 'red_1.aera', did you mean 'red_1.area'?", "red_1.area = 0": "expected an expression",
                 "red_1.area == 0 for long": "expected how long it must hold", "red_1.area == 0 for 2": "for 0.5 s"}
        for text, said in wrong.items():
            self.assertIn(said, self.seam("--when", text, check=2).stderr)
        self.seam(check=2)
        names = self.seam("--names").stdout.split()
        for name in ("red_1.area", "red_1.seldom_seen", "red2.command.pan_rad", "truth.red2.left_front_knee_rad",
                     "truth.ball.x_m", "event.kick", "red2.event.printed", "time_s"):
            self.assertIn(name, names)

    def test_the_viewer_finds_the_same(self):
        with viewer(SEAM, self.log) as ask:
            for when in ("red_1.area == 0 for 0.5 s", "event.kick", "red_1.area == 9"):
                found = ask("find", when=when)
                self.assertEqual((found["format"], found["when"], found["count"]), ("seam-find/1", when, len(found["hits"])))
                self.assertEqual(found["hits"], self.hits(when, check=0 if found["hits"] else 1))
            self.assertEqual(ask("find", when="red_1.area == 0")["robot"], "red-1")
            cut = ask("find", when="red_1.area == 0", most=1)
            self.assertEqual((len(cut["hits"]), cut["more"]), (1, True))
            self.assertEqual(ask("find")["names"], self.seam("--names").stdout.split())
            hostile = {"red_1.aera == 0": "did you mean 'red_1.area'?", "red_1.area = 0": "expected an expression",
                       "time_s > 1 for 1e99 s": "expected how long it must hold", "(" * 900: "condition", "1+" * 600: "1000 at most",
                       "\0": "condition", "sin(" * 200 + "time_s" + ")" * 190: "condition", "'\u202e<script>": "condition"}
            for when, said in hostile.items():
                with self.subTest(when[:30]), self.assertRaises(urllib.error.HTTPError) as refused:
                    ask("find", when=when)
                self.assertEqual(refused.exception.code, 400)
                self.assertIn(said, json.loads(refused.exception.read())["error"])

    def test_lanes_of_the_viewer(self):
        with viewer(SEAM, self.log) as ask:
            lanes = ask("lanes", robot="red-1", **{"from": 1, "to": 2, "points": 1000})
            times = [one["t"] for one in ask("decisions", robot="red-1", **{"from": 1, "to": 2})["decisions"]]
            self.assertEqual([t for t in lanes["decisions"] if t < 2], times)
            few = ask("lanes", robot="red-1", points=10)
            self.assertLessEqual(len(few["decisions"]), 11)
            self.assertEqual(few["frames"], [], "this behaviour asks for none")
            self.assertEqual([round(t, 1) for t in few["texts"]], [0.5])

    def test_a_hit_is_a_link_for_the_viewer(self):
        line = self.seam("--when", "red_1.area == 0", "--first").stdout
        command = re.search(r"seam (view .*)$", line, re.M)[1].split()
        self.assertEqual(command[1], str(self.log))
        viewer = subprocess.Popen([SEAM, *command], stdout=subprocess.PIPE, text=True)
        address = viewer.stdout.readline().strip()
        viewer.send_signal(signal.SIGINT)
        viewer.communicate(timeout=30)
        self.assertRegex(address, r"^http://127\.0\.0\.1:\d+/\?t=1\.\d{3}&robot=red-1#token=[0-9a-f]{64}$")
        refused = subprocess.run([SEAM, "view", self.log, "--robot", "red3"], capture_output=True, text=True, timeout=60)
        self.assertEqual(refused.returncode, 2)
        self.assertIn("red2", refused.stderr)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]])
