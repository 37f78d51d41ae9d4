#!/usr/bin/env python3
"""Effects hidden in whole runs, found again with the whole simulator (docs/reference/outcomes.md).

A robot that measures a ball's distance stands near it and far from it, swings its head and walks. `seam measure` makes sets
of what it measured, each by a model that lacks nothing but one effect, of a size that changes some number by about five of the
standard errors that the set states; `seam diagnose` is asked which. Runs are kept in OUT/runs, so that sets share those that are equal.

Usage: hidden_outcomes.py SEAM OUT [--only NAME...] [--sigmas 5]
"""
import argparse
import csv
import json
import math
import pathlib
import re
import shutil
import subprocess
import sys
import time


ROOT = pathlib.Path(__file__).resolve().parent.parent

# It walks a little in all runs, so that they scatter by more than what a pixel is.
NOMINAL = """format: seam-model/1
name: nominal
effects:
  pinhole: {fx_px: 161.9, fy_px: 162.5, cx_px: 88.5, cy_px: 71.5}
  read_noise: {sigma_dn: 1.5}
  lens_blur: {sigma_px: 1}
  walk_noise: {xy_sigma: 0.03, theta_sigma: 0.04}
"""
SETTINGS = """effects:
  ball_away:
    stage: scenario
    help: The ball lies farther away than the program assumes.
    parameters: {metres: {VALUEneutral: 0, min: -0.2, max: 0.2, scale: 0.02}}
    set: {"ball.x_m": metres}
"""
PLAN = """format: seam-sweep/1
scenario: scenario.yaml
set: {{duration_s: {duration_s}, "robots[0].behaviour.command": {command}}}
vary:
  - {{draws: 1, seed: {seed}, of: [{{path: "robots[0].pose.x_m", name: x_m, uniform: {x_m}}},
                                  {{path: "robots[0].pose.y_m", name: y_m, uniform: {y_m}}}]}}
seeds: [1, {seeds}]
keep:
  values: [{values}]
  expressions:
{expressions}
"""
SEEN = {"error_m": "distance_m - sqrt(x_m^2 + y_m^2)", "bearing_error_rad": "bearing_rad - atan2(-y_m, -x_m)",
        "area_error_m": "from_area_m - sqrt(x_m^2 + y_m^2)"}
SCENARIOS = {
    "near": {"duration_s": 0.2, "command": ["ball_ranger", "--walk", "0.25", "--from", "0.1"], "x_m": [-0.7, -0.5],
             "y_m": [-0.12, 0.12], "seed": 1, "values": ["distance_m", "bearing_rad", "from_area_m"], "made": SEEN},
    "far": {"duration_s": 0.2, "command": ["ball_ranger", "--walk", "0.25", "--from", "0.1"], "x_m": [-1.1, -0.8],
            "y_m": [-0.25, 0.25], "seed": 2, "values": ["distance_m", "bearing_rad", "from_area_m"], "made": SEEN},
    "swing": {"duration_s": 0.4, "command": ["ball_ranger", "--walk", "0.1", "--from", "0.25", "--rate", "120",
                                             "--amplitude", "12"],
              "x_m": [-0.7, -0.6], "y_m": [-0.05, 0.05], "seed": 3, "values": ["distance_m", "bearing_rad"],
              "statistics": ["min", "max", "mean"], "made": {key: SEEN[key] for key in ("error_m", "bearing_error_rad")}},
    "walk": {"duration_s": 0.7, "command": ["ball_ranger", "--walk", "0.4", "--from", "0.6"], "x_m": [-0.95, -0.85],
             "y_m": [-0.05, 0.05], "seed": 4, "values": ["distance_m", "bearing_rad"],
             "made": {"walked_m": "sqrt(x_m^2 + y_m^2) - distance_m", "aside_m": "bearing_rad * distance_m + y_m"}},
}
SEEDS = 4
# What numbers are read off with besides: a tape, and a protractor.
READ_TO = {"m": 2e-3, "rad": 3e-3}
# What the sets list as candidates; the ball's place stands beside them, as a setting of the scenario.
CANDIDATES = """
  focal_length_error: {fy_scale: [-0.2, 0.2]}
  mount_misalignment: {pitch_rad: [-0.15, 0.15]}
  mount_offset: {z_m: [-0.08, 0.08]}
  response_gamma: {gamma: [0.5, 2]}
  veiling_glare: {fraction: [0, 0.5]}
  frame_latency: {latency_s: [-0.1, 0.1]}
  servo_lag:
  encoder_offset: {pan_rad: [-0.15, 0.15]}
  encoder_scale: {pan_scale: [-0.3, 0.3]}
  odometry_scale: {vx_scale: [-0.6, 0.6]}
  heading_drift:
"""
# Effect, parameter and a size to begin with; the size is changed until some number is changed by `--sigmas` errors.
HIDDEN = [
    ("focal_length_error", "fy_scale", 0.04), ("focal_length_error", "fy_scale", -0.04),
    ("mount_misalignment", "pitch_rad", 0.02), ("mount_misalignment", "pitch_rad", -0.02), ("mount_offset", "z_m", 0.01),
    ("mount_offset", "z_m", -0.01), ("response_gamma", "gamma", 1.3), ("response_gamma", "gamma", 0.8),
    ("veiling_glare", "fraction", 0.1), ("frame_latency", "latency_s", 0.03), ("frame_latency", "latency_s", -0.005),
    ("servo_lag", "tau_s", 0.03), ("encoder_offset", "pan_rad", 0.02), ("encoder_offset", "pan_rad", -0.02),
    ("encoder_scale", "pan_scale", 0.05), ("odometry_scale", "vx_scale", 0.15), ("odometry_scale", "vx_scale", -0.15),
    ("heading_drift", "rad_per_m", 0.5), ("ball_away", "metres", 0.03), ("ball_away", "metres", -0.03)]
