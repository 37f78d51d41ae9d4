#!/usr/bin/env python3
"""`seam import wheels` on drives whose truth is known: counts and speeds of any names and units, motion capture beside them or
in a file with its own clock. Files that another import reads. `import_wheels_test.py path/to/seam`"""
import json

import numpy as np

from importing import RNG, imported, refused, rows_of, run, run_tests

BASE, PER_TICK = 0.3, 1e-4  # What the maker says.
LEFT, RIGHT, WIDER = 0.012, -0.004, 0.02  # What is wrong with it.
STEP = 0.05
N = 2400


def drive(n=N, fine=10):
    """Times, what the wheels turned until then in ticks (not rounded), poses, speeds of the wheels."""
    dt = STEP / fine
    t = np.arange(n * fine) * dt
    v = 0.35 + 0.2 * np.sin(0.7 * t)
    w = 0.9 * np.sin(0.37 * t + 0.4) + 0.35 * np.sin(1.3 * t)
    theta = np.concatenate([[0.3], 0.3 + np.cumsum(w * dt)])[:-1]
    middle = theta + 0.5 * w * dt
    x = np.concatenate([[1.0], 1.0 + np.cumsum(v * np.cos(middle) * dt)])[:-1]
    y = np.concatenate([[2.0], 2.0 + np.cumsum(v * np.sin(middle) * dt)])[:-1]
    base = BASE * (1 + WIDER)
    speeds = np.stack([(v - 0.5 * base * w) / (PER_TICK * (1 + LEFT)), (v + 0.5 * base * w) / (PER_TICK * (1 + RIGHT))], 1)
    turned = np.concatenate([[[0, 0]], np.cumsum(speeds * dt, axis=0)])[:-1]
    return t, turned, np.stack([x, y, theta], 1), speeds


T, TURNED, POSES, SPEEDS = drive()
ROWS = slice(0, None, 10)


def seen(poses):
    return poses + RNG.standard_normal(poses.shape) * [0.001, 0.001, 0.002]


def table(path, header, columns, digits=6):
    columns = [np.asarray(c) for c in columns]
    path.write_text(header + "\n" + "".join(
        ",".join(f"{x:d}" if isinstance(x, (int, np.integer)) else f"{x:.{digits}f}" for x in row) + "\n"
        for row in zip(*columns)))
    return path


def found_in(out, folder):
    run("discover", "--model", out / "nominal.yaml", "--data", out, "--out", folder / "d.yaml", "--json", folder / "d.json")
    found = json.loads((folder / "d.json").read_text())
    return found, {f"{s['effect']}.{n}": p for s in found["steps"] for n, p in s["parameters"].items()}


def holds_truth(out, folder):
    """Wheels and base are found off as they were made."""
    found, values = found_in(out, folder)
    for name, truth in (("wheel_scale.left", LEFT), ("wheel_scale.right", RIGHT), ("base_scale.scale", WIDER)):
        assert name in values, (name, values)
        assert abs(values[name]["value"] - truth) < max(4 * values[name]["sigma"], 3e-4), (name, values[name])
    assert found["error"] < 1.1, found["error"]


def counts():
    return np.floor(TURNED[ROWS]).astype(int)


STATED = ["--base", BASE, "--metres-per-tick", PER_TICK]


def test_counters_in_one_table(folder):
    """Counters of 16 bits that wrap around, milliseconds, names of their own."""
    c = (counts() + 30000) % 65536
    path = table(folder / "log.csv", "stamp [ms],zaehlerL,zaehlerR,x,y,yaw",
                 [np.round(1000 * T[ROWS]).astype(int), c[:, 0], c[:, 1], *seen(POSES[ROWS]).T])
    said = imported("wheels", path, "--map", "left=zaehlerL,right=zaehlerR", *STATED, out=folder / "set")
    assert "wrapped around" in said and "go on counting" in said, said
    rows = rows_of(folder / "set" / "odometry.csv")
    true = np.diff(counts(), axis=0)
    for i in range(1, len(rows)):
        at = round(float(rows[i]["time_s"]) / STEP)
        assert int(rows[i]["left_ticks"]) == true[at - 1, 0], rows[i]
    holds_truth(folder / "set", folder)
    refused("wheels", path, "--map", "left=zaehlerL,right=zaehlerX", out=folder / "no", words=["zaehlerX", "did you mean"])


def test_ticks_since_the_row_before(folder):
    c = np.diff(counts(), axis=0, prepend=0)
    path = table(folder / "log.csv", "t,left_ticks,right_ticks,x_mm,y_mm,theta_deg",
                 [T[ROWS], c[:, 0], c[:, 1], *(seen(POSES[ROWS]) * [1000, 1000, 180 / np.pi]).T])
    said = imported("wheels", path, *STATED, out=folder / "set")
    assert "since the row before" in said, said
    holds_truth(folder / "set", folder)
    # Our own table is read again.
    imported("wheels", folder / "set" / "odometry.csv", *STATED, out=folder / "again")
    again = rows_of(folder / "again" / "odometry.csv")
    assert {r["run"] for r in again} == {r["run"] for r in rows_of(folder / "set" / "odometry.csv")}


