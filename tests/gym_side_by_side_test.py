#!/usr/bin/env python3
"""Several worlds, and several robots in one: Gymnasium's VectorEnv and PettingZoo's ParallelEnv.

Usage: gym_side_by_side_test.py BUILD_DIR SOURCE_DIR [unittest arguments], by the interpreter that has gRPC and numpy. Where PettingZoo can be
imported its own checkers run, too; the checks of ours run with and without it.
"""
import sys
import unittest
import warnings

from gym_worlds import HAS_PETTINGZOO, Gym, same, wave, np
import seam_gym
import seam_sdk


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

    def test_what_a_vector_refuses(self):
        worlds = self.env(kind=seam_gym.VectorEnv, num_envs=2)
        with self.assertRaisesRegex(ValueError, "seed: expected one, or one for each of 2 worlds, found 1"):
            worlds.reset(seed=[3])
        worlds.reset(seed=[np.int64(3), None])
        worlds.reset(seed=np.uint32(3))
        for count in (1, 3):
            with self.assertRaisesRegex(ValueError, f"actions: expected 2, one for each world, found {count}"):
                worlds.step(np.stack([wave(0)] * count))
        # No world is left in the middle of a step by the action of another.
        with self.assertRaisesRegex(ValueError, "action: expected numbers of shape"):
            worlds.step([wave(0), wave(0)[:1]])
        self.assertEqual([one.time_ns for one in worlds.step(np.stack([wave(0)] * 2))[4]["seen"]], [32_000_000] * 2)
        worlds.close()
        worlds.close()

    def test_an_error_of_a_reward_leaves_no_world_behind(self):
        calls = []

        def reward(seen, truth):
            calls.append(seen.time_ns)
            if len(calls) == 3:  # Of the first world, at the first step.
                raise ZeroDivisionError("mine")
            return 0.0

        worlds = self.env(kind=seam_gym.VectorEnv, num_envs=2, reward=reward)
        worlds.reset(seed=3)
        actions = np.stack([wave(0)] * 2)
        with self.assertRaisesRegex(ZeroDivisionError, "mine"):
            worlds.step(actions)
        self.assertEqual(calls, [0, 0, 32_000_000, 32_000_000])
        with self.assertRaisesRegex(seam_sdk.SeamError, "no episode: reset begins one"):
            worlds.step(actions)
        worlds.reset(seed=3)
        self.assertEqual([one.time_ns for one in worlds.step(actions)[4]["seen"]], [32_000_000] * 2)

    def test_seeds_beyond_those_of_a_scenario_are_refused(self):
        for kind, arguments in ((seam_gym.Env, {}), (seam_gym.VectorEnv, {"num_envs": 2}), (seam_gym.ParallelEnv, {})):
            env = self.env(kind=kind, **arguments)
            for wrong in (-1, 1 << 63):
                with self.assertRaisesRegex(ValueError, f"seed: found {wrong}, expected a whole number from 0 to {(1 << 63) - 1}"):
                    env.reset(seed=wrong)
        env.reset(seed=(1 << 63) - 1)

    def test_a_wrong_argument_is_named(self):
        for wrong, said in (({"reward": 3}, "reward: found 3"), ({"terminated": None}, "terminated: found None"), ({"act": {}}, "act: found no order"),
                            ({"act": {"pan": (1,)}}, "act: pan: found .1,., expected a lower and an upper bound"),
                            ({"act": {"pan": 1}}, "act: pan: found 1"), ({"act": []}, "act: found .., expected"), ({"act": "pan"}, "act: found 'pan'"),
                            ({"observe": "joints"}, "observe: found 'joints', expected a list"), ({"options": 3}, "options: found 3"),
                            ({"kind": seam_gym.VectorEnv, "num_envs": 0}, "num_envs: found 0"),
                            ({"kind": seam_gym.ParallelEnv, "robots": []}, "robots: found ..")):
            with self.assertRaisesRegex(ValueError, "^" + said):
                self.env(**wrong)
        env = self.env("three.yaml", kind=seam_gym.ParallelEnv)
        with self.assertRaisesRegex(ValueError, "^options: found 3, expected such as {'set'"):
            env.reset(options=3)
        env.reset(seed=1)
        with self.assertRaisesRegex(ValueError, "^actions: no agent 'zz', expected among: r0 r1 r2"):
            env.step({"zz": wave(0)})

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


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
