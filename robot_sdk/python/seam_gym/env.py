"""Gymnasium's Env: one robot that learns."""
from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

import numpy as np

from .base import EnvBase, changes_of, check_seed, world_seed
from .episode import Episode
from .task import Task


class Env(EnvBase):
    """One robot of a scenario learns; the behaviours of all others are started.

    robot: left out: the scenario's only one. render_mode: "rgb_array" for `render()`, the newest frame.
    The other arguments are those of Task and of Episode.
    """
    metadata = {"render_modes": ["rgb_array"], "render_fps": 25}

    def __init__(self, scenario: str | os.PathLike[str], *, robot: str | None = None, render_mode: str | None = None,
                 log: str | os.PathLike[str] | None = None, options: Sequence[str] = (), episode: Episode | None = None,
                 **task: Any) -> None:
        self.render_mode = render_mode
        self.episode = episode or Episode(scenario, Task(**task), None if robot is None else [robot], log, options)
        if len(self.episode.sides) != 1:
            raise ValueError(f"robot: expected one of {' '.join(self.episode.sides)} (all of them learn in a ParallelEnv)")
        self.robot, side = next(iter(self.episode.sides.items()))
        self.observation_space, self.action_space = side.observation_space, side.action_space

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begins the next episode; options: {"set": {"robots[0].pose.x_m": 0.3}} changes its scenario."""
        check_seed(seed)
        super().reset(seed=seed)
        turn = self.episode.reset(world_seed(self.np_random, seed), changes_of(options))[self.robot]
        return turn.observation, turn.info

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        self.begin(self.decided(action))
        return self.finish()

    def decided(self, action: Any) -> Any:
        """What the action orders: worlds are begun when the actions of all of them are known to be good."""
        return self.episode.decided({self.robot: action})

    def begin(self, decided: Any) -> None:
        """The first half of `step`: worlds that were all begun go on side by side."""
        self.episode.begin(decided)

    def finish(self) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """The second half of `step`."""
        turn = self.episode.finish()[self.robot]
        return turn.observation, turn.reward, turn.ends, self.episode.over, turn.info

    def render(self) -> np.ndarray | None:
        return None if self.render_mode is None else self.episode.picture(self.robot)

    def close(self) -> None:
        self.episode.close()
