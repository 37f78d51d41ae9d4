"""Episodes of a world whose robots learn: a step is one turn of all of them."""
from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import seam_sdk

from .task import Side, Task, pixels


class Turn(NamedTuple):
    """An agent's."""
    observation: Any
    reward: float  # Of the step that led to it.
    ends: bool  # Its episode ends here.
    info: dict[str, Any]


class Episode:
    """A world, with robots that learn: the agents.

    agents: left out: all robots of the scenario. The behaviours of the others are started.
    log: where the replay log goes; `{episode}` in it is the episode's number, from 0.
    options: further ones of `seam serve`.
    sides: of another Episode of the same scenario and task; left out: a world is started to learn them.
    """

    def __init__(self, scenario: str | os.PathLike[str], task: Task, agents: Sequence[str] | None = None,
                 log: str | os.PathLike[str] | None = None, options: Sequence[str] = (),
                 sides: Mapping[str, Side] | None = None) -> None:
        if agents is not None and (isinstance(agents, str) or not list(agents)):
            raise ValueError(f"robots: found {agents!r}, expected names of robots; left out: all of them")
        if isinstance(options, str) or not isinstance(options, Sequence):
            raise ValueError(f"options: found {options!r}, expected a list of words, such as ['--set', 'duration_s=2']")
        self._scenario, self._task, self._wanted = scenario, task, agents
        self._log, self._options, self._number = log, options, 0
        self._world: seam_sdk.World | None = None
        if sides is None:
            with self._make_world(None, None, ()) as world:
                sides = {name: Side(task, robot) for name, robot in world.robots.items()}
        self.sides = dict(sides)
        self.over = True  # There are no more turns.
        self._frames: dict[str, seam_sdk.Frame] = {}  # The newest of each agent.
        self._last: dict[str, Turn] = {}  # Of each agent.
        self._first = True  # No turn was answered yet.
        self._truth: seam_sdk.Truth | None = None  # Of the newest turn, where functions are called with it.

    def reset(self, seed: int, changes: Mapping[str, Any]) -> dict[str, Turn]:
        """Begins the next episode.

        changes: values of keys of the scenario for this episode alone, as of `seam run --set`."""
        self.close()
        log = None if self._log is None else os.fspath(self._log).format(episode=self._number)
        options = [word for path, value in changes.items() for word in ("--set", f"{path}={value}")]
        self._world = self._make_world(seed, log, options)
        self._number += 1
        self._frames, self._last, self._first, self.over = {}, {}, True, False
        return self._turns()

    def decided(self, actions: Mapping[str, Any]) -> dict[str, seam_sdk.Decision]:
        """What actions order; an error where one of them is not of its space."""
        if self._world is None:
            raise seam_sdk.SeamError("no episode: reset begins one")
        return {name: self.sides[name].decision(action, self._last[name].info["seen"]) for name, action in actions.items()}

    def begin(self, decisions: dict[str, seam_sdk.Decision]) -> None:
        """The first half of a step, after which other worlds can be begun. Agents without a decision go on as they do."""
        if self._first and self._task.wants_frames:
            for name in self.sides:
                decisions.setdefault(name, seam_sdk.Decision()).request_all_frames()
        if not self._first and self._log is not None:
            for name, turn in self._last.items():
                decisions.setdefault(name, seam_sdk.Decision()).log_value("reward", turn.reward)
        self._first = False
        self._world.answer(decisions)

    def finish(self) -> dict[str, Turn]:
        """The second half of a step."""
        self._world.wait()
        return self._turns()

    @property
    def process(self) -> int:
        """The simulator's."""
        return self._world.process

    def picture(self, agent: str) -> np.ndarray:
        """The newest frame that it was sent; before the first one black."""
        return pixels(self._frames.get(agent), self.sides[agent].image_shape)

    def close(self) -> None:
        """Ends the world; its log is whole."""
        world, self._world, self.over = self._world, None, True
        if world is not None:
            world.close()

    # ---- Parts ----

    def _make_world(self, seed: int | None, log: str | None, options: Sequence[str]) -> seam_sdk.World:
        return seam_sdk.World(self._scenario, seed, robots=self._wanted, supervisor=True, watch=self._task.expressions, log=log,
                              options=[*self._options, *options])

    def _turns(self) -> dict[str, Turn]:
        world = self._world
        if not world.done and world.observations.keys() != self.sides.keys():
            raise seam_sdk.SeamError(
                f"at {world.time_ns * 1e-9:g} s it is the turn of {', '.join(world.observations)} alone, expected all of "
                f"{', '.join(self.sides)}: give robots that learn together one behaviour.clock")
        self.over = world.done
        # At the end robots sense nothing more, as in any run: the observation is that of the last turn, and so is the truth
        # that functions get. Expressions have their values at the end.
        if not world.done and self._task.calls_functions:
            self._truth = world.truth()
        for name, side in self.sides.items():
            seen = self._last[name].info["seen"] if world.done else world.observations[name]
            if seen.frames:
                self._frames[name] = seen.frames[-1]
            reward, ends, watched = side.judge(seen, self._truth, world.watched.get(name, ()))
            self._last[name] = Turn(side.observation(seen, self._frames.get(name)), reward, ends, {"seen": seen, "watched": watched})
        return self._last
