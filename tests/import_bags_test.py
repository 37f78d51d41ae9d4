#!/usr/bin/env python3
"""`seam import` of bags of ROS and of our own logs, made here with the truth known. `import_bags_test.py path/to/seam`"""
import json

import numpy as np

from importing import HERE, D, K, imported, refused, rows_of, run, run_tests, servo_log
from ros_bags import Cdr, mcap_file, ros1_bag


def assert_walks_short(folder, out):
    """The robot of these bags gets 5 % less far than commanded."""
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
    for ros1, name, packing in ((False, "two.mcap", ""), (False, "lz4.mcap", "lz4"), (False, "zstd.mcap", "zstd"),
                                (False, "direct.mcap", "direct"), (True, "one.bag", "none"), (True, "bz2.bag", "bz2"),
                                (True, "lz4.bag", "lz4")):
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
        if packing == "direct":  # What stands before the cut is whole.
            said = imported("ros", folder / name, out=folder / "cut")
            assert "ends in the middle of a record" in said, said
            assert 250 < len(rows_of(folder / "cut" / "joints.csv")) < 320
        else:
            run("import", "ros", folder / name, "--out", folder / "not-cut", code=1)
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


def test_imu(folder):
    """Readings of sensor_msgs/Imu in both forms, by the stamps of their headers; what a driver does not have is left out."""
    rng = np.random.default_rng(3)
    gyro, accel = 0.01 * rng.normal(size=(400, 3)), rng.normal(size=(400, 3)) + [0, 0, 9.81]

    def messages(ros1, topic, no_gyro=False, odd=None):
        out = []
        for k in range(400):
            message = Cdr(ros1).header(7 + 0.005 * k).put("d", 0, 0, 0, 1, -1, *[0] * 8)
            message.put("d", *gyro[k], -1 if no_gyro or k == odd else 1e-4, *[0] * 8, *accel[k], 1e-2, *[0] * 8)
            out.append((topic, "sensor_msgs/Imu", 9 + 0.005 * k, message.data))
        return out

    for ros1, name, packing in ((False, "two.mcap", "zstd"), (True, "one.bag", "none"), (True, "bz2.bag", "bz2")):
        write = lambda data: (folder / name).write_bytes((ros1_bag if ros1 else mcap_file)(data, packing))
        write(messages(ros1, "/imu0"))
        said = imported("imu", folder / name, out=folder / f"imu-{name}")
        assert "readings of /imu0" in said, said
        rows = rows_of(folder / f"imu-{name}" / "imu.csv")
        assert len(rows) == 400
        for row, g, a in zip(rows, gyro, accel):
            assert [float(row[f"w{axis}_radps"]) for axis in "xyz"] == list(g)
            assert [float(row[f"a{axis}_mps2"]) for axis in "xyz"] == list(a)
        assert abs(float(rows[399]["time_s"]) - float(rows[0]["time_s"]) - 399 * 0.005) < 1e-6
        write(messages(ros1, "/imu0") + messages(ros1, "/imu1", no_gyro=True))
        refused("imu", folder / name, out=folder / "none", words=["found 2 topics of sensor_msgs/Imu", "--map imu=TOPIC", "/imu1 ("])
        imported("imu", folder / name, "--map", "imu=/imu1", out=folder / f"second-{name}")
        assert "wx_radps" not in rows_of(folder / f"second-{name}" / "imu.csv")[0]
        write(messages(ros1, "/imu0", odd=100))
        refused("imu", folder / name, out=folder / "none", words=["/imu0: some messages say that they have no angular velocity"])
        write(bag_messages(ros1)[0])
        refused("imu", folder / name, out=folder / "none", words=["found 0 topics of sensor_msgs/Imu", "/joint_states ("])
    # A file a run, of either form.
    (folder / "two.mcap").write_bytes(mcap_file(messages(False, "/imu0")))
    (folder / "one.bag").write_bytes(ros1_bag(messages(True, "/imu0")))
    imported("imu", folder / "two.mcap", folder / "one.bag", out=folder / "both")
    assert {row["run"] for row in rows_of(folder / "both" / "imu.csv")} == {"1 two", "2 one"}


RULE = "=" * 80 + "\n"
POINT = RULE + """MSG: trajectory_msgs/JointTrajectoryPoint
float64[] positions
float64[] velocities
float64[] accelerations
float64[] effort
duration time_from_start
"""
HEADER = RULE + "MSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n"
HEADER2 = RULE + """MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
""" + RULE + "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n" + RULE + \
    "MSG: builtin_interfaces/Duration\nint32 sec\nuint32 nanosec\n"


