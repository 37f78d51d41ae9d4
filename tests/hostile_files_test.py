#!/usr/bin/env python3
"""Every command of `seam` with files that somebody made to do harm: nothing outside the output folder changes, no program
that a file names is started, nothing crashes, nothing is sent to the terminal that moves its cursor.

Compared before and after each command: names, kinds, sizes, times of change, rights and contents of all files of a scratch
folder that holds the working folder, HOME, TMPDIR, decoys that the files name, and the inputs; the names, sizes and times
of the source tree; and what the files name in /tmp and /.

Usage: hostile_files_test.py BUILD_DIR SOURCE_DIR [unittest arguments]
"""
import contextlib
import hashlib
import io
import json
import os
import pathlib
import re
import shutil
import signal
import sqlite3
import stat
import subprocess
import sys
import tarfile
import tempfile
import time
import unittest
import urllib.error
import urllib.request

sys.dont_write_bytecode = True  # The source tree is compared.
import hostile_logs  # noqa: E402

import by_hand

BUILD, SOURCE = by_hand.arguments("build", "source")
SEAM = BUILD / "seam"
LIMIT_S = 120
MARK = f"seam-hostile-{os.getpid()}"
ESCAPE = "\x1b]0;owned\x07\x1b[2J"
OUTSIDE = [pathlib.Path("/tmp") / MARK, pathlib.Path("/") / MARK, pathlib.Path.home() / MARK]

SCENARIO = f"""format: seam-scenario/1
name: NAME
duration_s: 0.3
seed: 5
field: {SOURCE}/models/field_2002.yaml
robots:
  - id: ROBOT
    team: red
    pose: {{x_m: -0.9, y_m: 0.4, theta_rad: 0.3}}
    body: {SOURCE}/models/robot_ers210.yaml
    camera: {{model: {SOURCE}/models/ers210.yaml, every_frame: true}}
    behaviour: {{command: COMMAND}}
"""
SET = """format: seam-measurement/1
kind: points
title: "TITLE"
camera: {width_px: 178, height_px: 144, frame_period_s: 0.04}
noise: {u_px: 0.15, v_px: 0.15}
group: frame
files: {points: POINTS, joints: JOINTS}
rig:
  chain:
    - {translate_m: [0.0, 0.0, 0.195]}
    - {joint: tilt, axis: [0, 1, 0]}
    - {joint: pan, axis: [0, 0, 1]}
"""
MODEL = """format: seam-model/1
name: "NAME"
effects:
  pinhole: {fx_px: 161.9, fy_px: 162.5, cx_px: 88.5, cy_px: 71.5}
"""


def in_yaml(text):
    return '"' + "".join(f"\\x{ord(c):02x}" if ord(c) < 32 or c in '"\\' else c for c in text) + '"'


def state_of(path, contents):
    status = path.lstat()
    found = [stat.filemode(status.st_mode), status.st_uid]
    if path.is_symlink():
        found.append(os.readlink(path))
    elif stat.S_ISREG(status.st_mode):
        found += [status.st_size, status.st_mtime_ns]
        if contents:
            found.append(hashlib.sha256(path.read_bytes()).hexdigest())
    return found


