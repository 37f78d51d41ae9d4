#!/usr/bin/env python3
"""Causes that people have, hidden in made sets: `seam` names each alone, and one that needs a column of the log is no
candidate without it. Usage: causes_test.py SEAM SOURCE_DIR"""
import csv
import json
import pathlib
import subprocess
import tempfile

import by_hand

seam, source = by_hand.arguments("seam", "source")

HIDDEN = {
    "landmark_height": ("landmarks", "{landmark_height: {z_m: 0.5}}"),
    "wall_excess": ("landmarks", "{wall_excess: {size_m: 0.1, direction_rad: 1.5708, at_m: 0.5, reach_m: 0.4}}"),
    "dark_current_spread": ("photometry", "{dark_current_spread: {sigma_dn_per_s: 60}}"),
    "noise_filter": ("photometry", "{noise_filter: {along_rows: 0.08, along_columns: 0.05}}"),
    "tap_gain": ("photometry", "{tap_gain: {odd_rows: 0.01}}"),
    "mount_sag": ("points", "{mount_sag: {tilt_rad: 0.03}}"),
    "focal_drift": ("points", "{focal_drift: {per_s: 0.004}}"),
    "elastic_joint": ("joints", "{elastic_joint: {period_s: 0.11, damping: 0.1}}"),
    "gear_ripple": ("joints", "{gear_ripple: {amplitude_rad: 0.002, per_turn: 37.3, phase_rad: 0.5}}"),
}


def ask(*command):
    done = subprocess.run([seam, *map(str, command)], capture_output=True, text=True)
    assert done.returncode == 0, (command, done.stderr)
    return done.stdout


def test_studies(scratch):
    for effect, (kind, hidden) in HIDDEN.items():
        ask("study", kind, "--hide", hidden, "--seeds", "1", "--first-seed", "3", "--jobs", "1", "--json", scratch / "study.json")
        row = json.loads((scratch / "study.json").read_text())["rows"][0]
        assert row["exact"]["hits"] == 1, (effect, row)


