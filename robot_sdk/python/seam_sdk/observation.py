"""What a robot gets, as plain values. It gets nothing of other robots, and no ground truth."""
from __future__ import annotations

import dataclasses
import enum
import typing

if typing.TYPE_CHECKING:
    import numpy
    from seam.v1 import simulation_pb2 as wire


@dataclasses.dataclass(frozen=True)
class JointAngles:
    time_ns: int  # When the encoders were read.
    tilt_rad: float
    pan_rad: float
    roll_rad: float
    legs_rad: tuple[float, ...]  # 12: LF, RF, LR, RR, each rotator, elevator, knee.
    # Of each joint in the order of Robot.joint_names, whatever the robot; one that is no ERS-210 has nothing in the
    # fields above. Of a sliding joint m.
    angles_rad: tuple[float, ...] = ()


@dataclasses.dataclass(frozen=True)
class Odometry:
    """Since the start, in the frame of the start; drifts."""
    x_m: float
    y_m: float
    heading_rad: float


@dataclasses.dataclass(frozen=True)
class Sensors:
    joints: JointAngles
    joint_log: tuple[JointAngles, ...]  # All encoder readings since the last observation.
    acceleration_m_s2: tuple[float, float, float]  # In the body's frame, gravity included.
    odometry: Odometry
    paw_contact: tuple[bool, ...]  # Left front, right front, left rear, right rear.
    # In the body's frame; None where the scenario gives this robot no gyroscope (`sensors.gyroscope`).
    angular_velocity_rad_s: tuple[float, float, float] | None = None


@dataclasses.dataclass(frozen=True)
class Frame:
    """A camera image. Row v collected light from row_start_ns[v] to row_end_ns[v]."""
    index: int
    stamp_ns: int
    width_px: int
    height_px: int
    rgb: bytes  # Row-major, interleaved.
    ycrcb: bytes  # The same as Y, Cr, Cb.
    colours: bytes  # The colour detection table's output, bit c for channel c; empty where the robot has no table.
    colours_width_px: int
    colours_height_px: int
    row_start_ns: tuple[int, ...]
    row_end_ns: tuple[int, ...]

    def row_middle_ns(self, v: int) -> int:
        return self.row_start_ns[v] + (self.row_end_ns[v] - self.row_start_ns[v]) // 2

    # As numpy arrays, which share the bytes and so cannot be written to. Without numpy: ImportError.

    def rgb_array(self) -> numpy.ndarray:
        """(height, width, 3), uint8."""
        return _array(self.rgb, (self.height_px, self.width_px, 3))

    def ycrcb_array(self) -> numpy.ndarray:
        """(height, width, 3), uint8."""
        return _array(self.ycrcb, (self.height_px, self.width_px, 3))

    def colours_array(self) -> numpy.ndarray:
        """(height, width), uint8, one bit a colour channel; (0, 0) where the robot has no table."""
        return _array(self.colours, (self.colours_height_px, self.colours_width_px))


def _array(data: bytes, shape: tuple[int, ...]) -> numpy.ndarray:
    import numpy  # Here, so that behaviours which look at no pixel need none.
    return numpy.frombuffer(data, dtype=numpy.uint8).reshape(shape)


@dataclasses.dataclass(frozen=True)
class RadioMessage:
    sender: str  # The team mate's id.
    sent_ns: int
    arrived_ns: int
    payload: bytes


class PlayState(enum.IntEnum):
    INITIAL = 0
    READY = 1
    SET = 2
    PLAYING = 3
    FINISHED = 4


@dataclasses.dataclass(frozen=True)
class Game:
    """What the referee tells everybody."""
    state: PlayState
    first_half: bool
    kick_off_team: str
    own_score: int
    opponent_score: int
    remaining_ns: int  # Of this half.
    penalty: int  # This robot's; 0: none.
    penalty_remaining_ns: int


@dataclasses.dataclass(frozen=True)
class Observation:
    sequence: int
    time_ns: int
    sensors: Sensors
    frames: tuple[Frame, ...]  # Finished since the last observation, in order of time.
    messages: tuple[RadioMessage, ...]  # From team mates, in order of arrival.
    game: Game

    @property
    def time_s(self) -> float:
        return self.time_ns * 1e-9


def _joints(message: wire.JointAngles) -> JointAngles:
    angles_rad = tuple(message.angles_rad)
    if message.legs_rad:
        angles_rad = (message.tilt_rad, message.pan_rad, message.roll_rad, *message.legs_rad)
    return JointAngles(message.time_ns, message.tilt_rad, message.pan_rad, message.roll_rad, tuple(message.legs_rad),
                       angles_rad)


def _vector(message: wire.Vector3) -> tuple[float, float, float]:
    return message.x, message.y, message.z


def _sensors(message: wire.Sensors) -> Sensors:
    odometry = message.odometry
    return Sensors(
        joints=_joints(message.joints),
        joint_log=tuple(map(_joints, message.joint_log)),
        acceleration_m_s2=_vector(message.acceleration_m_s2),
        odometry=Odometry(odometry.x_m, odometry.y_m, odometry.heading_rad),
        paw_contact=tuple(message.paw_contact),
        angular_velocity_rad_s=_vector(message.angular_velocity_rad_s) if message.HasField("angular_velocity_rad_s") else None)


def _frame(message: wire.Frame) -> Frame:
    return Frame(
        index=message.index, stamp_ns=message.stamp_ns, width_px=message.width_px, height_px=message.height_px,
        rgb=message.rgb, ycrcb=message.ycrcb, colours=message.colours, colours_width_px=message.colours_width_px,
        colours_height_px=message.colours_height_px, row_start_ns=tuple(message.row_start_ns),
        row_end_ns=tuple(message.row_end_ns))


def _game(message: wire.GameState) -> Game:
    return Game(
        state=PlayState(message.state), first_half=message.first_half, kick_off_team=message.kick_off_team,
        own_score=message.own_score, opponent_score=message.opponent_score, remaining_ns=message.remaining_ns,
        penalty=message.penalty, penalty_remaining_ns=message.penalty_remaining_ns)


def from_wire(message: wire.Observation) -> Observation:
    return Observation(
        sequence=message.sequence, time_ns=message.time_ns, sensors=_sensors(message.sensors),
        frames=tuple(map(_frame, message.frames)),
        messages=tuple(RadioMessage(getattr(radio, "from"), radio.sent_ns, radio.arrived_ns, radio.payload)
                       for radio in message.messages),
        game=_game(message.game))
