#!/usr/bin/env python3
"""Robots from URDF as a user has them: run, made again from the log, told by joint names, refused what they have not.

Usage: robots_test.py BUILD_DIR SOURCE_DIR PYTHON [unittest arguments]; PYTHON is the interpreter that has gRPC.
"""
import csv
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

from viewing import viewer

BUILD = pathlib.Path(sys.argv[1]).resolve()
SOURCE = pathlib.Path(sys.argv[2]).resolve()
PYTHON = sys.argv[3]
SEAM = BUILD / "seam"

BEHAVIOUR = f"""#!{PYTHON}
import sys
sys.path.insert(0, {str(BUILD / "python")!r})
import seam_sdk
robot = seam_sdk.Robot()
robot.on_refusal = lambda refusal: print("REFUSED", refusal.field, refusal.message, flush=True)
for seen in robot.observations():
    assert robot.joint_names == ("shoulder_pan", "shoulder_lift", "elbow", "wrist_flex", "gripper"), robot.joint_names
    assert len(seen.sensors.joints.angles_rad) == 5
    robot.joints([seam_sdk.JointTarget("elbow", 0.5), seam_sdk.JointTarget("gripper", 0.02)])
    try:
        robot.joint("knee")
    except ValueError as error:
        print("NAMES", error, flush=True)
    if seen.sequence == 3:
        ORDER
"""


class Robots(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        shutil.copytree(SOURCE / "models", self.folder / "models")
        shutil.copytree(SOURCE / "scenarios/arm", self.folder / "scenarios/arm")
        self.arm = self.folder / "scenarios/arm/arm.yaml"
        self.arm.write_text(self.arm.read_text().replace("duration_s: 2", "duration_s: 0.6"))

    def seam(self, *arguments, code=0):
        done = subprocess.run([SEAM, *map(str, arguments)], stdin=subprocess.DEVNULL, capture_output=True, text=True,
                              timeout=200)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done.stdout + done.stderr

    def shown(self, log, at_s):
        self.seam("replay", "show", log, "--at", at_s, "--json", self.folder / "shown.json")
        return json.loads((self.folder / "shown.json").read_text())

    def with_behaviour(self, order):
        program = self.folder / "behaviour.py"
        program.write_text(BEHAVIOUR.replace("ORDER", order))
        program.chmod(0o755)
        lines = self.arm.read_text().splitlines(keepends=True)
        self.arm.write_text("".join(f"    behaviour: {{command: [{program}]}}\n" if "shoulder_pan, --rate" in line else line
                                    for line in lines))

    def test_an_arm_swings_and_is_made_again(self):
        log = self.folder / "arm.mcap"
        self.seam("run", self.arm, "--log", log, "--frames", self.folder / "frames")
        self.assertIn("the same", self.seam("replay", "verify", log))
        shown = self.shown(log, 0.4)
        self.assertGreater(abs(shown["robots"]["arm"]["shoulder_pan_rad"]), 0.05)
        self.assertNotIn("tilt_rad", shown["robots"]["arm"])
        self.seam("replay", "export", log, "--out", self.folder / "csv")
        with open(self.folder / "csv/joint_commands.csv", newline="") as file:
            self.assertEqual({row["joint"] for row in csv.DictReader(file)}, {"shoulder_pan", "elbow"})
        # The servo's own model: the shoulder trails by its lag and play, and a set of the log has it.
        self.seam("import", "log", log, "--part", "joints", "--camera", "arm", "--out", self.folder / "set")
        with open(self.folder / "set/joints.csv", newline="") as file:
            self.assertEqual({row["joint"] for row in csv.DictReader(file)}, {"shoulder_pan"})
        # Nothing of the URDF file is needed any more.
        (self.folder / "scenarios/arm/arm.urdf").unlink()
        self.assertIn("the same", self.seam("replay", "verify", log))

    def test_joints_have_names_in_python(self):
        self.with_behaviour("pass")
        text = self.seam("run", self.arm, "--log", self.folder / "arm.mcap")
        self.assertIn("no joint 'knee', expected one of: shoulder_pan", text)
        self.assertNotIn("REFUSED", text)
        shown = self.shown(self.folder / "arm.mcap", 0.59)
        self.assertAlmostEqual(shown["robots"]["arm"]["elbow_rad"], 0.5, places=6)
        self.assertAlmostEqual(shown["robots"]["arm"]["gripper_rad"], 0.02, places=6)

    def test_what_a_robot_has_not_is_refused(self):
        for order, field in (("robot.head(pan_rad=0.1)", "head"), ("robot.kick(seam_sdk.Kick.LEG_FORWARD)", "kick"),
                             ("robot.joints([seam_sdk.JointTarget(5, 0.1)])", "joints[1].targets[0].joint")):
            with self.subTest(field):
                self.with_behaviour(order)
                self.assertIn(f"REFUSED {field} ", self.seam("run", self.arm))
                shutil.copy(SOURCE / "scenarios/arm/arm.yaml", self.arm)
                self.arm.write_text(self.arm.read_text().replace("duration_s: 2", "duration_s: 0.6"))

    def test_a_bad_file_is_named_with_its_line(self):
        urdf = self.folder / "scenarios/arm/arm.urdf"
        urdf.write_text(urdf.read_text().replace('<parent link="base"/>', '<parent link="nobody"/>'))
        text = self.seam("check", self.arm, code=1)
        self.assertIn("arm.urdf, line ", text)
        self.assertIn("'nobody', which is not there", text)

    def test_the_viewer_knows_their_joints(self):
        log = self.folder / "arm.mcap"
        self.seam("run", self.arm, "--log", log)
        with viewer(SEAM, log) as ask:
            names = ask("series", robot="arm")["names"]
            self.assertIn("gripper_rad", names)
            self.assertNotIn("tilt_rad", names)
            pan = ask("series", robot="arm", names="shoulder_pan_rad")["series"]["shoulder_pan_rad"]
            self.assertNotIn("ball", ask("truth"))
            self.assertNotIn("field", ask("info")["logs"][0])
        for i in (0, len(pan["t"]) // 2, len(pan["t"]) - 1):
            shown = self.shown(log, pan["t"][i])["robots"]["arm"]["shoulder_pan_rad"]
            self.assertAlmostEqual(pan["values"][i], shown, places=9)
        self.assertGreater(max(map(abs, pan["values"])), 0.1)

    def test_a_base_moves_where_it_may(self):
        text = self.arm.read_text().replace("urdf: arm.urdf", "urdf: arm.urdf\n    moves: true")
        self.arm.write_text(text)
        self.with_behaviour("robot.walk(vx_m_s=0.2)")
        self.seam("run", self.arm, "--log", self.folder / "arm.mcap")
        shown = self.shown(self.folder / "arm.mcap", 0.59)
        self.assertGreater(shown["robots"]["arm"]["x_m"], 0.05)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[4:])