def with_column(folder, table, name, value_of_row):
    """Adds a column to a table of a set."""
    with (folder / table).open(newline="") as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        row[name] = value_of_row(row)
    with (folder / table).open("w", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def room(folder):
    """The room of the tutorial."""
    folder.mkdir()
    for file in (source / "docs/tutorial/room").iterdir():
        (folder / file.name).write_bytes(file.read_bytes())
    return folder


def with_exposures(folder):
    """The room, in which every second frame is exposed ten times as long."""
    room(folder)
    with_column(folder, "points.csv", "exposure_s", lambda row: 0.02 if int(row["frame"]) % 2 else 0.002)
    return folder


def test_stamps_of_exposures(scratch):
    """No latency explains both sorts of frames."""
    truth = scratch / "starts.yaml"
    truth.write_text("format: seam-model/1\nname: made\neffects:\n"
                     "  pinhole: {fx_px: 161.9, fy_px: 162.5, cx_px: 88.5, cy_px: 71.5}\n"
                     "  exposure_stamp: {per_exposure: 0.5}\n")
    ask("measure", "--model", truth, "--protocol", with_exposures(scratch / "exposed"), "--seed", "4", "--out", scratch / "starts")
    nominal = source / "docs/tutorial/nominal.yaml"
    ask("discover", "--model", nominal, "--data", scratch / "starts", "--out", scratch / "found.yaml", "--json", scratch / "found.json")
    found = {step["effect"]: step for step in json.loads((scratch / "found.json").read_text())["steps"]}
    assert list(found) == ["exposure_stamp"], found
    assert abs(found["exposure_stamp"]["parameters"]["per_exposure"]["value"] - 0.5) < 0.05, found
    assert "frame_latency" not in found["exposure_stamp"].get("indistinguishable_from", []), found
    # Without the column, the effect is no candidate.
    ask("measure", "--model", nominal, "--protocol", source / "docs/tutorial/room", "--seed", "4", "--out", scratch / "plain")
    refused = subprocess.run([seam, "add", "exposure_stamp", "--model", nominal, "--data", scratch / "plain", "--out",
                              scratch / "no.yaml"], capture_output=True, text=True)
    assert refused.returncode == 1 and "exposure_s" in refused.stderr, refused


def test_lens_that_warms(scratch):
    """A room seen by a camera that warms up and cools down; a column with one value constrains nothing."""
    nominal = source / "docs/tutorial/nominal.yaml"
    truth = write_model(scratch / "warm.yaml", "  pinhole: {fx_px: 161.9, fy_px: 162.5, cx_px: 88.5, cy_px: 71.5}\n"
                                               "  focal_temperature: {per_k: 3e-4}\n")

    def measured(name, warmth):
        protocol = room(scratch / f"{name} protocol")
        with_column(protocol, "points.csv", "temperature_c", warmth)
        ask("measure", "--model", truth, "--protocol", protocol, "--seed", "4", "--out", scratch / name)
        return scratch / name
    warm = measured("warm", lambda row: 10 + 8 * (5 * int(row["frame"]) % 9))
    ask("discover", "--model", nominal, "--data", warm, "--out", scratch / "found.yaml", "--json", scratch / "found.json")
    found = {step["effect"]: step for step in json.loads((scratch / "found.json").read_text())["steps"]}
    assert list(found) == ["focal_temperature"], found
    value = found["focal_temperature"]["parameters"]["per_k"]
    assert abs(value["value"] - 3e-4) < 4 * value["sigma"] < 1e-4, value
    even = measured("even", lambda row: 31.5)
    said = ask("check", even, "--model", nominal)
    assert "the column temperature_c is 31.5 in every row" in said, said
    ask("measure", "--model", nominal, "--protocol", source / "docs/tutorial/room", "--seed", "4", "--out", scratch / "no column")
    for names in (("compare", "--model", truth),
                  ("add", "focal_temperature", "--model", nominal, "--out", scratch / "no.yaml")):
        refused = subprocess.run([seam, *map(str, names), "--data", scratch / "no column"], capture_output=True, text=True)
        assert refused.returncode == 1 and "temperature_c" in refused.stderr, refused
    with_column(room(scratch / "kelvin"), "points.csv", "temperature_c", lambda row: 295)
    refused = subprocess.run([seam, "measure", "--model", truth, "--protocol", scratch / "kelvin", "--out", scratch / "no"],
                             capture_output=True, text=True)
    assert refused.returncode == 1 and "degrees Celsius" in refused.stderr, refused
    # No camera file holds it.
    for more, code in ((), 1), (("--drop", "focal_temperature"), 0):
        done = subprocess.run([seam, "export", truth, "--to", "opencv", "--out", scratch / "camera.yaml", "--size", "178x144",
                               *more], capture_output=True, text=True)
        assert done.returncode == code and "focal_temperature" in done.stdout + done.stderr, done


def write_model(path, effects):
    path.write_text(f"format: seam-model/1\nname: made\neffects:\n{effects}")
    return path


def test_motors(scratch):
    """Steps of a motor at two gains that warms up from run to run, with and without its temperatures."""
    protocol = scratch / "moves"
    protocol.mkdir()
    rows = ["run,time_s,joint,command_rad,kp"]
    for run in range(6):
        for k in range(120):
            command = ((7 * run + 5 * (k // 40)) % 9 - 4) * 0.25 if k > 1 else 0
            rows.append(f"{run},{0.01 * k:.2f},arm,{command},{1 + run % 2}")
    (protocol / "joints.csv").write_text("\n".join(rows) + "\n")
    (protocol / "measurement.yaml").write_text("format: seam-measurement/1\nkind: joints\ntitle: moves\n"
                                               "noise: {measured_rad: 0.0005}\ngroup: run\nfiles: {joints: joints.csv}\n")
    motor = "  motor_servo: {stall_rad_per_s2: 200, back_emf_per_s: 10, gain: 0.3}\n"
    nominal = write_model(scratch / "motor.yaml", motor)
    ask("measure", "--model", nominal, "--protocol", protocol, "--seed", "4", "--out", scratch / "plain")
    refused = subprocess.run([seam, "add", "motor_heating", "--model", nominal, "--data", scratch / "plain", "--out",
                              scratch / "no.yaml"], capture_output=True, text=True)
    assert refused.returncode == 1 and "temperature_c" in refused.stderr, refused
    with_column(protocol, "joints.csv", "temperature_c", lambda row: 25 + 7 * int(row["run"]))
    for effect, parameter, value in (("motor_heating", "per_k", 0.004), ("friction_asymmetry", "rad_per_s2", -1.5)):
        truth = write_model(scratch / f"{effect}.yaml", motor + f"  {effect}: {{{parameter}: {value}}}\n")
        ask("measure", "--model", truth, "--protocol", protocol, "--seed", "4", "--out", scratch / effect)
        ask("discover", "--model", nominal, "--data", scratch / effect, "--out", scratch / "found.yaml", "--json",
            scratch / "found.json")
        found = {step["effect"]: step for step in json.loads((scratch / "found.json").read_text())["steps"]}
        assert list(found) == [effect], found
        assert abs(found[effect]["parameters"][parameter]["value"] / value - 1) < 0.1, found


for test in (test_motors, test_stamps_of_exposures, test_lens_that_warms, test_studies):
    with tempfile.TemporaryDirectory() as folder:
        test(pathlib.Path(folder))
