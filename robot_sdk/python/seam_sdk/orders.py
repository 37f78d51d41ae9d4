"""What a robot is ordered to do: calls that gather one decision."""
from __future__ import annotations

import dataclasses
import enum
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, TypeVar

from seam.v1 import simulation_pb2 as wire

if TYPE_CHECKING:
    from .robot import Robot

_Self = TypeVar("_Self", bound="Orders")
_NAMED = 1 << 20  # From here on numbers of joints stand for names, of which the robot's numbers are not known yet.


class Kick(enum.IntEnum):
    """GRAB holds a ball between the front legs until a kick or RELEASE."""
    NONE = 0
    LEG_FORWARD = 1
    LEG_LEFT = 2
    LEG_RIGHT = 3
    HEAD_LEFT = 4
    HEAD_RIGHT = 5
    GRAB = 6
    RELEASE = 7


@dataclasses.dataclass(frozen=True)
class JointTarget:
    joint: int | str  # Its name or its place in Robot.joint_names.
    angle_rad: float
    max_speed_rad_s: float = 0.0  # 0: as fast as the servo goes.


class Orders:
    """Orders that are gathered until they are sent; each call returns the object, for more calls."""

    def __init__(self) -> None:
        self._answer = wire.ClientMessage()

    def _joint_number(self, name: str) -> int:
        raise NotImplementedError

    def head(self: _Self, tilt_rad: float = 0.0, pan_rad: float = 0.0, roll_rad: float = 0.0,
             max_speed_rad_s: float = 0.0) -> _Self:
        """Targets of the head's servos; speed 0: as fast as they go."""
        self._answer.decision.head.CopyFrom(
            wire.HeadCommand(tilt_rad=tilt_rad, pan_rad=pan_rad, roll_rad=roll_rad, max_speed_rad_s=max_speed_rad_s))
        return self

    def walk(self: _Self, vx_m_s: float = 0.0, vy_m_s: float = 0.0, omega_rad_s: float = 0.0) -> _Self:
        """Velocity in the body's frame."""
        self._answer.decision.walk.CopyFrom(wire.WalkCommand(vx_m_s=vx_m_s, vy_m_s=vy_m_s, omega_rad_s=omega_rad_s))
        return self

    def stop(self: _Self) -> _Self:
        self.walk()
        return self

    def kick(self: _Self, kind: Kick) -> _Self:
        self._answer.decision.kick = int(kind)
        return self

    def joints(self: _Self, targets: Iterable[JointTarget] | Mapping[str, float], offset_ns: int = 0) -> _Self:
        """Joint targets, this long after the decision acts; several calls make several frames, in ascending order.

        {"pan": 0.2} stands for [JointTarget("pan", 0.2)]. Leg targets replace the gait until the next walk().
        """
        frame = self._answer.decision.joints.add(offset_ns=offset_ns)
        if isinstance(targets, Mapping):
            targets = [JointTarget(name, angle_rad) for name, angle_rad in targets.items()]
        for target in targets:
            joint = self._joint_number(target.joint) if isinstance(target.joint, str) else target.joint
            frame.targets.add(joint=joint, angle_rad=target.angle_rad, max_speed_rad_s=target.max_speed_rad_s)
        return self

    def request_frame(self: _Self, after_ns: int = 0) -> _Self:
        """The next whose stamp is not before this time."""
        self._answer.decision.frame_requests.add(which=wire.FrameRequest.NEXT, after_ns=after_ns)
        return self

    def request_frames(self: _Self, count: int) -> _Self:
        """The next `count`."""
        self._answer.decision.frame_requests.add(which=wire.FrameRequest.NEXT, count=count)
        return self

    def request_all_frames(self: _Self) -> _Self:
        self._answer.decision.frame_requests.add(which=wire.FrameRequest.ALL)
        return self

    def request_no_frames(self: _Self) -> _Self:
        self._answer.decision.frame_requests.add(which=wire.FrameRequest.NONE)
        return self

    def send(self: _Self, payload: bytes) -> _Self:
        """By radio, to team mates."""
        self._answer.decision.messages.append(payload)
        return self

    # ---- For the log and the viewer ----

    def log_value(self: _Self, name: str, value: float) -> _Self:
        self._answer.decision.debug.add(name=name, value=value)
        return self

    def log_text(self: _Self, name: str, text: str) -> _Self:
        self._answer.decision.debug.add(name=name, text=text)
        return self

    def log_drawing(self: _Self, name: str, points: Iterable[tuple[float, float]], in_image: bool = False,
                    frame_index: int | None = None) -> _Self:
        """Points (x, y) on the field (metres, world frame) or (u, v) in the image (pixels), joined by a line.

        A drawing in the image belongs to the newest frame that this robot was sent, or to `frame_index`."""
        drawing = wire.Drawing(in_image=in_image, points=[part for point in points for part in point],
                               frame_index=frame_index)
        self._answer.decision.debug.add(name=name, drawing=drawing)
        return self


class Decision(Orders):
    """The orders of one turn, for World.step: Decision().head(pan_rad=0.5).walk(vx_m_s=0.1)."""

    def __init__(self) -> None:
        super().__init__()
        self._names: list[str] = []  # Of joints, whose numbers are known once it is given to a robot.

    def _joint_number(self, name: str) -> int:
        if name not in self._names:
            self._names.append(name)
        return _NAMED + self._names.index(name)

    def give_to(self, robot: Robot) -> None:
        """Adds these orders to the robot's next decision."""
        orders = wire.Decision()
        orders.CopyFrom(self._answer.decision)
        for frame in orders.joints:
            for target in frame.targets:
                if target.joint >= _NAMED:
                    target.joint = robot.joint(self._names[target.joint - _NAMED])
        robot._answer.decision.MergeFrom(orders)
