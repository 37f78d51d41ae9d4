#!/usr/bin/env python3
"""Servo logs with the motor's torque as a column: what it tells beside the angles, and whether it raises false alarms.

    benchmark/efforts.py build/seam [--sets 20] [--first 0] [--keep FOLDER] [--json FILE]

The angles and torques are those of the solver in motors.py (fourth order, stops at reversals), not of SEAM. The drive is
never off and never saturates: angles alone give the sum of back-EMF and viscous friction. Each set is fitted without the
column and with it (the share of back-EMF within two and three of the errors, and the inertia); diagnosed with its own
effects (null: nothing may be missing); and with torques that a wrong torque constant made, the inertia being stated.
Half of the sets leave the torque's noise unstated, a third have a torque in every third row only.
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


def moved(effects, command):
    """Angles and torques over the inertia at the rows, each just before the row's command acts."""
    joint, q, w, active = Joint(effects), command[0], 0.0, None
    angles, drives = [], []
    for new in command:
        if active is not None:
            q, w = joint.advance(q, w, active, 1, 1, STEP_S)
        duty = max(-1.0, min(1.0, joint.gain * ((new if active is None else active) - q)))
        angles.append(q)
        drives.append(joint.stall * duty - joint.back_emf * w)
        active = new
    return np.array(angles), np.array(drives)


def drawn(number):
    draw = Draw("efforts", number)
    rate = draw.log_uniform(10, 25)
    typical, drag = 0.3 * rate ** 2, 2 * rate * draw.uniform(0.4, 0.9)
    share = draw.uniform(0.2, 0.8)
    gain = 0.25
    effects = {"motor_servo": {"stall_rad_per_s2": rate ** 2 / gain, "back_emf_per_s": drag * share, "gain": gain},
               "viscous_friction": {"per_s": drag * (1 - share)},
               "gravity_torque": {"rad_per_s2": typical * draw.uniform(0.3, 0.8), "level_rad": draw.uniform(-1.5, 1.5)},
               "coulomb_friction": {"rad_per_s2": typical * draw.uniform(0.1, 0.3)}}
    inertia = draw.log_uniform(0.001, 0.5)
    made = [moved(effects, row) for row in commands(draw.of("commands"), RUNS, kinds=3)]
    command = commands(draw.of("commands"), RUNS, kinds=3)
    angles, drives = (np.stack([one[k] for one in made]) for k in (0, 1))
    sigma_nm = inertia * typical * draw.log_uniform(0.01, 0.1)
    angles = angles + draw.of("noise").normal(NOISE_RAD, size=angles.shape)
    noise_nm = draw.of("torques").normal(sigma_nm, size=angles.shape)
    return {"effects": effects, "inertia": inertia, "command": command, "angles": angles, "torques": inertia * drives,
            "noise_nm": noise_nm, "sigma_nm": sigma_nm, "stated": number % 2 == 0, "every": 3 if number % 3 == 2 else 1,
            "wrong": draw.signed(0.05, 0.3), "draw": draw.of("start")}


def write_set(folder, one, torques):
    folder.mkdir(parents=True)
    lines = ["run,time_s,joint,command_rad,measured_rad" + ("" if torques is None else ",effort_nm")]
    for run in range(RUNS):
        for k in range(LENGTH):
            line = f"{run},{k * STEP_S:.3f},arm,{one['command'][run, k]:.5f},{one['angles'][run, k]:.9f}"
            if torques is not None:
                line += "," + (f"{torques[run, k]:.9g}" if k % one["every"] == 0 else "")
            lines.append(line)
    (folder / "joints.csv").write_text("\n".join(lines) + "\n")
    noise = f"measured_rad: {NOISE_RAD}"
    if torques is not None and one["stated"]:
        noise += f", effort_nm: {one['sigma_nm']:.9g}"
    (folder / "measurement.yaml").write_text(
        f"format: seam-measurement/1\nkind: joints\ntitle: made\nnoise: {{{noise}}}\ngroup: run\n"
        "files: {joints: joints.csv}\n")


