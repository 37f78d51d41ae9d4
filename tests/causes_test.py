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
    "mount_sag": ("points", "{mount_sag: {tilt_rad: 0.03}}"),
    "focal_drift": ("points", "{focal_drift: {per_s: 0.004}}"),
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


def with_exposures(folder):
    """The room of the tutorial, in which every second frame is exposed ten times as long."""
    folder.mkdir()
    for file in (source / "docs/tutorial/room").iterdir():
        (folder / file.name).write_bytes(file.read_bytes())
    with (folder / "points.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        row["exposure_s"] = 0.02 if int(row["frame"]) % 2 else 0.002
    with (folder / "points.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
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


for test in (test_stamps_of_exposures, test_studies):
    with tempfile.TemporaryDirectory() as folder:
        test(pathlib.Path(folder))