def trajectory_state(ros1, fields):
    """The definition of a JointTrajectoryControllerState with these points."""
    text = "# Of one controller\nstd_msgs/Header header\nstring[] joint_names\nint32 VERSION=2  # a constant\n" + "".join(
        f"trajectory_msgs/JointTrajectoryPoint {field}\n" for field in fields) + "string[] multi_dof_joint_names\n"
    return text + (HEADER + POINT if ros1 else HEADER2 + POINT.replace("duration", "builtin_interfaces/Duration"))


def test_controllers(folder):
    """Command and state in one message: the old fields, the new ones, both with the old ones left empty, one joint a
    message, several in a list, and a message of one's own."""
    t, command, measured = servo_log(300)

    def check(out, joints):
        rows = rows_of(out / "joints.csv")
        for joint, factor in joints.items():
            mine = [r for r in rows if r["joint"] == joint]
            assert np.allclose([float(r["command_rad"]) for r in mine], factor * command, atol=1e-12), joint
            assert np.allclose([float(r["measured_rad"]) for r in mine], factor * measured, atol=1e-12), joint
            assert np.allclose([float(r["time_s"]) for r in mine], t + 50, atol=1e-6), joint
        assert len(rows) == len(joints) * len(t), len(rows)

    def point(message, positions):
        message.reals(positions).reals([]).reals([]).reals([]).put("I", 0, 0)

    kind = "control_msgs/JointTrajectoryControllerState"
    for ros1, fields, filled in ((True, ["desired", "actual", "error"], ("desired", "actual")),
                                 (False, ["desired", "actual", "error"], ("desired", "actual")),
                                 (False, ["reference", "feedback", "error", "output"], ("reference", "feedback")),
                                 (False, ["desired", "actual", "reference", "feedback", "error"], ("reference", "feedback")),
                                 (False, ["desired", "actual", "reference", "feedback", "error"], ("desired", "actual"))):
        messages = [("/jtc/controller_state", kind, 49.0, Cdr(ros1).header(49.0).texts([]).data)]
        for a, b, c in zip(t + 50, command, measured):
            message = Cdr(ros1).header(a).texts(["arm", "wrist"])
            for field in fields:
                point(message, [b, 0.5 * b] if field == filled[0] else [c, 0.5 * c] if field == filled[1] else [])
            messages.append(("/jtc/controller_state", kind, a + 0.01, message.texts([]).data))
        # Before the first trajectory a controller has no reference.
        empty = Cdr(ros1).header(49.0).texts(["arm", "wrist"])
        for field in fields:
            point(empty, [0, 0] if field == filled[1] else [])
        messages[0] = ("/jtc/controller_state", kind, 49.0, empty.texts([]).data)
        name = f"{filled[0]}-{len(fields)}-{ros1}"
        (folder / name).write_bytes((ros1_bag if ros1 else mcap_file)(messages, definitions={kind: trajectory_state(ros1, fields)}))
        said = imported("ros", folder / name, out=folder / f"out-{name}")
        assert f"{filled[0]}.positions and {filled[1]}.positions of /jtc/controller_state" in said, said
        assert "1 messages without command or state" in said, said
        check(folder / f"out-{name}", {"arm": 1, "wrist": 0.5})

    # A controller for each joint, as ROS 1 has them; that of several in a list; a message of nobody's package.
    one = "Header header\nfloat64 set_point\nfloat64 process_value\nfloat64 error\nfloat64 command\nbool antiwindup\n" + HEADER
    many = "std_msgs/Header header\ncontrol_msgs/SingleDOFState[] dof_states\n" + HEADER2 + RULE + \
        "MSG: control_msgs/SingleDOFState\nstring name\nfloat64 reference\nfloat64 feedback\nfloat32 error\n"
    own = "std_msgs/Header header\nint16 mode\nstring<=20 name\nfloat64[2] goal_position\nfloat64[<=4] present_position\n" + HEADER2
    single, several, mine = [], [], []
    for a, b, c in zip(t + 50, command, measured):
        for joint, factor in (("arm", 1), ("wrist", 0.5)):
            single.append((f"/{joint}_controller/state", "control_msgs/JointControllerState", a,
                           Cdr(True).header(a).put("d", factor * b, factor * c, 0, 7).put("B", 1).data))
        message = Cdr(False).header(a).put("I", 2)
        for joint, factor in (("arm", 1), ("wrist", 0.5)):
            message.text(joint).put("d", factor * b, factor * c).put("f", 0)
        several.append(("/pid/controller_state", "control_msgs/MultiDOFStateStamped", a, message.data))
        mine.append(("/servos", "my_msgs/ServoLog", a,
                     Cdr(False).header(a).put("h", -3).text("left").put("d", b, 0.5 * b).reals([c, 0.5 * c]).data))
    for name, data, joints in (
            ("single.bag", ros1_bag(single, "bz2", {"control_msgs/JointControllerState": one}),
             {"arm_controller": 1, "wrist_controller": 0.5}),
            ("several.mcap", mcap_file(several, "zstd", definitions={"control_msgs/MultiDOFStateStamped": many}),
             {"arm": 1, "wrist": 0.5}),
            ("own.mcap", mcap_file(mine, definitions={"my_msgs/ServoLog": own}), {"joint0": 1, "joint1": 0.5})):
        (folder / name).write_bytes(data)
        imported("ros", folder / name, out=folder / f"out-{name}")
        check(folder / f"out-{name}", joints)
    # The wrist turned about, as --reverse does it.
    turned = [(topic, kind, a, data) for topic, kind, a, data in single]
    (folder / "single.bag").write_bytes(ros1_bag(turned, "none", {"control_msgs/JointControllerState": one}))
    imported("ros", folder / "single.bag", "--reverse", "wrist_controller", out=folder / "turned")
    rows = [r for r in rows_of(folder / "turned" / "joints.csv") if r["joint"] == "wrist_controller"]
    assert np.allclose([float(r["measured_rad"]) for r in rows], -0.5 * measured, atol=1e-12)
    # Definitions that do not hold are reported, and never followed without end.
    for text, words in (("my_msgs/ServoLog again\n" + HEADER2, "nested too deep"), ("my_msgs/None other\n", "missing"),
                        ("float64\n", "expected TYPE NAME")):
        (folder / "bad.mcap").write_bytes(mcap_file(mine, definitions={"my_msgs/ServoLog": text}))
        refused("ros", folder / "bad.mcap", out=folder / "none", words=["found no joints with commands"])
        (folder / "bad.mcap").write_bytes(mcap_file(mine + bag_messages(False)[0], definitions={"my_msgs/ServoLog": text}))
        assert words in imported("ros", folder / "bad.mcap", out=folder / f"beside-{len(words)}")
    huge = "std_msgs/Header header\nmy_msgs/A[1000000] x\nfloat64 goal\nfloat64 position\n" + HEADER2 + RULE + \
        "MSG: my_msgs/A\nmy_msgs/B[1000000] y\n" + RULE + "MSG: my_msgs/B\nfloat64[0] z\n"
    (folder / "huge.mcap").write_bytes(mcap_file(mine, definitions={"my_msgs/ServoLog": huge}))
    refused("ros", folder / "huge.mcap", out=folder / "none", words=["elements: damaged"])


