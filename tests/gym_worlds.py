"""Worlds for tests of seam_gym: scenarios, episodes of known actions, what is the same to the bit.

A test that imports it ends with 77, "skipped", where there is no numpy. GYM_TEST_ALONE hides Gymnasium and PettingZoo, as
where they are not installed.
"""
import importlib.util
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import by_hand
import one_robot

BUILD, SOURCE = by_hand.arguments("build", "source")
sys.path.insert(0, str(BUILD / "python"))
try:
    import numpy as np
except ImportError:
    print("skipped: no numpy")
    sys.exit(77)
if os.environ.get("GYM_TEST_ALONE"):
    sys.modules["gymnasium"] = sys.modules["pettingzoo"] = None
import seam_gym  # noqa: E402

SEAM = BUILD / "seam"
HAS_GYMNASIUM, HAS_PETTINGZOO = (not os.environ.get("GYM_TEST_ALONE") and importlib.util.find_spec(name) is not None
                                 for name in ("gymnasium", "pettingzoo"))
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


def scenario(*robots, phase_s=0.0):
    return one_robot.turns_of(SOURCE, "gym", *robots, apart_m=0.7, camera_period_s=0.04, behaviour="command: [head_swing, --no-frames], ",
                              phases_s=[0, phase_s])


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
