#!/usr/bin/env python3
"""The whole way of a log: recorded by a real run, read by the independent MCAP reader, verified, broken,
cut, recovered, resumed, compared, exported. Usage: replay_test.py SEAM NODE_FOLDER [TEST...]"""
import bisect
import contextlib
import csv
import json
import math
import os
import pathlib
import random
import re
import shutil
import signal
import statistics
import struct
import subprocess
import sys
import tempfile
import time
import unittest

import by_hand

SEAM, NODE = by_hand.arguments("seam", "node")
ROOT = pathlib.Path(__file__).resolve().parent.parent
KILLS = int(os.environ.get("SEAM_KILLS", "3"))  # test.sh --all asks for 50.
CAMERA_PERIOD_S = 0.04  # Of the runs that are killed.
SCENARIO = f"""format: seam-scenario/1
name: replay_test
duration_s: 3
seed: 5
field: {ROOT}/models/field_2002.yaml
ball: {{x_m: 0.3, y_m: 0.2, vx_mps: 0.4}}
lighting: {{lambert: true, direction: [0.3, -0.2, 0.9]}}
robots:
  - id: red1
    team: red
    pose: {{x_m: -0.8, y_m: 0.1}}
    body: {ROOT}/models/robot_ers210.yaml
    camera: {{model: {ROOT}/models/ers210.yaml, width_px: 178, height_px: 144, every_frame: true,
              clock: {{period_s: 0.2}}}}
    behaviour: {{command: [ball_watcher]}}
  - id: blue1
    team: blue
    pose: {{x_m: 0.9, y_m: -0.2, theta_rad: 3.1}}
    body: {ROOT}/models/robot_ers210.yaml
    behaviour: {{command: [head_swing, --rate, "2", --amplitude, "0.5"]}}
"""


def seam(*arguments, check=None):
    done = subprocess.run([SEAM, *map(str, arguments)], capture_output=True, text=True, timeout=280)
    if check is not None and done.returncode != check:
        raise AssertionError(f"seam {' '.join(map(str, arguments))}: exit {done.returncode}, expected {check}\n"
                             f"{done.stdout}\n{done.stderr}")
    return done


def node(script, *arguments):
    return subprocess.run(["node", NODE / script, *map(str, arguments)], capture_output=True, text=True, timeout=120)


