#!/usr/bin/env python3
"""What `seam export` writes is read by the programs that it is written for, where they are installed
(python3-opencv, mrcal, ROS's camera_calibration_parsers), and projects a grid as the model does.
`export_test.py path/to/seam CXX`

The model's projection is written out here again, from docs/reference/effects.md, in numpy.
"""
import json
import pathlib
import subprocess
import tempfile

import numpy as np
import yaml

import by_hand

SEAM, CXX = by_hand.arguments("seam", "cxx")
HERE = pathlib.Path(__file__).resolve().parent
MODEL = """format: seam-model/1
name: seen
effects:
  pinhole: {fx_px: 161.9, fy_px: 162.5, cx_px: 88.5, cy_px: 71.5}
  radial_polynomial: {k1: -0.21, k2: 0.06, k3: 0.002}
  tangential_distortion: {p1: 0.003, p2: -0.002}
  rolling_shutter: {line_delay_s: {value: 0.0002, sigma: 1.0e-6}}
"""
SIZE = ["--size", "178x144"]


def grid():
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, 21), np.linspace(-0.4, 0.4, 17))
    return np.stack([x.ravel(), y.ravel(), np.ones(x.size)], axis=1)


def expected(points):
    x, y = points[:, 0], points[:, 1]
    r2 = x * x + y * y
    radial = 1 - 0.21 * r2 + 0.06 * r2**2 + 0.002 * r2**3
    xd = x * radial + 2 * 0.003 * x * y - 0.002 * (r2 + 2 * x * x)
    yd = y * radial + 0.003 * (r2 + 2 * y * y) - 2 * 0.002 * x * y
    return np.stack([161.9 * xd + 88.5, 162.5 * yd + 71.5], axis=1)


def export(folder, form, name, *more, code=0):
    model = folder / "model.yaml"
    model.write_text(MODEL)
    out = folder / name
    run = subprocess.run([SEAM, "export", str(model), "--to", form, "--out", str(out), *more],
                         capture_output=True, text=True)
    assert run.returncode == code, (run.returncode, run.stdout, run.stderr)
    return out, run.stdout + run.stderr


def agrees(what, seen, limit_px=1e-6):
    worst = np.abs(seen - expected(grid())).max()
    assert worst < limit_px, f"{what}: {worst} px"
    print(f"{what}: projects as the model does, to {worst:.1e} px")


def servo(folder):
    """A servo as a simulator's attributes, for an inertia of 1."""
    import xml.etree.ElementTree as xml
    model = folder / "servo.yaml"
    text = """format: seam-model/1
name: arm
effects:
  motor_servo: {stall_rad_per_s2: {value: 200, sigma: 3}, back_emf_per_s: 8, gain: 0.5, damping_s: 0.01, max_duty: 0.9}
  viscous_friction: {per_s: 2}
  coulomb_friction: {rad_per_s2: 5}
"""
    model.write_text(text)

    def export_servo(form, *more, code=0):
        out = folder / f"arm.{form}"
        out.unlink(missing_ok=True)
        run = subprocess.run([SEAM, "export", str(model), "--to", form, "--out", str(out), *more],
                             capture_output=True, text=True)
        assert run.returncode == code, run.stderr
        return (xml.parse(out).getroot() if code == 0 else None), run.stdout + run.stderr

    root, said = export_servo("mjcf")
    joint, actuator = root.find(".//joint"), root.find(".//position")
    assert joint.attrib == {"damping": "10", "frictionloss": "5"} and "inertia of 1" in said, joint.attrib
    assert (float(actuator.get("kp")), float(actuator.get("kv"))) == (100, 2), actuator.attrib
    assert actuator.get("forcerange") == "-180 180", actuator.attrib
    root, _ = export_servo("urdf")
    assert root.find(".//dynamics").attrib == {"damping": "10", "friction": "5"}
    limit = root.find(".//limit")
    assert (float(limit.get("effort")), float(limit.get("velocity"))) == (180, 22.5), limit.attrib
    # What the stiffness is to be multiplied by; a set whose controller had one gain gets that one.
    data = folder / "log"
    data.mkdir()
    (data / "measurement.yaml").write_text("format: seam-measurement/1\nkind: joints\ngroup: run\nfiles: {joints: joints.csv}\n")
    rows = ["run,time_s,joint,command_rad,measured_rad,kp"]
    for kp in (6, 12):
        rows += [f"{kp},{0.01 * i:.2f},arm,{0.1 * i:.3f},{0.09 * i:.3f},{kp}" for i in range(20)]
    (data / "joints.csv").write_text("\n".join(rows) + "\n")
    for more, words in [([], "multiply kp by the gain"), (["--data", str(data)], "6, 12")]:
        root, said = export_servo("mjcf", *more)
        assert words in said and words in (folder / "arm.mjcf").read_text(), said
        assert root.find(".//position").get("kp") == "100"
    (data / "joints.csv").write_text("\n".join(rows[:21]) + "\n")
    root, said = export_servo("mjcf", "--data", str(data))
    assert root.find(".//position").get("kp") == "600" and "controller gain of the set, 6" in said, said
    for effect in ("torque_cogging: {rad_per_s2: 8, per_turn: 12}", "friction_asymmetry: {rad_per_s2: 3}"):
        model.write_text(f"{text}  {effect}\n")
        _, said = export_servo("mjcf", code=1)
        assert f"'{effect.split(':')[0]}'" in said
    model.write_text(text + "  servo_latency: {latency_s: 0.02}\n")
    _, said = export_servo("mjcf", code=1)
    assert "'servo_latency'" in said
    _, said = export_servo("mjcf", "--drop", "servo_latency")
    assert "without servo_latency: up to" in said and "mrad" in said, said
    model.write_text("format: seam-model/1\nname: k\neffects:\n  ideal_servo: {}\n  servo_lag: {tau_s: 0.05}\n"
                     "  speed_limit: {rad_per_s: 3}\n")
    _, said = export_servo("mjcf", code=1)
    assert "'speed_limit'" in said
    root, _ = export_servo("mjcf", "--drop", "speed_limit")
    assert root.find(".//position").get("timeconst") == "0.05"
    root, _ = export_servo("urdf", "--drop", "servo_lag")
    assert root.find(".//limit").get("velocity") == "3"
    model.write_text(MODEL)
    _, said = export_servo("urdf", code=1)
    assert "holds a servo" in said
    print("servos: attributes for a simulator")


