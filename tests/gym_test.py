#!/usr/bin/env python3
"""Environments for learning: the contract of Gymnasium with one robot, spaces, frames, actions.

Usage: gym_test.py BUILD_DIR SOURCE_DIR [unittest arguments], by the interpreter that has gRPC and numpy. Where Gymnasium can be imported
its own checker runs, too; the checks of ours run with and without it.
"""
import os
import re
import subprocess
import sys
import unittest
import warnings

from gym_worlds import BUILD, HAS_GYMNASIUM, HAS_PETTINGZOO, PAN, SOURCE, Gym, same, wave, np
import seam_gym
import seam_sdk
from seam_gym.spaces import Box, Dict, Discrete


class OneRobot(Gym):
    def test_an_episode_keeps_the_contract(self):
        env = self.env(observe=["joints", "odometry", "acceleration", "paws", "time_s", "frame", "row_s"])
        turns = self.play(env, 3)
        # Turns at 0, 0.032, ..., 0.48 s of 0.5 s, and the end, at which nothing new is sensed.
        self.assertEqual(len(turns), 17)
        self.assertAlmostEqual(turns[-1][0]["time_s"][0], 0.48, 5)
        for number, (seen, reward, terminated, truncated, info) in enumerate(turns):
            self.assertIn(seen, env.observation_space)
            self.assertIs(type(reward), float)
            self.assertIs(terminated, False)
            self.assertIs(truncated, number == 16)
            self.assertIsInstance(info["seen"], seam_sdk.Observation)
        self.assertIn(env.action_space.sample(), env.action_space)
        with self.assertRaisesRegex(seam_sdk.SeamError, "the run is over: reset"):
            env.step(wave(0))

    def test_a_gyroscope_where_the_scenario_names_one(self):
        with self.assertRaisesRegex(ValueError, "a robot without a gyroscope, expected `gyroscope: {}` under its `sensors`"):
            self.env(observe=["angular_velocity"]).reset(seed=1)
        with (self.here / "one.yaml").open("a") as scenario:
            scenario.write("    sensors: {gyroscope: {}}\n")
        for seen, _, _, _, info in self.play(self.env(observe=["angular_velocity"]), 3):
            self.assertEqual(seen["angular_velocity"].tolist(), np.float32(info["seen"].sensors.angular_velocity_rad_s).tolist())
        self.assertTrue(seen["angular_velocity"].any())

    def test_seeds_give_the_same_bits(self):
        env = self.env(observe=["joints", "frame"])
        first, again, other = self.play(env, 3), self.play(env, 3), self.play(env, 4)
        for one, two in zip(first, again):
            for part, counterpart in zip(one[:4], two):
                self.assertTrue(same(part, counterpart))
        self.assertFalse(all(same(one[0], two[0]) for one, two in zip(first, other)))
        # Without a seed episodes go on from the last one: the same sequence after the same seed.
        sequences = []
        for _ in range(2):
            env.reset(seed=9)
            sequences.append([])
            for _ in range(2):
                env.reset()
                sequences[-1].append([env.step(wave(turn))[0] for turn in range(3)][-1])
        self.assertTrue(same(sequences[0][0], sequences[1][0]) and same(sequences[0][1], sequences[1][1]))
        self.assertFalse(same(sequences[0][0], sequences[0][1]))

    def test_actions_are_scaled_numbered_or_of_your_own(self):
        env = self.env(act={"pan": (0.0, 1.0)}, log="scaled.mcap")
        env.reset(seed=1)
        for action in (-1, 0, 0.5, 1, 7):
            env.step(np.array([action], np.float32))
        env.close()
        for pan_rad in (0.0, 0.5, 0.75, 1.0):
            self.seam("replay", "find", "scaled.mcap", "--when", f"r0.command.pan_rad == {pan_rad}")
        self.seam("replay", "find", "scaled.mcap", "--when", "r0.command.pan_rad > 1", code=1)
        env = self.env(act=[{}, {"pan": 0.25}, {"kick": seam_sdk.Kick.LEG_FORWARD}], log="numbered.mcap")
        self.assertEqual(env.action_space, Discrete(3))
        env.reset(seed=1)
        for action in (0, 1, 2, np.int64(0)):
            env.step(action)
        env.close()
        self.seam("replay", "find", "numbered.mcap", "--when", "r0.command.pan_rad == 0.25")
        self.seam("replay", "find", "numbered.mcap", "--when", "r0.command.pan_rad != 0.25", code=1)
        own = seam_gym.Act(Box(0, 1, (2, 2)), lambda action, seen: seam_sdk.Decision().log_value("sum", action.sum() + seen.sequence))
        env = self.env(act=own, log="own.mcap")
        env.reset(seed=1)
        env.step(np.ones((2, 2), np.float32))
        env.close()
        self.seam("replay", "find", "own.mcap", "--when", "r0.sum == 5")
        with self.assertRaisesRegex(ValueError, "act: no order 'nose', expected one of: vx_m_s .* tilt pan roll"):
            self.env(act={"nose": (0, 1)})
        with self.assertRaisesRegex(ValueError, "observe: no sense 'smell', expected a Sense or one of: joints"):
            self.env(observe=["smell"])

    def test_wrong_actions_are_refused_and_the_episode_goes_on(self):
        env = self.env()
        with self.assertRaisesRegex(seam_sdk.SeamError, "no episode: reset begins one"):
            env.step(wave(0))
        env.reset(seed=1)
        for wrong in (0.5, [0.5], [0.5, 0, 0], [[0.5, 0]], [np.nan, 0], [np.inf, 0], None):
            with self.assertRaisesRegex(ValueError, r"action: expected numbers of shape \(2,\) for pan, vx_m_s, found "):
                env.step(wrong)
        self.assertEqual(env.step([0.5, 0])[4]["seen"].time_ns, 32_000_000)
        env.close()
        env.close()
        with self.assertRaisesRegex(seam_sdk.SeamError, "no episode: reset begins one"):
            env.step(wave(0))
        self.assertEqual(env.reset(seed=1)[1]["seen"].time_ns, 0)
        env = self.env(act=[{}, {"pan": 0.25}])
        env.reset(seed=1)
        for wrong in (-1, 2, 0.5, "x", np.array([1])):
            with self.assertRaisesRegex(ValueError, "action: expected a whole number from 0 to 1, found "):
                env.step(wrong)
        env.step(1)

    def test_frames_are_arrays_with_the_times_of_their_rows(self):
        bright = seam_gym.Sense("bright", Box(0, 255, (1,)), lambda seen, frame: np.array([0 if frame is None else frame.rgb_array().mean()], np.float32))
        env = self.env(observe=["frame", "row_s", bright], render_mode="rgb_array")
        turns = self.play(env, 3)
        self.assertEqual(turns[0][0]["frame"].shape, (36, 44, 3))
        self.assertEqual((turns[0][0]["frame"].max(), turns[0][0]["row_s"].max()), (0, 0))
        newest = None
        for seen, *_, info in turns:
            newest = info["seen"].frames[-1] if info["seen"].frames else newest
            if newest is None:
                continue
            self.assertTrue(np.array_equal(seen["frame"], newest.rgb_array()))
            self.assertAlmostEqual(seen["bright"][0], newest.rgb_array().mean(), 3)
            rows = (np.array([newest.row_start_ns, newest.row_end_ns]).T - info["seen"].time_ns) * 1e-9
            self.assertTrue(np.allclose(seen["row_s"], rows, atol=1e-6))
            self.assertTrue(np.all(np.diff(seen["row_s"][:, 0]) > 0) and np.all(seen["row_s"] <= 0))
        self.assertIsNotNone(newest)
        self.assertTrue(np.array_equal(env.render(), newest.rgb_array()))

    def test_keys_of_the_scenario_change_for_one_episode(self):
        env = self.env(watch={"x_m": "truth.{robot}.x_m"})
        starts = [env.reset(seed=1, options=options)[1]["watched"]["x_m"]
                  for options in ({"set": {"robots[0].pose.x_m": 0.25}}, None, {"other": 1})]
        self.assertEqual(starts, [0.25, -0.9, -0.9])
        with self.assertRaisesRegex(seam_sdk.SeamError, "robots.0..pose.q_m"):
            env.reset(options={"set": {"robots[0].pose.q_m": 0.25}})

    @unittest.skipUnless(HAS_GYMNASIUM, "no gymnasium")
    def test_gymnasium_finds_no_fault(self):
        import gymnasium
        from gymnasium.utils.env_checker import check_env
        for act in (PAN, [{}, {"pan": 0.5}]):
            env = self.env(observe=["joints", "time_s", "frame", "row_s"], act=act, render_mode="rgb_array",
                           terminated="truth.ball.x_m > 9", watch={"x_m": "truth.{robot}.x_m"})
            self.assertIsInstance(env, gymnasium.Env)
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                check_env(env)
            # Its advice: sizes of spaces that no physical bound limits, and an id in its registry.
            found = [str(one.message) for one in caught if not re.search("infinity|registered|spec|image", str(one.message))]
            self.assertEqual(found, [])


class Alone(unittest.TestCase):
    @unittest.skipUnless(HAS_GYMNASIUM or HAS_PETTINGZOO, "they are not here, so all of this ran without them")
    def test_nothing_needs_gymnasium_and_pettingzoo(self):
        done = subprocess.run([sys.executable, __file__, BUILD, SOURCE], env=dict(os.environ, GYM_TEST_ALONE="1"), capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_spaces(self):
        for space, others in ((Box(-1, 1, (3,)), [np.full(3, 2, np.float32), np.zeros(2, np.float32)]), (Discrete(3), [3, -1, "x"]),
                              (Box(0, 255, (2, 2), np.uint8), [np.zeros((2, 2), np.float64)]),
                              (Box(-np.inf, np.inf, (2,)), [[0.0]]), (Dict({"a": Box(0, 1, (1,)), "b": Discrete(2)}), [{}, 1])):
            space.seed(3)
            first = [space.sample() for _ in range(20)]
            space.seed(3)
            for one in first:
                self.assertIn(one, space)
                self.assertTrue(same(one, space.sample()))
            for other in others:
                self.assertNotIn(other, space)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
