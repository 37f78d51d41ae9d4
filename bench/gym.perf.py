#!/usr/bin/python3
"""What a step of a learner costs: worlds of seam_gym beside `seam run` with a behaviour in C++, in processor time.

Usage: gym.perf.py [BUILD_DIR] [--csv FILE]. Processor time is that of this process and of all simulators; where other work
runs beside it, it says more than the time on the wall. A ratio compares a step with a turn of `seam run` in the same call.
"""
import argparse
import csv
import os
import pathlib
import resource
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
CORES = 2  # Of the machine for which the aims are stated.
SCENARIO = """format: seam-scenario/1
name: gym
duration_s: {duration_s}
seed: 5
field: {root}/models/field_2002.yaml
ball: {{x_m: 0.4, y_m: 0.2}}
robots:
  - id: r0
    team: red
    pose: {{x_m: -0.9, y_m: 0.4, theta_rad: 0.3}}
    body: {root}/models/robot_ers210.yaml
    camera: {{model: {root}/models/ers210_full.yaml, width_px: 84, height_px: 84, clock: {{period_s: 0.032}}{frames}}}
    behaviour: {{command: [head_swing{option}]}}
"""


def processor_s(pid="self"):
    """User and system time so far."""
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def steps_of(file, worlds, turns, **task):
    """Processor and wall seconds of one step of all worlds, after the first ones."""
    import seam_gym
    envs = seam_gym.VectorEnv(file, worlds, act={"pan": (-1.5, 1.5)}, reward="-abs(truth.r0.pan_rad - 0.5)", **task)
    envs.reset(seed=1)

    def so_far():
        return processor_s() + sum(processor_s(env.episode.process) for env in envs.envs), time.perf_counter()

    actions, frames = envs.action_space.sample(), 0
    for turn in range(turns + 20):
        if turn == 20:
            begin = so_far()
            frames = 0
        *_, infos = envs.step(actions)
        frames += sum(len(seen.frames) for seen in infos["seen"])
    end = so_far()
    envs.close()
    return (end[0] - begin[0]) / turns, (end[1] - begin[1]) / turns, frames / turns


def run_of(build, folder, name, duration_s, **scenario):
    """Processor seconds of a turn of `seam run`, less those of a run that ends at once."""
    def spent(seconds):
        file = folder / f"{name}_run.yaml"
        file.write_text(SCENARIO.format(root=ROOT, duration_s=seconds, **scenario))
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([build / "seam", "run", file], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    return (spent(duration_s) - spent(0.04)) / (duration_s / 0.032)


def reset_of(file, resets=5):
    """Processor seconds of a reset."""
    import seam_gym
    env = seam_gym.Env(file, reward="truth.r0.pan_rad")
    before = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    for _ in range(resets):
        env.reset(seed=1)
    env.close()
    after = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(b.ru_utime + b.ru_stime - a.ru_utime - a.ru_stime for a, b in zip(before, after)) / resets


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("build", nargs="?", type=pathlib.Path, default=ROOT / "build")
    parser.add_argument("--csv")
    given = parser.parse_args()
    sys.path.insert(0, str(given.build / "python"))
    rows = []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        file = folder / "one.yaml"
        file.write_text(SCENARIO.format(root=ROOT, duration_s=10000, frames="", option=""))
        for what, worlds, turns, task, scenario in (
                ("8 worlds, no frames", 8, 300, {"observe": ["joints"]}, {"frames": "", "option": ", --no-frames"}),
                ("1 world, no frames", 1, 1500, {"observe": ["joints"]}, {"frames": "", "option": ", --no-frames"}),
                ("8 worlds, frames of 84x84 with all effects", 8, 50, {"observe": ["joints", "frame"]},
                 {"frames": ", every_frame: true", "option": ""})):
            step_s, wall_s, frames = steps_of(file, worlds, turns, **task)
            turn_s = run_of(given.build, folder, "x", 30 if not scenario["frames"] else 3, **scenario)
            rate = worlds / step_s
            rows.append([what, f"{1e3 * step_s / worlds:.2f} ms", f"{CORES * rate:,.0f}", f"{CORES * frames / step_s:,.0f}",
                         f"{step_s / worlds / turn_s:.1f}", f"{worlds / wall_s:,.0f}"])
        rows.append(["a reset", f"{1e3 * reset_of(file):.0f} ms", "", "", "", ""])
    columns = ["What", "Processor time a step", f"Steps/s on {CORES} cores", f"Frames/s on {CORES} cores",
               "Ratio to a turn of `seam run` with a C++ behaviour", "Steps/s on the wall"]
    for row in (columns, *rows):
        print(" | ".join(row))
    if given.csv:
        with open(given.csv, "w", newline="") as out:
            csv.writer(out).writerows([columns, *rows])


if __name__ == "__main__":
    main()
