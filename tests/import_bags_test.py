#!/usr/bin/env python3
"""`seam import` of bags of ROS and of our own logs, made here with the truth known. `import_bags_test.py path/to/seam`"""
import json

import numpy as np

from importing import HERE, D, K, imported, refused, rows_of, run, run_tests, servo_log
from ros_bags import Cdr, mcap_file, ros1_bag


def assert_walks_short(folder, out):
    """The robot of these bags gets 5 % less far than it was told."""
    run("add", "odometry_scale", "--model", out / "nominal.yaml", "--data", out, "--out", folder / "o.yaml", "--json",
        folder / "o.json")
    found = json.loads((folder / "o.json").read_text())["parameters"]["vx_scale"]
    assert abs(found["value"] + 0.05) < 2e-3, found


def bag_messages(ros1):
    t, command, measured = servo_log(300)
    joints = []
    for a, b, c in zip(t + 50, command, measured):
        joints.append(("/joint_states", "sensor_msgs/JointState", a,
                       Cdr(ros1).header(a).texts(["arm", "wrist"]).reals([c, 0.5 * c]).reals([]).reals([]).data))
        joints.append(("/commands", "std_msgs/Float64MultiArray", a + 0.001,
                       Cdr(ros1).put("I", 0, 0).reals([b, 0.5 * b]).data))
    walk, x, y, theta = [], 0.0, 0.0, 0.0
    for k in range(400):
        a = 100 + 0.05 * k
        vx, omega = 0.4 + 0.1 * np.sin(k / 40), 0.5 * np.sin(k / 25)
        walk.append(("/odom", "nav_msgs/Odometry", a, Cdr(ros1).header(a).text("base_link").put(
            "d", x, y, 0, 0, 0, np.sin(theta / 2), np.cos(theta / 2), *[0] * 36, vx, 0, 0, 0, 0, omega, *[0] * 36).data))
        walk.append(("/cmd_vel", "geometry_msgs/Twist", a, Cdr(ros1).put("d", vx, 0, 0, 0, 0, omega).data))
        middle = theta + 0.025 * omega
        x, y, theta = x + 0.95 * vx * 0.05 * np.cos(middle), y + 0.95 * vx * 0.05 * np.sin(middle), theta + 0.05 * omega
    info = [("/camera/camera_info", "sensor_msgs/CameraInfo", 5.0, Cdr(ros1).header(5).put("I", 480, 640).text("plumb_bob")
             .reals(list(D)).put("d", K[0], 0, K[2], 0, K[1], K[3], 0, 0, 1).data)]
    return joints, walk, info


