"""What a learner senses, does and is rewarded for: the part of an environment that one robot has."""
from __future__ import annotations

import dataclasses
import math
import numbers
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Optional, Union

import numpy as np
import seam_sdk

from .spaces import Box, Dict, Discrete

_WALK = ("vx_m_s", "vy_m_s", "omega_rad_s")
_OF_FRAMES = ("frame", "row_s")


@dataclasses.dataclass(frozen=True)
class Sense:
    """A part of the observation: its name, its space, and what makes it from what the robot senses and its newest frame,
    which is None before the first one. `frames`: whether it reads frames, which the robot then asks for.
    """
    name: str
    space: Any
    read: Callable[[seam_sdk.Observation, Optional[seam_sdk.Frame]], Any]
    frames: bool = True


@dataclasses.dataclass(frozen=True)
class Act:
    """Actions of your own: their space, and what orders they are after what the robot senses."""
    space: Any
    decide: Callable[[Any, seam_sdk.Observation], seam_sdk.Decision]


# A reward or an end: an expression of seam_sdk.World(watch=[...]), or a function of what the robot senses and of where
# everything truly is.
Judged = Union[str, Callable[[seam_sdk.Observation, seam_sdk.Truth], float]]


@dataclasses.dataclass(frozen=True)
class Task:
    """What a robot is to learn; the same for each robot. `{robot}` in an expression is its name.

    observe: names (joints, odometry, acceleration, angular_velocity, paws, time_s, frame, row_s) and Sense objects: a dictionary.
    act: {"pan": (-1.5, 1.5), ...}: numbers from -1 to 1, which are scaled to these bounds; a list of orders such as
         [{}, {"pan": 0.5}, {"kick": Kick.LEG_FORWARD}]: the number of one of them; or an Act. Orders are joints by their
         names, vx_m_s, vy_m_s, omega_rad_s.
    reward, terminated: what a turn is rewarded with, and whether it ends the episode (not 0).
    watch: more expressions by name, whose values info["watched"] has.
    """
    observe: Sequence[str | Sense] = ("joints",)
    act: Mapping[str, tuple[float, float]] | Sequence[Mapping[str, float]] | Act = ({},)
    reward: Judged = "0"
    terminated: Judged = "0"
    watch: Mapping[str, str] = dataclasses.field(default_factory=dict)

    def __post_init__(self) -> None:
        if isinstance(self.observe, str) or not isinstance(self.observe, Iterable):
            raise ValueError(f"observe: found {self.observe!r}, expected a list of senses, such as ['joints']")
        for name in ("reward", "terminated"):
            if not isinstance(one := getattr(self, name), str) and not callable(one):
                raise ValueError(f"{name}: found {one!r}, expected an expression or a function")

    @property
    def expressions(self) -> list[str]:
        """In the order in which `Side.judge` takes their values."""
        return [one for one in (self.reward, self.terminated, *self.watch.values()) if isinstance(one, str)]

    @property
    def calls_functions(self) -> bool:
        """Of truth, which is then asked for at each turn."""
        return callable(self.reward) or callable(self.terminated)

    @property
    def wants_frames(self) -> bool:
        return any(sense.frames if isinstance(sense, Sense) else sense in _OF_FRAMES for sense in self.observe)


class Side:
    """One robot's spaces, and what its turns are in them."""

    def __init__(self, task: Task, robot: seam_sdk.Robot) -> None:
        self._task = task
        self.image_shape = (*reversed(robot.image_size_px), 3)
        known = _senses(robot)
        for name in task.observe:
            if isinstance(name, str) and name not in known:
                raise ValueError(f"observe: no sense {name!r}, expected a Sense or one of: {' '.join(known)}")
        self._senses = [known[sense] if isinstance(sense, str) else sense for sense in task.observe]
        self.observation_space = Dict({sense.name: sense.space for sense in self._senses})
        self._act = _act(task.act, robot)
        self.action_space = self._act.space

    def observation(self, seen: seam_sdk.Observation, frame: seam_sdk.Frame | None) -> dict[str, Any]:
        return {sense.name: sense.read(seen, frame) for sense in self._senses}

    def decision(self, action: Any, seen: seam_sdk.Observation) -> seam_sdk.Decision:
        return self._act.decide(action, seen)

    def judge(self, seen: seam_sdk.Observation, truth: seam_sdk.Truth | None,
              values: Sequence[float]) -> tuple[float, bool, dict[str, float]]:
        """Reward, whether the episode ends, and what is watched, by the values of the task's expressions. What is no number
        counts as 0."""
        rest = iter(values)
        reward, ends = (float(one(seen, truth) if callable(one) else next(rest)) for one in (self._task.reward, self._task.terminated))
        watched = dict(zip(self._task.watch, rest))
        return 0.0 if math.isnan(reward) else reward, ends != 0 and not math.isnan(ends), watched


