#!/usr/bin/env python3
"""What makes the simulated robot find itself as badly as the paper's real one (docs/evidence/paper-robot.md).

Each variant changes one thing, or two: an effect of the camera or the head, or a setting of the program or the clocks, at a
size that a robot of 2002 plausibly had. `seam measure` makes the 36 runs of each with the same seeds, and their
statistics are compared with the sixteen printed numbers of Table 1(a). Resumes: runs are kept in OUT/runs.

Usage: paper_robot.py SEAM OUT [--duration-s 30] [--only NAME...] [--plot FILE.png] (the plot needs python3-matplotlib)
"""
import argparse
import csv
import json
import math
import pathlib
import shutil
import subprocess

ROOT = pathlib.Path(__file__).resolve().parent.parent
SET = ROOT / "scenarios/outcomes/paper_table1"
SWING_S = 4.0373

SETTING = "stage: scenario, parameters: {{value: {{value: {value}, neutral: -1, min: -1, max: 1e6}}}}, set: {{\"{path}\": value}}"
PARTICLES, WIDTH = "robots[0].behaviour.command[6]", "robots[0].behaviour.command[8]"
PERIOD = "robots[0].camera.clock.period_s"


def setting(path, value):
    return "{" + SETTING.format(value=value, path=path) + "}"


# Name: the effects that a model gets, and keys of the scenario that are no numbers.
SINGLE = {
    "as it is": {},
    "camera 20 mm higher": {"mount_offset": "{z_m: 0.02}"},
    "camera 20 mm lower": {"mount_offset": "{z_m: -0.02}"},
    "camera looks 2 deg lower": {"mount_misalignment": "{pitch_rad: 0.035}"},
    "camera looks 2 deg higher": {"mount_misalignment": "{pitch_rad: -0.035}"},
    "camera rolled by 3 deg": {"mount_misalignment": "{roll_rad: 0.052}"},
    "tilt encoder off by 3 deg": {"encoder_offset": "{tilt_rad: 0.052}"},
    "pan encoder off by 3 deg": {"encoder_offset": "{pan_rad: 0.052}"},
    "play of the pan, 4 deg": {"backlash": "{width_rad: 0.07}"},
    "frames 60 ms late": {"frame_latency": "{latency_s: 0.06}"},
    "focal length 5 % longer": {"focal_length_error": "{fx_scale: 0.05, fy_scale: 0.05}"},
    "focal length 5 % shorter": {"focal_length_error": "{fx_scale: -0.05, fy_scale: -0.05}"},
    "glare of 10 %": {"veiling_glare": "{fraction: 0.1}"},
    "dark tones lifted, gamma 0.8": {"response_gamma": "{gamma: 0.8}"},
    "dark tones pressed, gamma 1.3": {"response_gamma": "{gamma: 1.3}"},
    "250 particles": {"particles": setting(PARTICLES, 250)},
    "100 particles": {"particles": setting(PARTICLES, 100)},
    "50 particles": {"particles": setting(PARTICLES, 50)},
    "filter trusts half as much": {"width": setting(WIDTH, 2)},
    "filter trusts a quarter": {"width": setting(WIDTH, 4)},
    "a frame each 112 ms": {"period": setting(PERIOD, 0.112)},
    "a frame each 208 ms": {"period": setting(PERIOD, 0.208)},
}
LOCKED = {"locked to the swing, 112 ms": 0.112, "locked to the swing, 208 ms": 0.208}
PAIRS = [("100 particles", "filter trusts half as much"), ("100 particles", "camera looks 2 deg lower"),
         ("100 particles", "camera 20 mm lower"), ("100 particles", "pan encoder off by 3 deg"),
         ("100 particles", "a frame each 208 ms"), ("50 particles", "filter trusts half as much"),
         ("filter trusts a quarter", "camera looks 2 deg lower"), ("filter trusts a quarter", "focal length 5 % shorter")]


def variants():
    found = {name: (effects, None) for name, effects in SINGLE.items()}
    found |= {name: ({}, frame_s) for name, frame_s in LOCKED.items()}
    for a, b in PAIRS:
        found[f"{a}; {b}"] = (SINGLE[a] | SINGLE[b], None)
    return found


