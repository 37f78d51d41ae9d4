#!/usr/bin/env python3
"""Behaviours in Python (robot_sdk/python) over real gRPC: the same run as in C++, all that a robot gets and can do,
and what is refused.

Usage: python_sdk_test.py BUILD_DIR SOURCE_DIR PYTHON [unittest arguments]; PYTHON is the interpreter that has gRPC.
"""
import io
import json
import math
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

from PIL import Image

from viewing import viewer

import by_hand

BUILD, SOURCE, PYTHON = by_hand.arguments("build", "source", "python")
SEAM = BUILD / "seam"
GOLDEN = SOURCE / "tests" / "golden" / "fingerprints.json"
LIMIT_S = 240  # A hang is a failure.
BY_GRPC = "/usr/bin/env, -u, SEAM_LINE"  # Before a behaviour's program: without a direct line.

PROLOGUE = f"""#!{PYTHON}
import json, math, os, sys
sys.path.insert(0, {str(BUILD / "python")!r})
import seam_sdk
"""


def scenario(behaviour, robots=1, duration_s=0.6):
    text = (f"format: seam-scenario/1\nname: python\nduration_s: {duration_s}\nseed: 5\n"
            f"field: {SOURCE}/models/field_2002.yaml\nball: {{x_m: 0.4, y_m: 0.1}}\nrobots:\n")
    for i in range(robots):
        text += (f"  - id: r{i}\n    team: red\n    pose: {{x_m: {-0.9 + 0.6 * i}, y_m: 0.4, theta_rad: 0}}\n"
                 f"    body: {SOURCE}/models/robot_ers210.yaml\n"
                 f"    camera: {{model: {SOURCE}/models/ers210.yaml, "
                 f"colour_table: {SOURCE}/models/colour_table_2002.yaml}}\n"
                 f"    behaviour: {{command: [{behaviour}]}}\n")
    return text


