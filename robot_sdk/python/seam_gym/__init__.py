"""Environments for learning: Gymnasium's Env and VectorEnv, PettingZoo's ParallelEnv, over seam_sdk.World.

    import seam_gym

    env = seam_gym.Env("scenario.yaml", observe=["joints", "frame"], act={"pan": (-1.5, 1.5)},
                       reward="-abs(truth.r0.pan_rad - 0.5)")
    seen, info = env.reset(seed=1)
    seen, reward, terminated, truncated, info = env.step(env.action_space.sample())

Where Gymnasium and PettingZoo are installed the classes inherit from theirs; without them they have the same methods, and
spaces of their own (seam_gym.spaces). numpy is needed in any case.
"""
from .env import Env
from .parallel import ParallelEnv
from .spaces import Box, Dict, Discrete
from .task import Act, Sense, Task
from .vector import VectorEnv

__all__ = ["Act", "Box", "Dict", "Discrete", "Env", "ParallelEnv", "Sense", "Task", "VectorEnv"]
