#!/usr/bin/env python3
"""How the time of `seam discover` grows with the rows of a set, for each kind.

  scripts/growth.py                                  every kind, 1,000 to 100,000 rows
  scripts/growth.py --kinds joints landmarks --rows 5000 20000 --seam build/seam

Each set is made by `seam measure`. In `one` an effect of the mean is hidden; in `wander` so is one of
spread, a noise that wanders where the kind has one, and both are to be found. Prints a line a set: rows, wall time,
processor time, the most memory, the verdict and what was found. Rows of photometry are values of pixels."""
import argparse
import json
import math
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent


def between(name, index, low, high):
    """A number that is the same in every run, and like a random one."""
    seed = sum((k + 1) * ord(c) for k, c in enumerate(name))
    return low + (high - low) * (0.6180339887498949 * (index + 1) * (1 + seed % 7) + 0.1 * seed) % 1.0 \
        if low == 0 and high == 1 else low + (high - low) * between(name, index, 0, 1)


def write(folder, name, header, rows):
    (folder / name).write_text("\n".join([header, *rows]) + "\n")


def describe(folder, kind, group, files, more=""):
    (folder / "measurement.yaml").write_text(
        f"format: seam-measurement/1\nkind: {kind}\ntitle: Growth of {kind}\n{more}group: {group}\nfiles: {{{files}}}\n")


def points(folder, rows, _):
    """A head that nods and swings before a room: views of about 80 points."""
    views = max(8, round(rows / 80))
    end = 0.3 + 0.041 * views
    write(folder, "joints.csv", "time_s,tilt_rad,pan_rad",
          (f"{0.008 * i:.6f},{0.25 * math.sin(0.0264 * i + 0.4):.7f},"
           f"{0.8 * math.sin(0.0408 * i) + 0.1 * math.sin(0.136 * i):.7f}" for i in range(int(end / 0.008) + 8)))
    room = []
    for k in range(290):
        bearing, away = between("bearing", k, -1.3, 1.3), between("range", k, 0.7, 3)
        room.append(f"{k},{away * math.cos(bearing):.5f},{away * math.sin(bearing):.5f},"
                    f"{0.25 + away * between('height', k, -0.55, 0.55):.5f}")
    write(folder, "points.csv", "frame,time_s,point,x_m,y_m,z_m",
          (f"{view},{0.15 + 0.041 * view:.6f},{place}" for view in range(views) for place in room))
    describe(folder, "points", "frame", "points: points.csv, joints: joints.csv",
             "camera: {width_px: 178, height_px: 144, frame_period_s: 0.041}\nnoise: {u_px: 0.15, v_px: 0.15}\n"
             "rig:\n  chain:\n    - {translate_m: [0, 0, 0.195]}\n    - {joint: tilt, axis: [0, -1, 0]}\n"
             "    - {translate_m: [0, 0, 0.048]}\n    - {joint: pan, axis: [0, 0, 1]}\n"
             "    - {translate_m: [0.0666, 0, 0]}\n")


