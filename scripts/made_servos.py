#!/usr/bin/env python3
"""Servos whose torque physics is known: how often `seam discover` finds it from an ideal servo alone.

    scripts/made_servos.py build/seam [--sort stiff --sort soft ...] [--sets 20] [--first 0] [--keep FOLDER]

Each set has a motor with controller, load and frictions drawn by its number, far from those of the practice sets, and is
made by `seam measure`. A set is right where the search ends with the hidden effects, or their declared ties, and no
others. Coverage counts the parameters of right sets whose truth lies within two of the stated errors; the strength of a
motor and its gain count as their product where their errors say that no run separates them.
"""
import argparse
import csv
import json
import math
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile
import time

NOISE_RAD = 0.0005
# Seconds between rows, rows of a run, runs; slowest and fastest controller, rad/s; damping of the joint by its motor.
SORTS = {
    "stiff": {"dt": 0.01, "rows": 250, "runs": 8, "rate": (10, 35), "damping": (0.3, 1.0), "gains": (4, 8, 16)},
    "soft": {"dt": 0.01, "rows": 250, "runs": 8, "rate": (3, 8), "damping": (0.15, 0.7), "gains": (100, 200, 800)},
    "released": {"dt": 0.01, "rows": 250, "runs": 8, "rate": (6, 25), "damping": (0.2, 0.8), "gains": (1, 2)},
    # A leg's joint: no column kp, damped by its own controller, never switched off.
    "legged": {"dt": 0.005, "rows": 300, "runs": 8, "rate": (12, 40), "damping": (0.05, 0.3), "gains": (),
               "own_damping": (0.2, 0.6)},
    # A head: few rows, a joint that carries little.
    "head": {"dt": 0.008, "rows": 120, "runs": 4, "rate": (10, 30), "damping": (0.3, 0.9), "gains": ()},
}
STIFF, LEGGED = SORTS["stiff"], SORTS["legged"]
SORTS |= {
    # Encoders of 12 bits a turn and of 10 bits in 300 degrees, noise not stated.
    "rounded": STIFF | {"steps": (2 * math.pi / 4096, math.radians(300) / 1024)},
    "late": LEGGED | {"latency": (0.003, 0.03)},
    # Duty that is cut off below the whole supply: the same motion as a weaker motor with more gain.
    "pwm": STIFF | {"duty": (0.3, 0.8)},
    # Rows that come early and late, and are lost.
    "uneven": LEGGED | {"jitter": 0.35, "lost": 0.03},
    # A supply that sags; in one set of three the column never changes.
    "volts": STIFF | {"volts": True},
}
FRICTIONS = ("coulomb_friction", "load_friction", "stribeck_friction")


