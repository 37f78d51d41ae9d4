#!/usr/bin/env python3
"""A head whose servo has torque (scenarios/servo_swing.yaml): pictures show that it hangs and swings through, and a log of
its servo, made with the same model, leads back to what drives, loads and brakes it.
`servo_swing_test.py path/to/seam path/to/source`
"""
import csv
import json
import math
import pathlib
import subprocess
import sys
import tempfile

import PIL.Image

import by_hand

SEAM, SOURCE = by_hand.arguments("seam", "source")
FY_PX, CY_PX = 162.5, 71.5
# models/ers210_torque.yaml
TRUTH = {"motor_servo.stall_rad_per_s2": 220, "motor_servo.back_emf_per_s": 22, "motor_servo.gain": 3,
         "gravity_torque.rad_per_s2": 40, "gravity_torque.level_rad": 0.1, "coulomb_friction.rad_per_s2": 6,
         "load_friction.fraction": 0.15}


def seam(*arguments):
    done = subprocess.run([SEAM, *arguments], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def tilts(folder, *model):
    """The head's tilt in each picture, from how high the beacon's pink half stands in it."""
    seam("run", SOURCE / "scenarios/servo_swing.yaml", "--frames", folder, *model)
    with open(folder / "frames.csv", encoding="utf-8") as file:
        names = sorted({row["file"] for row in csv.DictReader(file)})
    angles = []
    for name in names:
        with PIL.Image.open(folder / name) as image:
            width = image.width
            pink = [i // width for i, (r, g, b) in enumerate(image.convert("RGB").getdata())
                    if r > 150 and r - g > 60 and b - g > 20]
        # Cut off by the picture's rim it would stand nearer to the middle than it does.
        if len(pink) > 100:
            angles.append(math.atan((sum(pink) / len(pink) - CY_PX) / FY_PX))
    assert len(angles) > 30, len(angles)
    return angles


def check_pictures(folder):
    torque = tilts(folder / "torque")
    ideal = tilts(folder / "ideal", "--model", SOURCE / "models/ers210.yaml")
    # 20 degrees to both sides are commanded. Gravity pulls the head down at both ends of its swing.
    print("highest and lowest, rad:", max(torque), min(torque), "with an ideal servo:", max(ideal), min(ideal))
    assert abs(max(ideal) - min(ideal) - 2 * math.radians(20)) < 0.04
    assert max(torque) < max(ideal) - 0.05
    assert sum(torque) / len(torque) < sum(ideal) / len(ideal) - 0.02


def protocol(folder):
    """Steps and swings of the tilt; after the steps the torque is switched off."""
    folder.mkdir()
    rows = ["run,time_s,joint,command_rad,torque_enable"]
    for run, steps in enumerate([(0.4, -0.5, 0.2), (-0.6, 0.5, -0.1), (0.8, 0.3, -0.7), (-0.3, -0.8, 0.6),
                                 (0.6, 0.6, -0.4), (-0.7, 0.1, 0.8)]):
        for k in range(150):
            t = 0.008 * k
            swing = steps[0] * math.sin((3 + 2 * run) * t) + 0.3 * steps[1] * math.sin(17 * t)
            command = swing if run % 2 else steps[min(2, k // 50)]
            free = run % 2 == 0 and k >= 110
            rows.append(f"{run},{t:.3f},tilt,{command if k > 1 else 0:.5f},{0 if free else 1}")
    (folder / "joints.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    (folder / "measurement.yaml").write_text(
        "format: seam-measurement/1\nkind: joints\ntitle: The head's tilt, bidden and let go\n"
        "noise: {measured_rad: 0.0005}\ngroup: run\nfiles: {joints: joints.csv}\n", encoding="utf-8")


def check_log(folder):
    protocol(folder / "protocol")
    nominal, found = folder / "nominal.yaml", folder / "found.json"
    nominal.write_text("format: seam-model/1\nname: nominal\neffects: {ideal_servo: {}}\n", encoding="utf-8")
    seam("measure", "--model", SOURCE / "models/ers210_torque.yaml", "--protocol", folder / "protocol", "--seed", "4",
         "--out", folder / "log")
    print(seam("discover", "--model", nominal, "--data", folder / "log", "--out", folder / "found.yaml", "--json", found))
    result = json.loads(found.read_text(encoding="utf-8"))
    values = {}
    for step in result["steps"]:
        for name, value in step["parameters"].items():
            values[f"{step['effect']}.{name}"] = (value["value"], value["sigma"])
    assert {step["effect"] for step in result["steps"]} == {name.split(".")[0] for name in TRUTH}, values
    for name, true in TRUTH.items():
        value, sigma = values[name]
        assert abs(value - true) < 4 * sigma and sigma < 0.1 * abs(true), (name, value, sigma)
    assert result["verdict"] == "adequate" and result["error"] < 1.15, result["error"]


def main():
    with tempfile.TemporaryDirectory() as folder:
        check_pictures(pathlib.Path(folder))
        check_log(pathlib.Path(folder))
    return 0


if __name__ == "__main__":
    sys.exit(main())
