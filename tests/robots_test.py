#!/usr/bin/env python3
"""Robots from URDF as a user has them: run, made again from the log, told by joint names, refused what they have not.

Usage: robots_test.py BUILD_DIR SOURCE_DIR PYTHON [unittest arguments]; PYTHON is the interpreter that has gRPC.
"""
import csv
import json
import math
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

from viewing import viewer

import by_hand

BUILD, SOURCE, PYTHON = by_hand.arguments("build", "source", "python")
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
        if code is not None:
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

    def test_the_viewer_draws_where_a_camera_looks(self):
        log = self.folder / "arm.mcap"
        self.seam("run", self.arm, "--log", log)
        with viewer(SEAM, log) as ask:
            truth = ask("truth")
            pan = ask("series", robot="arm", names="shoulder_pan_rad")["series"]["shoulder_pan_rad"]["values"]
        rows = truth["robots"]["arm"]
        self.assertEqual(len(rows), len(pan))
        for row, angle in zip(rows, pan):
            x, y, heading, elevation = row[6:]
            # The camera looks along the arm, which turns about the base's middle, and down by 0.15 rad.
            self.assertAlmostEqual(heading, angle, places=5)
            self.assertAlmostEqual(elevation, -0.15, delta=0.2)
            self.assertAlmostEqual(math.hypot(x - row[0], y - row[1]), 0.17, delta=0.1)
        self.assertGreater(max(row[8] for row in rows) - min(row[8] for row in rows), 0.1)

    def robot(self, links, camera="base", more=""):
        """A scenario with a robot of its own."""
        (self.folder / "robot.urdf").write_text(f'<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">{links}</robot>')
        (self.folder / "camera.yaml").write_text("format: seam-model/1\nname: c\neffects:\n"
                                                 "  pinhole: {fx_px: 150, fy_px: 150, cx_px: 88.5, cy_px: 71.5}\n")
        path = self.folder / "own.yaml"
        path.write_text("format: seam-scenario/1\nduration_s: 0.3\nhas_field: false\nball: {present: false}\nrobots:\n"
                        "  - id: a\n    team: red\n    pose: {x_m: 0, y_m: 0, theta_rad: 0}\n    camera: {model: camera.yaml}\n"
                        f"    body: {{urdf: robot.urdf, camera: {{link: {camera}}}}}\n{more}")
        return path

    def test_a_humanoid_moves_all_its_joints(self):
        links = '<link name="l0"/>' + "".join(
            f'<link name="l{i}"/><joint name="j{i}" type="revolute"><parent link="l{i - 1}"/><child link="l{i}"/>'
            '<axis xyz="0 0 1"/><limit lower="-1" upper="1" velocity="2"/></joint>' for i in range(1, 65))
        log = self.folder / "humanoid.mcap"
        scenario = self.robot(links, "l64", "    behaviour: {command: [joint_swing, --joint, j64]}\n")
        self.seam("run", scenario, "--log", log)
        self.assertIn("the same", self.seam("replay", "verify", log))
        shown = self.shown(log, 0.25)["robots"]["a"]
        self.assertGreater(abs(shown["j64_rad"]), 0.01)
        self.assertEqual(shown["j1_rad"], 0)
        self.seam("import", "log", log, "--part", "joints", "--camera", "a", "--out", self.folder / "set")

    def test_placeholders_are_left_out_and_said(self):
        scenario = self.robot('<link name="base"><visual><geometry><box size="0 0 0"/></geometry></visual></link>')
        said = "the shape of link 'base' has no volume and is left out"
        self.assertIn(said, self.seam("check", scenario))
        self.assertIn(f"warning: {self.folder}/robot.urdf, line 1: {said}", self.seam("run", scenario))

    def test_check_reads_meshes_and_a_camera_inside_one_is_said(self):
        mesh = self.folder / "cube.obj"
        corners = "".join(f"v {x} {y} {z}\n" for x in (-1, 1) for y in (-1, 1) for z in (-1, 1))
        faces = "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n"
        mesh.write_text(corners + faces)
        scenario = self.robot('<link name="base"/><link name="hand"><visual><geometry><mesh filename="cube.obj" scale="0.1 0.1 0.1"/>'
                              '</geometry></visual></link><joint name="j" type="fixed"><parent link="base"/><child link="hand"/></joint>')
        text = self.seam("check", scenario, code=None)
        if "this build has none" in text:
            self.skipTest(text)
        self.assertIn("1 meshes of 12 triangles", text)
        said = "robot 'a', at 0 s: its camera is inside the mesh 'cube.obj' of link 'hand'"
        self.assertIn(said, self.seam("run", scenario))
        self.assertIn("its camera is inside the mesh 'cube.obj' of link 'hand'",
                      self.seam("frame", scenario, "--robot", "a", "--at", 0.05, "--out", self.folder / "a.png"))
        apart = scenario.read_text().replace("{link: base}", "{link: base, translate_m: [0.11, 0, 0]}")
        scenario.write_text(apart)
        self.assertNotIn("warning", self.seam("run", scenario))
        mesh.write_text(corners + "f 1 2 99\n")
        text = self.seam("check", scenario, code=1)
        self.assertIn("cube.obj: not a readable mesh", text)
        self.assertNotIn("own.yaml: a valid", text)

    def test_a_base_moves_where_it_may(self):
        text = self.arm.read_text().replace("urdf: arm.urdf", "urdf: arm.urdf\n    moves: true")
        self.arm.write_text(text)
        self.with_behaviour("robot.walk(vx_m_s=0.2)")
        self.seam("run", self.arm, "--log", self.folder / "arm.mcap")
        shown = self.shown(self.folder / "arm.mcap", 0.59)
        self.assertGreater(shown["robots"]["arm"]["x_m"], 0.05)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[4:])
