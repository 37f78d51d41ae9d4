#!/usr/bin/env python3
"""Bundles: studies repeated in another folder, and archives that somebody made to do harm.

Usage: bundle_test.py BUILD_DIR SOURCE_DIR PYTHON [unittest arguments]; PYTHON is the interpreter that has gRPC.
With SEAM_EMULATED_CPUS="Nehalem Haswell" a bundle is rerun on these, too (qemu-user).
"""
import gzip
import hashlib
import io
import json
import os
import pathlib
import shutil
import sqlite3
import subprocess
import sys
import tarfile
import tempfile
import unittest

import by_hand

BUILD, SOURCE, PYTHON = by_hand.arguments("build", "source", "python")
SEAM = BUILD / "seam"
LIMIT_S = 300
CPUS = os.environ.get("SEAM_EMULATED_CPUS", "").split()

SCENARIO = """format: seam-scenario/1
name: bundled
duration_s: 0.4
seed: 5
field: field.yaml
robots:
  - id: r0
    team: red
    pose: {x_m: -0.9, y_m: 0.4, theta_rad: 0.3}
    body: robot.yaml
    camera: {model: model.yaml, width_px: 44, height_px: 36, clock: {period_s: 0.1}}
    behaviour: {command: [./bot.py, TABLE, --rate=3]}
"""
PLAN = """format: seam-sweep/1
scenario: scenario.yaml
vary: [{path: "robots[0].pose.y_m", name: y_m, values: [0.1, 0.2]}]
seeds: [1, 2]
keep: {values: [brightness], logs: LOGS}
"""
# A behaviour with a module beside it, a file among its arguments, and one that it opens by itself.
BOT = f"""#!{PYTHON}
import pathlib, sys
import gains, zipimporter_of_nobody_else
import seam_sdk
robot = seam_sdk.Robot()
robot.request_all_frames()
factor = gains.FACTOR * float(pathlib.Path(sys.argv[1]).read_text()) * float(pathlib.Path("data/more.txt").read_text())
for seen in robot.observations():
    for frame in seen.frames:
        robot.log_value("brightness", sum(frame.rgb[:300]))
    robot.head(pan_rad=factor * seen.time_s)
"""


