"""Swings the head from side to side at a constant rate and asks for every frame: what head_swing.main.cc does, decision
for decision.

Usage: head_swing.py [--rate DEG_PER_S] [--amplitude DEG] [--no-frames]
"""
import argparse
import math
import sys

from seam_sdk import Robot, SeamError


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rate", type=float, default=300, help="deg/s")
    parser.add_argument("--amplitude", type=float, default=45, help="deg")
    parser.add_argument("--no-frames", action="store_true")
    options, _ = parser.parse_known_args()  # The rest is the connection's.
    rate_rad_s = options.rate * (math.pi / 180)
    amplitude_rad = options.amplitude * (math.pi / 180)

    robot = Robot()
    if not options.no_frames:
        robot.request_all_frames()
    for seen in robot.observations():
        # A triangle wave: from one end to the other takes `sweep_s`.
        sweep_s = 2 * amplitude_rad / rate_rad_s
        sweeps = seen.time_s / sweep_s + 0.5
        leftwards = math.floor(sweeps) % 2 == 0
        robot.head(pan_rad=amplitude_rad if leftwards else -amplitude_rad, max_speed_rad_s=rate_rad_s)
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except SeamError as error:
        sys.exit(str(error))
