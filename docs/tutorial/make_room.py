#!/usr/bin/env python3
"""Writes room/: what was done in the tutorial's recording, without what was measured (a protocol).

A head swings in a room whose points are known; every 0.2 s the camera takes a frame. Which points a
frame may hold is found with the nominal camera, and a margin; `seam measure` leaves out those that fall
outside the image.
"""
import math
import pathlib

OUT = pathlib.Path(__file__).resolve().parent / "room"
WIDTH, HEIGHT, FX, FY, CX, CY = 178, 144, 161.9, 162.5, 88.5, 71.5
DURATION_S, JOINT_PERIOD_S, FRAME_PERIOD_S, MARGIN_PX = 24.0, 0.008, 0.2, 12


def tilt_rad(t):
    return 0.10 + 0.14 * math.sin(2 * math.pi * 0.37 * t)


def pan_rad(t):
    return 0.85 * math.sin(2 * math.pi * 0.71 * t) + 0.1 * math.sin(2 * math.pi * 0.13 * t)


def room_points():
    """Points on a half circle of walls, at three distances, by a fixed rule."""
    for i in range(64):
        azimuth = -1.55 + 3.1 * ((i * 0.618034) % 1.0)
        distance = 1.1 + 1.3 * ((i * 0.754878) % 1.0)
        height = -0.25 + 0.85 * ((i * 0.569840) % 1.0)
        yield i, distance * math.cos(azimuth), distance * math.sin(azimuth), height


def seen(point, t):
    """Where the nominal camera at rest would see it: the chain of measurement.yaml, link by link."""
    x, y, z = point[0], point[1], point[2] - 0.195
    tilt, pan = tilt_rad(t), pan_rad(t)
    x, z = x * math.cos(tilt) - z * math.sin(tilt), x * math.sin(tilt) + z * math.cos(tilt)
    z -= 0.048
    x, y = x * math.cos(pan) + y * math.sin(pan), -x * math.sin(pan) + y * math.cos(pan)
    x -= 0.0666
    if x < 0.1:
        return None
    return FX * -y / x + CX, FY * -z / x + CY


def main():
    OUT.mkdir(exist_ok=True)
    with open(OUT / "joints.csv", "w", encoding="utf-8") as file:
        file.write("time_s,tilt_rad,pan_rad\n")
        for i in range(round(DURATION_S / JOINT_PERIOD_S) + 1):
            t = i * JOINT_PERIOD_S
            file.write(f"{t:.3f},{tilt_rad(t):.6f},{pan_rad(t):.6f}\n")
    with open(OUT / "points.csv", "w", encoding="utf-8") as file:
        file.write("frame,time_s,point,x_m,y_m,z_m\n")
        for frame in range(1, round(DURATION_S / FRAME_PERIOD_S) - 1):
            t = frame * FRAME_PERIOD_S
            for i, *point in room_points():
                at = seen(point, t)
                if at and -MARGIN_PX < at[0] < WIDTH + MARGIN_PX and -MARGIN_PX < at[1] < HEIGHT + MARGIN_PX:
                    file.write(f"{frame},{t:.2f},{i}," + ",".join(f"{c:.4f}" for c in point) + "\n")


if __name__ == "__main__":
    main()
