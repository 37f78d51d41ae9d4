#!/usr/bin/env python3
"""Mistakes and causes that people brought, made anew by plain formulas: what `seam` says of each in its first lines.
Usage: cases_test.py SEAM [unittest arguments]
"""
import json
import math
import pathlib
import random
import re
import subprocess
import sys
import tempfile
import unittest

import by_hand

SEAM = by_hand.arguments("seam")
FOCAL_PX, CENTRE_PX = 600, (319.5, 239.5)
BOARD = [(0.03 * i, 0.03 * k) for k in range(-2, 4) for i in range(-4, 5)]
BEACONS = ((0, 0), (6, 0), (6, 5), (0, 5))


def rotated(vector, p):
    """Rodrigues' formula."""
    angle = math.sqrt(sum(x * x for x in vector))
    if angle == 0:
        return p
    axis = [x / angle for x in vector]
    along = sum(a * b for a, b in zip(axis, p))
    return [c * math.cos(angle) + n * math.sin(angle) + a * along * (1 - math.cos(angle))
            for a, c, n in zip(axis, p, cross(axis, p))]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


class View:
    """A board before a camera of 640 x 480 pixels with f = 600, k1 = -0.2, k2 = 0.05 and 0.1 px of noise."""

    def __init__(self, draw, focus=0.0, turn=0.0, speed=0.0):
        self.draw = draw
        self.rotation = [draw.uniform(-0.45, 0.45), draw.uniform(-0.45, 0.45), draw.uniform(-0.3, 0.3)]
        self.place = [draw.uniform(-0.09, 0.09), draw.uniform(-0.06, 0.06), draw.uniform(0.35, 0.6)]
        self.focal_px = FOCAL_PX * (1 + draw.gauss(0, focus))
        self.turn = [draw.gauss(0, turn) for _ in range(3)]
        self.speed = [draw.gauss(0, speed) for _ in range(3)]

    def pixel(self, x, y):
        at = [a + b for a, b in zip(rotated(self.rotation, [x, y, 0]), self.place)]
        row = CENTRE_PX[1]
        for _ in range(5):
            # Rows are read 30 us after each other, by a camera that turns and moves.
            t_s = 30e-6 * (row - CENTRE_PX[1])
            px, py, pz = (p - t_s * (w + v) for p, w, v in zip(at, cross(self.turn, at), self.speed))
            px, py = px / pz, py / pz
            r2 = px * px + py * py
            lens = 1 - 0.2 * r2 + 0.05 * r2 * r2
            row = self.focal_px * lens * py + CENTRE_PX[1]
        return self.focal_px * lens * px + CENTRE_PX[0] + self.draw.gauss(0, 0.1), row + self.draw.gauss(0, 0.1)


def walk(draw, runs, left=1.0, tracker=(0.0, 0.0)):
    """Commands and poses of a robot that turns to the left more than commanded, seen by a tracker off its axle."""
    rows = ["run,time_s,vx_cmd_mps,vy_cmd_mps,omega_cmd_radps,x_m,y_m,theta_rad"]
    for run in range(runs):
        x, y, theta = draw.uniform(-1, 1), draw.uniform(-1, 1), draw.uniform(-3, 3)
        for k in range(280):
            if k % 47 == 0:
                v = draw.choice((0, 1, 1)) * draw.uniform(0.05, 0.4)
                omega = draw.choice((-1, 0, 1, 1, -1)) * draw.uniform(0.4, 1.2)
            u = (x + tracker[0] * math.cos(theta) - tracker[1] * math.sin(theta),
                 y + tracker[0] * math.sin(theta) + tracker[1] * math.cos(theta))
            rows.append(f"{run},{0.02 * k:.3f},{v:.5f},0,{omega:.5f},{u[0] + draw.gauss(0, 5e-4):.5f},"
                        f"{u[1] + draw.gauss(0, 5e-4):.5f},{theta + draw.gauss(0, 1e-3):.5f}")
            half = 0.01 * omega * (left if omega > 0 else 1)
            x, y, theta = x + 0.02 * v * math.cos(theta + half), y + 0.02 * v * math.sin(theta + half), theta + 2 * half
    return rows


def ranges(draw, delays, height):
    """A robot's rounds among four beacons; each answers late, and stands above it."""
    path, seen = [], []
    for k in range(2400):
        t = 0.1 * k
        x, y = 3 + 2.2 * math.sin(0.31 * t) + 0.4 * math.sin(0.083 * t), 2.5 + 1.6 * math.cos(0.31 * t + 0.4)
        path.append((t, x, y, 0.31 * t))
        if k % 2 == 0:
            b = k // 2 % 4
            way = math.sqrt((x - BEACONS[b][0]) ** 2 + (y - BEACONS[b][1]) ** 2 + height ** 2)
            seen.append(f"{t:.2f},{b + 1},{way + delays[b] + draw.gauss(0, 0.02):.4f}")
    return path, ["time,anchor,range", *seen]


