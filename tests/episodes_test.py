#!/usr/bin/env python3
"""`seam replay episodes`: what a robot sensed and ordered, as arrays; compared with what its script saw and decided.

Usage: episodes_test.py BUILD_DIR SOURCE_DIR [unittest arguments], by the interpreter that has gRPC and numpy.
"""
import csv
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np

import by_hand
import one_robot

BUILD, SOURCE = by_hand.arguments("build", "source")
sys.path.insert(0, str(BUILD / "python"))
import seam_sdk  # noqa: E402

SEAM = BUILD / "seam"
SCENARIO = one_robot.turns_of(SOURCE, "episodes", "r0", duration_s=0.6, more="    sensors: {gyroscope: {sigma: 0.01}}\n")


class Episodes(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.here = pathlib.Path(folder.name)
        (self.here / "scenario.yaml").write_text(SCENARIO)

    def seam(self, *words, code=0):
        done = subprocess.run([SEAM, *words], cwd=self.here, capture_output=True, text=True)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done.stdout + done.stderr

    def play(self, seed, log):
        """A run, and what its script saw."""
        seen = []
        with seam_sdk.World(self.here / "scenario.yaml", seed=seed, log=self.here / log) as world:
            while not world.done:
                now = world.observations["r0"]
                seen.append(now)
                decision = seam_sdk.Decision()
                if len(seen) == 1:
                    decision.request_all_frames()
                if len(seen) == 3:
                    decision.head(pan_rad=0.4, tilt_rad=-0.2)
                if len(seen) == 5:
                    decision.walk(vx_m_s=0.1, omega_rad_s=0.2).joints({"pan": -0.3})
                if len(seen) == 9:
                    decision.kick(seam_sdk.Kick.HEAD_LEFT).walk(vy_m_s=0.05)
                world.step({"r0": decision})
        return seen

    def test_rows_are_what_the_robot_sensed_and_ordered(self):
        runs = [self.play(7, "a.mcap"), self.play(8, "b.mcap")]
        said = self.seam("replay", "episodes", "a.mcap", "b.mcap", "--out", "data", "--frames")
        self.assertIn(f"2 episodes, {sum(map(len, runs))} rows", said)
        schema = json.loads((self.here / "data/schema.json").read_text())
        self.assertEqual((schema["format"], schema["total_episodes"], schema["total_frames"], schema["fps"]),
                         ("seam-episodes/1", 2, sum(map(len, runs)), 31.25))
        self.assertEqual([(e["seed"], e["log"], e["length"]) for e in schema["episodes"]],
                         [(7, "a.mcap", len(runs[0])), (8, "b.mcap", len(runs[1]))])
        state, action = (schema["features"][name]["names"] for name in ("observation.state", "action"))
        self.assertEqual((state[1], action[1], action[-4:]),
                         ("joints.pan_rad", "joints.pan_rad", ["walk.vx_m_s", "walk.vy_m_s", "walk.omega_rad_s", "kick"]))
        first = 0
        for number, seen in enumerate(runs):
            rows = np.load(self.here / "data" / schema["data_path"].format(episode_index=number))
            for name, feature in schema["features"].items():
                shape = () if feature["shape"] == [1] else tuple(feature["shape"])
                self.assertEqual((rows[name].shape, str(rows[name].dtype)), ((len(seen), *shape), feature["dtype"]), name)
            self.assertEqual(rows["time_ns"].tolist(), [now.time_ns for now in seen])
            self.assertTrue(np.allclose(rows["timestamp"], rows["time_ns"] * 1e-9))
            self.assertEqual(rows["index"].tolist(), list(range(first, first + len(seen))))
            self.assertEqual((set(rows["episode_index"].tolist()), rows["next.done"].tolist()), ({number}, [0] * (len(seen) - 1) + [1]))
            first += len(seen)
            column = dict(zip(state, rows["observation.state"].T))
            self.assertEqual(column["joints.pan_rad"].tolist(), [now.sensors.joints.pan_rad for now in seen])
            self.assertEqual(column["odometry.x_m"].tolist(), [now.sensors.odometry.x_m for now in seen])
            self.assertEqual(column["acceleration.z_m_s2"].tolist(), [now.sensors.acceleration_m_s2[2] for now in seen])
            self.assertEqual(column["angular_velocity.x_rad_s"].tolist(), [now.sensors.angular_velocity_rad_s[0] for now in seen])
            # Orders hold until there are others.
            orders = dict(zip(action, rows["action"].T))
            pan = seen[0].sensors.joints.pan_rad
            self.assertEqual(orders["joints.pan_rad"].tolist(), [pan] * 2 + [0.4] * 2 + [-0.3] * (len(seen) - 4))
            self.assertEqual(orders["walk.vx_m_s"].tolist(), [0] * 4 + [0.1] * 4 + [0] * (len(seen) - 8))
            self.assertEqual(orders["walk.vy_m_s"].tolist(), [0] * 8 + [0.05] * (len(seen) - 8))
            self.assertEqual(np.flatnonzero(orders["kick"]).tolist(), [8])
            newest, index = np.zeros((36, 44, 3), np.uint8), -1
            for row, now in enumerate(seen):
                if now.frames:
                    newest, index = now.frames[-1].rgb_array(), now.frames[-1].index
                self.assertEqual(rows["observation.images.camera.index"][row], index)
                self.assertTrue(np.array_equal(rows["observation.images.camera"][row], newest))
            self.assertGreater(index, 1)
        # Each joint's commands and angles, by name, as a set of measurements.
        self.seam("import", "servo", "data/episode_000000.npz", "data/episode_000001.npz", "--out", "set")
        with open(self.here / "set/joints.csv", newline="") as file:
            table = list(csv.DictReader(file))
        self.assertEqual({row["joint"] for row in table} >= {"pan", "tilt", "left_front_knee"}, True)
        self.assertEqual(list(table[0]), ["run", "time_s", "joint", "command_rad", "measured_rad"])
        again = self.seam("replay", "episodes", "a.mcap", "--out", "more")
        self.assertIn("1 episodes", again)
        self.assertNotIn("observation.images.camera", np.load(self.here / "more/episode_000000.npz"))

    def test_what_does_not_fit_is_refused(self):
        self.play(7, "a.mcap")
        (self.here / "slower.yaml").write_text(SCENARIO.replace("period_s: 0.032", "period_s: 0.064"))
        with seam_sdk.World(self.here / "slower.yaml", log=self.here / "slower.mcap") as world:
            for _ in range(3):
                world.step()
        self.assertIn("slower.mcap: its robot has other joints, camera or turns than that of a.mcap",
                      self.seam("replay", "episodes", "a.mcap", "slower.mcap", "--out", "mixed", code=1))
        self.assertFalse((self.here / "mixed/schema.json").exists())
        self.assertIn("'r9'", self.seam("replay", "episodes", "a.mcap", "--robot", "r9", "--out", "x", code=2))
        self.assertIn("scenario.yaml", self.seam("replay", "episodes", "scenario.yaml", "--out", "x", code=1))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