def test_dark(folder):
    """A chunk that packs as well as black pictures do is no bomb."""
    joints, _, _ = bag_messages(False)
    black = ("/camera", "sensor_msgs/Image", 60.0, bytes(8 << 20))
    (folder / "dark.mcap").write_bytes(mcap_file([*joints, black], "lz4"))
    imported("ros", folder / "dark.mcap", out=folder / "dark")
    assert len(rows_of(folder / "dark" / "joints.csv")) == 2 * 299


def test_parts(folder):
    """A recording that was split, and files that are no bags of ROS."""
    joints, _, _ = bag_messages(False)
    split = folder / "split"
    split.mkdir()
    for k in range(11):  # run_10 stands behind run_9.
        (split / f"run_{k}.mcap").write_bytes(mcap_file(joints[len(joints) * k // 11:len(joints) * (k + 1) // 11]))
    (split / "metadata.yaml").write_text("rosbag2_bagfile_information: {}\n")
    imported("ros", split, out=folder / "whole")
    (folder / "one.mcap").write_bytes(mcap_file(joints))
    imported("ros", folder / "one.mcap", out=folder / "one")
    assert (folder / "whole" / "joints.csv").read_bytes() == (folder / "one" / "joints.csv").read_bytes()
    (split / "other_0.mcap").write_bytes(b"")
    refused("ros", split, out=folder / "two", words=["12 bags", "other_0.mcap"])
    for name, data, words in (("json.mcap", mcap_file(joints, encoding="json"), ["messages are json", "cdr"]),
                              ("empty.mcap", b"", ["is empty"]),
                              ("packed.mcap.zstd", b"\x28\xb5\x2f\xfd" + bytes(60), ["unzstd"]),
                              ("lfs.bag", b"version https://git-lfs.github.com/spec/v1\n", ["Git LFS"]),
                              ("old.bag", b"#ROSBAG V1.2\n" + bytes(60), ["V1.2", "rosbag migrates"]),
                              ("sql.db3", b"SQLite format 3\0" + bytes(60), ["ros2 bag convert"]),
                              ("text.mcap", b"no bag at all, but some text\n", ["not an MCAP file"])):
        (folder / name).write_bytes(data)
        refused("ros", folder / name, out=folder / "none", words=[name, *words])
    # Poses of one topic in two frames make no path.
    _, walk, _ = bag_messages(False)
    mixed = [(topic, kind, t, data.replace(b"map", b"usa") if k > 200 and topic == "/odom" else data)
             for k, (topic, kind, t, data) in enumerate(walk)]
    (folder / "mixed.mcap").write_bytes(mcap_file(mixed))
    refused("ros", folder / "mixed.mcap", out=folder / "mixed", words=["/odom: at 105", "'usa'", "'map'", "one frame"])
    # Topics without messages are reported; a position that is no number is an error.
    t, command, measured = servo_log(60)
    bad = [("/joint_states", "sensor_msgs/JointState", a,
            Cdr(False).header(a).texts(["arm"]).reals([float("nan") if k == 30 else c]).reals([]).reals([float("nan")]).data)
           for k, (a, c) in enumerate(zip(t, measured))]
    told = [("/commands", "std_msgs/Float64MultiArray", a, Cdr(False).put("I", 0, 0).reals([b]).data) for a, b in zip(t, command)]
    both = [m for pair in zip(told, bad) for m in pair]
    (folder / "nan.mcap").write_bytes(mcap_file(both))
    refused("ros", folder / "nan.mcap", out=folder / "nan", words=["joint arm at 0.3", "finite"])
    good = [m for k, m in enumerate(both) if k // 2 != 30]
    (folder / "effort.mcap").write_bytes(mcap_file(good))  # Efforts that no encoder tells are NaN by habit.
    imported("ros", folder / "effort.mcap", out=folder / "effort")
    rows = rows_of(folder / "effort" / "joints.csv")
    assert len(rows) == 59 and "effort_nm" not in rows[0], rows[0]
    # Measured ones become torques, blank where they are no number.
    force = [(topic, kind, a, Cdr(False).header(a).texts(["arm"]).reals([0.1]).reals([]).reals(
        [float("nan") if k == 5 else 0.25 * k]).data) for k, (topic, kind, a, _) in enumerate(bad)]
    (folder / "force.mcap").write_bytes(mcap_file([m for pair in zip(told, force) for m in pair]))
    said = imported("ros", folder / "force.mcap", out=folder / "force")
    efforts = [r["effort_nm"] for r in rows_of(folder / "force" / "joints.csv")]
    assert "effort_nm" in said and "" in efforts and set(efforts) - {""} <= {f"{0.25 * k:g}" for k in range(60)}, efforts


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
    # A camera without values of its own, which the robot of the scenario draws.
    camera = folder / "camera.yaml"
    camera.write_text("format: seam-model/1\nname: seen\neffects:\n  pinhole: {fx_px: 161.9, fy_px: 162.5, cx_px: 88.5, cy_px: 71.5}\n"
                      "  rolling_shutter: {line_delay_s: 2.78e-4}\n  exposure: {exposure_s: 0.005}\n  lens_blur: {sigma_px: 0.8}\n"
                      "  read_noise: {sigma_dn: 2}\n")
    run("run", scenario, "--model", camera, "--log", folder / "frames.mcap")
    # Its frames, with where its camera was and what stood there: the camera that drew them explains them, and no other.
    said = imported("log", folder / "frames.mcap", "--part", "frames", out=folder / "frames")
    assert "49 of 49 frames" in said and "not to the last bit" not in said, said
    assert len(list((folder / "frames/frames").glob("*.png"))) == 49
    errors = {}
    for name, model in (("nominal", folder / "frames" / "nominal.yaml"), ("true", camera)):
        run("compare", "--model", model, "--data", folder / "frames", "--json", folder / "c.json")
        errors[name] = json.loads((folder / "c.json").read_text())["error"]
    assert errors["true"] < 1.1 and errors["nominal"] > 3 * errors["true"], errors
    refused("log", folder / "run.mcap", "--part", "odometry", out=folder / "walk", words=["has no command to walk"])
    refused("log", folder / "run.mcap", "--camera", "red9", out=folder / "who", words=["red9", "red1"])


run_tests(globals())