class Cases(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = pathlib.Path(scratch.name)
        self.draw = random.Random(48)

    def write(self, name, lines):
        (self.folder / name).write_text("\n".join(lines) + "\n", encoding="utf-8")
        return self.folder / name

    def run_seam(self, *arguments, code=0):
        done = subprocess.run([SEAM, *map(str, arguments)], capture_output=True, text=True, timeout=300)
        self.assertEqual(done.returncode, code, (arguments, done.stdout, done.stderr))
        return done.stdout + done.stderr

    def board(self, views):
        """Views (or lists of corners of one) as a set, which is searched."""
        rows = ["frame,time_s,point,x_m,y_m,z_m,u_px,v_px"]
        for frame, (view, corners) in enumerate(views):
            for i in corners:
                x, y = BOARD[i]
                rows.append(f"{frame},{frame},{i},{x:.4f},{y:.4f},0," + ",".join(f"{p:.4f}" for p in view.pixel(x, y)))
        self.write("points.csv", rows)
        return self.discover("kind: points\ncamera: {width_px: 640, height_px: 480}\nrig: {pose: unknown}\n"
                             "files: {points: points.csv}\n",
                             "pinhole: {fx_px: {value: 590, free: true}, fy_px: {value: 590, free: true}, "
                             "cx_px: {value: 319.5, free: true}, cy_px: {value: 239.5, free: true}}")

    def discover(self, data, effects):
        self.write("measurement.yaml", ["format: seam-measurement/1", data])
        return self.found(self.write("nominal.yaml", ["format: seam-model/1", "name: n", "effects:", "  " + effects]),
                          self.folder)

    def found(self, model, data):
        """What was printed, and the result."""
        said = self.run_seam("discover", "--model", model, "--data", data, "--out", self.folder / "found.yaml", "--json",
                             self.folder / "found.json")
        return said, json.loads((self.folder / "found.json").read_text(encoding="utf-8"))

    def holds(self, result, effect, **truths):
        """The effect's values lie within four of their errors."""
        step = next(step for step in result["steps"] if step["effect"] == effect)
        for name, truth in truths.items():
            value = step["parameters"][name]
            self.assertLess(abs(value["value"] - truth), 4 * value["sigma"], (effect, name, value))

    def named(self, result, *effects):
        self.assertEqual(result["verdict"], "adequate", result["headline"])
        for effect in effects:
            self.assertIn(effect, result["headline"])

    def lens(self, result):
        """One form of the lens that these data do not separate from its like, and the focal length."""
        steps = [step["effect"] for step in result["steps"]]
        self.assertTrue({"radial_distortion", "radial_polynomial"} & set(steps), steps)
        self.assertNotIn("rational_lens", steps)
        for figure in result["figures"]["figures"][:2]:
            self.assertLess(abs(figure["value"] - FOCAL_PX), 4 * figure["sigma"], figure)

    def test_autofocus_between_views(self):
        _, result = self.board([(View(self.draw, focus=0.015), range(54)) for _ in range(24)])
        self.named(result, "focus_variation")
        self.holds(result, "focus_variation", sigma=0.015)
        self.lens(result)

    def test_still_views_through_a_rolling_shutter(self):
        said, result = self.board([(View(self.draw, turn=0.5, speed=0.15), range(54)) for _ in range(24)])
        self.named(result, "view_motion")
        self.assertIn("say motion: constant_velocity", said)
        self.lens(result)

    def test_views_of_one_row_of_corners(self):
        views = [(View(self.draw), range(54)) for _ in range(12)] + [(View(self.draw), range(4)) for _ in range(4)]
        said, result = self.board(views)
        self.assertEqual(result["verdict"], "adequate", result["headline"])
        self.assertLess(result["error"], 1.1)
        self.assertIn("frame 12, 13, 14, 15 left out, 4 of 16 views: they show points on one line", said)
        self.assertNotIn("mirrored", said)
        self.lens(result)

    def test_a_tracker_off_the_axle(self):
        self.write("odometry.csv", walk(self.draw, 4, tracker=(0.08, 0.02)))
        _, result = self.discover("kind: odometry\nfiles: {odometry: odometry.csv}\n", "ideal_odometry: {}")
        self.named(result, "tracker_offset")
        self.assertEqual([step["effect"] for step in result["steps"]], ["tracker_offset"])
        self.holds(result, "tracker_offset", x_m=0.08, y_m=0.02)

    def test_left_turns_that_are_longer(self):
        self.write("odometry.csv", walk(self.draw, 6, left=1.05))
        _, result = self.discover("kind: odometry\nfiles: {odometry: odometry.csv}\n", "ideal_odometry: {}")
        self.named(result, "turn_asymmetry")
        self.assertEqual([step["effect"] for step in result["steps"]], ["turn_asymmetry"])
        self.holds(result, "turn_asymmetry", left_excess=0.05)

    def beacons(self, delays=(0, 0, 0, 0), height=0.0, told=False):
        path, seen = ranges(self.draw, delays, height)
        anchors = [f"{b + 1},{x},{y}" + (f",{height}" if told else "") for b, (x, y) in enumerate(BEACONS)]
        files = [self.write("ranges.csv", seen),
                 self.write("anchors.csv", ["anchor,x,y" + (",z" if told else ""), *anchors]),
                 self.write("path.csv", ["time,x,y,theta" + (",z" if told else "")] +
                            [f"{t:.2f},{x:.4f},{y:.4f},{a:.5f}" + (",0" if told else "") for t, x, y, a in path])]
        said = self.run_seam("import", "ranges", *files, "--out", self.folder / "set")
        return said, *self.found(self.folder / "set/nominal.yaml", self.folder / "set")

    def test_beacons_that_answer_late(self):
        delays = (0.15, -0.05, 0.3, 0.02)
        _, said, result = self.beacons(delays=delays)
        self.named(result, "landmark_delay")
        self.assertEqual([step["effect"] for step in result["steps"]], ["landmark_delay"])
        told = re.findall(r"ranges of landmark (\d) are too (long|short) by ([\d.]+) \+- ([\d.]+) cm", said)
        self.assertEqual(len(told), 4, said)
        for beacon, way, size, error in told:
            truth = 100 * delays[int(beacon) - 1]
            self.assertLess(abs(float(size) * (1 if way == "long" else -1) - truth), 4 * float(error), said)

    def test_beacons_above_the_plane(self):
        imported, _, result = self.beacons(height=2.2, told=True)
        self.assertNotIn("all lies in a plane", imported)
        self.assertEqual((result["verdict"], result["steps"]), ("adequate", []), result["headline"])

    def test_beacons_above_the_plane_of_unknown_height(self):
        imported, _, result = self.beacons(height=2.2)
        self.assertIn("all lies in a plane (a column z", imported)
        self.named(result, "landmark_height")
        self.holds(result, "landmark_height", z_m=2.2)

    def test_a_calibration_that_folds(self):
        for name, focal, model, coefficients, code, words in (
                ("pole", 530, "rational_polynomial", [-2.75, 0.02, 0, 0, 0.01, -2.70, 0.02, 0.01], 0, "folds the image over"),
                ("fold", 530, "plumb_bob", [-0.35, -0.6, 0, 0, 0.9], 0, "folds the image over"),
                ("zero", 0, "plumb_bob", [0] * 5, 1, "is not calibrated")):
            file = self.write(name + ".yaml", [
                "image_width: 640", "image_height: 480", "camera_name: cam",
                f"camera_matrix: {{rows: 3, cols: 3, data: [{focal},0,{focal and 320},0,{focal},{focal and 240},0,0,{focal and 1}]}}",
                f"distortion_model: {model}",
                f"distortion_coefficients: {{rows: 1, cols: {len(coefficients)}, data: {coefficients}}}"])
            said = self.run_seam("import", "opencv", file, "--board", "9x6", "--spacing", "0.03", "--out", self.folder / name,
                                 code=code)
            self.assertIn(words, said)

    def test_a_joint_that_counts_the_other_way(self):
        files = []
        for run in range(3):
            rows, angle, goal = ["time,goal,present"], 0.0, 0.0
            for k in range(400):
                if k % 40 == 30:
                    goal = self.draw.uniform(-0.6, 0.6)
                rows.append(f"{0.02 * k:.4f},{goal:.4f},{self.draw.gauss(angle, 5e-4):.4f}")
                angle += (-goal - angle) * (1 - math.exp(-0.02 / 0.08))
            files.append(self.write(f"flip{run}.csv", rows))
        columns = ["--map", "command=goal,measured=present", "--unit", "rad"]
        question = "does one of the two columns count the other way"
        self.assertIn(question, self.run_seam("import", "servo", *files, *columns, "--out", self.folder / "set"))
        said = self.run_seam("compare", "--model", self.folder / "set/nominal.yaml", "--data", self.folder / "set")
        self.assertIn(question, said.splitlines()[0])
        turned = self.run_seam("import", "servo", *files, *columns, "--reverse", "joint", "--out", self.folder / "turned")
        self.assertNotIn(question, turned)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