def test_motion_capture_with_a_clock_of_its_own(folder):
    """Another rate, another epoch, a quaternion, millimetres."""
    fine = slice(3, None, 2)
    poses = seen(POSES[fine])
    half = 0.5 * poses[:, 2]
    wheels = table(folder / "wheels.csv", "time,enc_left,enc_right", [12.0 + T[ROWS], *counts().T])
    mocap = table(folder / "mocap.csv", "time,pos_x,pos_y,pos_z,qw,qx,qy,qz",
                  [1.7e9 + 40.125 + T[fine], *(1000 * poses[:, :2]).T, 0 * half + 120, np.cos(half), 0 * half, 0 * half,
                   np.sin(half)], 9)
    said = imported("wheels", wheels, mocap, "--length-unit", "x=mm,y=mm,z=mm", *STATED, out=folder / "set")
    assert "the poses' clock is put forward by -1700000028." in said, said
    shift = float(said.split("put forward by ")[1].split(" s")[0])
    assert abs(shift - (12 - 1.7e9 - 40.125)) < 0.02, shift
    holds_truth(folder / "set", folder)
    # The same clock: nothing is shifted, and the same is found.
    mocap = table(folder / "mocap.csv", "pt,pos_x,pos_y,heading", [12.0 + T[fine], *poses.T])
    said = imported("wheels", wheels, mocap, "--map", "pose_time=pt", *STATED, out=folder / "same")
    assert "put forward" not in said, said
    holds_truth(folder / "same", folder)
    # Slower than the wheels: each pose tells one row.
    slow = slice(0, None, 40)
    mocap = table(folder / "slow.csv", "time,x,y,theta", [12.0 + T[slow], *seen(POSES[slow]).T])
    imported("wheels", wheels, mocap, *STATED, out=folder / "slow")
    rows = rows_of(folder / "slow" / "odometry.csv")
    assert sum(r["x_m"] != "" for r in rows) == len(T[slow]), len(rows)


def test_speeds_of_wheels(folder):
    """Turns in radians per second with the wheels' radius, in rpm, and metres per second."""
    radius = 0.05
    poses = seen(POSES[ROWS])
    for name, factor, more in (("left_vel [rad/s]", PER_TICK / radius, ["--radius", radius]),
                               ("left_rpm", PER_TICK / radius * 30 / np.pi, ["--radius", radius]),
                               ("left_speed_mps", PER_TICK, [])):
        path = table(folder / "log.csv", f"time,{name},{name.replace('left', 'right')},x,y,theta",
                     [T[ROWS], *(factor * SPEEDS[ROWS]).T, *poses.T], 8)
        out = folder / name.split()[0]
        imported("wheels", path, "--base", BASE, *more, out=out)
        holds_truth(out, folder)


