#!/usr/bin/python3
"""Keeps the ball in the middle of the image. Where the ball is lost, the head turns to the side on which it went."""
import math
import sys

from seam_sdk import Robot, SeamError

FOCAL_PX, GAIN = 162, 0.15


def find_ball(frame):
    """The mean place of the orange pixels (u, v), their number, and the colour in their middle."""
    us = vs = area = 0
    for v in range(0, frame.height_px, 2):
        for u in range(0, frame.width_px, 2):
            red, green, blue = pixel(frame, u, v)
            if red > 60 and red > 2 * green and red > 4 * blue:
                us, vs, area = us + u, vs + v, area + 4
    if area == 0:
        return 0, 0, 0, (0, 0, 0)
    u, v = 4 * us // area, 4 * vs // area
    return u, v, area, pixel(frame, u, v)


def pixel(frame, u, v):
    at = 3 * (v * frame.width_px + u)
    return tuple(frame.rgb[at:at + 3])


def main():
    robot = Robot()
    robot.request_all_frames()
    pan_rad, seen_s, side = 0.0, 0.0, 1
    for seen in robot.observations():
        for frame in seen.frames:
            u, v, area_px, colour = find_ball(frame)
            off_rad = math.atan((frame.width_px / 2 - u) / FOCAL_PX)  # Left is positive.
            side = math.copysign(1, off_rad)
            robot.log_value("ball_area_px", area_px)
            robot.log_value("side", side)
            if area_px >= 8:
                pan_rad += GAIN * off_rad
                seen_s = seen.time_s
                robot.log_drawing("ball", [(u, v)], in_image=True)
                robot.log_text("colour", "{} {} {}".format(*colour))
        if seen.time_s - seen_s > 0.1:
            pan_rad += side * 0.06  # Lost: look where it went.
        pan_rad = min(1.5, max(-1.5, pan_rad))
        robot.head(pan_rad=pan_rad, tilt_rad=-0.15)


if __name__ == "__main__":
    try:
        main()
    except SeamError as error:
        sys.exit(str(error))
