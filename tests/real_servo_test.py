#!/usr/bin/env python3
"""A small servo that swings a mass (docs/evidence/real-servo.md): torque physics found from an ideal servo alone, and a gain
predicted that the fit never saw. `real_servo_test.py path/to/seam [folder of real sets]`
"""
import csv
import json
import pathlib
import re
import subprocess
import sys
import tempfile

from real_sets import SEAM, SETS, SKIP, discover, has, parameters

SET = SETS / "real-servo"
MOST_RAD = 0.060  # Root mean square on runs that were held out, simulated whole.


def part(folder, keeps):
    """The set's runs at these gains alone."""
    folder.mkdir()
    (folder / "measurement.yaml").write_text((SET / "measurement.yaml").read_text())
    rows = list(csv.DictReader((SET / "joints.csv").open()))
    with (folder / "joints.csv").open("w") as out:
        writer = csv.DictWriter(out, rows[0].keys())
        writer.writeheader()
        writer.writerows(row for row in rows if keeps(row["kp"]))


def main():
    if not has("real-servo"):
        return SKIP
    found, _, model = discover(SET, SET / "nominal.yaml")
    assert found["steps"][-1]["error_after"] == found["error"]
    rms = found["error"] * found["noise"]["measured_rad"]
    assert rms < MOST_RAD, rms
    values = parameters(found)
    for name in ("motor_servo.back_emf_per_s", "gravity_torque.rad_per_s2", "load_friction.carried_fraction"):
        value, sigma = values[name]
        assert 0 < 4 * sigma < value, (name, value, sigma)
    # What hangs at 0 is level a quarter turn away; 0.49 kg at 0.10 m weigh 98 rad/s^2 at most.
    assert abs(values["gravity_torque.level_rad"][0] - 1.571) < 0.05, values
    assert 50 < values["gravity_torque.rad_per_s2"][0] < 98, values
    # A gain that no fit saw.
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        part(folder / "rest", lambda kp: kp != "200")
        part(folder / "new", lambda kp: kp == "200")
        start, fitted, fixed = (folder / f"{name}.yaml" for name in ("start", "fitted", "fixed"))
        start.write_text(model)
        subprocess.run([SEAM, "fit", "--model", start, "--data", folder / "rest", "--out", fitted], check=True,
                       timeout=600)
        # Plain numbers stay as they are.
        fixed.write_text(re.sub(r"\{value: ([^,}]+), [^}]*\}", r"\1", fitted.read_text().split("history:")[0]))
        answer = folder / "compare.json"
        subprocess.run([SEAM, "compare", "--model", fixed, "--data", folder / "new", "--json", answer], check=True,
                       timeout=100)
        rms = json.loads(answer.read_text())["native"]["measured_rad"]
        print(f"the gain left out: {rms:.4f} rad")
        assert rms < MOST_RAD, rms
    return 0


if __name__ == "__main__":
    sys.exit(main())
