"""What expressions read, by the names that `seam replay find` has for a log:

    time_s                 simulated seconds
    truth.r0.x_m           x_m, y_m, heading_rad, ball_distance_m (on the field), joints such as pan_rad
    truth.ball.x_m         x_m, y_m, z_m
    r0.NAME                what r0's agent logged as a value; holds until the next one
    NAME.age_s             of a logged value: since it came, or since the start
"""
from __future__ import annotations

import difflib
import math
import re
from collections.abc import Iterable, Mapping

import seam_sdk

_AGE = ".age_s"
_HEAD = ("tilt_rad", "pan_rad", "roll_rad")  # Of an ERS-210; of other robots joints are known where they are agents.


def plain_name(name: str) -> str:
    """As expressions write it."""
    return re.sub(r"[^A-Za-z0-9_.]", "_", name)


class Signals:
    """The newest values of the names that are read.

    joints: of each agent, by its name.
    """

    def __init__(self, wanted: Iterable[str], joints: Mapping[str, tuple[str, ...]]) -> None:
        self._joints = {name: [plain_name(f"{joint}_rad") for joint in of_robot] for name, of_robot in joints.items()}
        self._wanted, self._checked = sorted(wanted), False
        self._ages = [name for name in self._wanted if name.endswith(_AGE)]
        self._logged: dict[str, float] = {}
        self._since: dict[str, float] = {}

    def _check(self, known: Iterable[str]) -> None:
        """What is no truth is a value that an agent may still log."""
        self._checked = True
        for name in self._wanted:
            if name in known or any(name.startswith(plain_name(robot) + ".") for robot in self._joints):
                continue
            near = difflib.get_close_matches(name, known, 1)
            raise ValueError(f"no {name!r} here" + (f", did you mean {near[0]!r}?" if near else
                                                    f", expected a value that an agent logs, or one of: {' '.join(known)}"))

    def restart(self) -> None:
        self._logged, self._since = {}, {}

    def log(self, robot: str, time_s: float, values: Mapping[str, float]) -> None:
        for name, value in values.items():
            full = plain_name(f"{robot}.{name}")
            self._logged[full], self._since[full] = value, time_s

    def values(self, time_s: float, truth: seam_sdk.Truth | None) -> dict[str, float]:
        found = {**self._logged, "time_s": time_s}
        for name in self._ages:
            found[name] = time_s - self._since.get(name.removesuffix(_AGE), 0.0)
        if truth is not None:
            self._add_truth(found, truth)
        if not self._checked:
            self._check(found)
        return found

    def _add_truth(self, found: dict[str, float], truth: seam_sdk.Truth) -> None:
        ball_x, ball_y, _ = truth.ball_m
        found.update(zip(("truth.ball.x_m", "truth.ball.y_m", "truth.ball.z_m"), truth.ball_m))
        for name, robot in truth.robots.items():
            own = f"truth.{plain_name(name)}."
            found[own + "x_m"], found[own + "y_m"], found[own + "heading_rad"] = robot.x_m, robot.y_m, robot.heading_rad
            found[own + "ball_distance_m"] = math.hypot(ball_x - robot.x_m, ball_y - robot.y_m)
            for joint, angle_rad in zip(self._joints.get(name, _HEAD), robot.joints_rad):
                found[own + joint] = angle_rad