class Replay(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="seam-replay-"))
        cls.scenario = cls.folder / "scenario.yaml"
        cls.scenario.write_text(SCENARIO)
        cls.log = cls.folder / "whole.mcap"
        seam("run", cls.scenario, "--log", cls.log, "--log-frames", "--log-poses", "--json",
             cls.folder / "run.json", check=0)
        cls.fingerprint = json.loads((cls.folder / "run.json").read_text())["fingerprint"]

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    def verify(self, log, code):
        out = self.folder / "verify.json"
        seam("replay", "verify", log, "--json", out, check=code)
        result = json.loads(out.read_text())
        self.assertEqual(result["format"], "seam-verify/1")
        self.assertEqual(result["ok"], code == 0)
        return result["first_divergence"]

    def need_node(self):
        if not (NODE / "node_modules" / "@mcap").exists():
            self.skipTest("tests/mcap_node has no packages: npm ci could not reach its registry")

    def test_verifies(self):
        self.assertIsNone(self.verify(self.log, 0))

    def test_the_independent_reader_agrees(self):
        self.need_node()
        done = node("read_log.mjs", self.log)
        self.assertEqual(done.returncode, 0, done.stderr)
        found = json.loads(done.stdout)
        shown = self.folder / "show.json"
        seam("replay", "show", self.log, "--json", shown, check=0)
        ours = json.loads(shown.read_text())
        for topic, count in ours["messages"].items():
            self.assertEqual(found["counts"].get(topic), count, topic)
        self.assertEqual(found["chunks"], ours["chunks"])
        for schema in ("foxglove.CompressedImage", "foxglove.FrameTransforms", "foxglove.SceneUpdate",
                       "seam.v1.LogStep", "seam.v1.Turn"):
            self.assertIn(schema, found["schemas"])
        self.assertIn("scenario.yaml", found["attachments"])

    def test_a_broken_byte_of_a_command_is_named(self):
        self.need_node()
        broken = self.folder / "broken.mcap"
        done = node("edit_log.mjs", "break-command", self.log, broken)
        self.assertEqual(done.returncode, 0, done.stderr)
        changed = json.loads(done.stdout)
        first = self.verify(broken, 1)
        robot = ("red1", "blue1")[changed["robot"]]
        self.assertEqual(first["section"], f"robot/{robot}")
        self.assertNotEqual(first["field"], "")
        self.assertGreaterEqual(first["time_ns"], changed["time_ns"])
        self.assertLess(first["time_ns"], changed["time_ns"] + 50_000_000)
        seam("diff", self.log, broken, "--json", self.folder / "diff.json", check=1)
        diff = json.loads((self.folder / "diff.json").read_text())
        self.assertEqual(diff["first_decision"]["robot"], robot)
        self.assertEqual(diff["first_decision"]["time_ns"], changed["time_ns"])
        # The command's first joint target was changed: it is named, with both values, and the frame was the same.
        self.assertEqual(len(diff["first_decision"]["fields"]), 1)
        field = diff["first_decision"]["fields"][0]
        self.assertRegex(field["field"], "^(tilt|pan|roll)_rad$")
        self.assertNotEqual(field["a"], field["b"])
        self.assertTrue(diff["first_decision"]["frame"] is None or diff["first_decision"]["frame"]["same"])

    def test_other_writers_and_older_logs_verify(self):
        self.need_node()
        for mode in ("same", "older"):
            copy = self.folder / f"{mode}.mcap"
            done = node("edit_log.mjs", mode, self.log, copy)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIsNone(self.verify(copy, 0), mode)

    def test_damage_is_told_and_mended(self):
        whole = self.log.read_bytes()
        draw = random.Random(1)
        cuts = [len(whole) // 3, len(whole) // 2, len(whole) - 5000] + [draw.randrange(20000, len(whole)) for _ in range(3)]
        for cut in cuts:
            damaged = self.folder / "damaged.mcap"
            damaged.write_bytes(whole[:cut])
            out = self.folder / "mended.mcap"
            done = seam("replay", "recover", damaged, "--out", out)
            self.assertIn(done.returncode, (0, 3), (cut, done.stderr))
            if done.returncode == 3:
                self.assertIn("lost", done.stdout)
            seam("replay", "show", out, check=0)
        self.verify(out, 0)
        seam("replay", "recover", self.log, "--out", out, check=0)
        nothing = self.folder / "nothing.mcap"
        nothing.write_bytes(whole[:40])
        seam("replay", "recover", nothing, "--out", out, check=1)
        corrupted = self.folder / "corrupted.mcap"
        middle = len(whole) // 2
        corrupted.write_bytes(whole[:middle] + bytes([whole[middle] ^ 0x55]) + whole[middle + 1:])
        self.verify(corrupted, 1)
        seam("replay", "recover", corrupted, "--out", out, check=3)

    def test_a_damaged_index_is_named_and_made_anew(self):
        damaged, mended, report = self.folder / "index.mcap", self.folder / "mended.mcap", self.folder / "index.json"
        whole = bytearray(self.log.read_bytes())
        (summary,) = struct.unpack_from("<Q", whole, len(whole) - 8 - 20)  # The footer's first field.
        whole[summary + 20] ^= 0x10
        damaged.write_bytes(whole)
        said = seam("replay", "verify", damaged, "--json", report, check=0).stdout
        self.assertIn("the index is damaged at offset", said)
        self.assertIn("the same", said)
        self.assertIn("damaged", json.loads(report.read_text())["index"])
        said = seam("replay", "recover", damaged, "--out", mended, "--json", report, check=0).stdout
        self.assertIn("the index is damaged at offset", said)
        self.assertIn("a new index was written", said)
        self.assertIn("damaged", json.loads(report.read_text())["index"])
        self.assertNotIn("index", seam("replay", "verify", mended, "--json", report, check=0).stdout)
        self.assertIsNone(json.loads(report.read_text())["index"])

    def test_a_run_that_ended_before_its_first_step_is_no_divergence(self):
        scenario = self.folder / "early.yaml"
        scenario.write_text(SCENARIO)
        for number, sent in enumerate((signal.SIGTERM, signal.SIGKILL)):
            log = self.folder / f"early{number}.mcap"
            # It waits for a renderer, which never comes.
            server = subprocess.Popen([SEAM, "serve", scenario, "--listen", f"unix:{self.folder}/early{number}", "--renderers", "1",
                                       "--log", log], stdout=subprocess.PIPE, text=True)
            self.assertIn("listening", server.stdout.readline())
            server.send_signal(sent)
            server.wait(60)
            server.stdout.close()
            done = seam("replay", "verify", log)
            self.assertNotIn("divergence", done.stdout)
            said = {signal.SIGTERM: (0, "nothing to compare: the run ended before its first step"),
                    signal.SIGKILL: (1, "the run was killed before it wrote one")}[sent]
            self.assertEqual((done.returncode, said[1] in done.stdout), (said[0], True), done.stdout)

    def test_killed_runs_resume_to_the_same_end(self):
        """kill -9 of server and behaviours at a random moment. How far the run had come is known from the pictures that it
        wrote (--frames), of which there is one each 0.04 s: the log must reach at least to one second before."""
        scenario = self.folder / "killed.yaml"
        scenario.write_text(SCENARIO.replace("period_s: 0.2", f"period_s: {CAMERA_PERIOD_S}"))
        whole = self.folder / "uninterrupted.mcap"
        seam("run", scenario, "--log", whole, check=0)
        draw = random.Random(2)
        worst_s, open_ends = 0.0, 0
        for number in range(KILLS):
            log, pictures = self.folder / "killed.mcap", self.folder / f"pictures{number}"
            log.unlink(missing_ok=True)  # Else the new log would grow beside it.
            run = subprocess.Popen([SEAM, "run", scenario, "--log", log, "--frames", pictures, "--force"],
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
            # A moment of the run, however fast the machine is: after some picture, and a little later.
            wanted, later_s = draw.randrange(1, int(3 / CAMERA_PERIOD_S)), draw.uniform(0, 0.02)
            while run.poll() is None and sum(1 for _ in pictures.glob("*.png")) < wanted:
                time.sleep(0.001)
            time.sleep(later_s)
            with contextlib.suppress(ProcessLookupError):  # It may have ended by itself.
                os.killpg(run.pid, signal.SIGKILL)
            run.wait()
            frames = [int(path.stem.rsplit("_", 1)[1]) for path in pictures.glob("*.png")]
            shutil.rmtree(pictures)
            report = self.folder / "killed.json"
            seam("replay", "show", log, "--json", report, check=0)
            shown = json.loads(report.read_text())
            open_ends += shown["fingerprint"] is None
            lost_s = max(frames) * CAMERA_PERIOD_S - shown["end_s"]
            worst_s = max(worst_s, lost_s)
            self.assertLess(lost_s, 1.0, f"kill {number}: the log ends at {shown['end_s']} s")
            resumed, summary = self.folder / "resumed.mcap", self.folder / "resumed.json"
            seam("replay", "resume", log, "--log", resumed, "--json", summary, "--force",
                 "--run-programs", check=0)
            # The whole log again, byte by byte, and with it the fingerprint at the end.
            self.assertEqual(resumed.read_bytes(), whole.read_bytes(), f"kill {number}")
        print(f"{KILLS} kills, {open_ends} of them before the end; the log ended at most {worst_s:.3f} s before the last "
              f"picture", file=sys.stderr)
        self.assertGreater(2 * open_ends, KILLS, "most kills came too late to test anything")

    def test_frames_are_those_of_the_run(self):
        eyes = self.folder / "eyes"
        seam("replay", "frames", self.log, "--robot", "red1", "--from", "1", "--to", "1.5", "--out", eyes, check=0)
        export = self.folder / "export"
        seam("replay", "export", self.log, "--out", export, check=0)
        made = sorted(path.name for path in eyes.glob("*.png"))
        self.assertGreaterEqual(len(made), 2)
        for name in made:
            self.assertEqual((eyes / name).read_bytes(), (export / name).read_bytes(), name)

    def test_tables_join_by_integer_times_and_have_the_columns_of_their_page(self):
        tables = self.folder / "tables"
        seam("replay", "export", self.log, "--out", tables, check=0)
        page = dict(re.findall(r"^\| `(\w+\.csv)` \|.*\| `([\w,]+)` \|$", (ROOT / "docs/reference/tables.md").read_text(), re.M))
        rows = {}
        for path in tables.glob("*.csv"):
            self.assertEqual(path.read_text().splitlines()[0], page.pop(path.name), path.name)
            with open(path, newline="") as file:
                rows[path.name] = list(csv.DictReader(file))
            self.assertNotIn("00000000", ",".join(row.get("time_s", "") for row in rows[path.name]), path.name)
        self.assertEqual(page, {})
        decisions = {(row["time_ns"], row["robot"]): row for row in rows["decisions.csv"]}
        self.assertEqual(len(decisions), len(rows["decisions.csv"]))
        for name in ("joint_commands.csv", "debug.csv"):
            self.assertGreater(len(rows[name]), 10)
            for row in rows[name]:
                self.assertIn((row["time_ns"], row["robot"]), decisions, name)
        frames = {(row["robot"], row["frame"]): row for row in rows["frames.csv"]}
        for row in rows["decisions.csv"]:
            self.assertEqual(float(row["time_s"]), int(row["time_ns"]) / 1e9)
            if row["frame"]:
                self.assertLessEqual(int(frames[row["robot"], row["frame"]]["end_ns"]), int(row["time_ns"]))
        # The truth at a decision is what `show` has for that instant.
        for row in rows["decisions.csv"][5:60:18]:
            out = self.folder / "at.json"
            seam("replay", "show", self.log, "--at", row["time_s"], "--json", out, check=0)
            at = json.loads(out.read_text())
            self.assertEqual(at["time_ns"], int(row["time_ns"]))
            for name in ("x_m", "y_m", "heading_rad", "tilt_rad", "pan_rad", "roll_rad"):
                self.assertEqual(float(row[name]), at["robots"][row["robot"]][name], name)
            for name in ("x_m", "y_m", "z_m"):
                self.assertEqual(float(row["ball_" + name]), at["ball"][name], name)

    def test_what_if_says_where_a_program_first_decides_otherwise_and_draws_for_it_alone(self):
        """Another rate of the head changes decisions at once, which have no effect before --from."""
        other = ["replay", "whatif", self.log, "--robot", "blue1", "--from", "1", "--client"]
        done = seam(*other, "head_swing --rate 1 --amplitude 0.5", check=0)
        self.assertRegex(done.stdout, r"blue1 first decides otherwise at [\d.]+ m?s, after \d+ decisions as in the log; "
                         r"before --from, without effect\n  tilt\.max_speed_rad_s: \S+ in the log, \S+ now")
        self.assertIn("no fingerprint: frames that no client sees were not drawn", done.stdout)
        same = seam(*other, "head_swing --rate 2 --amplitude 0.5", check=0)
        self.assertRegex(same.stdout, r"blue1 decides as in the log, each of \d+ times")
        self.assertIn("equal (compared up to", same.stdout)
        # A log that is kept can be verified: its frames are the log's until then, and drawn from then on.
        kept = self.folder / "kept.mcap"
        seam(*other, "head_swing --rate 1 --amplitude 0.5", "--log", kept, "--force", check=0)
        seam("replay", "verify", kept, check=0)

    def test_what_if_shows_what_follows(self):
        out = self.folder / "whatif.json"
        seam("replay", "whatif", self.log, "--robot", "blue1", "--client", "head_swing --rate 1 --amplitude 0.2",
             "--from", "1", "--json", out, check=0)
        diff = json.loads(out.read_text())
        self.assertFalse(diff["equal"])
        self.assertGreaterEqual(diff["first"]["time_ns"], 1_000_000_000)
        self.assertEqual(diff["first"]["section"], "robot/blue1")
        done = seam("replay", "whatif", self.log, "--robot", "blue1", "--client", "head_swing", "--from", "9", check=2)
        self.assertIn("--from 9: the log ends at 3 s", done.stderr)

    def test_accuracy_is_what_the_tables_say(self):
        """A player's estimates against the truth, by the command and once more from the exported tables."""
        scenario, log = self.folder / "player.yaml", self.folder / "player.mcap"
        text = SCENARIO[:SCENARIO.index("  - id: blue1")].replace("every_frame: true", f"colour_table: {ROOT}/models/colour_table_2002.yaml")
        scenario.write_text(text.replace("ball_watcher", "player").replace("period_s: 0.2", "period_s: 0.04"))
        seam("run", scenario, "--log", log, check=0)
        out, tables = self.folder / "accuracy.json", self.folder / "player"
        seam("replay", "accuracy", log, "--json", out, check=0)
        told = json.loads(out.read_text())
        seam("replay", "export", log, "--out", tables, check=0)

        def table(name):
            with open(tables / name, newline="") as file:
                return list(csv.DictReader(file))

        def at(rows, columns, time_s):
            times = [float(row["time_s"]) for row in rows]
            i = min(max(bisect.bisect_left(times, time_s), 1), len(rows) - 1)
            part = min(max((time_s - times[i - 1]) / (times[i] - times[i - 1]), 0), 1)
            return [float(rows[i - 1][c]) * (1 - part) + float(rows[i][c]) * part for c in columns]

        poses, ball, values = table("poses.csv"), table("ball.csv"), {}
        for row in table("debug.csv"):
            if row["kind"] == "value":
                values.setdefault(row["name"], []).append((float(row["time_s"]), float(row["value"])))
        position = []
        for (time_s, x_m), (_, y_m) in zip(values["x_m"], values["y_m"]):
            true_x, true_y = at(poses, ("x_m", "y_m"), time_s)
            position.append(math.hypot(x_m - true_x, y_m - true_y))
        distance, bearing = [], []
        for time_s, distance_m in values["ball_distance_m"]:
            x, y, heading = at(poses, ("x_m", "y_m", "heading_rad"), time_s)
            ball_x, ball_y = at(ball, ("x_m", "y_m"), time_s)
            distance.append(distance_m - math.hypot(ball_x - x, ball_y - y))
        for time_s, bearing_rad in values["ball_bearing_rad"]:
            x, y, heading = at(poses, ("x_m", "y_m", "heading_rad"), time_s)
            ball_x, ball_y = at(ball, ("x_m", "y_m"), time_s)
            bearing.append(math.remainder(bearing_rad - math.atan2(ball_y - y, ball_x - x) + heading, 2 * math.pi))
        for name, errors in (("position_m", position), ("ball_distance_m", distance), ("ball_bearing_rad", bearing)):
            for summary in (told["all"][name], told["robots"]["red1"][name]):
                self.assertEqual(summary["n"], len(errors))
                self.assertGreater(len(errors), 9)
                self.assertAlmostEqual(summary["mean"], statistics.fmean(errors), 5)
                self.assertAlmostEqual(summary["median_abs"], statistics.median(map(abs, errors)), 5)
                self.assertAlmostEqual(summary["max_abs"], max(map(abs, errors)), 5)
        # And the estimates are of use.
        self.assertLess(told["all"]["ball_distance_m"]["median_abs"], 0.1)
        self.assertLess(told["all"]["ball_bearing_rad"]["median_abs"], 0.1)
        seam("replay", "accuracy", self.log, "--json", out, check=0)  # Its clients estimate nothing.
        self.assertEqual(json.loads(out.read_text())["all"]["position_m"]["n"], 0)

    def test_a_signed_log_and_a_kind_without_events(self):
        keys = [self.folder / "log.key", self.folder / "log.pub"]
        subprocess.run(["openssl", "genpkey", "-algorithm", "ed25519", "-out", keys[0]], check=True)
        subprocess.run(["openssl", "pkey", "-in", keys[0], "-pubout", "-out", keys[1]], check=True)
        log = self.folder / "signed.mcap"
        seam("run", self.scenario, "--log", log, "--sign", keys[0], check=0)
        self.assertIn(f"{log}: signed with the key of {keys[1]}\n", seam("replay", "verify", log, "--key", keys[1], check=0).stdout)
        self.assertIn("no events of these kinds", seam("replay", "show", log, "--kind", "fault", check=0).stdout)

    def test_wrong_use_says_so(self):
        seam("replay", "verify", check=2)
        seam("replay", "frames", self.log, "--robot", "nobody", "--out", self.folder / "x", check=2)
        seam("replay", "verify", self.folder / "missing.mcap", check=1)
        done = seam("replay", "show", self.scenario, check=1)
        self.assertIn("not an MCAP file", done.stderr)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v", *sys.argv[3:]])