def _senses(robot: seam_sdk.Robot) -> dict[str, Sense]:
    def measured(name: str, size: int, read: Callable[[seam_sdk.Observation], Any], low: float = -np.inf,
                high: float = np.inf) -> Sense:
        return Sense(name, Box(low, high, (size,), np.float32), lambda seen, _: np.array(read(seen), np.float32))

    width, height = robot.image_size_px
    shape = (height, width, 3)
    senses = [
        measured("joints", len(robot.joint_names), lambda seen: seen.sensors.joints.angles_rad),
        measured("odometry", 3, lambda seen: dataclasses.astuple(seen.sensors.odometry)),
        measured("acceleration", 3, lambda seen: seen.sensors.acceleration_m_s2),
        measured("angular_velocity", 3, _angular_velocity),
        measured("paws", 4, lambda seen: seen.sensors.paw_contact, 0, 1),
        measured("time_s", 1, lambda seen: [seen.time_s], 0),
        Sense("frame", Box(0, 255, shape, np.uint8), lambda _, frame: pixels(frame, shape)),
        Sense("row_s", Box(-np.inf, np.inf, (height, 2), np.float32), lambda seen, frame: _row_times(seen, frame, height)),
    ]
    return {sense.name: sense for sense in senses}


def _angular_velocity(seen: seam_sdk.Observation) -> tuple[float, float, float]:
    if (rate := seen.sensors.angular_velocity_rad_s) is None:
        raise ValueError("observe: found angular_velocity of a robot without a gyroscope, expected `gyroscope: {}` under its "
                         "`sensors` in the scenario")
    return rate


def pixels(frame: seam_sdk.Frame | None, shape: tuple[int, ...]) -> np.ndarray:
    return np.zeros(shape, np.uint8) if frame is None else frame.rgb_array().copy()


def _row_times(seen: seam_sdk.Observation, frame: seam_sdk.Frame | None, height: int) -> np.ndarray:
    """When each row began and ended to collect light, seconds after the observation's time; 0 before the first frame."""
    if frame is None:
        return np.zeros((height, 2), np.float32)
    return ((np.array([frame.row_start_ns, frame.row_end_ns]).T - seen.time_ns) * 1e-9).astype(np.float32)


def _act(given: Any, robot: seam_sdk.Robot) -> Act:
    if isinstance(given, Act):
        return given
    if isinstance(given, Mapping):
        names = list(given)
        _check_names(names, robot)
        low, high = _bounds(given)
        middle, half = (low + high) / 2, (high - low) / 2
        space = Box(-1, 1, (len(names),), np.float32)

        def scaled(action: Any, _: seam_sdk.Observation) -> seam_sdk.Decision:
            # numpy would stretch one number to all of the orders.
            if np.shape(action) != space.shape or not np.all(np.isfinite(action)):
                raise ValueError(f"action: expected numbers of shape {space.shape} for {', '.join(names)}, found {action!r}")
            return _decision(dict(zip(names, (middle + half * np.clip(action, -1, 1)).tolist())))

        return Act(space, scaled)
    if isinstance(given, str) or not isinstance(given, Sequence) or not given or not all(isinstance(one, Mapping) for one in given):
        raise ValueError(f"act: found {given!r}, expected bounds by order, a list of orders, or an Act")
    choices = [dict(choice) for choice in given]
    for choice in choices:
        _check_names([name for name in choice if name != "kick"], robot)
    space = Discrete(len(choices))

    def chosen(action: Any, _: seam_sdk.Observation) -> seam_sdk.Decision:
        if not space.contains(action):
            raise ValueError(f"action: expected a whole number from 0 to {len(choices) - 1}, found {action!r}")
        return _decision(choices[int(action)])

    return Act(space, chosen)


def _bounds(given: Mapping[str, Any]) -> np.ndarray:
    """Rows of lower and of upper bounds."""
    if not given:
        raise ValueError("act: found no order, expected such as {'pan': (-1.5, 1.5)}")
    for name, pair in given.items():
        if np.shape(pair) != (2,) or not all(isinstance(bound, numbers.Real) and math.isfinite(bound) for bound in pair):
            raise ValueError(f"act: {name}: found {pair!r}, expected a lower and an upper bound")
    return np.array(list(given.values()), np.float64).T


def _check_names(names: Sequence[str], robot: seam_sdk.Robot) -> None:
    known = (*_WALK, *robot.joint_names)
    for name in names:
        if name not in known:
            raise ValueError(f"act: no order {name!r}, expected one of: {' '.join(known)}")


def _decision(orders: Mapping[str, float]) -> seam_sdk.Decision:
    decision = seam_sdk.Decision()
    if walk := {name: orders[name] for name in _WALK if name in orders}:
        decision.walk(**walk)
    if "kick" in orders:
        decision.kick(seam_sdk.Kick(int(orders["kick"])))
    if joints := {name: value for name, value in orders.items() if name not in (*_WALK, "kick")}:
        decision.joints(joints)
    return decision
