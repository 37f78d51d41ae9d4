"""Gymnasium's VectorEnv: the same task in several worlds, which go on side by side."""
from __future__ import annotations

import concurrent.futures
import numbers
import os
from collections.abc import Sequence
from typing import Any

import numpy as np

from .base import AutoresetMode, VectorBase
from .env import Env
from .episode import Episode
from .spaces import batched, stacked
from .task import Task


class VectorEnv(VectorBase):
    """`num_envs` worlds in this process. A world whose episode ended begins the next one at the next step, which leaves its
    action out (Gymnasium's NEXT_STEP).

    log: as of Env, with `{world}` for the world's number beside `{episode}`.
    """
    metadata = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}

    def __init__(self, scenario: str | os.PathLike[str], num_envs: int, *, robot: str | None = None,
                 log: str | os.PathLike[str] | None = None, options: Sequence[str] = (), **task: Any) -> None:
        self.num_envs, self._task = num_envs, Task(**task)
        robots = None if robot is None else [robot]
        sides = None
        self.envs: list[Env] = []
        for world in range(num_envs):
            own_log = None if log is None else os.fspath(log).replace("{world}", str(world))
            episode = Episode(scenario, self._task, robots, own_log, options, sides)
            sides = episode.sides
            self.envs.append(Env(scenario, robot=robot, episode=episode))
        self.single_observation_space, self.single_action_space = self.envs[0].observation_space, self.envs[0].action_space
        self.observation_space = batched(self.single_observation_space, num_envs)
        self.action_space = batched(self.single_action_space, num_envs)
        self._ended = np.zeros(num_envs, bool)  # Whose episodes ended with the last step.
        self._starts = concurrent.futures.ThreadPoolExecutor(max(1, os.cpu_count() or 1))

    def reset(self, *, seed: int | Sequence[int | None] | None = None,
              options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begins an episode in each world. One seed stands for seed, seed + 1, ...; options as of Env."""
        one = int(seed) if isinstance(seed, numbers.Integral) else None
        super().reset(seed=one)
        seeds = [one + i for i in range(self.num_envs)] if one is not None else [None] * self.num_envs if seed is None else seed
        if len(seeds) != self.num_envs:
            raise ValueError(f"seed: expected one, or one for each of {self.num_envs} worlds, found {len(seeds)}")
        self._ended[:] = False
        turns = list(self._starts.map(lambda env, own: env.reset(seed=own, options=options), self.envs, seeds))
        return stacked(self.single_observation_space, [seen for seen, _ in turns]), _gathered([info for _, info in turns])

    def step(self, actions: Any) -> tuple[Any, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        count = len(next(iter(actions.values())) if isinstance(actions, dict) else actions)
        if count != self.num_envs:
            raise ValueError(f"actions: expected {self.num_envs}, one for each world, found {count}")
        decided = {i: env.decided(_part(actions, i)) for i, env in enumerate(self.envs) if not self._ended[i]}
        anew = {i: self._starts.submit(self.envs[i].reset) for i in np.flatnonzero(self._ended)}
        for i, decision in decided.items():
            self.envs[i].begin(decision)
        turns = []
        for i, env in enumerate(self.envs):
            if i in anew:
                seen, info = anew[i].result()
                turns.append((seen, 0.0, False, False, info))
            else:
                turns.append(env.finish())
        seen, rewards, terminated, truncated, infos = zip(*turns)
        terminated, truncated = np.array(terminated), np.array(truncated)
        self._ended = terminated | truncated
        return stacked(self.single_observation_space, seen), np.array(rewards), terminated, truncated, _gathered(infos)

    def close_extras(self, **kwargs: Any) -> None:
        for env in self.envs:
            env.close()
        self._starts.shutdown()


def _part(actions: Any, i: int) -> Any:
    return {name: part[i] for name, part in actions.items()} if isinstance(actions, dict) else actions[i]


def _gathered(infos: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Each world's infos as one, as Gymnasium has them: arrays, and masks of who has the value."""
    gathered: dict[str, Any] = {}
    for name, first in infos[0].items():
        values = [info[name] for info in infos]
        if isinstance(first, dict):
            gathered[name] = _gathered(values)
        elif isinstance(first, float):
            gathered[name] = np.array(values)
        else:
            gathered[name] = np.empty(len(values), object)
            gathered[name][:] = values
        gathered["_" + name] = np.ones(len(values), bool)
    return gathered