NOTHING = 4


def plan(settings):
    values = list(settings["values"])
    for statistic in settings.get("statistics", []):
        values.append(f"{{name: pan_rad, statistic: {statistic}, as: {statistic}_pan_rad}}")
    expressions = "\n".join(f"    {name}: {text}" for name, text in settings["made"].items())
    return PLAN.format(duration_s=settings["duration_s"], command=json.dumps(settings["command"]),
                       seed=settings["seed"], x_m=settings["x_m"], y_m=settings["y_m"], seeds=SEEDS,
                       values=", ".join(values), expressions=expressions)


def numbers_of(name):
    """What a scenario of the set keeps."""
    return list(SCENARIOS[name]["made"]) + [f"{s}_pan_rad" for s in SCENARIOS[name].get("statistics", [])]


def write_protocol(folder):
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    rows = ["scenario,value,statistic,measured,sigma,reading_sigma"]
    for name, settings in SCENARIOS.items():
        (folder / f"{name}.yaml").write_text(plan(settings))
        rows += [f"{name},{value},mean,,,{READ_TO['rad' if value.endswith('_rad') else 'm']}" for value in numbers_of(name)]
    (folder / "outcomes.csv").write_text("\n".join(rows) + "\n")
    scenario = (ROOT / "scenarios/ball_distance.yaml").read_text().replace("../models/", "models/")
    (folder / "scenario.yaml").write_text(scenario)
    shutil.copytree(ROOT / "models", folder / "models")
    (folder / "measurement.yaml").write_text(
        "format: seam-measurement/1\nkind: outcomes\ntitle: a ball, near and far, by a swinging head and on a walk\n"
        f"files: {{outcomes: outcomes.csv}}\nscenarios: {{{', '.join(f'{n}: {n}.yaml' for n in SCENARIOS)}}}\n"
        f"most_runs: 12000\ncandidates:{CANDIDATES}")


