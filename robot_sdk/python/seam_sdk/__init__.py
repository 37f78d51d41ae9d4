"""Behaviours for SEAM in Python: the wire of proto/seam/v1/simulation.proto, made comfortable.

    from seam_sdk import Robot

    robot = Robot()
    robot.request_all_frames()
    for seen in robot.observations():
        robot.head(pan_rad=0.5 * math.sin(seen.time_s))

Units: metres, radians, seconds; simulated time in integer nanoseconds. Body frame: x forward, y left, z up. Pan turns
left, tilt looks up. Pixel (0, 0) is the centre of the top-left pixel.
"""
import sys

try:
    import google.protobuf  # noqa: F401
    import grpc  # noqa: F401
except ModuleNotFoundError as missing:
    raise ImportError(f"seam_sdk needs the packages protobuf and grpcio, and this Python ({sys.executable}) has no "
                      f"'{missing.name}': use /usr/bin/python3, for which scripts/dependencies.sh installs them") from None

from .observation import Frame, Game, JointAngles, Observation, Odometry, PlayState, RadioMessage, Sensors
from .orders import Decision, JointTarget, Kick
from .robot import Connection, Refusal, Robot, SeamError
from .world import RefusedDecision, RobotTruth, Truth, World

__all__ = ["Connection", "Decision", "Frame", "Game", "JointAngles", "JointTarget", "Kick", "Observation", "Odometry", "PlayState",
           "RadioMessage", "Refusal", "RefusedDecision", "Robot", "RobotTruth", "SeamError", "Sensors", "Truth", "World"]