def ros_reads(folder, path):
    """Whether ROS's own reader is there; it must find what the model says."""
    reader = folder / "camera_info_reader"
    made = subprocess.run([CXX, "-std=c++17", HERE / "camera_info_reader.cc", "-o", reader, "-lcamera_calibration_parsers"],
                          capture_output=True, text=True)
    if made.returncode != 0:
        assert "camera_calibration_parsers" in made.stderr, made.stderr
        return False
    size, lens, matrix, coefficients = subprocess.run([reader, path], capture_output=True, text=True,
                                                      check=True).stdout.splitlines()
    numbers = [np.array(line.split(), float) for line in (size, matrix, coefficients)]
    assert numbers[0].tolist() == [178, 144] and lens == "plumb_bob", (size, lens)
    assert np.allclose(numbers[1], [161.9, 0, 88.5, 0, 162.5, 71.5, 0, 0, 1], atol=1e-6), matrix
    assert np.allclose(numbers[2], [-0.21, 0.06, 0.003, -0.002, 0.002], atol=1e-6), coefficients
    print("ros: read by camera_calibration_parsers")
    return True


def main():
    skipped = []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        # What cannot be held is refused by name, and leaves no file.
        out, said = export(folder, "opencv", "refused.yaml", *SIZE, code=1)
        assert "'rolling_shutter'" in said and not out.exists(), said
        _, said = export(folder, "opencv", "unknown.yaml", "--drop", "lens_blur", *SIZE, code=1)
        assert "lens_blur" in said
        _, said = export(folder, "opencw", "x.yaml", code=2)
        assert "opencv" in said

        out, said = export(folder, "ros", "ros.yaml", "--drop", "rolling_shutter", *SIZE)
        assert "4.63 px while the camera turns by 1 rad/s" in said, said
        info = yaml.safe_load(out.read_text())
        assert info["distortion_model"] == "plumb_bob" and info["image_width"] == 178
        assert np.allclose(info["distortion_coefficients"]["data"],
                           [-0.21, 0.06, 0.003, -0.002, 0.002], atol=1e-6)
        if not ros_reads(folder, out):
            skipped.append("libcamera-calibration-parsers-dev")

        _, said = export(folder, "kalibr", "camchain.yaml", *SIZE)
        chain = yaml.safe_load((folder / "camchain.yaml").read_text())["cam0"]
        assert chain["line_delay"] == 0.0002 and chain["distortion_model"] == "radtan", chain
        assert "misses by" in said  # k3 is not radtan's.

        out, _ = export(folder, "json", "model.json")
        effects = json.loads(out.read_text())["effects"]
        assert effects["rolling_shutter"]["line_delay_s"] == {"value": 0.0002, "sigma": 1e-6}

        _, said = export(folder, "mrcal", "x", "--form", "fisheye", "--drop", "all", *SIZE, code=2)
        assert "ordinary, rational" in said, said
        fisheye, said = export(folder, "opencv", "fisheye.yaml", "--form", "fisheye", "--drop", "all", *SIZE)
        assert "lens: fisheye" in said and "# Lens: fisheye" in fisheye.read_text(), said
        opencv, said = export(folder, "opencv", "opencv.yaml", "--drop", "all", *SIZE)
        assert "lens: ordinary (k1, k2, p1, p2, k3)" in said and "# Lens: ordinary" in opencv.read_text(), said
        mrcal_file, _ = export(folder, "mrcal", "mrcal.cameramodel", "--drop", "all", *SIZE)
        try:
            import cv2
            store = cv2.FileStorage(str(opencv), cv2.FILE_STORAGE_READ)
            seen, _ = cv2.projectPoints(grid(), np.zeros(3), np.zeros(3),
                                        store.getNode("camera_matrix").mat(),
                                        store.getNode("distortion_coefficients").mat())
            agrees("opencv", seen[:, 0])
        except ImportError:
            skipped.append("python3-opencv")
        try:
            import mrcal
            agrees("mrcal", mrcal.project(grid(), *mrcal.cameramodel(str(mrcal_file)).intrinsics()))
        except ImportError:
            skipped.append("mrcal")
        servo(folder)
    if skipped:
        print("not installed, not tried:", ", ".join(skipped))


main()
