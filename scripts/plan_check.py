#!/usr/bin/env python3
"""Compares `seam plan` with made sets: scripts/plan_check.py SEAM --out FOLDER [--sets N] [--scatter N] [--only CASE].

For each case: the plan's standard error against the scatter of estimates (`seam add` on made sets), and the smallest size that
is found with 95 % against the size that `seam diagnose` finds in 95 of 100 made sets: a normal curve through the shares found at
three sizes, by highest likelihood. Writes FOLDER/errors.csv and FOLDER/sizes.csv for scripts/evidence.py --record plan.
"""
import argparse
import concurrent.futures
import csv
import json
import math
import pathlib
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
SIZES = (0.75, 0.95, 1.2)  # Of the planned size.
# One sigma above which a normal variable lies in 5 % of cases.
SIGMAS_95 = 1.6449


def wave(t, parts):
    return sum(a * math.sin(w * t + p) for a, w, p in parts)


def servo(folder):
    """Five runs of a servo that follows a swing."""
    rows = [f"{run},{0.01 * i:.2f},pan,{wave(0.01 * i, [(0.5, 3 + run, 0.3 * run), (0.2, 11, run)]):.6f}"
            for run in range(10) for i in range(60)]
    (folder / "joints.csv").write_text("run,time_s,joint,command_rad\n" + "\n".join(rows) + "\n")
    (folder / "measurement.yaml").write_text("format: seam-measurement/1\nkind: joints\ntitle: A servo\nnoise: {measured_rad: 0.002}\n"
                                             "group: run\nfiles: {joints: joints.csv}\n")
    return "  ideal_servo: {}\n"


def walk(folder):
    """Walks in arcs, seen from above."""
    rows = []
    for run in range(12):
        for i in range(25):
            turn = 0.8 * math.sin(0.5 * i + run)
            rows.append(f"{run},{0.2 * i:.2f},{0.2 + 0.1 * math.sin(run):.4f},{0.05 * math.cos(run):.4f},{turn:.4f}")
    (folder / "odometry.csv").write_text("run,time_s,vx_cmd_mps,vy_cmd_mps,omega_cmd_radps\n" + "\n".join(rows) + "\n")
    (folder / "measurement.yaml").write_text("format: seam-measurement/1\nkind: odometry\ntitle: Walks\n"
                                             "noise: {x_m: 0.005, y_m: 0.005, theta_rad: 0.01}\ngroup: run\nfiles: {odometry: odometry.csv}\n")
    return "  ideal_odometry: {}\n"


def landmarks(folder):
    """A robot that walks in circles among six landmarks."""
    places = [(1.5, 0.2), (0.3, 1.4), (-1.2, 0.9), (-1.4, -0.8), (0.2, -1.5), (1.3, -1.1)]
    (folder / "landmarks.csv").write_text("landmark,x_m,y_m\n" + "".join(f"l{i},{x},{y}\n" for i, (x, y) in enumerate(places)))
    poses, seen = [], []
    for run in range(12):
        for i in range(61):
            t, at = 0.1 * i, 20 * run + 0.1 * i
            poses.append(f"{run},{at:.3f},{0.6 * math.cos(t + run):.5f},{0.5 * math.sin(t + run):.5f},{t + run + 1.57:.5f}")
        for i in range(8):
            for k in range(6):
                seen.append(f"{run},{20 * run + 0.4 + 0.65 * i:.3f},l{k}")
    (folder / "poses.csv").write_text("run,time_s,x_m,y_m,theta_rad\n" + "\n".join(poses) + "\n")
    (folder / "observations.csv").write_text("run,time_s,landmark\n" + "\n".join(seen) + "\n")
    (folder / "measurement.yaml").write_text(
        "format: seam-measurement/1\nkind: landmarks\ntitle: Landmarks\nnoise: {range_m: 0.03, bearing_rad: 0.01}\ngroup: run\n"
        "files: {observations: observations.csv, landmarks: landmarks.csv, poses: poses.csv}\n")
    return "  ideal_detector: {}\n"