def test_ros(folder):
    for ros1, name, packing in ((False, "two.mcap", ""), (False, "lz4.mcap", "lz4"), (True, "one.bag", "none"),
                                (True, "bz2.bag", "bz2"), (True, "lz4.bag", "lz4")):
        joints, walk, info = bag_messages(ros1)

        def write(messages):
            data = (ros1_bag if ros1 else mcap_file)(messages, packing)
            (folder / name).write_bytes(data)
            return data

        data = write(joints)
        out = folder / f"joints-{name[:-5]}-{ros1}"
        imported("ros", folder / name, out=out)
        rows = rows_of(out / "joints.csv")
        assert len(rows) == 2 * 299 and {r["joint"] for r in rows} == {"arm", "wrist"}, len(rows)
        (folder / name).write_bytes(data[:len(data) // 2])
        run("import", "ros", folder / name, "--out", folder / "cut", code=1)
        write(walk)
        out = folder / f"walk-{name[:-5]}-{ros1}"
        imported("ros", folder / name, out=out)
        assert_walks_short(folder, out)
        write(info)
        out = folder / f"info-{name[:-5]}-{ros1}"
        imported("ros", folder / name, out=out)
        assert "fx_px: 400, fy_px: 405" in (out / "nominal.yaml").read_text()
        write([m for m in walk if m[0] == "/cmd_vel"])
        refused("ros", folder / name, out=folder / "alone", words=["/cmd_vel (geometry_msgs/Twist, 400 messages)", "--map"])


def test_dark(folder):
    """A chunk that packs as well as black pictures do is no bomb."""
    joints, _, _ = bag_messages(False)
    black = ("/camera", "sensor_msgs/Image", 60.0, bytes(8 << 20))
    (folder / "dark.mcap").write_bytes(mcap_file([*joints, black], "lz4"))
    imported("ros", folder / "dark.mcap", out=folder / "dark")
    assert len(rows_of(folder / "dark" / "joints.csv")) == 2 * 299


def test_transforms(folder):
    """TF: a robot's walk in a map that odometry drifts in, under commands, or as poses alone."""
    for ros1, kind, name in ((False, "tf2_msgs/TFMessage", "two.mcap"), (True, "tf/tfMessage", "one.bag")):

        def transform(message, t, parent, child, x, y, theta):
            message.header(t, parent).text(child).put("d", x, y, 0, 0, 0, np.sin(theta / 2), np.cos(theta / 2))

        messages, commands = [], []
        x = y = theta = 0.0
        for k in range(300):
            t = 100 + 0.05 * k
            vx, omega = 0.4 + 0.1 * np.sin(k / 40), 0.5 * np.sin(k / 25)
            message = Cdr(ros1).put("I", 3)
            # The map's frame turns by 0.3 rad halfway: all that was before stays.
            turn = 0.3 if k >= 150 else 0.0
            transform(message, t, "map", "odom", 1.0, 2.0, turn)
            c, s = np.cos(turn), np.sin(turn)
            transform(message, t, "odom", "base_link", c * x + s * y, c * y - s * x, theta - turn)
            transform(message, t, "base_link", "camera", 0.1, 0, 0)
            messages.append(("/tf", kind, t, message.data))
            commands.append(("/cmd_vel", "geometry_msgs/Twist", t, Cdr(ros1).put("d", vx, 0, 0, 0, 0, omega).data))
            middle = theta + 0.025 * omega
            x, y, theta = x + 0.95 * vx * 0.05 * np.cos(middle), y + 0.95 * vx * 0.05 * np.sin(middle), theta + 0.05 * omega
        write = ros1_bag if ros1 else mcap_file
        (folder / name).write_bytes(write([m for pair in zip(messages, commands) for m in pair]))
        out = folder / f"walk-{ros1}"
        imported("ros", folder / name, out=out)
        assert_walks_short(folder, out)
        (folder / f"tf-{name}").write_bytes(write(messages))
        out = folder / f"poses-{ros1}"
        assert "the poses of /tf:map:base_link" in imported("ros", folder / f"tf-{name}", out=out)
        poses = rows_of(out / "poses.csv")
        assert len(poses) == 300 and abs(float(poses[0]["x_m"]) - 1) < 1e-9, (len(poses), poses[0])
        assert np.allclose([float(poses[-1][c]) for c in ("x_m", "y_m")], [1 + x, 2 + y], atol=0.05)
        out = folder / f"named-{ros1}"
        imported("ros", folder / f"tf-{name}", "--map", "measured=/tf:odom:camera", out=out)
        assert abs(float(rows_of(out / "poses.csv")[0]["x_m"]) - 0.1) < 1e-9
        refused("ros", folder / f"tf-{name}", "--map", "measured=/tf:odom:base", out=folder / "none", words=["/tf:odom:base", "missing"])


def test_log(folder):
    """A recorded swing of the simulator's head: its limit of speed is found again."""
    scenario = HERE / "scenarios" / "head_swing.yaml"
    run("run", scenario, "--log", folder / "run.mcap")
    imported("log", folder / "run.mcap", out=folder / "head")
    run("add", "speed_limit", "--model", folder / "head" / "nominal.yaml", "--data", folder / "head", "--out",
        folder / "m.yaml", "--json", folder / "m.json")
    found = json.loads((folder / "m.json").read_text())["parameters"]["rad_per_s"]
    assert abs(found["value"] - np.radians(300)) < 1e-3, found
    refused("log", folder / "run.mcap", "--part", "odometry", out=folder / "walk", words=["never told to walk"])
    refused("log", folder / "run.mcap", "--camera", "red9", out=folder / "who", words=["red9", "red1"])


run_tests(globals())