class Study:
    def __init__(self, args):
        self.seam, self.out, self.wanted = args.seam, args.out, args.sigmas
        self.out.mkdir(parents=True, exist_ok=True)
        self.protocol = self.out / "protocol"
        write_protocol(self.protocol)
        self.nominal = self.out / "nominal.yaml"
        self.nominal.write_text(NOMINAL)
        self.settings = self.out / "settings.yaml"
        self.settings.write_text(SETTINGS.replace("VALUE", ""))
        self.plain = None

    def run(self, *arguments):
        done = subprocess.run([self.seam, *map(str, arguments)], capture_output=True, text=True, check=False)
        if done.returncode not in (0, 1) or done.stderr.startswith("seam"):
            sys.exit(f"{' '.join(map(str, arguments))}: {done.stderr}")
        return done

    def truth(self, hidden, value):
        effect, parameter, _ = hidden
        file = self.out / "truths" / f"{effect}_{parameter}.yaml"
        file.parent.mkdir(exist_ok=True)
        text = f"  {effect}: {{{parameter}: {value!r}}}\n"
        if effect == "ball_away":
            text = SETTINGS.replace("effects:\n", "").replace("VALUE", f"value: {value!r}, ")
        file.write_text(NOMINAL + text)
        return file

    def measured(self, model, name, *more):
        made = self.out / "made" / name
        self.run("measure", "--model", model, "--protocol", self.protocol, "--runs", self.out / "runs", "--out", made, *more)
        with open(made / "outcomes.csv", newline="") as table:
            return [(float(row["measured"]), float(row["sigma"])) for row in csv.DictReader(table)]

    def size_of(self, hidden, value):
        """By how many of the errors that its set states the number that is changed most is changed."""
        if self.plain is None:
            self.plain = self.measured(self.nominal, "sizing", "--noise", "off")
        there = self.measured(self.truth(hidden, value), "sizing", "--noise", "off")
        return max(abs(a - b) / sigma for (a, sigma), (b, _) in zip(there, self.plain))

    def sized(self, hidden):
        """A size near that by which some number is changed as wanted: where counts of pixels jump, the nearest that was met."""
        neutral = 1 if hidden[1] == "gamma" else 0
        by, below, above, met = hidden[2] - neutral, None, None, []
        for _ in range(8):
            sigmas = self.size_of(hidden, neutral + by)
            met.append((abs(math.log(max(sigmas, 0.1) / self.wanted)), neutral + by, sigmas))
            if abs(sigmas - self.wanted) < 0.15 * self.wanted:
                break
            if sigmas < self.wanted:
                below = by
            else:
                above = by
            step = by * min(4, max(0.25, self.wanted / max(sigmas, 0.1)))
            if below is not None and above is not None and not min(below, above) < step < max(below, above):
                step = (below + above) / 2
            by = float(f"{step:.3g}")
        return min(met)[1:]

    def told(self, model, name, seed):
        self.measured(model, name, "--seed", seed)
        began = time.time()
        done = self.run("diagnose", "--model", self.nominal, "--data", self.out / "made" / name, "--candidates", self.settings,
                        "--runs", self.out / "runs", "--json", self.out / f"{name}.json")
        (self.out / f"{name}.txt").write_text(done.stdout)
        told = json.loads((self.out / f"{name}.json").read_text())
        runs = re.search(r"([\d,]+) runs were made, of at most", done.stdout)
        return told, runs.group(1) if runs else "?", time.time() - began


def named_first(told):
    """The first candidate and those declared to be tied with it."""
    candidates = told["candidates"]
    if told["verdict"] != "missing_effect" or not candidates:
        return []
    return [candidates[0]["effect"], *candidates[0].get("indistinguishable_from", [])]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("seam")
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--only", nargs="*")
    parser.add_argument("--sigmas", type=float, default=5)
    study = Study(parser.parse_args())
    only = parser.parse_args().only
    right = total = alarms = 0
    for number, hidden in enumerate(HIDDEN):
        name = f"{hidden[0]}_{number}"
        if only and name not in only:
            continue
        value, sigmas = study.sized(hidden)
        told, runs, wall_s = study.told(study.truth(hidden, value), name, number + 1)
        first = named_first(told)
        right += hidden[0] in first
        total += 1
        print(f"{name:32s} {value:9.4g} {sigmas:5.1f} sigma  {'right' if hidden[0] in first else 'WRONG':5s}  "
              f"{told['verdict']}: {', '.join(first)}  ({runs} runs, {wall_s:.0f} s)", flush=True)
    for number in range(NOTHING):
        name = f"nothing_{number}"
        if only and name not in only:
            continue
        told, runs, wall_s = study.told(study.nominal, name, 100 + number)
        alarms += bool(named_first(told))
        print(f"{name:32s} {told['verdict']}: {', '.join(named_first(told))}  ({runs} runs, {wall_s:.0f} s)", flush=True)
    print(f"{right} of {total} first or tied; {alarms} false alarms")


if __name__ == "__main__":
    main()