class Hostile(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory(prefix="seam-foreign-")
        cls.root = pathlib.Path(cls.scratch.name).resolve()
        for name in ("decoys", "home", "tmp", "work", "inputs", "work/deep"):
            (cls.root / name).mkdir()
        for name in ("points.csv", "joints.csv", "secret.txt", "scene.yaml"):
            (cls.root / "decoys" / name).write_text("mine\n")
        (cls.root / "home" / ".profile").write_text("mine\n")
        cls.environment = dict(os.environ, HOME=str(cls.root / "home"), TMPDIR=str(cls.root / "tmp"))
        cls.environment.pop("XDG_STATE_HOME", None)
        cls.inputs = cls.root / "inputs"
        cls.make_scenarios()
        cls.make_logs()
        cls.make_sets()
        cls.results = {}
        cls.known = None  # What the last command left, where nothing else changed since.

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    @classmethod
    def make_scenarios(cls):
        harm = f"[/bin/sh, -c, 'touch {cls.root}/decoys/started']"

        def scenario(name, title, robot, command):
            text = SCENARIO.replace("NAME", in_yaml(title)).replace("ROBOT", in_yaml(robot)).replace("COMMAND", command)
            (cls.inputs / name).write_text(text)
            return cls.inputs / name

        cls.well = scenario("well.yaml", "well", "r0", "[head_swing, --rate, '200']")
        cls.harm = harm
        # A scenario's programs are started by `seam run`: that is what it is for (SECURITY.md). Here they are ours.
        cls.scenarios = [scenario("title.yaml", f"../../decoys/secret.txt{ESCAPE}", "r0", "[head_swing, --rate, '200']"),
                         scenario("robot.yaml", "x", "../../decoys/secret", "[head_swing]"),
                         scenario("absolute.yaml", "x", f"/tmp/{MARK}", "[head_swing]"),
                         scenario("escape.yaml", "x", f"r{ESCAPE}", "[head_swing]")]

    @classmethod
    def make_logs(cls):
        well = cls.inputs / "well.mcap"
        subprocess.run([SEAM, "run", cls.well, "--log", well, "--log-frames", "--log-poses"], check=True, capture_output=True,
                       env=cls.environment, cwd=cls.root / "work")
        shutil.rmtree(cls.root / "home" / ".local")  # What a run that is ours notes; the logs below are not.
        data = well.read_bytes()
        scenario = hostile_logs.scenario_of(data)
        harmful = re.sub(rb"command: \[.*?\]", b"command: " + cls.harm.encode(), scenario, flags=re.S)
        assert harmful != scenario, scenario
        usual = {"scenario": harmful, "name": b"x", "robots": [b"r0"], "sections": [b"ball"],
                 "attachments": [(b"scenario.yaml", harmful)]}
        kinds = {
            "programs": {"sections": [ESCAPE.encode()], "name": f"../../decoys/secret.txt{ESCAPE}".encode()},
            "attachments": {"attachments": [(b"scenario.yaml", harmful), (b"../../decoys/secret.txt", b"harm"),
                                            (f"/tmp/{MARK}".encode(), b"harm"), (ESCAPE.encode(), b"harm")]},
            "robots": {"robots": [b"../../decoys/secret"]},
            "absolute": {"robots": [f"/tmp/{MARK}\0".encode()]},
            "escapes": {"robots": [ESCAPE.encode()]},
        }
        cls.logs = [well]
        for name, changed in kinds.items():
            cls.logs.append(cls.inputs / f"{name}.mcap")
            cls.logs[-1].write_bytes(hostile_logs.forged(data, **{**usual, **changed}))

    @classmethod
    def make_sets(cls):
        joints = "time_s,tilt_rad,pan_rad\n" + "".join(f"{i * 0.008:.3f},0.1,{i * 0.01:.3f}\n" for i in range(60))
        points = "frame,time_s,point,x_m,y_m,z_m,u_px,v_px\n" + "".join(
            f"{i},{0.1 + 0.04 * i:.2f},{k},{1.0 + k * 0.1:.1f},{0.1 * k:.1f},0.2,{80 + k}.0,{70 + i}.0\n"
            for i in range(8) for k in range(5))

        def make(name, title, points_name, joints_name):
            folder = cls.inputs / name
            folder.mkdir()
            (folder / "points.csv").write_text(points)
            (folder / "joints.csv").write_text(joints)
            text = SET.replace("TITLE", title).replace("POINTS", in_yaml(points_name)).replace("JOINTS", in_yaml(joints_name))
            (folder / "measurement.yaml").write_text(text)
            shutil.copy(folder / "measurement.yaml", folder / "set.yaml")
            return folder

        up = "../../decoys/points.csv"
        cls.sets = [make("set-well", "well\\x1b[2J", "points.csv", "joints.csv"),
                    make("set-up", "up", up, "joints.csv"),
                    make("set-absolute", "absolute", f"/tmp/{MARK}", "joints.csv"),
                    make("set-nul", "nul", "points.csv", "joints.csv\0.png"),
                    make("set-link", "link", "linked.csv", "joints.csv"),
                    make("set-scene", "scene", "points.csv", "joints.csv")]
        (cls.inputs / "set-link" / "linked.csv").symlink_to("../../decoys/points.csv")
        with (cls.inputs / "set-scene" / "measurement.yaml").open("a") as file:
            file.write("scene: ../../decoys/scene.yaml\n")
        cls.left_out = [cls.inputs / f"left-out-{i}.csv" for i in range(3)]
        for path, text in zip(cls.left_out, (f"row,reason\n3,{ESCAPE}<script>", f"file,row,reason\n../../decoys/points.csv,2,{ESCAPE}",
                                             f"row,reason\n{ESCAPE},x")):
            path.write_bytes(text.encode() + b"\xff\xfe\n")
        cls.model = cls.inputs / "model.yaml"
        cls.model.write_text(MODEL.replace("NAME", f"../x\\x1b[2J"))
        cls.result = cls.inputs / "result.json"
        cls.result.write_text('{"format": "seam-compare/1", "title": "\\u001b[2J<script>../../x", "data": "../../decoys"}')

    # ---- What is compared ----

    def snapshot(self, out):
        found = {}
        for folder, folders, files in os.walk(self.root):
            here = pathlib.Path(folder)
            if here == out:
                folders.clear()
                continue
            for name in folders + files:
                if here / name != out:
                    found[str(here / name)] = state_of(here / name, True)
        for folder, folders, files in os.walk(SOURCE):
            folders[:] = [name for name in folders if not name.startswith(("build", ".", "node_modules", "__pycache__"))]
            for name in files:
                path = pathlib.Path(folder) / name
                if path.lstat().st_mode & 0o170000 == stat.S_IFREG:
                    found[str(path)] = state_of(path, False)
        for path in OUTSIDE:
            found[str(path)] = state_of(path, True) if path.exists() else None
        return found

    def walk(self, command, *arguments, serves=None, codes=None):
        """Runs it, with {out} a fresh output folder, and compares the file system."""
        with self.subTest(command=command, arguments=[str(a).replace(str(self.root), "") for a in arguments]):
            out = self.root / "out"
            out.mkdir()
            before = self.known or self.snapshot(out)
            line = [SEAM, *command.split(), *[str(a).replace("{out}", str(out)) for a in arguments]]
            usual = {"cwd": self.root / "work", "env": self.environment, "stdin": subprocess.DEVNULL}
            if serves:
                code, text = serves(line, usual)
            else:
                done = subprocess.run(line, capture_output=True, timeout=LIMIT_S, **usual)
                code, text = done.returncode, done.stdout + done.stderr
            after = self.known = self.snapshot(out)
            shutil.rmtree(out)
            changed = sorted(path for path in before.keys() | after.keys() if before.get(path) != after.get(path))
            self.assertEqual(changed, [], text.decode(errors="replace"))
            self.assertIn(code, codes or (0, 1, 2, 3), text.decode(errors="replace"))
            self.assertNotIn(b"\x1b", text)
            self.assertNotIn(b"\x07", text)
        self.results[command] = self.results.get(command, 0) + 1

    # ---- The commands ----

    def test_every_command(self):
        asked = subprocess.run([SEAM, "help", "--markdown"], capture_output=True, text=True, check=True).stdout
        commands = set(re.findall(r"^## `seam (.*?)`$", asked, re.M)) - {"replay", "experiment", "open-r"}
        for part in (self.logs_are_read, self.logs_are_run, self.scenarios_are_read, self.sets_are_read, self.sets_are_made,
                     self.sweeps, self.all_else):
            part()
        self.assertEqual(commands - self.results.keys(), set(), "commands that no hostile file was given to")

    def logs_are_read(self):
        for log in self.logs:
            self.walk("replay verify", log, "--json", "{out}/v.json")
            self.walk("replay show", log, "--at", "0.1", "--json", "{out}/s.json")
            self.walk("replay diff", log, self.logs[0], "--json", "{out}/d.json")
            self.walk("diff", self.logs[0], log)
            self.walk("replay find", log, "--when", "r0.pan_rad > 0", "--json", "{out}/w.json")
            self.walk("replay export", log, "--out", "{out}/e")
            self.walk("replay episodes", log, "--robot", "r0", "--frames", "--out", "{out}/p")
            self.walk("replay recover", log, "--out", "{out}/r.mcap", "--json", "{out}/r.json")
            self.walk("replay accuracy", log, "--json", "{out}/a.json")
            self.walk("replay frames", log, "--robot", "r0", "--to", "0.1", "--out", "{out}/f")
            self.walk("check", log)
            self.walk("view", log, serves=self.looked_at)

    def logs_are_run(self):
        for log in self.logs[1:]:
            self.walk("replay resume", log, "--log", "{out}/r.mcap", "--frames", "{out}/f", codes=(1, 2))
            self.walk("replay feed", log, "--robot", "r0", "--client", "head_swing --rate 200", "--json", "{out}/g.json")
            self.walk("replay whatif", log, "--robot", "r0", "--client", "head_swing --rate 200", "--others", "live",
                      "--log", "{out}/w.mcap")

    def looked_at(self, line, usual):
        with subprocess.Popen(line, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, **usual) as server:
            said = server.stdout.readline()
            found = re.search(rb"(http://[^/]*/).*#token=(\w+)", said)
            cookie = ""
            if found:
                token = json.dumps({"token": found[2].decode()}).encode()
                with urllib.request.urlopen(found[1].decode() + "api/enter", token, timeout=30) as answer:
                    cookie = answer.headers["Set-Cookie"].split(";")[0]
            for path in ("api/info", "api/state?t=0.1", "api/frame?robot=r0&frame=0", "api/frame?robot=..%2f..%2fdecoys&frame=0",
                         "../../decoys/secret.txt", "%2e%2e/%2e%2e/decoys/secret.txt", "..%2f..%2fdecoys%2fsecret.txt",
                         "api/events?log=../../decoys"):
                if not found:
                    break
                try:
                    request = urllib.request.Request(found[1].decode() + path, headers={"Cookie": cookie})
                    with urllib.request.urlopen(request, timeout=30) as answer:
                        self.assertNotIn(b"mine\n", answer.read(), path)
                except urllib.error.HTTPError as error:
                    self.assertNotIn(b"mine\n", error.read(), path)
            server.send_signal(signal.SIGTERM)
            said += server.stdout.read()
            code = server.wait(LIMIT_S)
        return (0 if code == -signal.SIGTERM else code), said

    def served(self, line, usual):
        with subprocess.Popen(line, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, **usual) as server:
            said = server.stdout.readline()
            time.sleep(0.1)
            server.send_signal(signal.SIGTERM)
            said += server.stdout.read()
            return server.wait(LIMIT_S), said

    def scenarios_are_read(self):
        for scenario in self.scenarios:
            # What `run` notes of its own runs in the user's state folder is none of the file's doing (docs/replay.md).
            self.environment["XDG_STATE_HOME"] = str(self.root / "out" / "state")
            self.walk("run", scenario, "--log", "{out}/r.mcap", "--frames", "{out}/f", "--json", "{out}/r.json")
            del self.environment["XDG_STATE_HOME"]
            self.walk("serve", scenario, "--listen", "unix:{out}/socket", "--log", "{out}/s.mcap", "--tokens", "{out}/t",
                      serves=self.served)
            self.walk("serve", scenario, "--dm-env-rpc", "--listen", "unix:{out}/socket", "--logs", "{out}/l", serves=self.served)
            self.walk("frame", scenario, "--robot", "r0", "--at", "0.1", "--stages", "{out}/stages", "--out", "{out}/f.png")
            self.walk("colour-table", scenario, "--robot", "r0", "--to", "0.1", "--out", "{out}/c.yaml")
            self.walk("joints", scenario)
            self.walk("check", scenario)

    def sets_are_read(self):
        for folder in self.sets:
            both = ["--model", self.model, "--data", folder]
            self.walk("check", folder, "--model", self.model)
            self.walk("compare", *both, "--json", "{out}/c.json", "--report", "{out}/c.html")
            self.walk("fit", *both, "--out", "{out}/f.yaml")
            self.walk("add", "rolling_shutter", *both, "--out", "{out}/a.yaml")
            self.walk("diagnose", *both, "--json", "{out}/d.json", "--suggest", "{out}/s.yaml")
            self.walk("discover", *both, "--out", "{out}/d.yaml")
            for left_out in self.left_out:
                self.walk("compare", *both, "--leave-out", left_out, "--json", "{out}/c.json", "--report", "{out}/c.html")
            self.environment["XDG_STATE_HOME"] = str(self.root / "out" / "state")
            self.walk("workbench", folder, "--session", "{out}/session", serves=self.looked_at)
            del self.environment["XDG_STATE_HOME"]

        self.walk("schema", f"../../decoys/{ESCAPE}", codes=(2,))

    def sets_are_made(self):
        for folder in self.sets:
            self.walk("measure", "--model", self.model, "--protocol", folder, "--out", "{out}/set")
            self.walk("plan", "--model", self.model, "--protocol", folder, "--effects", "rolling_shutter", "--json", "{out}/p.json",
                      "--report", "{out}/p.html")

    def sweeps(self):
        """Plans, and results whose plan somebody changed after they were made."""
        def plan(name, text):
            path = self.inputs / name
            path.write_text("format: seam-sweep/1\n" + text)
            return path

        well = plan("plan.yaml", "scenario: well.yaml\nset: {duration_s: 0.1}\nseeds: [1, 2]\n")
        plans = [plan("up.yaml", "scenario: ../../decoys/secret.txt\nseeds: [1]\n"),
                 plan("absolute_plan.yaml", f"scenario: /tmp/{MARK}\nseeds: [1]\n"),
                 plan("names.yaml", "scenario: well.yaml\nvary:\n  - {path: \"robots[0].pose.x_m\", name: "
                      f"{in_yaml('../x' + ESCAPE)}, values: [0]}}\n")]
        results = self.inputs / "well.sqlite"
        subprocess.run([SEAM, "sweep", well, "--out", results], check=True, capture_output=True, env=self.environment,
                       cwd=self.root / "work")
        shutil.rmtree(self.root / "home" / ".local")  # As if it were made elsewhere.
        foreign = self.inputs / "foreign.sqlite"
        shutil.copy(results, foreign)
        with contextlib.closing(sqlite3.connect(foreign)) as file, file:
            (scenario,) = file.execute("select value from meta where key = 'scenario'").fetchone()
            harmful = re.sub(r'command: \[.*?\]|command:(\n\s+- .*)+', "command: " + self.harm, scenario)
            assert harmful != scenario, scenario
            file.execute("update meta set value = ? where key = 'scenario'", (harmful,))
            file.execute("update meta set value = ? where key = 'plan_name'", (f"../../decoys/x{ESCAPE}",))
            file.execute("update runs set end = ?, error = ?", (ESCAPE, ESCAPE))
        broken = self.inputs / "broken.sqlite"
        broken.write_bytes(results.read_bytes()[:5000])
        self.known = None
        for path in plans:
            self.environment["XDG_STATE_HOME"] = str(self.root / "out" / "state")
            self.walk("sweep", path, "--out", "{out}/r.sqlite")
            del self.environment["XDG_STATE_HOME"]
            self.walk("sweep submit", path, "--slurm", "--only-write", "--shards", "2", "--out", "{out}/r.sqlite")
        for file in (results, foreign, broken, self.result):
            for command in ("sweep status", "sweep table", "sweep rerun"):
                self.walk(command, file)
            self.walk("sweep plot", file, "--value", "sim_s", "--over", "seed", "--out", "{out}/p.png")
            self.walk("sweep merge", file, "--out", "{out}/m.sqlite")
            self.walk("sweep bundle", file, "--out", "{out}/b.seam")
        for file in (self.logs[1], self.make_bundle(foreign)):
            self.walk("sweep bundle", file, "--out", "{out}/b.seam")
            self.walk("sweep rerun", file)

    def make_bundle(self, results):
        """Results with a foreign program, in a bundle whose other names lead elsewhere."""
        subprocess.run([SEAM, "sweep", "bundle", results, "--out", self.inputs / "well.seam"], check=True, capture_output=True,
                       env=self.environment, cwd=self.root / "work")
        with tarfile.open(self.inputs / "well.seam") as archive:
            files = [(entry, archive.extractfile(entry).read()) for entry in archive]
        manifest = json.loads(files[0][1])
        manifest["words"] = {"/bin/sh": "../../decoys/secret.txt"}
        manifest["needs"] = [ESCAPE]
        bad = self.inputs / "bad.seam"
        with tarfile.open(bad, "w:gz", format=tarfile.USTAR_FORMAT) as archive:
            for entry, data in [(files[0][0], json.dumps(manifest).encode())] + files[1:]:
                entry.size = len(data)
                archive.addfile(entry, io.BytesIO(data))
        self.known = None
        return bad

    def all_else(self):
        decoy = "../decoys/secret.txt"
        self.walk("history", self.model, "--json", "{out}/h.json", "--report", "{out}/h.html")
        self.walk("report", self.result, "--out", "{out}/r.html")
        self.walk("contact-sheet", self.inputs / "set-link", "--out", "{out}/sheet.png")
        self.walk("camera-calibrate", "--model", self.model, "--out", "{out}/calibration")
        names = self.inputs / "names.csv"  # A map of columns whose names lead elsewhere.
        names.write_text(f"time_s,../../decoys/secret.txt,{ESCAPE}\n0,1,2\n0.1,2,3\n")
        link = self.inputs / "link.csv"
        link.symlink_to("../decoys/points.csv")
        self.known = None
        for kind in ("images", "servo", "ranges", "opencv", "kalibr", "mrcal", "bouguet", "ros", "euroc", "tum", "emva1288", "flats", "log"):
            for source in (names, link, self.logs[1], self.inputs / "set-link"):
                board = ["--board", "9x6", "--spacing", "0.03"] if kind == "images" else []
                self.walk("import", kind, source, *board, "--out", "{out}/set")
        for form in ("opencv", "ros", "mrcal", "kalibr", "json"):
            self.walk("export", self.model, "--to", form, "--size", "178x144", "--out", "{out}/e")
        self.walk("effects", decoy)
        self.walk("help", decoy)
        for name in (decoy, f"/tmp/{MARK}", "../../x", "a/b", ESCAPE):
            self.walk("new-effect", name, "--stage", "light")
        self.walk("new-effect", "honest", "--stage", "light", "--out", "{out}/honest")
        self.open_r_programs()
        self.walk("certs", "{out}/certs", "--host", f"{ESCAPE}/../../x")
        self.walk("study", "../../decoys", "--seeds", "1", "--json", "{out}/s.json")
        for name in ("ball-distance", "localization", "head-swing-bias"):
            # They read no foreign file; an output that cannot be had ends them before they begin.
            self.walk(f"experiment {name}", "--quick", "--out", "{out}/x", "--json", "{out}/no/such/x.json", codes=(1,))

    def open_r_programs(self):
        """Names that would lead out of the memory stick, in each file that a build reads."""
        names = ("../../decoys/x", f"/tmp/{MARK}", ESCAPE, "..", "$(shell touch " + MARK + ")")
        for i, name in enumerate(names):
            program = self.root / f"aibo{i}"
            conf, head = program / "MS/OPEN-R/MW/CONF", program / "Head"
            conf.mkdir(parents=True)
            head.mkdir()
            (conf / "OBJECT.CFG").write_text(f"/MS/OPEN-R/MW/OBJS/{name}\n" if i % 2 else "/MS/OPEN-R/MW/OBJS/HEAD.BIN\n")
            (head / "head.ocf").write_text(f"object {name} 3072 16384 128 cache tlb user\n")
            (head / "Makefile").write_text(f"head.bin: {name}.o\ninstall: head.bin\n\tgzip -c head.bin > {name}.BIN\n")
            (head / "stub.cfg").write_text(f"ObjectName : {name}\n")
            self.known = None  # These files are new.
            self.walk("open-r build", program, "--out", "{out}/o", codes=(1,))
            self.walk("open-r stub", head / "stub.cfg", "--out", "{out}/o", codes=(1,))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