def joints(folder, rows, groups):
    """Runs of steps, swings and ramps, of 500 rows, or ten where there are few."""
    runs = groups or max(10, rows // 500)
    each = rows // runs

    def command(run, i):
        t = 0.016 * i
        if i < 3:
            return 0
        if run % 3 == 0:
            return between("step", 100 * run + i // 14, -1.2, 1.2)
        if run % 3 == 1:
            return 0.7 * math.sin((2 + 1.5 * (run % 10)) * t)
        return 0.1 * (1 + run % 9) * (2 * abs((0.6 * t) % 1 - 0.5) - 0.5)

    write(folder, "joints.csv", "run,time_s,joint,command_rad",
          (f"{run},{0.016 * i:.6f},pan,{command(run, i):.6f}" for run in range(runs) for i in range(each)))
    describe(folder, "joints", "run", "joints: joints.csv", "noise: {measured_rad: 0.0006}\n")


def odometry(folder, rows, groups):
    """Walks of 200 rows, or ten where there are few."""
    runs = groups or max(10, rows // 200)
    each = rows // runs

    def row(run, i):
        leg = 100 * run + i // 6
        return (f"{run},{0.2 * i:.3f},{between('vx', leg, -0.1, 0.25):.5f},{between('vy', leg, -0.12, 0.12):.5f},"
                f"{between('omega', leg, -1, 1):.5f}")

    write(folder, "odometry.csv", "run,time_s,vx_cmd_mps,vy_cmd_mps,omega_cmd_radps",
          (row(run, i) for run in range(runs) for i in range(each)))
    describe(folder, "odometry", "run", "odometry: odometry.csv",
             "noise: {x_m: 0.002, y_m: 0.002, theta_rad: 0.003}\n")


def landmarks(folder, rows, groups):
    """Walks among six landmarks, three of them seen ten times a second; 600 rows a walk, or ten walks."""
    runs = groups or max(10, rows // 600)
    each = math.ceil(rows / runs / 3)
    write(folder, "landmarks.csv", "landmark,x_m,y_m",
          (f"{k},{2.2 * math.cos(1.05 * k):.4f},{1.6 * math.sin(1.05 * k):.4f}" for k in range(6)))
    poses, seen = [], []
    for run in range(runs):
        for i in range(5 * each + 6):
            t, turn = 0.02 * i, 0.018 * i + run
            poses.append(f"{run},{t:.4f},{0.8 * math.cos(turn):.7f},{0.6 * math.sin(turn + 0.3 * run):.7f},"
                         f"{turn + math.pi / 2 + 0.3 * math.sin(2 * t):.7f}")
        seen += (f"{run},{0.1 * i + 0.05:.4f},{(2 * k + i // 20) % 6}" for i in range(each) for k in range(3))
    write(folder, "poses.csv", "run,time_s,x_m,y_m,theta_rad", poses)
    write(folder, "observations.csv", "run,time_s,landmark", seen)
    describe(folder, "landmarks", "run",
             "observations: observations.csv, landmarks: landmarks.csv, poses: poses.csv",
             "noise: {range_m: 0.03, bearing_rad: 0.006}\n")


def photometry(folder, rows, _):
    """40 flat fields at four levels and two exposures."""
    height = max(4, round(math.sqrt(rows / 40 * 0.75)))
    width = max(4, round(rows / 40 / height))
    frames = [(exposure, light) for exposure in (0.005, 0.01) for light in (0, 0.08, 0.2, 0.4) for _ in range(5)]
    write(folder, "frames.csv", "frame,file,time_s,exposure_s,illumination",
          (f"{k},{k}.png,{0.041 * k:.6f},{exposure},{light}" for k, (exposure, light) in enumerate(frames)))
    describe(folder, "photometry", "frame", "frames: frames.csv",
             f"camera: {{width_px: {width}, height_px: {height}, frame_period_s: 0.041}}\n")


PINHOLE = "pinhole: {fx_px: 161.9, fy_px: 162.5, cx_px: 88.5, cy_px: 71.5}"
RESPONSE = "linear_response: {gain_dn: 220, black_dn: 16}, read_noise: {sigma_dn: 1.4}"
KINDS = {  # What makes the set, the model that is given, what `one` hides, what `wander` hides beside it.
    "points": (points, PINHOLE, "rolling_shutter: {line_delay_s: 2.0e-4}",
               "point_scatter: {fraction: 0.05, sigma_px: 0.8}"),
    "joints": (joints, "ideal_servo: {}", "servo_lag: {tau_s: 0.04}",
               "joint_wander: {sigma_rad: 0.0015, tau_s: 0.4}"),
    "odometry": (odometry, "ideal_odometry: {}", "walk_lag: {tau_s: 0.15}",
                 "walk_noise: {xy_sigma: 0.01, theta_sigma: 0.02}"),
    "landmarks": (landmarks, "ideal_detector: {}", "range_scale: {scale: 0.04}",
                  "heading_wander: {sigma_rad: 0.015, tau_s: 2}"),
    "photometry": (photometry, RESPONSE, "vignetting: {a2: 0.2, a4: 0.05}",
                   "pixel_gain_spread: {sigma: 0.01}"),
}


def model(folder, name, effects):
    path = folder / f"{name}.yaml"
    path.write_text(f"format: seam-model/1\nname: {name}\neffects: {{{effects}}}\n")
    return path


def run_timed(command):
    """Wall and processor time, and the most memory of a command that ends."""
    began = time.monotonic()
    child = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    _, status, used = os.wait4(child.pid, 0)
    wall = time.monotonic() - began
    if status != 0:
        sys.exit(f"{' '.join(map(str, command))}: status {status}")
    return wall, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024


def measure(seam, kind, rows, groups, wander, scratch):
    make, nominal, hidden, beside = KINDS[kind]
    protocol, data = scratch / "protocol", scratch / "data"
    protocol.mkdir()
    make(protocol, rows, groups)
    truth = model(scratch, "truth", ", ".join([nominal, hidden] + ([beside] if wander else [])))
    given = model(scratch, "given", nominal)
    subprocess.run([seam, "measure", "--model", truth, "--protocol", protocol, "--seed", "1", "--out", data],
                   check=True, stdout=subprocess.DEVNULL)
    found = scratch / "found.json"
    wall, cpu, memory = run_timed([seam, "discover", "--model", given, "--data", data, "--json", found,
                                   "--out", scratch / "found.yaml"])
    result = json.loads(found.read_text())
    name = {"joints": "joints.csv", "odometry": "odometry.csv", "landmarks": "observations.csv",
            "points": "points.csv"}.get(kind)
    count = rows if name is None else sum(1 for _ in open(data / name)) - 1
    print(f"{kind:10} {'wander' if wander else 'one':6} {count:9,} {wall:8.1f} {cpu:8.1f} {memory:7.0f}  "
          f"{result['verdict']}: {', '.join(step['effect'] for step in result['steps'])}", flush=True)


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--seam", default=str(ROOT / "build" / "seam"))
    options.add_argument("--kinds", nargs="+", default=list(KINDS), choices=list(KINDS))
    options.add_argument("--rows", nargs="+", type=int, default=[1000, 5000, 20000, 100000])
    options.add_argument("--sets", nargs="+", default=["one", "wander"], choices=["one", "wander"])
    options.add_argument("--groups", type=int, default=0, help="as many runs of servos, walks and landmarks, however long; 0: more with rows")
    options.add_argument("--keep", help="keeps the sets in this folder")
    given = options.parse_args()
    print("kind       set         rows   wall_s    cpu_s      MB  found")
    for kind in given.kinds:
        for which in given.sets:
            for rows in given.rows:
                if given.keep:
                    scratch = pathlib.Path(given.keep) / f"{kind}-{which}-{rows}"
                    shutil.rmtree(scratch, ignore_errors=True)
                    scratch.mkdir(parents=True)
                    measure(given.seam, kind, rows, given.groups, which == "wander", scratch)
                    continue
                with tempfile.TemporaryDirectory() as scratch:
                    measure(given.seam, kind, rows, given.groups, which == "wander", pathlib.Path(scratch))


if __name__ == "__main__":
    main()