def protocol(out, duration_s, frame_s):
    """The set with runs of this length, and frames locked to the swing where asked for."""
    folder = out / "sets" / (f"locked_{round(1e3 * frame_s)}" if frame_s else "plain")
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    plan = (SET / "plan.yaml").read_text().replace("../../localization.yaml", "scenario.yaml")
    keys = f"set:\n  duration_s: {duration_s}\n"
    if frame_s:
        keys += (f'  "robots[0].camera.locked": true\n  "robots[0].camera.lock_cycle_s": {SWING_S}\n'
                 f'  "robots[0].camera.lock_frames": {round(SWING_S / frame_s)}\n')
    (folder / "plan.yaml").write_text(plan.replace("set:\n", keys))
    scenario = (ROOT / "scenarios/localization.yaml").read_text()
    (folder / "scenario.yaml").write_text(scenario.replace("../models/", "models/"))
    shutil.copytree(ROOT / "models", folder / "models")
    for name in ("measurement.yaml", "outcomes.csv"):
        shutil.copy(SET / name, folder / name)
    return folder


def measured(seam, out, name, effects, set_folder):
    model = (ROOT / "models/ers210.yaml").read_text() + "".join(f"  {key}: {value}\n" for key, value in effects.items())
    tag = "".join(c if c.isalnum() else "_" for c in name)
    (out / f"{tag}.yaml").write_text(model)
    subprocess.run([seam, "measure", "--model", out / f"{tag}.yaml", "--protocol", set_folder, "--noise", "off", "--runs",
                    out / "runs", "--out", out / "made" / tag], check=True, stdout=subprocess.DEVNULL)
    with open(out / "made" / tag / "outcomes.csv", newline="") as table:
        return [(float(row["measured"]), float(row["sigma"])) for row in csv.DictReader(table)]


def plot(found, file):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    real, variants_ = found["rows"], found["variants"]
    labels = [f"{row['statistic']} {row['value']}" for row in real]
    names = list(variants_)
    figure, axes = plt.subplots(figsize=(11, 0.32 * len(names) + 2.2))
    z = [[max(-8, min(8, x)) for x in variants_[name]["z"]] for name in names]
    picture = axes.imshow(z, cmap="RdBu_r", vmin=-8, vmax=8, aspect="auto")
    axes.set_xticks(range(len(labels)), labels, rotation=55, ha="right", fontsize=8)
    axes.set_yticks(range(len(names)), [f"{name}  ({variants_[name]['error']:.1f})" for name in names], fontsize=8)
    for i, row in enumerate(z):
        for k, value in enumerate(row):
            if abs(value) < 2:
                axes.text(k, i, "o", ha="center", va="center", fontsize=8)
    figure.colorbar(picture, label="simulated minus printed, in errors of both (o: within 2)")
    figure.tight_layout()
    figure.savefig(file, dpi=110)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("seam")
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--duration-s", type=float, default=30)
    parser.add_argument("--only", nargs="*")
    parser.add_argument("--plot", type=pathlib.Path)
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    with open(SET / "outcomes.csv", newline="") as table:
        real = list(csv.DictReader(table))
    found = {}
    for name, (effects, frame_s) in variants().items():
        if args.only and name not in args.only:
            continue
        ours = measured(args.seam, args.out, name, effects, protocol(args.out, args.duration_s, frame_s))
        z = [(value - float(row["measured"])) / math.hypot(float(row["sigma"]), sigma)
             for (value, sigma), row in zip(ours, real)]
        found[name] = {"values": [value for value, _ in ours], "z": z, "error": math.sqrt(sum(x * x for x in z) / len(z)),
                       "within_2": sum(abs(x) < 2 for x in z)}
        print(f"{name:55s} error {found[name]['error']:5.2f}, {found[name]['within_2']:2d} of {len(z)} within 2 sigma",
              flush=True)
        (args.out / "found.json").write_text(json.dumps({"rows": real, "variants": found}, indent=1))
    if args.plot:
        plot({"rows": real, "variants": found}, args.plot)


if __name__ == "__main__":
    main()
