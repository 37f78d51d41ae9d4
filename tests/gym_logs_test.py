#!/usr/bin/env python3
"""Logs of environments for learning are those of `seam run`: verify, diff and what-if work for them; the pages that show it.

Usage: gym_logs_test.py BUILD_DIR SOURCE_DIR [unittest arguments], by the interpreter that has gRPC and numpy.
"""
import os
import re
import subprocess
import sys
import unittest

from gym_worlds import BEHAVIOUR, BUILD, SOURCE, Gym, np, wave
import seam_gym


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

    def test_worlds_side_by_side_and_robots_that_learn_together_write_the_same_logs(self):
        worlds = self.env(kind=seam_gym.VectorEnv, num_envs=2, log="world{world}-{episode}.mcap")
        worlds.reset(seed=7)
        for turn in range(16):
            worlds.step(np.stack([wave(turn)] * 2))
        worlds.close()
        self.play(self.env(log="alone.mcap"), 8)
        self.seam("diff", "world1-0.mcap", "alone.mcap")
        self.seam("diff", "world0-0.mcap", "world1-0.mcap", code=1)
        for number in range(2):
            env = self.env("three.yaml", kind=seam_gym.ParallelEnv, log=f"together{number}.mcap")
            env.reset(seed=3)
            turn = 0
            while env.agents:
                env.step(dict.fromkeys(env.agents, wave(turn)))
                turn += 1
        self.seam("diff", "together0.mcap", "together1.mcap")
        self.seam("replay", "verify", "together0.mcap")
        (self.here / "bot.py").write_text(BEHAVIOUR)
        (self.here / "bot.py").chmod(0o755)
        # It logs no rewards, and decides the same.
        said = self.seam("replay", "whatif", "together0.mcap", "--robot", "r1", "--client", "./bot.py", "--log", "whatif.mcap")
        self.assertNotEqual(said, "")
        self.seam("replay", "verify", "whatif.mcap")

    def test_an_episode_that_was_left_has_a_whole_log(self):
        env = self.env(log="left{episode}.mcap", terminated="time_s > 0.1")
        self.play(env, 7)
        self.play(env, 7, most=2)
        env.close()
        for log in ("left0.mcap", "left1.mcap"):
            self.seam("replay", "verify", log)


class Pages(Gym):
    def run_by_python(self, *words):
        done = subprocess.run([sys.executable, *map(str, words)], capture_output=True, text=True, timeout=300,
                              env=dict(os.environ, PYTHONPATH=os.pathsep.join([str(BUILD / "python"), os.environ.get("PYTHONPATH", "")])))
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def test_the_example_runs(self):
        example = re.search(r"```python\n(import seam_gym\n.*?)```", (SOURCE / "docs/learn.md").read_text(), re.S)[1]
        self.run_by_python("-c", example.replace('"docs/learn/ball.yaml"', '"one.yaml"'))

    def test_the_recipe_plays_and_writes_its_curve(self):
        said = self.run_by_python(SOURCE / "docs/learn/learn.py", "--episodes", "2", "--out", "curve.csv")
        self.assertRegex(said, r"in sight in \d+% of the turns")
        self.assertEqual([line.split(",")[0] for line in (self.here / "curve.csv").read_text().splitlines()], ["episode", "1", "2"])


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
