#!/usr/bin/env python3
"""Servo logs whose commands a bus reads when its turn comes: whether the scatter of their times is named, with its size.

    benchmark/late_commands.py build/seam [--sets 20] [--first 0] [--keep FOLDER]

Each command acts after a time of its own, drawn evenly from 0 to the bus's period (2 to 8 ms; rows are 10 ms apart). The
motor's angles are those of the solver in motors.py, not of SEAM. `seam diagnose` gets the motor with a latency that is
free; right is `command_jitter` and nothing else. Beside each set stands one whose commands are all late by half of the
period, where nothing is missing.
"""
import math
import pathlib
import tempfile

import numpy as np

import own_sets
from draws import Draw
from motors import LENGTH, STEP_S, Joint
from servos import commands

RUNS = 6
NOISE_RAD = 0.0005


def moved(effects, command, late):
    """Angles at the rows of a joint whose commands act so much after their rows."""
    joint, q, w, active, angles = Joint(effects), command[0], 0.0, None, []
    for new, after in zip(command, late):
        angles.append(q)
        if active is not None and after > 0:
            q, w = joint.advance(q, w, active, 1, 1, after)
        active = new
        q, w = joint.advance(q, w, active, 1, 1, STEP_S - after)
    return np.array(angles)


def drawn(number):
    draw = Draw("late commands", number)
    rate, gain = draw.log_uniform(10, 30), 0.25
    effects = {"motor_servo": {"stall_rad_per_s2": rate ** 2 / gain, "back_emf_per_s": 2 * rate * draw.uniform(0.4, 0.9),
                               "gain": gain},
               "coulomb_friction": {"rad_per_s2": 0.3 * rate ** 2 * draw.uniform(0.1, 0.3)}}
    period = draw.uniform(0.002, 0.008)
    command = commands(draw.of("commands"), RUNS, kinds=3)
    late = draw.of("late").uniform(0, period, size=command.shape)
    noise = draw.of("noise").normal(NOISE_RAD, size=command.shape)
    return effects, period, command, late, noise


def write_set(folder, command, angles):
    folder.mkdir(parents=True)
    lines = [f"{run},{k * STEP_S:.3f},arm,{command[run, k]:.5f},{angles[run, k]:.9f}"
             for run in range(RUNS) for k in range(LENGTH)]
    (folder / "joints.csv").write_text("run,time_s,joint,command_rad,measured_rad\n" + "\n".join(lines) + "\n")
    (folder / "measurement.yaml").write_text(
        f"format: seam-measurement/1\nkind: joints\ntitle: made\nnoise: {{measured_rad: {NOISE_RAD}}}\ngroup: run\n"
        "files: {joints: joints.csv}\n")


def main():
    options = own_sets.options_of(__doc__)
    root = pathlib.Path(options.keep or tempfile.mkdtemp())
    named, quiet, sizes = 0, 0, []
    for number in range(options.first, options.first + options.sets):
        (effects, period, command, late, noise), folder = drawn(number), root / f"set{number}"
        write_set(folder / "late", command, np.stack([moved(effects, *row) for row in zip(command, late)]) + noise)
        even = np.full(command.shape, period / 2)
        write_set(folder / "even", command, np.stack([moved(effects, *row) for row in zip(command, even)]) + noise)
        model = folder / "model.yaml"
        model.write_text("format: seam-model/1\neffects:\n" + "".join(
            f"  {name}: {{" + ", ".join(f"{key}: {value:.9g}" if key == "gain" else f"{key}: {{value: {value:.9g}, free: true}}"
                                        for key, value in values.items()) + "}\n" for name, values in effects.items())
            + f"  servo_latency: {{latency_s: {{value: {period / 2:.9g}, free: true}}}}\n")
        answer, null = (own_sets.asked(options.seam, "diagnose", folder / name, model, folder / name / "answer.json")
                        for name in ("late", "even"))
        steps = [step["effect"] for step in answer["explanation"]["steps"]]
        named += steps == ["command_jitter"]
        none = null["verdict"] == "adequate"
        quiet += none
        for candidate in answer["candidates"]:
            if candidate["effect"] == "command_jitter":
                found = candidate["parameters"]["sigma_s"]
                sizes.append((found["value"] - period / math.sqrt(12)) / found["sigma"])
        print(number, f"{answer['baseline']['error']:.2f}", answer["verdict"], steps, f"{sizes[-1]:.2f}" if sizes else "",
              null["verdict"], flush=True)
    print(f"command_jitter, and nothing else, named in {named} of {options.sets}; nothing missing in {quiet} of {options.sets} "
          f"where all are as late\nsizes: {sum(abs(size) < 2 for size in sizes)} of {len(sizes)} within 2 errors, "
          f"{sum(abs(size) < 3 for size in sizes)} within 3; root mean square {math.sqrt(np.mean(np.square(sizes))):.2f}")


if __name__ == "__main__":
    main()
