"""Gymnasium's VectorEnv: the same task in several worlds, which go on side by side."""
from __future__ import annotations

import concurrent.futures
import numbers
import os
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
import seam_sdk

from .base import AutoresetMode, VectorBase, check_seed
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
        if not isinstance(num_envs, numbers.Integral) or num_envs < 1:
            raise ValueError(f"num_envs: found {num_envs!r}, expected a whole number from 1 on")
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
        self._in_step = False  # All worlds have come equally far.
        self._starts = concurrent.futures.ThreadPoolExecutor(max(1, os.cpu_count() or 1))

    def reset(self, *, seed: int | Sequence[int | None] | None = None,
              options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begins an episode in each world. One seed stands for seed, seed + 1, ...; options as of Env."""
        one = int(seed) if isinstance(seed, numbers.Integral) else None
        seeds = [one + i for i in range(self.num_envs)] if one is not None else [None] * self.num_envs if seed is None else seed
        if len(seeds) != self.num_envs:
            raise ValueError(f"seed: expected one, or one for each of {self.num_envs} worlds, found {len(seeds)}")
        for own in seeds:
            check_seed(own)
        super().reset(seed=one)
        self._ended[:], self._in_step = False, False
        starts = [self._starts.submit(env.reset, seed=own, options=options) for env, own in zip(self.envs, seeds)]
        turns = _all_of(start.result for start in starts)
        self._in_step = True
        return stacked(self.single_observation_space, [seen for seen, _ in turns]), _gathered([info for _, info in turns])

    def step(self, actions: Any) -> tuple[Any, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        count = len(next(iter(actions.values())) if isinstance(actions, dict) else actions)
        if count != self.num_envs:
            raise ValueError(f"actions: expected {self.num_envs}, one for each world, found {count}")
        if not self._in_step:
            raise seam_sdk.SeamError("no episode: reset begins one")
        decided = {i: env.decided(_part(actions, i)) for i, env in enumerate(self.envs) if not self._ended[i]}
        self._in_step = False  # Where one world fails, here or in a function of the task: only reset brings them together again.
        anew = {i: self._starts.submit(self.envs[i].reset) for i in np.flatnonzero(self._ended)}
        try:
            for i, decision in decided.items():
                self.envs[i].begin(decision)
        except Exception:
            concurrent.futures.wait(anew.values())
            raise
        turns = _all_of(anew[i].result if i in anew else env.finish for i, env in enumerate(self.envs))
        turns = [(turn[0], 0.0, False, False, turn[1]) if i in anew else turn for i, turn in enumerate(turns)]
        seen, rewards, terminated, truncated, infos = zip(*turns)
        terminated, truncated = np.array(terminated), np.array(truncated)
        self._ended, self._in_step = terminated | truncated, True
        return stacked(self.single_observation_space, seen), np.array(rewards), terminated, truncated, _gathered(infos)

    def close_extras(self, **kwargs: Any) -> None:
        for env in self.envs:
            env.close()
        self._starts.shutdown()


def _all_of(calls: Iterable[Callable[[], Any]]) -> list[Any]:
    """What all of them give, the first error only after the last of them: no world is left in the middle."""
    results, errors = [], []
    for call in calls:
        try:
            results.append(call())
        except Exception as error:
            errors.append(error)
    if errors:
        raise errors[0]
    return results


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
