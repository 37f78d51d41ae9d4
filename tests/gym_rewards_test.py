#!/usr/bin/env python3
"""Rewards, ends and watched values of environments for learning: expressions over truth and logged values.

Usage: gym_rewards_test.py BUILD_DIR SOURCE_DIR [unittest arguments], by the interpreter that has gRPC and numpy.
"""
import re
import sys
import unittest

from gym_worlds import Gym, np
import seam_gym
import seam_sdk
from seam_gym.spaces import Discrete


class Expressions(Gym):
    def test_reward_and_end_read_truth_and_logged_values(self):
        own = seam_gym.Act(Discrete(9), lambda action, seen: seam_sdk.Decision().log_value("turn-number", seen.sequence))
        env = self.env(act=own, reward="10 * truth.{robot}.x_m + time_s", terminated=lambda seen, truth: truth.time_ns > 300_000_000,
                       watch={"distance_m": "truth.{robot}.ball_distance_m", "turn": "{robot}.turn_number", "never": "{robot}.nothing",
                              "age_s": "{robot}.turn_number.age_s"})
        with seam_sdk.World("one.yaml", seed=3, supervisor=True) as world:
            _, info = env.reset(seed=3)
            turns = [(None, None, False, False, info)]
            while not turns[-1][2]:
                turns.append(env.step(1))
            for number, (_, reward, _, _, info) in enumerate(turns):
                truth = world.truth()
                robot, ball = truth.robots["r0"], truth.ball_m
                self.assertEqual(info["seen"].time_ns, truth.time_ns)
                self.assertAlmostEqual(info["watched"]["distance_m"], np.hypot(ball[0] - robot.x_m, ball[1] - robot.y_m), 12)
                self.assertTrue(np.isnan(info["watched"]["never"]))
                if number > 0:
                    self.assertAlmostEqual(reward, 10 * robot.x_m + info["seen"].time_s, 12)
                    self.assertEqual(info["watched"]["turn"], number)
                    self.assertAlmostEqual(info["watched"]["age_s"], 0.032, 9)
                world.step()
        self.assertEqual(turns[-1][4]["seen"].time_ns, 320_000_000)

    def test_a_log_says_the_same(self):
        expressions = ["truth.r0.pan_rad > 0.2", "truth.r0.ball_distance_m + truth.r0.y_m * 2 < 2.2 && time_s > 0.1", "-r0.reward ^ 2 > -0.09",
                       "abs(atan2(truth.r0.y_m, truth.r0.x_m)) > 2.7 ? r0.reward > 0 : sin(r0.reward) > 0.5", "r0.reward.age_s > 0.02 || 1 / 0"]
        env = self.env(reward="truth.r0.pan_rad", log="run.mcap", watch={str(number): text for number, text in enumerate(expressions)})
        turns = self.play(env, 3)
        for number, text in enumerate(expressions):
            # At the instant of a decision, from which on its reward is in the log.
            held = {turn[4]["seen"].time_ns for turn in turns[1:] if turn[4]["watched"][str(number)] == 1}
            code = 0 if held else 1
            self.seam("replay", "find", "run.mcap", "--when", text, "--json", "found.json", code=code)
            found = (self.here / "found.json").read_text()
            hits = list(zip(*([int(one) for one in re.findall(rf'"{end}_ns": (\d+)', found)] for end in ("begin", "end"))))
            for time_ns in (turn[4]["seen"].time_ns for turn in turns[2:-1]):
                if "reward" in text:  # Before this turn's decision.
                    time_ns -= 1
                inside = any(begin <= time_ns < end for begin, end in hits)
                at = time_ns + ("reward" in text)
                # The log keeps truth each few steps.
                if "truth" not in text or at % 128_000_000 == 0:
                    self.assertEqual(inside, at in held, f"{text} at {at}: {hits}")
            (self.here / "found.json").unlink()

    def test_events_count_since_the_turn_before(self):
        env = self.env(act=[{}, {"kick": seam_sdk.Kick.LEG_FORWARD}], log="kicks.mcap",
                       reward="{robot}.event.kick + 10 * event.goal", watch={"decided": "{robot}.event.decision", "frame": "r0.event.frame"})
        _, info = env.reset(seed=1, options={"set": {"ball.x_m": -0.74, "ball.y_m": 0.45}})  # Before its paws.
        self.assertEqual(info["watched"]["decided"], 0)
        rewards = []
        for action in (0, 1, *[0] * 12):  # The leg hits 0.25 s after the order.
            _, reward, *_, info = env.step(action)
            rewards.append(reward)
            self.assertEqual(info["watched"], {"decided": 1, "frame": 0})
        env.close()
        self.assertEqual((sum(rewards), max(rewards)), (1, 1))
        self.seam("replay", "find", "kicks.mcap", "--when", "r0.event.kick", "--json", "found.json")
        time_ns, = re.findall(r'"begin_ns": (\d+)', (self.here / "found.json").read_text())
        # At the turn behind the event.
        self.assertEqual(rewards.index(1), -(-int(time_ns) // 32_000_000) - 1)

    def test_what_is_watched_at_the_end_is_that_of_the_end(self):
        env = self.env(reward="time_s", watch={"y_m": "truth.{robot}.y_m"}, act={"vy_m_s": (-0.1, 0.1)})
        env.reset(seed=1)
        turns = [env.step(np.ones(1, np.float32)) for _ in range(16)]
        self.assertTrue(turns[-1][3])
        self.assertEqual([round(turns[-2][1], 9), turns[-1][1]], [0.48, 0.5])
        self.assertNotEqual(turns[-1][4]["watched"]["y_m"], turns[-2][4]["watched"]["y_m"])
        self.assertIs(turns[-1][4]["seen"], turns[-2][4]["seen"])

    def test_mistakes_are_named(self):
        for reward, fault in (("truth.r0.pan_deg", "no 'truth.r0.pan_deg' here, did you mean 'truth.r0.pan_rad'"),
                              ("1 +", r"watch.expressions\[0\]: .*Unexpected end of expression"), ("foo(1)", "formula 'foo.1.'"),
                              ("truth.r7.x_m", "no 'truth.r7.x_m' here"), ("battery", "no 'battery' here")):
            with self.assertRaisesRegex(seam_sdk.SeamError, fault):
                self.env(reward=reward)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
