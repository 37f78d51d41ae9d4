#!/usr/bin/env python3
"""Environments for learning: the contracts of Gymnasium and PettingZoo, expressions, frames, logs, separation.

Usage: gym_test.py BUILD_DIR SOURCE_DIR [unittest arguments], by the interpreter that has gRPC and numpy. Where Gymnasium and
PettingZoo can be imported their own checkers run, too; the checks of ours run with and without them.
"""
import importlib.util
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest
import warnings

import by_hand

BUILD, SOURCE = by_hand.arguments("build", "source")
sys.path.insert(0, str(BUILD / "python"))
try:
    import numpy as np
except ImportError:
    print("skipped: no numpy")
    sys.exit(77)
if os.environ.get("GYM_TEST_ALONE"):  # As where they are not installed.
    sys.modules["gymnasium"] = sys.modules["pettingzoo"] = None
import seam_gym  # noqa: E402
import seam_sdk  # noqa: E402
from seam_gym.spaces import Box, Dict, Discrete  # noqa: E402

SEAM = BUILD / "seam"
HAS_GYMNASIUM, HAS_PETTINGZOO = (not os.environ.get("GYM_TEST_ALONE") and importlib.util.find_spec(name) is not None
                                 for name in ("gymnasium", "pettingzoo"))
ROBOT = """  - id: ID
    team: red
    pose: {x_m: X, y_m: 0.4, theta_rad: 0.3}
    body: SOURCE/models/robot_ers210.yaml
    camera: {model: SOURCE/models/ers210.yaml, width_px: 44, height_px: 36, clock: {period_s: 0.04}}
    behaviour: {command: [head_swing, --no-frames], clock: {period_s: 0.032, phase_s: PHASE}}
"""
PAN = {"pan": (-1.5, 1.5), "vx_m_s": (-0.1, 0.1)}
# Decides as the environment with PAN does for the actions of `wave`.
BEHAVIOUR = f"""#!{sys.executable}
import math, sys
sys.path.insert(0, {str(BUILD / "python")!r})
import seam_sdk
import numpy as np
robot = seam_sdk.Robot()
for turn, seen in enumerate(robot.observations()):
    pan, walk = (float(np.float32(math.sin(one * (turn + 1)))) for one in (0.3, 0.2))
    robot.walk(vx_m_s=0.1 * walk)
    robot.joints({{"pan": 1.5 * pan}})
"""


def wave(turn):
    return np.sin(np.array([0.3, 0.2]) * (turn + 1)).astype(np.float32)


def scenario(*robots, phase_s=0.0, duration_s=0.5):
    text = f"format: seam-scenario/1\nname: gym\nduration_s: {duration_s}\nseed: 5\nfield: SOURCE/models/field_2002.yaml\nrobots:\n"
    for number, name in enumerate(robots):
        text += ROBOT.replace("ID", name).replace("X", str(0.7 * number - 0.9)).replace("PHASE", str(phase_s * number))
    return text.replace("SOURCE", str(SOURCE))


def same(one, other):
    """Equal to the bit."""
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(same(one[name], other[name]) for name in one)
    if isinstance(one, np.ndarray):
        return one.dtype == other.dtype and np.array_equal(one, other, equal_nan=one.dtype.kind == "f")
    return one == other