def room(folder):
    """A third of the tutorial's room, before a head that swings."""
    source = ROOT / "docs/tutorial/room"
    lines = (source / "points.csv").read_text().splitlines(keepends=True)
    (folder / "points.csv").write_text("".join(lines[:1 + len(lines) // 3]))
    for name in ("joints.csv", "measurement.yaml"):
        (folder / name).write_bytes((source / name).read_bytes())
    return "  pinhole: {fx_px: 161.9, fy_px: 162.5, cx_px: 88.5, cy_px: 71.5}\n"


def flats(folder):
    """Flat fields of seven levels, eight frames each."""
    levels = (0, 0.1, 0.2, 0.35, 0.5, 0.7, 0.85)
    rows = [f"{i},{i}.png,{0.04 * i:.2f},0.005,{levels[i % len(levels)]}" for i in range(8 * len(levels))]
    (folder / "frames.csv").write_text("frame,file,time_s,exposure_s,illumination\n" + "\n".join(rows) + "\n")
    (folder / "measurement.yaml").write_text(
        "format: seam-measurement/1\nkind: photometry\ntitle: Flats\ncamera: {width_px: 32, height_px: 24, channels: grey, bits: 12}\n"
        "group: frame\nfiles: {frames: frames.csv}\n")
    return ("  linear_response: {gain_dn: {value: 4000, free: true}, black_dn: {value: 100, free: true}}\n"
            "  read_noise: {sigma_dn: {value: 3, free: true}}\n  shot_noise: {electrons_per_dn: {value: 2, free: true}}\n")


CASES = {"latency": (room, "frame_latency", "latency_s"), "rows": (room, "rolling_shutter", "line_delay_s"),
         "servo": (servo, "encoder_scale", None), "walk": (walk, "heading_drift", "rad_per_m"),
         "range": (landmarks, "range_scale", "scale"), "noise": (landmarks, "bearing_noise", "sigma_rad"),
         "light": (flats, "uneven_lighting", "gx")}


class Case:
    def __init__(self, seam, folder, name):
        make, self.effect, self.parameter = CASES[name]
        self.seam, self.folder = seam, folder
        self.protocol = folder / "protocol"
        self.protocol.mkdir(parents=True)
        self.base = make(self.protocol)
        self.model = self.write("nominal.yaml", "")
        plan = self.run("plan", "--model", self.model, "--protocol", self.protocol, "--effects", self.effect, json_to="plan.json")
        planned = next(e for e in plan["effects"] if e["effect"] == self.effect)
        self.parameter = self.parameter or next(iter(planned["parameters"]))
        self.sigma = planned["parameters"][self.parameter]["sigma"]
        self.size = planned["smallest_found"][self.parameter]
        self.kind = plan["kind"]

    def write(self, name, more):
        path = self.folder / name
        path.write_text("format: seam-model/1\nname: made\neffects:\n" + self.base + more)
        return path

    def run(self, *arguments, json_to=None):
        line = [self.seam, *map(str, arguments)] + (["--json", str(self.folder / json_to)] if json_to else [])
        done = subprocess.run(line, capture_output=True, text=True, stdin=subprocess.DEVNULL)
        if done.returncode != 0:
            raise SystemExit(f"{' '.join(map(str, line))}: {done.stdout}{done.stderr}")
        return json.loads((self.folder / json_to).read_text()) if json_to else None

    def made(self, size, seed):
        truth = self.write(f"truth-{seed}.yaml", f"  {self.effect}: {{{self.parameter}: {size!r}}}\n")
        data = self.folder / f"set-{seed}"
        self.run("measure", "--model", truth, "--protocol", self.protocol, "--seed", seed, "--out", data, "--force")
        return data

    def estimate(self, seed):
        data = self.made(self.size, seed)
        added = self.run("add", self.effect, "--model", self.model, "--data", data, "--out", self.folder / f"added-{seed}.yaml",
                         json_to=f"added-{seed}.json")
        return added["parameters"][self.parameter]["value"]

    def is_found(self, size, seed):
        found = self.run("diagnose", "--model", self.model, "--data", self.made(size, seed), json_to=f"found-{seed}.json")
        best = [c for c in found["candidates"][:1] if c["significant"]]
        return bool(best) and self.effect in [best[0]["effect"], *best[0]["indistinguishable_from"]]


def normal_share(x):
    return min(1 - 1e-9, max(1e-9, 0.5 * math.erfc(-x / math.sqrt(2))))


def size_of_95(counts):
    """The size with 95 %, of the likeliest normal curve; counts: size, found, sets. Sizes are in planned ones."""
    best = None
    for middle in (0.3 + 0.005 * i for i in range(240)):
        for width in (0.08 + 0.01 * i for i in range(40)):
            likelihood = 0
            for size, found, sets in counts:
                p = normal_share((size - middle) / width)
                likelihood += found * math.log(p) + (sets - found) * math.log(1 - p)
            if best is None or likelihood > best[0]:
                best = (likelihood, middle + SIGMAS_95 * width)
    return best[1]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("seam", type=pathlib.Path)
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--sets", type=int, default=60, help="made sets at each size")
    parser.add_argument("--scatter", type=int, default=200, help="made sets whose estimates scatter")
    parser.add_argument("--only", choices=CASES, action="append")
    parser.add_argument("--jobs", type=int, default=2)
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    errors, sizes = [], []
    for name in given.only or CASES:
        with tempfile.TemporaryDirectory() as folder, concurrent.futures.ThreadPoolExecutor(given.jobs) as pool:
            case = Case(given.seam.resolve(), pathlib.Path(folder), name)
            values = list(pool.map(case.estimate, range(1, given.scatter + 1)))
            mean = sum(values) / len(values)
            scatter = math.sqrt(sum((v - mean) ** 2 for v in values) / (len(values) - 1))
            errors.append([case.kind, f"`{case.effect}`", f"`{case.parameter}`", f"{case.sigma:.3g}", f"{scatter:.3g}",
                           f"{case.sigma / scatter:.2f} ± {1 / math.sqrt(2 * len(values)):.2f}"])
            print(*errors[-1], flush=True)
            counts = []
            for k, share in enumerate(SIZES):
                seeds = range(1000 * (k + 1), 1000 * (k + 1) + given.sets)
                found = sum(pool.map(lambda seed: case.is_found(share * case.size, seed), seeds))
                counts.append((share, found, given.sets))
            measured = size_of_95(counts)
            sizes.append([case.kind, f"`{case.effect}`", f"{case.size:.3g}", f"{case.size / case.sigma:.1f}",
                          *[f"{found} of {sets}" for _, found, sets in counts], f"{1 / measured:.2f}"])
            print(*sizes[-1], flush=True)
    for path, header, rows in (
            ("errors.csv", ["Kind", "Effect", "Parameter", "Planned standard error", f"Scatter of {given.scatter} estimates", "Ratio"], errors),
            ("sizes.csv", ["Kind", "Effect", "Planned size", "in standard errors", *[f"Found at {share:g} of it" for share in SIZES],
                           "Planned over measured size with 95 %"], sizes)):
        with (given.out / path).open("w", newline="") as file:
            csv.writer(file).writerows([header, *rows])


if __name__ == "__main__":
    main()
