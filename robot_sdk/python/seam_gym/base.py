"""What environments inherit: Gymnasium's and PettingZoo's classes where they are installed, else the few lines of them
that are used here.
"""
from __future__ import annotations

import numbers
from collections.abc import Mapping
from typing import Any

import numpy as np

try:
    import gymnasium
    from gymnasium.vector import AutoresetMode

    EnvBase, VectorBase = gymnasium.Env, gymnasium.vector.VectorEnv
except ImportError:

    class AutoresetMode:
        """When a world that ended begins anew, as Gymnasium calls it."""
        NEXT_STEP = "NextStep"

    class _Seeded:
        metadata: dict[str, Any] = {}
        render_mode = None
        spec = None
        _np_random: np.random.Generator | None = None

        @property
        def np_random(self) -> np.random.Generator:
            if self._np_random is None:
                self._np_random = np.random.default_rng()
            return self._np_random

        @property
        def unwrapped(self) -> Any:
            return self

        def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> Any:
            if seed is not None:
                self._np_random = np.random.default_rng(seed)

        def __enter__(self) -> Any:
            return self

        def __exit__(self, *error: Any) -> None:
            self.close()

    class EnvBase(_Seeded):
        """An environment of one robot."""

    class VectorBase(_Seeded):
        """Environments side by side."""
        closed = False

        def close(self, **kwargs: Any) -> None:
            if not self.closed:
                self.close_extras(**kwargs)
                self.closed = True

try:
    from pettingzoo import ParallelEnv as ParallelBase
except ImportError:

    class ParallelBase:
        """An environment of several robots."""
        metadata: dict[str, Any] = {}

        @property
        def unwrapped(self) -> Any:
            return self

        @property
        def num_agents(self) -> int:
            return len(self.agents)

        @property
        def max_num_agents(self) -> int:
            return len(self.possible_agents)


_MOST_SEED = (1 << 63) - 1


def check_seed(seed: int | None) -> None:
    if seed is not None and not (isinstance(seed, numbers.Integral) and 0 <= seed <= _MOST_SEED):
        raise ValueError(f"seed: found {seed!r}, expected a whole number from 0 to {_MOST_SEED}")


def world_seed(random: np.random.Generator, seed: int | None) -> int:
    """The seed of an episode: the one that was given, else the next of this source."""
    return int(random.integers(1 << 31) if seed is None else seed)


def changes_of(options: dict[str, Any] | None) -> dict[str, Any]:
    """Keys of the scenario that `reset(options={"set": {...}})` changes for one episode."""
    changes = {} if options is None else options.get("set", {}) if isinstance(options, Mapping) else None
    if not isinstance(changes, Mapping):
        raise ValueError(f"options: found {options!r}, expected such as {{'set': {{'robots[0].pose.x_m': 0.3}}}}")
    return dict(changes)
