#!/usr/bin/env python3
"""Sets of ranges end to end: made, compared, an effect found, wrong input refused. `ranges_test.py path/to/seam`"""
import json
import pathlib
import subprocess
import tempfile

import by_hand

SEAM = by_hand.arguments("seam")

MODEL = """format: seam-model/1
name: base
effects:
  pinhole: {fx_px: 161.9, fy_px: 162.5, cx_px: 88.5, cy_px: 71.5}
  lens_blur: {sigma_px: 0.8}
  shot_noise: {electrons_per_dn: 50}
  read_noise: {sigma_dn: 1.5}
"""
SET = """format: seam-measurement/1
kind: ranges
scene: scene.yaml
detector: ball_ranger
files: {ranges: ranges.csv}
"""
SCENE = """format: seam-scene/1
background_rgb: [0.85, 0.85, 0.82]
objects:
  - {shape: rectangle, centre_m: [1, 0, 0], size_m: [4.2, 2.7], rgb: [0.04, 0.3, 0.07]}
  - {shape: sphere, centre_m: [0.8, 0.0, 0.042], radius_m: 0.042, rgb: [0.9, 0.28, 0.02]}
"""
PLACES = [(0.25, 0), (0.4, 0.25), (0.55, -0.3), (0.7, 0), (0.9, 0.25), (1.1, -0.3)]


def run(*arguments):
    return subprocess.run([str(SEAM), *map(str, arguments)], capture_output=True, text=True, timeout=300)


def good(*arguments):
    done = run(*arguments)
    assert done.returncode == 0, (arguments, done.stdout, done.stderr)
    return done


def refused(*arguments, saying):
    done = run(*arguments)
    assert done.returncode == 1 and all(part in done.stderr for part in saying), (done.returncode, done.stderr, saying)


def write(folder, table, set_yaml=SET, scene=SCENE):
    folder.mkdir(exist_ok=True)
    (folder / "measurement.yaml").write_text(set_yaml)
    (folder / "scene.yaml").write_text(scene)
    (folder / "ranges.csv").write_text(table)
    return folder


def main(scratch):
    model = scratch / "model.yaml"
    model.write_text(MODEL)
    table = "trial,true_m,bearing_rad\n" + "".join(f"{k},{d},{b}\n" for d, b in PLACES for k in range(12))
    protocol = write(scratch / "protocol", table)

    # Noise-free distances are the same in every trial; noise and seed count.
    good("measure", "--model", model, "--protocol", protocol, "--out", scratch / "clean", "--noise", "off")
    lines = (scratch / "clean/ranges.csv").read_text().splitlines()
    assert lines[0] == "trial,true_m,bearing_rad,measured_m" and len(lines) == 73, lines[0]
    assert len({line.split(",", 1)[1] for line in lines[1:]}) == len(PLACES), lines
    for seed in (1, 2):
        good("measure", "--model", model, "--protocol", protocol, "--seed", seed, "--out", scratch / f"none{seed}")
    assert (scratch / "none1/ranges.csv").read_text() != (scratch / "none2/ranges.csv").read_text()
    good("measure", "--model", model, "--protocol", scratch / "none2", "--seed", 1, "--out", scratch / "again")
    assert (scratch / "none1/ranges.csv").read_text() == (scratch / "again/ranges.csv").read_text()

    # The model that made them fits; one with another focal length does not, until its error is fitted.
    def compared(model_file, data):
        good("compare", "--model", model_file, "--data", data, "--json", scratch / "compare.json")
        return json.loads((scratch / "compare.json").read_text())
    same = compared(model, scratch / "none1")
    assert same["error"] < 1.3 and not same["structure"], same
    assert set(same["native"]) == {"mean_m", "spread_m"}, same
    truth = scratch / "truth.yaml"
    truth.write_text(MODEL + "  focal_length_error: {fx_scale: 0.04, fy_scale: 0.04}\n")
    good("measure", "--model", truth, "--protocol", protocol, "--seed", 3, "--out", scratch / "focal")
    wrong = compared(model, scratch / "focal")
    assert wrong["error"] > 1.6 and any(s["residual"] == "mean_m" for s in wrong["structure"]), wrong
    assert compared(truth, scratch / "focal")["error"] < 1.3
    done = good("add", "focal_length_error", "--model", model, "--data", scratch / "focal", "--out", scratch / "found.yaml",
                "--json", scratch / "add.json")
    added = json.loads((scratch / "add.json").read_text())
    assert added["error_after"] < 0.5 * added["error_before"], (added, done.stdout)
    # A ball's size is that of both focal lengths together.
    scales = [added["parameters"][name]["value"] for name in ("fx_scale", "fy_scale")]
    assert abs(sum(scales) / 2 - 0.04) < 0.02, added

    # What is wrong is said with its place.
    row = "1,0.5,0.52\n"
    head = "trial,true_m,measured_m\n"
    bad = scratch / "bad"
    for cells, saying in [("1,nan,0.5\n", ["ranges.csv:2", "true_m", "nan"]), ("1,0.5,\n", ["ranges.csv:2", "measured_m"]),
                          (row + "2,-1,0.5\n", ["ranges.csv:3", "true_m", "-1"]), ("1,0.5,0\n", ["measured_m"]),
                          ("1,0.5\n", ["ranges.csv:2"]), ("", ["ranges.csv", "no rows"])]:
        refused("compare", "--model", model, "--data", write(bad, head + cells), saying=saying)
    refused("compare", "--model", model, "--data", write(bad, "true_m,measured_m\n0.5,0.5\n"), saying=["trial"])
    refused("compare", "--model", model, "--data", write(bad, head + row, SET.replace("ball_ranger", "eye")),
            saying=["measurement.yaml:4", "eye", "ball_ranger"])
    refused("compare", "--model", model, "--data", write(bad, head + row, SET.replace("scene.yaml", "none.yaml")),
            saying=["measurement.yaml:3", "none.yaml"])
    refused("compare", "--model", model, "--data", write(bad, head + row, scene=SCENE.replace("sphere", "box")),
            saying=["scene.yaml"])
    refused("compare", "--model", model, "--data", write(bad, head + "1,15,15.1\n"), saying=["ranges.csv:2", "no ball", "15"])

    # One place alone: no effect can be distinguished from another.
    one = "".join(f"{k},0.5,{0.53 + 0.001 * k}\n" for k in range(8))
    good("diagnose", "--model", model, "--data", write(bad, head + one), "--json", scratch / "one.json")
    found = json.loads((scratch / "one.json").read_text())
    assert not found["candidates"] and any("one place" in n["why"] for n in found["not_testable"]), found
    print("ok")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        main(pathlib.Path(folder))