def test_velocities_and_poses(folder):
    """Commanded velocities that the body follows 6 % too slowly."""
    k = np.arange(N)
    v, w = 0.3 + 0.2 * np.sign(np.sin(0.11 * k * STEP * 6)), 0.8 * np.sign(np.sin(0.05 * k * STEP * 7 + 1))
    theta = 0.2 + np.concatenate([[0], np.cumsum(w * STEP)[:-1]])
    middle = theta + 0.5 * w * STEP
    chord = np.sinc(w * STEP / 2 / np.pi) * 0.94 * v * STEP
    x, y = (np.concatenate([[0], np.cumsum(chord * f(middle))[:-1]]) for f in (np.cos, np.sin))
    command = table(folder / "cmd.csv", "t,linear.x,angular_z [deg/s]", [k * STEP, v, 180 / np.pi * w])
    poses = table(folder / "poses.csv", "t,x,y,yaw,vx,omega", [k * STEP, *seen(np.stack([x, y, theta], 1)).T, v, w])
    imported("wheels", command, poses, out=folder / "set")
    found, values = found_in(folder / "set", folder)
    assert abs(values["odometry_scale.vx_scale"]["value"] + 0.06) < 2e-3, values
    one = table(folder / "one.csv", "t,v,w,x,y,theta", [k * STEP, v, w, *seen(np.stack([x, y, theta], 1)).T])
    imported("wheels", one, "--base", BASE, out=folder / "one")
    assert "differential_drive" in (folder / "one" / "nominal.yaml").read_text()
    more = table(folder / "more.csv", "t,v,w,x,y,theta,carpet,row", [k * STEP, v, w, *seen(np.stack([x, y, theta], 1)).T, k // 90 % 2, k])
    said = imported("wheels", more, out=folder / "more")
    assert "left out: carpet; an error that may depend on such a column shows once it stands in odometry.csv" in said, said


def test_what_is_not_said_is_estimated(folder):
    path = table(folder / "log.csv", "time,left_ticks,right_ticks,x,y,theta", [T[ROWS], *counts().T, *seen(POSES[ROWS]).T])
    said = imported("wheels", path, out=folder / "set")
    assert "estimated from the drive itself" in said and "--base" in said, said
    nominal = (folder / "set" / "nominal.yaml").read_text()
    assert nominal.count("free: true") == 2, nominal
    value = float(nominal.split("metres_per_tick: {value: ")[1].split(",")[0])
    assert abs(value / PER_TICK - 1) < 0.02, nominal
    value = float(nominal.split("base_m: {value: ")[1].split(",")[0])
    assert abs(value / BASE / (1 + WIDER) - 1) < 0.02, nominal


def test_refusals(folder):
    wheels = table(folder / "wheels.csv", "time,left_ticks,right_ticks", [T[ROWS], *counts().T])
    refused("wheels", wheels, out=folder / "no", words=["wheels.csv:1", "where the body was seen"])
    poses = table(folder / "poses.csv", "time,x,y", [T[ROWS], *POSES[ROWS, :2].T])
    refused("wheels", wheels, poses, out=folder / "no", words=["no heading", "theta"])
    poses = table(folder / "poses.csv", "time,x,y,z,theta",
                  [T[ROWS], *POSES[ROWS, :2].T, 4 * np.sin(0.2 * T[ROWS]), POSES[ROWS, 2]])
    refused("wheels", wheels, poses, out=folder / "no", words=["poses.csv", "leaves the plane"])
    other = table(folder / "poses.csv", "time,x,y,theta", [5000 + T[ROWS], *RNG.standard_normal((3, len(T[ROWS])))])
    refused("wheels", wheels, other, out=folder / "no", words=["times go from", "pose_time"])
    refused("wheels", wheels, "--base", "-1", out=folder / "no", words=["--base"], code=2)
    right = table(folder / "right.csv", "time,x,y,theta", [T[ROWS], *POSES[ROWS].T])
    refused("wheels", wheels, right, "--base", "240", out=folder / "no", words=["--base 240", "--base 0.24 if it is in millimetres"])
    refused("wheels", wheels, "--unit", "banana=deg", out=folder / "no", words=["unknown name 'banana'", "left"], code=2)
    (folder / "servo.csv").write_text("time,command,position\n0,1,2\n1,2,3\n")
    refused("servo", folder / "servo.csv", "--unit", "command=deg", out=folder / "no", words=["one unit for all"], code=2)


def test_files_that_another_import_reads(folder):
    """An import that a file is not for names the one that it is for."""
    t = np.arange(30) * 0.1
    files = {
        "kalibr": table(folder / "corners.csv", "frame,point,u,v", [t.astype(int), np.arange(30), 100 + t, 50 + t]),
        "servo": table(folder / "swing.csv", "time,goal_position,present_position", [t, np.sin(t), np.sin(t - 0.1)]),
        "wheels": table(folder / "run.csv", "time,enc_left,enc_right,x,y,theta", [t, 9 * t, 9 * t, t, 0 * t, 0 * t]),
        "ranges": table(folder / "uwb.csv", "time,anchor,distance", [t, np.arange(30) % 4, 3 + t]),
    }
    files["tum"] = folder / "path.txt"
    files["tum"].write_text("".join(f"{a:.2f} {a} 0 0 0 0 0 1\n" for a in t))
    files["opencv"] = folder / "camera.yaml"
    files["opencv"].write_text("camera_matrix: {rows: 3, cols: 3, data: [420.0, 0, 322.0, 0, 421.0, 238.0, 0, 0, 1]}\n")
    for kind in ("servo", "ranges", "wheels", "kalibr"):
        for right, path in files.items():
            if right == kind or (right == "tum" and kind in ("ranges", "wheels")):  # Which read poses, too.
                continue
            code = 2 if kind == "kalibr" and right != "opencv" else 1
            said = run("import", kind, path, "--out", folder / "none", code=code)
            assert f"`seam import {right}`" in said and path.name in said, (kind, right, said)
    # Where a set is expected, too.
    (folder / "m.yaml").write_text("format: seam-model/1\nname: m\neffects: {ideal_servo: {}}\n")
    for command in (["check", files["kalibr"]], ["compare", "--model", folder / "m.yaml", "--data", files["kalibr"]]):
        said = run(*command, code=1)
        assert "`seam import kalibr`" in said, said
    for word, kind in (("odometry", "wheels"), ("bearings", "ranges"), ("chessboard", "images"), ("bag", "ros")):
        refused(word, files["servo"], out=folder / "none", words=[f"unknown kind '{word}'", f"`seam import {kind}`"], code=2)


run_tests(globals())