class Gym(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.here = pathlib.Path(folder.name)
        (self.here / "one.yaml").write_text(scenario("r0"))
        (self.here / "three.yaml").write_text(scenario("r0", "r1", "r2"))
        (self.here / "apart.yaml").write_text(scenario("r0", "r1", phase_s=0.016))
        before = os.getcwd()
        os.chdir(self.here)
        self.addCleanup(os.chdir, before)

    def env(self, file="one.yaml", kind=seam_gym.Env, **arguments):
        arguments = {"act": PAN, "reward": "-abs(truth.{robot}.pan_rad - 0.5)", **arguments}
        made = kind(file, **arguments)
        self.addCleanup(made.close)
        return made

    def play(self, env, seed, most=1000):
        """The turns of an episode with the actions of `wave`."""
        seen, info = env.reset(seed=seed)
        turns = [(seen, 0.0, False, False, info)]
        while not (turns[-1][2] or turns[-1][3]) and len(turns) <= most:
            turns.append(env.step(wave(len(turns) - 1)))
        return turns

    def seam(self, *words, code=0):
        done = subprocess.run([SEAM, *map(str, words)], capture_output=True, text=True)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done.stdout


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

    def test_formulas_are_those_of_the_program(self):
        from seam_gym.expressions import Expression
        for text, value in (("1 + 2 * 3", 7), ("-2 ^ 2", -4), ("2 ^ 3 ^ 2", 512), ("1 < 2 && 3 < 2", 0), ("0 ? 2 : 1 ? 4 : 5", 4),
                            ("max(1, 2, 3) - min(4, 5)", -1), ("if(1, 2, 3)", 2), ("a.b * 2 - .5e1", 1), ("2 - 1 - 1", 0), ("2 ^ -1", 0.5),
                            ("sign(-3) + round(2.5)", 2), ("2 * pi", 2 * np.pi)):
            self.assertEqual(Expression(text)({"a.b": 3}), value, text)
        self.assertEqual(Expression("-1 / 0")({}), -np.inf)
        for text in ("sqrt(0 - 1)", "0 / 0", "other"):
            self.assertTrue(np.isnan(Expression(text)({})), text)
        for text, fault in (("1 +", "found the end"), ("1 2", "found '2'"), ("a $ b", "found '\\$ b'"), ("foo(1)", "no function 'foo'"),
                            ("abs(1, 2)", "2 arguments, expected 1"), ("(1", "found the end"), ("", "found the end")):
            with self.assertRaisesRegex(ValueError, fault):
                Expression(text)

    def test_mistakes_are_named(self):
        for reward, fault in (("truth.r0.pan_deg", "no 'truth.r0.pan_deg' here, did you mean 'truth.r0.pan_rad'"), ("1 +", "found the end"),
                              ("event.goal", "no 'event.goal' here, expected a value that an agent logs, or one of: time_s")):
            with self.assertRaisesRegex(ValueError, fault):
                self.env(reward=reward).reset()


class Logs(Gym):
    """One way to a robot: a world that learns writes the log that `seam run` writes."""

    def test_a_log_is_verified_compared_and_asked_what_if(self):
        (self.here / "bot.py").write_text(BEHAVIOUR)
        (self.here / "bot.py").chmod(0o755)
        text = (self.here / "one.yaml").read_text()
        (self.here / "one.yaml").write_text(text.replace("[head_swing, --no-frames]", "[./bot.py]"))
        env = self.env(log="gym{episode}.mcap", options=["--json", "gym.json"])
        self.play(env, 8)
        self.play(env, 7)
        env.close()
        self.seam("replay", "verify", "gym0.mcap")
        self.seam("replay", "verify", "gym1.mcap")
        self.seam("run", "one.yaml", "--seed", "7", "--log", "run.mcap", "--json", "run.json")
        fingerprints = [re.search(r'"fingerprint": "(\w+)"', (self.here / file).read_text())[1] for file in ("gym.json", "run.json")]
        self.assertEqual(*fingerprints)
        self.seam("replay", "whatif", "gym1.mcap", "--robot", "r0", "--client", "./bot.py", "--log", "whatif.mcap")
        self.seam("diff", "run.mcap", "whatif.mcap")
        self.seam("diff", "gym0.mcap", "gym1.mcap", code=1)

    def test_an_episode_that_was_left_has_a_whole_log(self):
        env = self.env(log="left{episode}.mcap", terminated="time_s > 0.1")
        self.play(env, 7)
        self.play(env, 7, most=2)
        env.close()
        for log in ("left0.mcap", "left1.mcap"):
            self.seam("replay", "verify", log)


class SideBySide(Gym):
    def test_each_world_is_an_environment_of_its_own(self):
        worlds = self.env(kind=seam_gym.VectorEnv, num_envs=3, observe=["joints", "frame"], watch={"x_m": "truth.{robot}.x_m"})
        seen, infos = worlds.reset(seed=5)
        self.assertEqual((seen["frame"].shape, seen["joints"].shape[0], infos["watched"]["x_m"].shape), ((3, 36, 44, 3), 3, (3,)))
        alone = [self.play(self.env(observe=["joints", "frame"]), 5 + world) for world in range(3)]
        for turn in range(1, 17):
            seen, rewards, terminated, truncated, infos = worlds.step(np.stack([wave(turn - 1)] * 3))
            self.assertIn(seen, worlds.observation_space)
            self.assertEqual(infos["seen"][1].time_ns, alone[1][turn][4]["seen"].time_ns)
            for world in range(3):
                expected, reward, *_ = alone[world][turn]
                self.assertTrue(same({name: part[world] for name, part in seen.items()}, expected))
                self.assertEqual(rewards[world], reward)
        self.assertTrue(truncated.all() and not terminated.any())
        # The next step begins anew, whatever the actions.
        seen, rewards, terminated, truncated, infos = worlds.step(worlds.action_space.sample())
        self.assertEqual([one.time_ns for one in infos["seen"]], [0, 0, 0])
        self.assertFalse(truncated.any() or rewards.any())
        self.assertEqual(worlds.step(worlds.action_space.sample())[4]["seen"][2].time_ns, 32_000_000)

    def test_several_robots_learn_in_one_world(self):
        env = self.env("three.yaml", kind=seam_gym.ParallelEnv, terminated=lambda seen, truth: seen.time_s > 0.2 and abs(seen.sensors.odometry.x_m) < 1e-3)
        runs = []
        for _ in range(2):
            seen, infos = env.reset(seed=3)
            self.assertEqual((env.agents, list(seen), list(infos)), (["r0", "r1", "r2"],) * 3)
            turns = []
            while env.agents:
                living = list(env.agents)
                turns.append(env.step({name: wave(len(turns)) * (name != "r2") for name in env.agents}))
                for part in turns[-1]:
                    self.assertEqual(list(part), living)
                for name in living:
                    self.assertIn(turns[-1][0][name], env.observation_space(name))
                self.assertEqual(env.agents, [name for name in living if not turns[-1][2][name] and not turns[-1][3][name]])
            runs.append(turns)
        self.assertTrue(same(dict(enumerate(runs[0][-1])), dict(enumerate(runs[1][-1]))))
        self.assertEqual(len(runs[0]), 16)
        # r2 stands still and ended early; the others were truncated.
        self.assertEqual((list(runs[0][-1][3].values()), list(runs[0][6][2].values())), ([True, True], [False, False, True]))

    def test_robots_with_clocks_of_their_own_are_refused(self):
        env = self.env("apart.yaml", kind=seam_gym.ParallelEnv)
        with self.assertRaisesRegex(seam_sdk.SeamError, "at 0 s it is the turn of r0 alone, expected all of r0, r1: .*behaviour.clock"):
            env.reset()
        self.play(self.env("apart.yaml", robot="r1"), 3)
        with self.assertRaisesRegex(ValueError, "robot: expected one of r0 r1"):
            self.env("apart.yaml")

    @unittest.skipUnless(HAS_PETTINGZOO, "no pettingzoo")
    def test_pettingzoo_finds_no_fault(self):
        import pettingzoo
        from pettingzoo.test import parallel_api_test, parallel_seed_test
        env = self.env("three.yaml", kind=seam_gym.ParallelEnv, terminated="truth.{robot}.x_m > 0 && time_s > 0.2")
        self.assertIsInstance(env, pettingzoo.ParallelEnv)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            parallel_api_test(env, 40)
            parallel_seed_test(lambda: self.env("three.yaml", kind=seam_gym.ParallelEnv), 40)


class Pages(Gym):
    def run_by_python(self, *words):
        done = subprocess.run([sys.executable, *map(str, words)], capture_output=True, text=True, timeout=300,
                              env=dict(os.environ, PYTHONPATH=os.pathsep.join([str(BUILD / "python"), os.environ.get("PYTHONPATH", "")])))
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def test_the_example_runs(self):
        example = re.search(r"```python\n(import seam_gym\n.*?)```", (SOURCE / "docs/learn.md").read_text(), re.S)[1]
        self.run_by_python("-c", example.replace('"scenario.yaml"', '"one.yaml"'))

    def test_the_recipe_plays_and_writes_its_curve(self):
        said = self.run_by_python(SOURCE / "docs/learn/learn.py", "--episodes", "2", "--out", "curve.csv")
        self.assertRegex(said, r"in sight in \d+% of the turns")
        self.assertEqual([line.split(",")[0] for line in (self.here / "curve.csv").read_text().splitlines()], ["episode", "1", "2"])


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
