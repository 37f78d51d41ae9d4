#!/usr/bin/env python3
"""Writes the protocols of the workbench's samples beside this script: what was commanded or exposed, without what was
measured. `seam measure` makes the measurements with each sample's robot.yaml.
"""
import math
import pathlib

HERE = pathlib.Path(__file__).resolve().parent


def write(name, header, rows):
    text = "\n".join([header, *(",".join(map(str, row)) for row in rows)]) + "\n"
    (HERE / name).write_text(text, encoding="utf-8")


def servo():
    """Six runs of sines, faster from run to run, with a step in each."""
    for run in range(6):
        for k in range(200):
            t = 0.008 * k
            command = 0.5 * math.sin((2 + run) * t) + (0.3 if k > 60 else 0)
            yield run, f"{t:.3f}", "pan", f"{command:.6f}"


def walk():
    """Eight walks in all directions, each with turns to both sides."""
    for run in range(8):
        for k in range(60):
            turn = 0.4 * math.sin(run + 0.1 * k)
            yield run, f"{0.2 * k:.1f}", f"{0.1 * math.cos(run):.3f}", f"{0.05 * math.sin(2 * run):.3f}", f"{turn:.4f}"


def flats():
    """Each of six light levels four times; level 0 is dark."""
    levels = [0, 0.1, 0.3, 0.5, 0.7, 0.9]
    for k in range(24):
        yield k, f"frames/{k}.png", f"{0.04 * k:.2f}", 0.005, levels[k % len(levels)]


if __name__ == "__main__":
    write("servo/joints.csv", "run,time_s,joint,command_rad", servo())
    write("walk/odometry.csv", "run,time_s,vx_cmd_mps,vy_cmd_mps,omega_cmd_radps", walk())
    write("flats/frames.csv", "frame,file,time_s,exposure_s,illumination", flats())
