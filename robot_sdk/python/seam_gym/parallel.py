"""PettingZoo's ParallelEnv: several robots of one world that learn together."""
from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from .base import ParallelBase, changes_of, check_seed, world_seed
from .episode import Episode
from .task import Task


class ParallelEnv(ParallelBase):
    """The agents are robots of a scenario, which have the same `behaviour.clock`; left out: all of them.

    A robot whose episode ended with `terminated` stays in the world and goes on as it does. The other arguments are those
    of Task and of Episode.
    """
    metadata = {"name": "seam", "render_modes": ["rgb_array"], "render_fps": 25, "is_parallelizable": True}

    def __init__(self, scenario: str | os.PathLike[str], *, robots: Sequence[str] | None = None, render_mode: str | None = None,
                 log: str | os.PathLike[str] | None = None, options: Sequence[str] = (), **task: Any) -> None:
        self.render_mode = render_mode
        self.episode = Episode(scenario, Task(**task), robots, log, options)
        self.possible_agents = list(self.episode.sides)
        self.agents: list[str] = []  # Those whose episode goes on.
        self._random = np.random.default_rng()

    def observation_space(self, agent: str) -> Any:
        return self.episode.sides[agent].observation_space

    def action_space(self, agent: str) -> Any:
        return self.episode.sides[agent].action_space

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[dict[str, Any], dict[str, Any]]:
        """Begins the next episode; options as of Env."""
        check_seed(seed)
        if seed is not None:
            self._random = np.random.default_rng(seed)
        turns = self.episode.reset(world_seed(self._random, seed), changes_of(options))
        self.agents = list(self.possible_agents)
        return {name: turn.observation for name, turn in turns.items()}, {name: turn.info for name, turn in turns.items()}

    def step(self, actions: Mapping[str, Any]) -> tuple[dict[str, Any], ...]:
        """Observations, rewards, terminations, truncations and infos of the agents whose episode went on."""
        for name in actions:
            if name not in self.possible_agents:
                raise ValueError(f"actions: no agent {name!r}, expected among: {' '.join(self.possible_agents)}")
        self.episode.begin(self.episode.decided({name: action for name, action in actions.items() if name in self.agents}))
        turns = self.episode.finish()
        found = {name: turns[name] for name in self.agents}
        over = self.episode.over
        self.agents = [name for name, turn in found.items() if not turn.ends and not over]
        return ({name: turn.observation for name, turn in found.items()}, {name: turn.reward for name, turn in found.items()},
                {name: turn.ends for name, turn in found.items()}, dict.fromkeys(found, over),
                {name: turn.info for name, turn in found.items()})

    def render(self) -> np.ndarray | None:
        """The agents' newest frames, side by side."""
        if self.render_mode is None:
            return None
        return np.concatenate([self.episode.picture(name) for name in self.possible_agents], 1)

    def close(self) -> None:
        self.episode.close()