class PythonSdk(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.here = pathlib.Path(folder.name)

    def write(self, text, name="scenario.yaml"):
        path = self.here / name
        path.write_text(text)
        return path

    def program(self, text):
        path = self.write(PROLOGUE + text, "behaviour.py")
        path.chmod(0o755)
        return path

    def seam(self, *arguments):
        done = subprocess.run([SEAM, *map(str, arguments)], capture_output=True, text=True, timeout=LIMIT_S)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done

    def run_json(self, path, *arguments):
        out = self.here / "run.json"
        done = self.seam("run", path, "--json", out, *arguments)
        return json.loads(out.read_text()), done.stderr

    def test_head_swing_in_python_is_the_same_run_as_in_cpp(self):
        text = (SOURCE / "scenarios" / "head_swing.yaml").read_text().replace("../models", f"{SOURCE}/models")
        self.assertIn("command: [head_swing, --rate", text)
        summary, _ = self.run_json(self.write(text.replace("command: [head_swing,", "command: [head_swing.py,")),
                                   "--log", self.here / "run.mcap")
        self.assertEqual(summary["fingerprint"], json.loads(GOLDEN.read_text())["head_swing"])
        self.assertEqual(summary["decisions"], 63)
        self.seam("replay", "verify", self.here / "run.mcap")

    def test_an_accelerometer_with_effects(self):
        """Over real gRPC a behaviour gets what the model's inertial effects make of the force at rest."""
        notes = self.here / "notes.json"
        program = self.program(f"""
robot = seam_sdk.Robot()
felt = [list(seen.sensors.acceleration_m_s2) for seen in robot.observations()]
open({str(notes)!r}, "w").write(json.dumps(felt))
""")
        effects = ("  accel_bias: {x_mps2: 0.5}\n  accel_scale: {z_scale: 0.02}\n  accel_white_noise: {x_mps2_rthz: 0.01}\n"
                   "  accel_saturation: {most_mps2: 9.9}\n"
                   "  accel_vibration: {y_mps2: 0.3, frequency_hz: 6, quality: 2}\n")
        lens = (SOURCE / "models" / "ers210.yaml").read_text()
        self.write(lens + ("" if lens.endswith("\n") else "\n") + effects, "felt.yaml")
        text = scenario(f"{BY_GRPC}, {program}", duration_s=16)
        self.run_json(self.write(text))
        true = json.loads(notes.read_text())[-1]  # The robot stands still, and its back slopes.
        log = self.here / "felt.mcap"
        self.run_json(self.write(text.replace(f"{SOURCE}/models/ers210.yaml", "felt.yaml")), "--log", log)
        axes = list(zip(*json.loads(notes.read_text())[1:]))
        count = len(axes[0])
        self.assertGreater(count, 400)
        mean = [sum(axis) / count for axis in axes]
        spread = [math.sqrt(sum((value - m) ** 2 for value in axis) / count) for axis, m in zip(axes, mean)]
        white = 0.01 / math.sqrt(0.008)  # Of a sample, by its density.
        self.assertAlmostEqual(mean[0] - true[0], 0.5, delta=4 * white / math.sqrt(count))
        self.assertAlmostEqual(spread[0] / white, 1, delta=4 / math.sqrt(2 * count))
        # The line's width is 3 Hz: so many swings are independent.
        swings = 16 * math.pi * 3
        self.assertAlmostEqual(mean[1] - true[1], 0, delta=4 * 0.3 / math.sqrt(swings))
        self.assertAlmostEqual(spread[1] / 0.3, 1, delta=4 / math.sqrt(swings))
        # With 2 % more it is beyond the end of the range.
        self.assertGreater(1.02 * true[2], 9.9)
        self.assertEqual({round(value, 9) for value in axes[2]}, {9.9})
        self.seam("replay", "verify", log)

    def test_a_gyroscope_with_effects(self):
        """Over real gRPC a robot that turns reads its turn, with what the model's effects make of it; one without a gyroscope reads none."""
        notes = self.here / "notes.json"
        program = self.program(f"""
robot = seam_sdk.Robot()
read = []
for seen in robot.observations():
    robot.walk(omega_rad_s=0.5)
    read.append((seen.sensors.angular_velocity_rad_s, seen.sensors.acceleration_m_s2))
if robot.name == "r0":
    open({str(notes)!r}, "w").write(json.dumps(read))
else:
    assert read and not any(rate for rate, _ in read), read
""")
        effects = ("  gyro_bias: {x_radps: 0.3}\n  gyro_scale: {z_scale: 0.1}\n  gyro_g_sensitivity: {z_radps_mps2: 0.02}\n"
                   "  gyro_white_noise: {x_radps_rthz: 0.002}\n")
        lens = (SOURCE / "models" / "ers210.yaml").read_text()
        self.write(lens + ("" if lens.endswith("\n") else "\n") + effects, "turned.yaml")
        text = scenario(f"{BY_GRPC}, {program}", robots=2, duration_s=8)
        text = text.replace("    behaviour:", "    sensors: {gyroscope: {period_s: 0.008}}\n    behaviour:", 1)
        self.run_json(self.write(text))
        readings = json.loads(notes.read_text())[50:]  # From then on its walk is steady.
        true, force = (list(zip(*sensor)) for sensor in zip(*readings))
        log = self.here / "turned.mcap"
        self.run_json(self.write(text.replace(f"{SOURCE}/models/ers210.yaml", "turned.yaml")), "--log", log)
        read = list(zip(*(rate for rate, _ in json.loads(notes.read_text())[50:])))
        count = len(true[0])
        self.assertGreater(count, 150)
        mean_of = lambda values: sum(values) / count
        self.assertAlmostEqual(mean_of(true[2]), 0.5, delta=0.01)
        for was, felt, now in zip(true[2], force[2], read[2]):
            self.assertAlmostEqual(now, 1.1 * was + 0.02 * felt, places=12)
        self.assertAlmostEqual(mean_of(force[2]), 9.8, delta=0.1)
        white = 0.002 / math.sqrt(0.008)  # Of a sample, by its density.
        errors = [now - was for was, now in zip(true[0], read[0])]
        self.assertAlmostEqual(mean_of(errors), 0.3, delta=4 * white / math.sqrt(count))
        spread = math.sqrt(mean_of([(error - mean_of(errors)) ** 2 for error in errors]))
        self.assertAlmostEqual(spread / white, 1, delta=4 / math.sqrt(2 * count))
        self.seam("replay", "verify", log)

    def test_what_a_robot_is_told_and_tells(self):
        """Two robots talk by radio; r0 walks and looks, and writes down what it got."""
        notes = self.here / "notes.json"
        program = self.program(f"""
robot = seam_sdk.Robot()
robot.request_frames(3)
told = {{"frames": [], "heard": [], "walked_m": 0, "readings": 0, "pan_rad": []}}
for seen in robot.observations():
    robot.walk(vx_m_s=0.2)
    robot.head(tilt_rad=-0.2, pan_rad=0.4)
    if seen.sequence == 3:
        robot.joints({{robot.joint_names[2]: 0.2}}, offset_ns=8_000_000)
        robot.kick(seam_sdk.Kick.LEG_FORWARD)
        robot.log_value("answer", 42)
        robot.log_text("word", "hello")
        robot.log_drawing("way", [(0, 0), (1, 0.5)])
    robot.send(f"{{robot.name}} {{robot.number}} {{robot.team}}".encode())
    for frame in seen.frames:
        rgb, classes = frame.rgb_array(), frame.colours_array()
        assert rgb[70, 88].tobytes() == frame.rgb[(70 * frame.width_px + 88) * 3:][:3]
        assert frame.row_start_ns[0] < frame.row_middle_ns(0) < frame.row_end_ns[0] < frame.row_end_ns[-1] <= seen.time_ns
        told["frames"].append([*rgb.shape, *classes.shape, *frame.ycrcb_array().shape, int(rgb.max()), int(classes.max())])
    told["heard"] += [[message.sender, message.payload.decode()] for message in seen.messages]
    told["walked_m"] = seen.sensors.odometry.x_m
    told["readings"] += len(seen.sensors.joint_log)
    told["pan_rad"].append(seen.sensors.joints.pan_rad)
    told["roll_rad"] = seen.sensors.joints.roll_rad
    told["gravity"] = seen.sensors.acceleration_m_s2[2]
    told["state"] = seen.game.state.name
    told["legs"] = len(seen.sensors.joints.legs_rad)
if robot.name == "r0":
    open({str(notes)!r}, "w").write(json.dumps(told))
""")
        log, tables = self.here / "run.mcap", self.here / "tables"
        self.run_json(self.write(scenario(program, robots=2, duration_s=1)), "--log", log)
        told = json.loads(notes.read_text())
        self.assertEqual(len(told["frames"]), 3)
        for frame in told["frames"]:
            self.assertEqual(frame[:8], [144, 178, 3, 72, 88, 144, 178, 3])
            self.assertGreater(frame[8], 100)  # Something is bright, and something has a colour.
            self.assertGreater(frame[9], 0)
        self.assertIn(["r1", "r1 1 red"], told["heard"])
        self.assertGreater(told["walked_m"], 0.02)
        self.assertGreater(told["readings"], 100)  # One in 8 ms.
        self.assertAlmostEqual(told["pan_rad"][-1], 0.4, delta=0.02)
        self.assertAlmostEqual(told["roll_rad"], 0, delta=0.02)  # The head order of each decision takes it back.
        self.assertEqual((told["state"], told["legs"]), ("PLAYING", 12))
        self.seam("replay", "export", log, "--out", tables)
        debug = (tables / "debug.csv").read_text()
        self.assertRegex(debug, r"r0,answer,value,42\b")
        self.assertRegex(debug, r"r0,word,text,hello\b")
        self.assertRegex(debug, r"r0,way,")
        self.assertIn("leg_forward", (tables / "decisions.csv").read_text())

    def test_a_mark_belongs_to_the_frame_that_the_decision_was_made_from(self):
        """A swinging head marks the ball in the newest frame that it has, and sometimes in an older one by its number."""
        notes = self.here / "notes.json"
        program = self.program(f"""
import numpy
robot = seam_sdk.Robot()
robot.request_all_frames()
marked, older = [], None
for seen in robot.observations():
    robot.head(tilt_rad=-0.2, pan_rad=0.35 * math.sin(6e-9 * seen.time_ns))
    for frame in seen.frames:
        rgb = frame.rgb_array().astype(int)
        v, u = numpy.nonzero((rgb[:, :, 0] > 130) & (rgb[:, :, 0] > 1.6 * rgb[:, :, 1]) & (rgb[:, :, 2] < 80))
        if len(u) < 9:
            continue
        middle = numpy.argmin((u - u.mean()) ** 2 + (v - v.mean()) ** 2)
        spot = (int(u[middle]), int(v[middle]))
        robot.log_drawing("ball", [spot], in_image=True)
        marked.append(["ball", seen.time_ns, frame.index, *spot, *frame.rgb_array()[spot[1], spot[0]].tolist()])
        if older:
            robot.log_drawing("before", [older[1:3]], in_image=True, frame_index=older[0])
            marked.append(["before", seen.time_ns, *older])
        older = [frame.index, *spot, *marked[-1 - bool(older)][5:]]
open({str(notes)!r}, "w").write(json.dumps(marked))
""")
        log = self.here / "run.mcap"
        self.run_json(self.write(scenario(program, duration_s=1.5)), "--log", log)
        marked = json.loads(notes.read_text())
        self.assertGreater(len(marked), 40)
        with viewer(SEAM, log) as ask:
            items = ask("debug", robot="r0", to=2)["items"]
            told = [[item["name"], round(item["t"] * 1e9), item["frame"], *item["points"][0]] for item in items]
            self.assertEqual(told, [one[:5] for one in marked])
            decisions = {round(one["t"] * 1e9): one.get("frame") for one in ask("decisions", robot="r0", to=2)["decisions"]}
            for name, time_ns, index, u, v, *rgb in marked:
                if name == "ball":
                    self.assertEqual(decisions[time_ns], index)
            for _, _, index, u, v, *rgb in marked[::9]:
                picture = Image.open(io.BytesIO(ask("frame", robot="r0", index=index)))
                self.assertEqual(list(picture.getpixel((u, v))), rgb)

    def test_a_bad_order_is_refused_with_its_field_and_the_run_goes_on(self):
        program = self.program("""
robot = seam_sdk.Robot()
for seen in robot.observations():
    robot.head(pan_rad=math.nan if seen.sequence == 2 else 0.1)
""")
        summary, errors = self.run_json(self.write(scenario(program)))
        self.assertEqual(summary["end"], "finished")
        self.assertIn("r0: the decision at 0.032 s was refused: head.pan_rad", errors)

    def test_over_tls_with_certificates_and_without_the_token(self):
        path = self.write(scenario("head_swing.py, --no-frames", duration_s=0.5))
        reference, _ = self.run_json(path)
        certificates, tokens, out = self.here / "certs", self.here / "tokens.yaml", self.here / "served.json"
        self.seam("certs", certificates)
        server = subprocess.Popen([SEAM, "serve", path, "--certs", certificates, "--listen", "127.0.0.1:0", "--tokens", tokens,
                                   "--json", out], stdout=subprocess.PIPE, text=True)
        self.addCleanup(lambda: (server.poll() is None and server.kill(), server.wait(), server.stdout.close()))
        address = server.stdout.readline().split()[-1]
        token = next(line.split()[1] for line in tokens.read_text().splitlines() if "r0:" in line)
        client = [BUILD / "behaviours" / "head_swing.py", "--no-frames", "--address", address, "--robot", "r0"]
        secure = dict(os.environ, SEAM_CERTS=str(certificates))

        def refused(command, environment):
            done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=60)
            self.assertEqual(done.returncode, 1)
            self.assertNotIn("Traceback", done.stderr)
            return done.stderr
        self.assertIn("token", refused([*client, "--token", "guess"], secure))
        self.assertIn("ca.pem", refused([*client, "--token", token], dict(secure, SEAM_CERTS=str(self.here / "nowhere"))))
        bare = {name: value for name, value in os.environ.items() if not name.startswith("SEAM_")}
        self.assertIn("SEAM_ADDRESS", refused([BUILD / "behaviours" / "head_swing.py"], bare))
        self.assertEqual(subprocess.run([*client, "--token", token], env=secure, timeout=LIMIT_S).returncode, 0)
        self.assertEqual(server.wait(LIMIT_S), 0)
        self.assertEqual(json.loads(out.read_text())["fingerprint"], reference["fingerprint"])

    def test_a_broken_stream_goes_on_at_the_pending_observation(self):
        """The client drops its own stream after an answer was made: the same decisions as without."""
        swing = """
robot = seam_sdk.Robot()
drop = "--drop" in sys.argv
if drop:  # The stream breaks as a network's does: in the midst of an iteration.
    inner, robot._drive = robot._drive, None
    def breaking(messages, send):
        for seen in inner(messages, send):
            yield seen
            if seen.sequence in (3, 4, 9):
                raise Broken()
    class Broken(seam_sdk.robot.grpc.RpcError):
        def code(self): return seam_sdk.robot.grpc.StatusCode.UNAVAILABLE
        def details(self): return "broken by the test"
    robot._drive = breaking
count = 0
for seen in robot.observations():
    count += 1
    robot.head(pan_rad=0.3 * math.sin(5 * seen.time_s))
    robot.log_value("count", count)
"""
        program = self.program(swing)
        whole, _ = self.run_json(self.write(scenario(program)), "--log", self.here / "whole.mcap")
        for command in (f"{program}, --drop", f"{BY_GRPC}, {program}, --drop"):
            broken, _ = self.run_json(self.write(scenario(command)), "--force", "--log",
                                      self.here / "broken.mcap")
            self.assertEqual(broken["fingerprint"], whole["fingerprint"])
            self.assertEqual(broken["decisions"], whole["decisions"])

    def test_a_direct_line_and_grpc_give_the_same_bits(self):
        """Also where an observation, with a frame of 900 kB, has no room in a socket."""
        found = set()
        for client in ("head_swing", "head_swing.py"):
            for by in ("", f"{BY_GRPC}, "):
                text = scenario(f"{by}{BUILD}/behaviours/{client}", duration_s=0.3)
                text, changed = re.subn("camera: .*", "camera: {width_px: 640, height_px: 480}", text)
                self.assertEqual(changed, 1)
                found.add(self.run_json(self.write(text), "--force", "--log", self.here / "run.mcap")[0]["fingerprint"])
                self.seam("replay", "verify", self.here / "run.mcap")
        self.assertEqual(len(found), 1, found)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]], verbosity=2)
