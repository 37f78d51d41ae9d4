#!/usr/bin/env python3
"""`seam replay feed`: a recorded run given to another program, as a test of a behaviour and for values after the fact.

Usage: feed_test.py BUILD_DIR SOURCE_DIR PYTHON [unittest arguments]; PYTHON is the interpreter that has gRPC.
"""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

import by_hand

BUILD, SOURCE, PYTHON = by_hand.arguments("build", "source", "python")
SEAM = BUILD / "seam"

# A behaviour that depends on its camera; what differs from one variant to the other is put in at the mark.
BEHAVIOUR = f"""#!{PYTHON}
import sys
sys.path.insert(0, {str(BUILD / "python")!r})
import seam_sdk
robot = seam_sdk.Robot()
robot.request_all_frames()
for seen in robot.observations():
    for frame in seen.frames:
        robot.log_value("brightness", sum(frame.rgb[:300]))
        robot.head(pan_rad=0.001 * (sum(frame.rgb[:3]) % 100))
    # MARK
"""


class Feed(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.here = pathlib.Path(cls.scratch.name)
        program = cls.program("recorded.py", "")
        lines = f"format: seam-scenario/1\nname: feed\nduration_s: 1\nseed: 5\nfield: {SOURCE}/models/field_2002.yaml\nrobots:\n"
        for name in ("red1", "red2"):
            lines += (f"  - id: {name}\n    team: red\n    pose: {{x_m: {-0.9 if name == 'red2' else 0.9}, y_m: 0.4}}\n"
                      f"    body: {SOURCE}/models/robot_ers210.yaml\n    behaviour: {{command: [{program}]}}\n"
                      f"    camera: {{model: {SOURCE}/models/ers210.yaml, width_px: 44, height_px: 36, clock: {{period_s: 0.2}}}}\n")
        (cls.here / "scenario.yaml").write_text(lines)
        cls.log = cls.here / "run.mcap"
        run = subprocess.run([SEAM, "run", cls.here / "scenario.yaml", "--log", cls.log], capture_output=True, text=True)
        if run.returncode != 0:
            raise AssertionError(run.stdout + run.stderr)

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    @classmethod
    def program(cls, name, more):
        path = cls.here / name
        path.write_text(BEHAVIOUR.replace("# MARK", more))
        path.chmod(0o755)
        return path

    def seam(self, *arguments, check=0):
        done = subprocess.run([SEAM, "replay", *map(str, arguments)], capture_output=True, text=True, timeout=120)
        self.assertEqual(done.returncode, check, done.stdout + done.stderr)
        return done

    def feed(self, program, *options, check=0):
        out = self.here / "feed.json"
        self.seam("feed", self.log, "--robot", "red1", "--client", program, "--json", out, *options, check=check)
        return json.loads(out.read_text())

    def test_the_same_program_decides_the_same_from_frames_of_its_robot_alone(self):
        found = self.feed(self.here / "recorded.py")
        self.assertEqual((found["format"], found["different"], found["frames_from_log"]), ("seam-feed/1", 0, 0))
        self.assertGreater(found["decisions"], 20)
        self.assertIn(found["frames_drawn"], (4, 5, 6))

    def test_frames_that_the_log_holds_are_not_drawn(self):
        log = self.here / "pictures.mcap"
        subprocess.run([SEAM, "run", self.here / "scenario.yaml", "--log", log, "--log-frames"], check=True,
                       capture_output=True)
        out = self.here / "pictures.json"
        self.seam("feed", log, "--robot", "red1", "--client", self.here / "recorded.py", "--json", out)
        found = json.loads(out.read_text())
        self.assertEqual((found["different"], found["frames_drawn"]), (0, 0))
        self.assertIn(found["frames_from_log"], (4, 5, 6))

    def test_another_decision_is_shown_field_by_field(self):
        late = self.program("late.py", "if seen.time_s > 0.5: robot.walk(vx_m_s=0.1)")
        found = self.feed(late, check=1)
        first = found["others"][0]
        self.assertAlmostEqual(first["time_ns"] * 1e-9, 0.5, delta=0.04)
        self.assertIn({"field": "walk.vx_m_s", "a": "", "b": "0.1"}, first["fields"])
        self.assertEqual(first["frame"], 2)
        self.assertEqual(first["view"], "?t=%.3f&robot=red1" % (first["time_ns"] * 1e-9))
        text = self.seam("feed", self.log, "--robot", "red1", "--client", late, check=1).stdout
        self.assertRegex(text, r"walk\.vx_m_s +nothing and 0\.1")

    def test_expected_decisions_are_a_test_of_a_behaviour(self):
        late = self.program("slow.py", "if seen.time_s > 0.5: robot.walk(vx_m_s=0.2)")
        expected = self.here / "expected.json"
        self.feed(late, "--write-expected", expected)
        self.assertEqual(self.feed(late, "--expect", expected)["different"], 0)
        found = self.feed(self.here / "recorded.py", "--expect", expected, check=1)
        self.assertIn({"field": "walk.vx_m_s", "a": "0.2", "b": ""}, found["others"][0]["fields"])
        expected.write_text("{}")
        self.assertIn("--write-expected", self.seam("feed", self.log, "--robot", "red1", "--client", late, "--expect",
                                                    expected, check=1).stderr)

    def test_values_are_added_to_a_copy_where_decisions_are_equal(self):
        more = self.program("more.py", "robot.log_value('after', 2)\n    if seen.time_s > 0.5: robot.walk(vx_m_s=0.1)")
        copy = self.here / "copy.mcap"
        self.feed(more, "--log", copy, check=1)
        self.assertIn("the same", self.seam("verify", copy).stdout)
        hits = self.here / "find.json"
        self.seam("find", copy, "--when", "red1.after == 2 && red1.after.age_s < 0.1", "--json", hits)
        hit, = json.loads(hits.read_text())["hits"]
        self.assertAlmostEqual(hit["end_s"], 0.6, delta=0.05)
        self.seam("find", self.log, "--when", "red1.after == 2", check=2)

    def test_a_program_that_ends_is_named_with_its_time(self):
        short = self.program("short.py", "if seen.time_s > 0.3: sys.exit(3)")
        done = self.seam("feed", self.log, "--robot", "red1", "--client", short, check=1)
        self.assertIn("did not decide at 0.3", done.stderr)
        self.assertIn("did you mean", self.seam("feed", self.log, "--robot", "red3", "--client", short, check=2).stderr)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]])
