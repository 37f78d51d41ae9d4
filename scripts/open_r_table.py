#!/usr/bin/env python3
"""Table 1 of the founding paper by an OPEN-R program (open_r/examples/localization), with and without the lock that a
robot has and the simulator of 2004 had not: images each fifth joint frame of 8 ms.

  scripts/open_r_table.py SEAM STICK [--seeds N] [--parallel N] [--runs FILE] [--csv FILE] [--quick]

STICK is the program's memory stick, as its CMakeLists.txt makes it. `shared` puts each image at a joint frame: camera and
joints have one clock. `own` lets the camera's clock be 0.127 % slow and begin anywhere, so that its images slip through the
8 ms about five times in 30 s. Both see the same poses, seeds and noise. --runs keeps what is done (JSON, one line a run) and
goes on from there; --csv writes the table for scripts/evidence.py. --quick: two poses, 1 s each.
"""
import argparse
import concurrent.futures
import csv
import json
import math
import pathlib
import random
import re
import statistics
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
FRAME_S = 0.008
SLOW_PPM = 1270
POSES = [(x, y, math.radians(t)) for t in (45, -135, -45, 135) for x in (0, 1, 1.75) for y in (0, 0.5, 1)]
MODES = {"shared": "One clock: an image each fifth joint frame", "own": "The camera's own clock"}
FOUND = re.compile(r"Localizer: at (\S+) (\S+) (\S+) from (\S+) (\S+) (\S+) to (\S+) (\S+) (\S+)")


def scenario(stick, duration_s):
    models = ROOT / "models"
    return (f"format: seam-scenario/1\nname: open_r_localization\nduration_s: {duration_s}\nseed: 1\nfield: {models}/field_2002.yaml\n"
            f"ball: {{present: false}}\nrobots:\n  - id: red1\n    team: red\n    pose: {{x_m: 1, y_m: 0.5, theta_rad: 0}}\n"
            f"    body: {models}/robot_ers210.yaml\n    camera: {{model: {models}/ers210.yaml, clock: {{period_s: 0.04}}}}\n"
            f"    behaviour: {{command: [open_r, {stick.resolve()}], clock: {{period_s: {FRAME_S}}}}}\n")


def make_run(seam, stick, duration_s, mode, pose, seed):
    """The estimate at the end, and the interval of the samples."""
    chance = random.Random(f"{pose} {seed}")
    phase_s = FRAME_S * chance.randrange(5) if mode == "shared" else 5 * FRAME_S * chance.random()
    drift_ppm = 0 if mode == "shared" else SLOW_PPM
    changes = {"seed": seed, "robots[0].camera.clock.phase_s": phase_s, "robots[0].camera.clock.drift_ppm": drift_ppm}
    changes |= {f"robots[0].pose.{name}": value for name, value in zip(("x_m", "y_m", "theta_rad"), pose)}
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "run.yaml"
        path.write_text(scenario(stick, duration_s))
        words = [word for name, value in changes.items() for word in ("--set", f"{name}={value}")]
        done = subprocess.run([seam, "run", path, *words], capture_output=True, text=True)
    found = FOUND.search(done.stdout + done.stderr)
    if done.returncode != 0 or not found:
        raise SystemExit(f"{mode} {pose} {seed}: exit code {done.returncode}\n{done.stdout}{done.stderr}")
    values = list(map(float, found.groups()))
    return {"mode": mode, "pose": pose, "seed": seed, "mean": values[:3], "low": values[3:6], "high": values[6:]}


def wrapped(angle):
    return math.remainder(angle, 2 * math.pi)


def row_of(runs):
    """Cells of Table 1 for the runs of a mode."""
    errors = [[1e3 * (r["mean"][0] - r["pose"][0]), 1e3 * (r["mean"][1] - r["pose"][1]),
               math.degrees(wrapped(r["mean"][2] - r["pose"][2]))] for r in runs]
    inside = [[r["low"][i] <= r["pose"][i] <= r["high"][i] if i < 2 else
               wrapped(r["pose"][2] - r["low"][2]) >= 0 <= wrapped(r["high"][2] - r["pose"][2]) for i in range(3)] for r in runs]
    widths = [[(r["high"][i] - r["low"][i]) * (1e3 if i < 2 else math.degrees(1)) for i in range(3)] for r in runs]
    cells = []
    for i, form in enumerate(("{:.0f} mm", "{:.0f} mm", "{:.1f} deg")):
        square = math.sqrt(statistics.fmean(e[i] ** 2 for e in errors))
        cells.append(f"{form.format(square)}, {form.format(statistics.fmean(w[i] for w in widths))}, "
                     f"{statistics.fmean(s[i] for s in inside):.0%}".replace("%", " %"))
    far = [math.hypot(e[0], e[1]) for e in errors]
    cells.append(f"{math.sqrt(statistics.fmean(f * f for f in far)):.0f} mm, largest {max(far):.0f} mm, "
                 f"{statistics.fmean(s[0] and s[1] for s in inside):.0%}".replace("%", " %"))
    return cells, far


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("seam")
    parser.add_argument("stick", type=pathlib.Path)
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--parallel", type=int, default=1)
    parser.add_argument("--runs", type=pathlib.Path)
    parser.add_argument("--csv", type=pathlib.Path)
    parser.add_argument("--quick", action="store_true")
    options = parser.parse_args()
    poses, duration_s = (POSES[:2], 1) if options.quick else (POSES, 30)
    done = {}
    if options.runs and options.runs.exists():
        for line in options.runs.read_text().splitlines():
            run = json.loads(line)
            done[run["mode"], tuple(run["pose"]), run["seed"]] = run
    wanted = [(mode, pose, seed) for seed in range(1, options.seeds + 1) for pose in poses for mode in MODES]
    with concurrent.futures.ThreadPoolExecutor(options.parallel) as pool:
        missing = [key for key in wanted if key not in done]
        for key, run in zip(missing, pool.map(lambda key: make_run(options.seam, options.stick, duration_s, *key), missing)):
            done[key] = run
            if options.runs:
                with options.runs.open("a") as file:
                    file.write(json.dumps(run) + "\n")
    rows, far = [["", "x: error, width, truth inside", "y", "theta", "xy: error, largest, truth inside"]], {}
    for mode, title in MODES.items():
        cells, far[mode] = row_of([done[key] for key in wanted if key[0] == mode])
        rows.append([title, *cells])
    # Seeds of a pose are no experiments of their own: what a place is like, they share.
    each = [a - b for a, b in zip(far["shared"], far["own"])]
    differences = [statistics.fmean(each[i::len(poses)]) for i in range(len(poses))]
    error = 1.96 * statistics.stdev(differences) / math.sqrt(len(differences))
    rows.append(["Paired difference of the distance to the truth, shared less own", "", "", "",
                 f"{statistics.fmean(differences):+.1f} ± {error:.1f} mm (95 %, {len(poses)} poses)"])
    for row in rows:
        print(" | ".join(row))
    if options.csv:
        with options.csv.open("w", newline="") as file:
            csv.writer(file).writerows(rows)


main()