class Bundle(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.root = pathlib.Path(cls.scratch.name)
        cls.home = cls.root / "study"
        (cls.home / "data").mkdir(parents=True)
        cls.elsewhere = cls.root / "elsewhere"
        cls.elsewhere.mkdir()
        for name, source in (("field", "field_2002"), ("robot", "robot_ers210"), ("model", "ers210")):
            shutil.copy(SOURCE / f"models/{source}.yaml", cls.home / f"{name}.yaml")
        outside = cls.root / "tables"
        outside.mkdir()
        (outside / "gain.txt").write_text("0.5\n")
        files = {"scenario.yaml": SCENARIO.replace("TABLE", str(outside / "gain.txt")), "gains.py": "FACTOR = 2\n",
                 "zipimporter_of_nobody_else.py": "", "plan.yaml": PLAN.replace("LOGS", "true"), "bot.py": BOT,
                 "data/more.txt": "1.5\n"}
        for name, text in files.items():
            (cls.home / name).write_text(text)
        (cls.home / "bot.py").chmod(0o755)
        cls.environment = {**os.environ, "HOME": str(cls.root), "XDG_STATE_HOME": str(cls.root / "state")}
        cls.seam("sweep", "plan.yaml", "--out", "results.sqlite", cwd=cls.home)
        cls.said = cls.seam("sweep", "bundle", "results.sqlite", "--out", cls.root / "study.seam", "--with", "data",
                            cwd=cls.home)
        cls.seam("run", "scenario.yaml", "--log", "run.mcap", cwd=cls.home)
        cls.seam("sweep", "bundle", "run.mcap", "--out", cls.root / "run.seam", "--with", "data", cwd=cls.home)
        cls.home.rename(cls.root / "gone")  # Nothing of a rerun comes from where the runs were made.
        outside.rename(cls.root / "gone-too")
        shutil.rmtree(cls.root / "state")

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    @classmethod
    def seam(cls, *arguments, code=0, cwd=None, run_by=()):
        done = subprocess.run([*run_by, SEAM, *map(str, arguments)], capture_output=True, text=True, timeout=LIMIT_S,
                              cwd=cwd or cls.elsewhere, env=cls.environment, stdin=subprocess.DEVNULL)
        if done.returncode != code:
            raise AssertionError((arguments, done.returncode, done.stdout, done.stderr))
        return done.stdout + done.stderr

    def rerun(self, bundle, *options, **more):
        return self.seam("sweep", "rerun", bundle, "--run-programs", *options, **more)

    def repacked(self, change):
        """The bundle with its files changed by change(files, manifest), and the manifest's checksums mended."""
        with tarfile.open(self.root / "study.seam") as archive:
            files = {entry.name: (archive.extractfile(entry).read(), entry.mode) for entry in archive}
        manifest = json.loads(files.pop("manifest.json")[0])
        change(files, manifest)
        for entry in manifest["files"]:
            data = files[entry["name"]][0]
            entry.update(bytes=len(data), sha256=hashlib.sha256(data).hexdigest())
        return self.packed({"manifest.json": (json.dumps(manifest).encode(), 0o644), **files})

    def packed(self, files, name="changed.seam"):
        raw = io.BytesIO()
        with tarfile.open(fileobj=raw, mode="w", format=tarfile.USTAR_FORMAT) as archive:
            for entry, (data, mode) in files.items():
                head = tarfile.TarInfo(entry)
                head.size, head.mode = len(data), mode
                archive.addfile(head, io.BytesIO(data))
        path = self.root / name
        path.write_bytes(gzip.compress(raw.getvalue()))
        return path

    # ---- What a reader does ----

    def test_the_runs_of_a_bundle_are_equal_in_another_folder_and_on_other_threads(self):
        for jobs in (1, 3):
            self.assertIn("equal: 4 of 4 runs made again, 0 of them differ", self.rerun(self.root / "study.seam", "--jobs", jobs))
        self.assertIn("equal: 2 of 2 runs made again", self.rerun(self.root / "study.seam", "--sample", "50%"))

    def test_the_run_of_a_log_is_equal(self):
        self.assertIn("equal: the run has the fingerprint", self.rerun(self.root / "run.seam"))
        self.assertIn("is of one run", self.rerun(self.root / "run.seam", "--sample", 1, code=2))

    def test_it_says_what_it_holds_and_what_else_is_needed(self):
        for text in ("work/bot.py", "work/gains.py", "work/data/more.txt", "work/outside/1/gain.txt"):
            self.assertIn(text, self.said)
        names = subprocess.run(["tar", "tzf", self.root / "study.seam"], capture_output=True, text=True, check=True).stdout.split()
        self.assertEqual(names[0], "manifest.json")
        for name in ("README.txt", "plan.yaml", "scenario.yaml", "results.sqlite", "logs/run_000003.mcap", "work/bot.py"):
            self.assertIn(name, names)

    def test_what_behaviours_need_beside_it_is_said(self):
        here = self.root / "needy"
        here.mkdir()
        environment = here / "venv"
        (environment / "bin").mkdir(parents=True)
        (environment / "pyvenv.cfg").write_text("home = /usr/bin\n")
        (environment / "bin/python3").symlink_to(PYTHON)
        (here / "bot.py").write_text(f"#!{environment}/bin/python3\nimport numpy, torch_of_mine\nimport os.path, json, math\n"
                                     "import seam_sdk\nfor seen in seam_sdk.Robot().observations(): pass\n")
        (here / "bot.py").chmod(0o755)
        shutil.copy(BUILD / "behaviours/head_swing", here / "compiled")
        (here / "weights").mkdir()
        text = SCENARIO.replace("[./bot.py, TABLE, --rate=3]", "[./bot.py, ./weights]").replace("duration_s: 0.4", "duration_s: 0.1")
        for name, source in (("field", "field_2002"), ("robot", "robot_ers210"), ("model", "ers210")):
            shutil.copy(SOURCE / f"models/{source}.yaml", here / f"{name}.yaml")
        (here / "scenario.yaml").write_text(text)
        (here / "bot.py").write_text((here / "bot.py").read_text().replace("import numpy, torch_of_mine", "try:\n    import numpy, torch_of_mine\nexcept ImportError: pass"))
        self.seam("run", "scenario.yaml", "--log", "run.mcap", cwd=here)
        said = self.seam("sweep", "bundle", "run.mcap", "--out", "run.seam", cwd=here)
        for expected in (f"r0: bot.py is run by {environment}/bin/python3, of a virtual environment, which must be there",
                         "r0: bot.py imports 'torch_of_mine', which is neither beside it nor among Debian's packages",
                         "r0: bot.py imports 'numpy', which must be installed", "names the folder './weights'"):
            self.assertIn(expected, said)
        for standard in ("'os'", "'json'", "'math'", "'seam_sdk'"):
            self.assertNotIn(standard, said)
        (here / "scenario.yaml").write_text(text.replace("./bot.py, ./weights", "./compiled, --no-frames"))
        self.seam("run", "scenario.yaml", "--log", "run.mcap", "--force", cwd=here)
        self.assertIn("r0: compiled is a compiled program", self.seam("sweep", "bundle", "run.mcap", "--out", "run.seam", cwd=here))

    def test_a_difference_names_run_value_and_step(self):
        def other_gain(files, manifest):
            files["work/gains.py"] = (b"FACTOR = 2.5\n", 0o644)
        said = self.rerun(self.repacked(other_gain), code=1)
        self.assertIn("4 of 4 runs made again, 4 of them differ", said)
        self.assertRegex(said, r"run 0: .*fingerprint was '\w+', is '\w+'")
        self.assertRegex(said, r"first.* differ.*0\.0\d+")

        def other_value(files, manifest):
            path = self.root / "results.sqlite"
            path.write_bytes(files["results.sqlite"][0])
            with sqlite3.connect(path) as results:
                results.execute("update runs set brightness = 7 where run = 2")
            results.close()
            files["results.sqlite"] = (path.read_bytes(), 0o644)
        said = self.rerun(self.repacked(other_value), code=1)
        self.assertRegex(said, r"run 2: brightness was '7', is '\d+'")
        self.assertIn("4 of 4 runs made again, 1 of them differ", said)

    @unittest.skipUnless(CPUS, "SEAM_EMULATED_CPUS names none")
    def test_the_runs_are_equal_on_other_cpus(self):
        for cpu in CPUS:
            # Of a log: workers of sweeps are forks, and the emulator's own thread is in their way.
            said = self.rerun(self.root / "run.seam", run_by=("qemu-x86_64", "-cpu", cpu))
            self.assertIn("equal: the run has the fingerprint", said, cpu)

    # ---- What somebody does who means harm ----

    def refused(self, path, *expected):
        before = sorted(str(p) for p in self.root.rglob("*"))
        said = self.rerun(path, code=1)
        for text in expected:
            self.assertIn(text, said)
        self.assertEqual(sorted(str(p) for p in self.root.rglob("*")), before)

    def test_nothing_is_started_without_a_word(self):
        def harm(files, manifest):
            files["work/bot.py"] = (f"#!/bin/sh\ntouch {self.root}/started\n".encode(), 0o755)
        said = self.seam("sweep", "rerun", self.repacked(harm), code=2)
        self.assertIn("--run-programs allows it", said)
        self.assertFalse((self.root / "started").exists())

        def other_word(files, manifest):
            manifest["words"]["./bot.py"] = "/bin/false"
        self.assertIn("r0: /bin/false", self.seam("sweep", "rerun", self.repacked(other_word), code=2))

    def test_names_lead_nowhere_else(self):
        for name in ("../out.txt", "/tmp/seam-bundle-out", "work/../../out.txt", "work/./x", "work//x", "x\x1b[2J", "", "work/"):
            def add(files, manifest, name=name):
                manifest["files"].append({"name": name, "bytes": 1, "sha256": "0" * 64, "program": False})
                files[name] = (b"x", 0o644)
            with self.subTest(name=name):
                self.refused(self.repacked(add), "manifest.json")
        self.assertFalse(pathlib.Path("/tmp/seam-bundle-out").exists())

    def test_archives_that_are_none_of_ours_are_refused(self):
        with gzip.open(self.root / "study.seam") as file:
            plain = file.read()
        whole = (self.root / "study.seam").read_bytes()
        bad = self.root / "bad.seam"

        def write(data, pack=True):
            bad.write_bytes(gzip.compress(data) if pack else data)
            return bad

        for cut in (10, 500, len(whole) // 2, len(whole) - 9, len(whole) - 1):
            self.refused(write(whole[:cut], False), "cut off" if cut > 10 else "")
        for cut in (700, 5000, len(plain) - 512, len(plain) - 1024, len(plain) - 1):
            self.refused(write(plain[:cut]), "expected")
        self.refused(write(whole + b"x", False), "something follows its end")
        self.refused(write(plain + plain[:512]), "something follows its end")
        self.refused(write(plain[:-1024] + bytes(512 * 30)), "something follows its end")
        self.refused(write(bytes(1 << 20)))
        self.refused(write(whole[:200] + bytes([whole[200] ^ 1]) + whole[201:], False))
        flipped = bytearray(plain)
        flipped[plain.index(b"FACTOR = 2")] ^= 1
        self.refused(write(bytes(flipped)), "work/gains.py: found the SHA-256", "damaged or changed")

    def entries(self, *more, drop=()):
        """The bundle with other entries of tar behind its own."""
        raw = io.BytesIO()
        with tarfile.open(self.root / "study.seam") as archive, tarfile.open(fileobj=raw, mode="w", format=tarfile.USTAR_FORMAT) as out:
            for entry in archive:
                if entry.name not in drop:
                    out.addfile(entry, archive.extractfile(entry))
            for entry, data in more:
                out.addfile(entry, io.BytesIO(data))
        path = self.root / "bad.seam"
        path.write_bytes(gzip.compress(raw.getvalue()))
        return path

    def test_links_devices_duplicates_and_what_the_manifest_lacks_are_refused(self):
        for kind in (tarfile.SYMTYPE, tarfile.LNKTYPE, tarfile.CHRTYPE, tarfile.BLKTYPE, tarfile.FIFOTYPE, tarfile.DIRTYPE):
            head = tarfile.TarInfo("work/link")
            head.type, head.linkname = kind, "/etc/passwd"
            self.refused(self.entries((head, b"")), "")
        head = tarfile.TarInfo("work/bot.py")
        head.size = 1
        self.refused(self.entries((head, b"x")), "which its manifest does not have")
        self.refused(self.entries(drop=("work/gains.py",)), "expected work/gains.py")
        self.refused(self.entries(drop=("manifest.json",)), "it does not begin with manifest.json")

        def twice(files, manifest):
            manifest["files"].append(manifest["files"][0])
        self.refused(self.repacked(twice), "twice, expected each file once")

        def file_and_folder(files, manifest):
            manifest["files"].append({"name": "work/bot.py/x", "bytes": 1, "sha256": "", "program": False})
            files["work/bot.py/x"] = (b"x", 0o644)
        self.refused(self.repacked(file_and_folder), "as a file and as a folder")

    def test_sizes_are_bounded_in_sum(self):
        manifest = {"format": "seam-bundle/1", "seam": {"version": "1", "program": "1"}, "of": "a", "needs": [], "folders": {}, "words": {},
                    "files": [{"name": name, "bytes": 5 << 30, "sha256": "", "program": False} for name in "ab"]}
        self.refused(self.packed({"manifest.json": (json.dumps(manifest).encode(), 0o644)}), "in sum, expected less")
        manifest["files"][1:] = []
        manifest["files"][0]["bytes"] = -1
        self.refused(self.packed({"manifest.json": (json.dumps(manifest).encode(), 0o644)}), "manifest.json")
        manifest["folders"] = {"/x": "../../x"}
        manifest["files"][0]["bytes"] = 0
        self.refused(self.packed({"manifest.json": (json.dumps(manifest).encode(), 0o644)}), "leads out of the folder")
        self.refused(self.packed({"manifest.json": (b"[" * 100_000, 0o644)}), "manifest.json")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]])