def write_model(path, one, inertia=""):
    lines = ["format: seam-model/1", "effects:"]
    for name, values in one["effects"].items():
        shown = {key: value * math.exp(one["draw"].uniform(-0.1, 0.1)) for key, value in values.items()}
        # The share of back-EMF is what is asked for: it starts from a half.
        drag = one["effects"]["motor_servo"]["back_emf_per_s"] + one["effects"]["viscous_friction"]["per_s"]
        shown |= {key: drag / 2 for key in shown if key in ("back_emf_per_s", "per_s")}
        shown |= {key: one["effects"]["motor_servo"]["gain"] for key in shown if key == "gain"}  # The controller's own.
        lines.append(f"  {name}: {{" + ", ".join(
            f"{key}: {value:.9g}" if key == "gain" else f"{key}: {{value: {value:.9g}, free: true}}"
            for key, value in shown.items()) + "}")
    path.write_text("\n".join(lines) + "\n" + inertia)


def asked(seam, folder, command, data, model):
    words = ["--out", str(folder / "fitted.yaml")] if command == "fit" else []
    return own_sets.asked(seam, command, folder / data, folder / f"{model}.yaml", folder / "answer.json", *words)


class Errors:
    """Estimates in units of their stated errors, and these errors as shares of the true values."""

    def __init__(self):
        self.sizes, self.shares = {}, {}

    def add(self, name, found, truth):
        self.sizes.setdefault(name, []).append((found["value"] - truth) / found["sigma"])
        self.shares.setdefault(name, []).append(found["sigma"] / abs(truth))

    def print(self):
        for name, sizes in self.sizes.items():
            two, three = (sum(abs(size) < most for size in sizes) for most in (2, 3))
            print(f"{name}: {two} of {len(sizes)} within 2 errors, {three} within 3; root mean square "
                  f"{math.sqrt(np.mean(np.square(sizes))):.2f}; an error is {np.median(self.shares[name]):.2%} of the value")


def main():
    options = own_sets.options_of(__doc__)
    root = pathlib.Path(options.keep or tempfile.mkdtemp())
    errors, open_before, quiet, named = Errors(), 0, 0, 0
    for number in range(options.first, options.first + options.sets):
        one, folder = drawn(number), root / f"set{number}"
        write_set(folder / "angles", one, None)
        write_set(folder / "torques", one, one["torques"] + one["noise_nm"])
        write_set(folder / "wrong", one, (1 + one["wrong"]) * one["torques"] + one["noise_nm"])
        inertia = one["inertia"]
        write_model(folder / "free.yaml", one)
        write_model(folder / "inertia.yaml", one, f"  joint_inertia: {{kg_m2: {{value: {inertia * 1.2:.9g}, free: true}}}}\n")
        write_model(folder / "stated.yaml", one, f"  joint_inertia: {{kg_m2: {inertia:.9g}}}\n")
        found = asked(options.seam, folder, "fit", "angles", "free")["parameters"]
        open_before += not all(name in found and (found[name].get("sigma") or math.inf) < abs(found[name]["value"])
                               for name in ("motor_servo.back_emf_per_s", "viscous_friction.per_s"))
        found = asked(options.seam, folder, "fit", "torques", "inertia")["parameters"]
        errors.add("back-EMF", found["motor_servo.back_emf_per_s"], one["effects"]["motor_servo"]["back_emf_per_s"])
        errors.add("viscous friction", found["viscous_friction.per_s"], one["effects"]["viscous_friction"]["per_s"])
        errors.add("inertia", found["joint_inertia.kg_m2"], inertia)
        null = asked(options.seam, folder, "diagnose", "torques", "free")
        quiet += null["verdict"] == "adequate" and not null["structure"]
        wrong = asked(options.seam, folder, "diagnose", "wrong", "stated")
        steps = [step["effect"] for step in wrong["explanation"]["steps"]]
        named += steps == ["effort_scale"]
        for candidate in wrong["candidates"]:
            if candidate["effect"] == "effort_scale":
                errors.add("torque constant", candidate["parameters"]["scale"], one["wrong"])
        print(number, null["verdict"], f"{null['baseline']['error']:.3f}", steps, flush=True)
    print(f"angles alone leave back-EMF and viscous friction open in {open_before} of {options.sets} sets")
    errors.print()
    print(f"nothing missing in {quiet} of {options.sets} sets where nothing is; "
          f"a wrong torque constant, and nothing else, named in {named} of {options.sets}")


if __name__ == "__main__":
    main()