def truth_of(sort, draw):
    """Effects with their values, and the largest error of angle that is commanded."""
    form = SORTS[sort]
    rate = math.exp(draw.uniform(*map(math.log, form["rate"])))
    typical = 0.3 * rate ** 2  # Acceleration at 0.3 rad from the command, without friction.
    kp = form["gains"][len(form["gains"]) // 2] if form["gains"] else 1
    # Half of the sets ask for more than the motor has.
    ask = draw.uniform(1.3, 3) if draw.random() < 0.5 else draw.uniform(0.2, 0.8)
    gain = ask / 1.5 / kp
    stall = rate ** 2 / (gain * kp)
    motor = {"stall_rad_per_s2": stall, "back_emf_per_s": 2 * rate * draw.uniform(*form["damping"]), "gain": gain}
    if "own_damping" in form:
        motor["damping_s"] = 2 * rate * draw.uniform(*form["own_damping"]) / stall
    effects = {"motor_servo": motor}
    if draw.random() < 0.7:
        effects["gravity_torque"] = {"rad_per_s2": typical * draw.uniform(0.3, 1), "level_rad": draw.uniform(-1.6, 1.6)}
    choice = draw.sample(FRICTIONS, draw.choice((1, 1, 2)))
    # Without drive the back-EMF is gone, viscous friction is not: nothing else separates them.
    if sort == "released" and draw.random() < 0.5:
        effects["viscous_friction"] = {"per_s": motor["back_emf_per_s"] * draw.uniform(0.1, 0.4)}
    if "coulomb_friction" in choice:
        effects["coulomb_friction"] = {"rad_per_s2": typical * draw.uniform(0.1, 0.5)}
    if "load_friction" in choice:
        effects["load_friction"] = {"fraction": draw.uniform(0.1, 0.35)}
    if "stribeck_friction" in choice:
        effects["stribeck_friction"] = {"rad_per_s2": typical * draw.uniform(0.15, 0.5),
                                        "rad_per_s": 0.3 * rate * draw.uniform(0.1, 0.4)}
    if draw.random() < 0.25:
        most = min(stall, 1.2 * rate ** 2)
        held = sum(effects.get(name, {}).get("rad_per_s2", 0) for name in ("gravity_torque", *FRICTIONS))
        effects["torque_limit"] = {"rad_per_s2": max(draw.uniform(0.4, 0.7) * most, 1.5 * held)}
    if "latency" in form:
        effects["servo_latency"] = {"latency_s": draw.uniform(*form["latency"])}
    if "steps" in form:
        effects["encoder_quantisation"] = {"step_rad": draw.choice(form["steps"])}
    if "duty" in form:
        motor["max_duty"] = draw.uniform(*form["duty"])
        for name, power in (("stall_rad_per_s2", -1), ("gain", 1)):
            motor[name] *= motor["max_duty"] ** power
    return effects


def protocol(folder, sort, draw):
    form = SORTS[sort]
    gains = form["gains"] if form["gains"] and draw.random() < 0.8 else form["gains"][:1]
    names = "run,time_s,joint,command_rad,torque_enable" + (",kp" if gains else "") + (
        ",voltage_v" if "volts" in form else "")
    rows, sag = [names], draw.choice((0, 0.4, 1.2)) if "volts" in form else 0
    for run in range(form["runs"]):
        ends = [draw.uniform(-1, 1) for _ in range(6)]
        kind = run % 3  # Steps, a swing that grows faster, slow ramps.
        free = sort == "released" and run % 2 == 1
        length = form["rows"]
        for k in range(length):
            at, block = k / length, int(6 * k / length)
            t = k * form["dt"]
            if "jitter" in form and k > 0:
                t += form["jitter"] * draw.uniform(-1, 1) * form["dt"]
            command = ends[block]
            if kind == 1:
                command = ends[0] * math.sin((2 + 3 * t) * t) + 0.4 * ends[1] * math.sin(11 * t)
            elif kind == 2:
                command = ends[block // 2] + (ends[block // 2 + 1] - ends[block // 2]) * (3 * at) % 1.0
            enabled = 0 if free and block in (2, 5) else 1
            kp = f",{gains[run % len(gains)]}" if gains else ""
            volts = f",{12 - sag * (0.3 * run / form['runs'] + 0.7 * at ** 2):.2f}" if "volts" in form else ""
            if k == 0 or "lost" not in form or draw.random() >= form["lost"]:
                rows.append(f"{run},{t:.{5 if 'jitter' in form else 3}f},joint,{command if k > 1 else 0:.5f},{enabled}"
                            f"{kp}{volts}")
    noise = NOISE_RAD if "steps" not in form else 0.1 * min(form["steps"])
    folder.mkdir()
    (folder / "joints.csv").write_text("\n".join(rows) + "\n")
    (folder / "measurement.yaml").write_text(
        f"format: seam-measurement/1\nkind: joints\ntitle: made\nnoise: {{measured_rad: {noise}}}\ngroup: run\n"
        "files: {joints: joints.csv}\n")


def model_text(effects):
    lines = [f"  {name}: {{{', '.join(f'{key}: {value:.6g}' for key, value in values.items())}}}"
             for name, values in effects.items()]
    return "format: seam-model/1\nname: made\neffects:\n" + "\n".join(lines) + "\n"


def seam(binary, *arguments):
    done = subprocess.run([binary, *arguments], capture_output=True, text=True, timeout=1500)
    if done.returncode != 0:
        sys.exit(done.stderr)
    return done.stdout


def deviations(truth, values):
    """In stated errors, of what both know."""
    list_of = []
    known = dict(values)
    strength, gain = (known.get(f"motor_servo.{name}") for name in ("stall_rad_per_s2", "gain"))
    if strength and gain and max(strength[1] / strength[0], gain[1] / gain[0]) > 0.2:
        del known["motor_servo.stall_rad_per_s2"], known["motor_servo.gain"]
    hidden = {name: dict(parameters) for name, parameters in truth.items()}
    motor = hidden["motor_servo"]
    most = motor.pop("max_duty", 1)
    for name, power in (("stall_rad_per_s2", 1), ("gain", -1), ("damping_s", -1)):
        motor[name] = motor.get(name, 0) * most ** power
    if not known.get("motor_servo.damping_s", (0, 0))[0]:
        # Not asked for: where nothing saturates damping is back-EMF by another name.
        motor["back_emf_per_s"] += motor["stall_rad_per_s2"] * motor.pop("damping_s")
    for name, (value, sigma) in known.items():
        effect, parameter = name.split(".")
        true = hidden.get(effect, {}).get(parameter)
        if true is not None and sigma:
            list_of.append((name, (value - true) / sigma))
    return list_of


def judged(truth, found):
    """`right`, `tie` (a declared tie stands for a hidden effect) or `wrong`. Steps of an encoder are noise by another name
    where the set states none, and gross errors that are too long may be left out or told by their name."""
    missing, spare, tied = set(truth), [], False
    for step in found["steps"]:
        if step["effect"] in missing:
            missing.remove(step["effect"])
        else:
            spare.append([step["effect"], *step.get("indistinguishable_from", [])])
    for names in spare:
        other = next((name for name in names if name in missing), None)
        if other is None:
            return "wrong"
        missing.remove(other)
        tied = True
    return "wrong" if missing - {"encoder_quantisation", "range_tail"} else "tie" if tied else "right"


def angles(binary, folder, effects):
    """What a servo of these effects would log without noise."""
    with tempfile.TemporaryDirectory() as scratch:
        model = pathlib.Path(scratch) / "model.yaml"
        model.write_text(model_text(effects))
        seam(binary, "measure", "--model", model, "--protocol", folder / "protocol", "--noise", "off", "--out",
             pathlib.Path(scratch) / "made")
        with open(pathlib.Path(scratch) / "made" / "joints.csv", newline="") as rows:
            return [float(row["measured_rad"]) for row in csv.DictReader(rows)]


def make(binary, sort, number, folder):
    """A servo's set by `seam measure`, and what is hidden in it: a limit of torque that its runs never ask for, so that no
    row moves by a hundredth of the noise, is not."""
    draw = random.Random(f"{sort} {number}")
    truth = truth_of(sort, draw)
    protocol(folder / "protocol", sort, draw)
    (folder / "truth.yaml").write_text(model_text(truth))
    (folder / "nominal.yaml").write_text("format: seam-model/1\nname: nominal\neffects: {ideal_servo: {}}\n")
    seam(binary, "measure", "--model", folder / "truth.yaml", "--protocol", folder / "protocol", "--seed", str(number),
         "--out", folder / "data")
    if "steps" in SORTS[sort]:
        yaml = folder / "data" / "measurement.yaml"
        yaml.write_text("".join(line for line in yaml.read_text().splitlines(True) if "noise" not in line))
    less = {name: values for name, values in truth.items() if name != "torque_limit"}
    if less != truth:
        moved = max(abs(a - b) for a, b in zip(angles(binary, folder, truth), angles(binary, folder, less)))
        return truth if moved > 0.01 * NOISE_RAD else less
    return truth


def one_set(binary, sort, number, folder, make_set, deviations_of):
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    truth = make_set(binary, sort, number, folder)
    begin = time.time()
    text = seam(binary, "discover", "--model", folder / "nominal.yaml", "--data", folder / "data", "--out",
                folder / "found.yaml", "--json", folder / "found.json")
    (folder / "found.txt").write_text(text)
    found = json.loads((folder / "found.json").read_text())
    values = {f"{step['effect']}.{name}": (value["value"], value["sigma"])
              for step in found["steps"] for name, value in step["parameters"].items()}
    verdict = judged(truth, found)
    print(f"{sort:9} {number:3} {verdict:6} error {found['error']:.3f} {time.time() - begin:4.0f} s  hidden "
          f"{' '.join(sorted(truth))}", flush=True)
    if verdict == "wrong":
        print("              found " + " ".join(
            f"{step['effect']} ({step['error_after']:.4g})" for step in found["steps"]), flush=True)
    return verdict, found["error"], deviations_of(truth, values) if verdict == "right" else []


def search_all(summary, sorts, make_set, deviations_of):
    """Makes sets and searches them as the command line says, and prints the table."""
    parser = argparse.ArgumentParser(description=summary)
    parser.add_argument("seam", type=pathlib.Path)
    parser.add_argument("--sort", action="append", choices=sorts)
    parser.add_argument("--sets", type=int, default=20)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--keep", type=pathlib.Path, help="a folder for all sets, their truth and what was found")
    parser.add_argument("--least", type=float, default=0, help="fails where a smaller share is right or tied")
    options = parser.parse_args()
    binary = options.seam.resolve()
    rows, every, good, sets = [], [], 0, 0
    with tempfile.TemporaryDirectory() as scratch:
        folder = options.keep or pathlib.Path(scratch)
        for sort in options.sort or sorts:
            results = [one_set(binary, sort, number, folder / f"{sort}-{number}", make_set, deviations_of)
                       for number in range(options.first, options.first + options.sets)]
            counts = [sum(verdict == name for verdict, _, _ in results) for name in ("right", "tie", "wrong")]
            off = [deviation for _, _, list_of in results for deviation in list_of]
            every += off
            good, sets = good + counts[0] + counts[1], sets + len(results)
            within = [sum(abs(z) <= sigmas for _, z in off) for sigmas in (1, 2)]
            rows.append(f"| {sort} | {len(results)} | {counts[0]} | {counts[1]} | {counts[2]} | {within[0]} and "
                        f"{within[1]} of {len(off)} |")
    print("\n| Sort | Sets | Right | Declared tie | Wrong | Within 1 and 2 sigma |\n|---|---|---|---|---|---|")
    print("\n".join(rows))
    print("farthest:", ", ".join(f"{name} {z:.1f}" for name, z in sorted(every, key=lambda d: -abs(d[1]))[:8]))
    return 0 if good >= options.least * sets else f"{good} of {sets} right or tied, expected {options.least:.0%}"


if __name__ == "__main__":
    sys.exit(search_all(__doc__.splitlines()[0], SORTS, make, deviations))
