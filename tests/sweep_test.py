#!/usr/bin/env python3
"""Sweeps as a user runs them: sweep_test.py BUILD_DIR SOURCE_DIR [unittest arguments]

Interrupted, killed, in shards and on a cluster's engine they give the bytes of one that was let be.
SEAM_KILLS=20 kills as often.
"""
import csv
import io
import json
import os
import pathlib
import random
import re
import resource
import shutil
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time
import unittest

import by_hand
import one_robot

BUILD, SOURCE = by_hand.arguments("build", "source")
SEAM = BUILD / "seam"
LIMIT_S = 300
KILLS = int(os.environ.get("SEAM_KILLS", "3"))

SWING = one_robot.scenario(SOURCE, "swing", 0.2, camera="", options=", --no-frames")
PLAN = """format: seam-sweep/1
scenario: swing.yaml
vary:
  - {path: "robots[0].pose.y_m", name: y_m, range: [-0.5, 0.5], step: 0.25}
  - {path: "robots[0].pose.x_m", name: x_m, draws: 3, uniform: [-1, 1]}
seeds: [1, 2]
"""
RUNS = 30
# Runs each task of an array here and now, and says which job it was.
SBATCH = """#!/bin/bash
script="${@: -1}"
echo "$@" >> "$(dirname "$0")/submitted"
last=$(sed -n 's/^#SBATCH --array=1-//p' "$script")
for task in $(seq 1 "${last:-1}"); do SLURM_ARRAY_TASK_ID=$task bash "$script" >&2 || exit 1; done
echo "17;cluster"
"""


def behaviours_below(folder):
    """Processes that play in runs whose private socket is below this folder."""
    found = []
    for entry in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            environment = (entry / "environ").read_bytes()
        except OSError:
            continue
        if f"SEAM_ADDRESS=unix:{folder}".encode() in environment:
            found.append(int(entry.name))
    return found


class Sweep(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.here = pathlib.Path(folder.name)
        self.scratch = self.here / "tmp"
        self.scratch.mkdir()
        (self.here / "swing.yaml").write_text(SWING)
        (self.here / "plan.yaml").write_text(PLAN)

    def environment(self, **more):
        return {**os.environ, "TMPDIR": str(self.scratch), **more}

    def seam(self, *arguments, code=0, **more):
        done = subprocess.run([SEAM, *map(str, arguments)], capture_output=True, text=True, timeout=LIMIT_S, cwd=self.here,
                              **{"env": self.environment(), **more})
        self.assertEqual(done.returncode, code, (arguments, done.stdout, done.stderr))
        return done.stdout + done.stderr

    def sweep(self, out, *arguments, plan="plan.yaml", **more):
        return self.seam("sweep", plan, "--out", out, "--jobs", 2, *arguments, **more)

    def table(self, results):
        return subprocess.run([SEAM, "sweep", "table", results], capture_output=True, timeout=LIMIT_S, cwd=self.here,
                              check=True).stdout

    def rows(self, results):
        return list(csv.DictReader(io.StringIO(self.table(results).decode())))

    def finished(self, results):
        """How many runs are finished while the sweep runs; 0 where the file is not there yet."""
        done = subprocess.run([SEAM, "sweep", "status", results], capture_output=True, text=True, cwd=self.here, timeout=LIMIT_S)
        found = re.search(r": (\d+) of \d+ runs are finished", done.stdout)
        return int(found[1]) if found else 0

    @unittest.skipUnless((BUILD / "behaviours" / "head_swing.py").exists(), "no Python SDK")
    def test_behaviours_are_started_once_and_used_again(self):
        """Each run has a client of its own all the same, whose run is that of a program started for it; one that fails
        is its own run's fault."""
        program = self.here / "behaviour.py"
        program.write_text(f"""#!/usr/bin/python3
import pathlib, sys
sys.path.insert(0, {str(BUILD / "python")!r})
import seam_sdk
here, count = pathlib.Path({str(self.here)!r}), 0
(here / "started").open("a").write("x")
robot = seam_sdk.Robot()
with (here / "played").open("a") as played:
    played.write("x")
if (here / "played").stat().st_size == 3:
    sys.exit(7)
for seen in robot.observations():
    count += 1
    robot.head(pan_rad=0.1 * count)
    robot.log_value("count", count)
""")
        program.chmod(0o755)
        (self.here / "swing.yaml").write_text(re.sub(r"command: .*\]", f"command: [{program}]", SWING))
        (self.here / "plan.yaml").write_text("format: seam-sweep/1\nscenario: swing.yaml\nseeds: [1, 6]\nkeep: {values: [count]}\n")
        self.seam("sweep", "plan.yaml", "--out", "once.sqlite", "--jobs", 1, code=1)
        self.assertEqual((self.here / "started").read_text(), "x")
        rows = self.rows("once.sqlite")
        self.assertEqual([bool(row["error"]) for row in rows], [False, False, True, False, False, False])
        self.assertIn("exit code 7", rows[2]["error"])
        self.seam("sweep", "plan.yaml", "--out", "once.sqlite", "--jobs", 1)  # Mends the one that failed.
        for row in self.rows("once.sqlite"):
            self.assertEqual(row["count"], "7")
            self.seam("run", "swing.yaml", "--set", f"seed={row['seed']}", "--json", "run.json")
            self.assertEqual(row["fingerprint"], json.loads((self.here / "run.json").read_text())["fingerprint"])
        for _ in range(100):  # Who stood by ends with the worker.
            if not (left := behaviours_below(self.scratch)):
                break
            time.sleep(0.05)
        self.assertEqual(left, [])

    def test_the_time_left_counts_the_start_of_a_run(self):
        """Boards of many squares: the world takes longer to make than the run does."""
        boards = "".join(f"  - {{shape: board, pattern: chessboard, columns: 100, rows: 100, pitch_m: 0.01, pose: {{x_m: {i}}}}}\n"
                         for i in range(40))
        (self.here / "swing.yaml").write_text(SWING.replace("duration_s: 0.2", "duration_s: 0.05") + "objects:\n" + boards)
        (self.here / "plan.yaml").write_text("format: seam-sweep/1\nscenario: swing.yaml\nseeds: [1, 3]\n")
        took_s = []
        for _ in range(2):  # The second time no run is left.
            began = time.monotonic()
            self.seam("sweep", "plan.yaml", "--out", "boards.sqlite", "--jobs", 1)
            took_s.append(time.monotonic() - began)
        self.seam("sweep", "status", "boards.sqlite", "--json", "status.json")
        wall_s = json.loads((self.here / "status.json").read_text())["wall_s"]
        self.assertGreater(wall_s, 0.5 * (took_s[0] - took_s[1]))

    def start(self, out):
        process = subprocess.Popen([SEAM, "sweep", "plan.yaml", "--out", out, "--jobs", "2"], cwd=self.here,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=self.environment())
        self.addCleanup(lambda: (process.poll() is None and process.kill(), process.wait(), process.stdout.close(),
                                 process.stderr.close()))
        return process

    def wait_until_none_plays(self):
        end = time.monotonic() + 20
        while behaviours_below(self.scratch):
            self.assertLess(time.monotonic(), end, "behaviours outlive the sweep")
            time.sleep(0.05)

    def test_killed_and_in_shards_it_is_the_same_table(self):
        self.sweep("whole.sqlite")
        whole = self.table("whole.sqlite")
        rows = self.rows("whole.sqlite")
        self.assertEqual([row["run"] for row in rows], [str(run) for run in range(RUNS)])
        self.assertEqual({row["end"] for row in rows}, {"finished"})
        self.assertEqual([row["seed"] for row in rows], ["1", "2"] * (RUNS // 2))
        # Nothing in this scenario is drawn: each pose has one history, whatever the seed.
        self.assertEqual(len({row["fingerprint"] for row in rows}), RUNS // 2)
        self.assertEqual([row["y_m"] for row in rows[::6]], ["-0.5", "-0.25", "0", "0.25", "0.5"])

        dice = random.Random(1)
        for _ in range(KILLS):
            process = self.start("killed.sqlite")
            time.sleep(dice.uniform(0.05, 1.5))
            process.send_signal(signal.SIGKILL)
            process.wait()
            self.wait_until_none_plays()
        self.sweep("killed.sqlite")
        self.assertEqual(self.table("killed.sqlite"), whole)
        # All is there: nothing is made again.
        self.assertIn("0 of them now", self.sweep("killed.sqlite"))

        for part in (3, 1, 2):
            self.sweep(f"{part}.sqlite", "--shard", f"{part}/3")
        message = self.seam("sweep", "merge", "1.sqlite", "3.sqlite", "--out", "merged.sqlite", code=1)
        self.assertIn("lack runs of the plan: 1, 4, 7", message)
        self.assertFalse((self.here / "merged.sqlite").exists())
        self.seam("sweep", "merge", "2.sqlite", "3.sqlite", "1.sqlite", "3.sqlite", "--out", "merged.sqlite")
        self.assertEqual(self.table("merged.sqlite"), whole)
        self.assertIn("is there already", self.seam("sweep", "merge", "1.sqlite", "--out", "merged.sqlite", code=1))

        # A shard done twice, with other bits.
        shutil.copy(self.here / "1.sqlite", self.here / "other.sqlite")
        with sqlite3.connect(self.here / "other.sqlite") as other:
            other.execute("UPDATE runs SET fingerprint = 'beef' WHERE run = 6")
        message = self.seam("sweep", "merge", "1.sqlite", "2.sqlite", "3.sqlite", "other.sqlite", "--out", "m2.sqlite", code=1)
        self.assertIn("run 6 differs", message)
        self.assertEqual(list(self.here.glob("m2*")), [])
        # Made again, the wrong one is named.
        self.assertIn("equal: 10 of 10 runs made again, 0 of them differ", self.seam("sweep", "rerun", "1.sqlite"))
        self.assertIn("no package of Debian 12 writes Parquet",
                      self.seam("sweep", "table", "1.sqlite", "--format", "parquet", code=2))
        self.assertIn("run 6: fingerprint was 'beef'", self.seam("sweep", "rerun", "other.sqlite", "--run", 6, code=1))
        self.assertIn("3 of 3 runs", self.seam("sweep", "rerun", "whole.sqlite", "--sample", "8%"))

    def test_ctrl_c_keeps_what_is_finished(self):
        process = self.start("r.sqlite")
        end = time.monotonic() + 60
        while self.finished("r.sqlite") == 0:
            self.assertLess(time.monotonic(), end)
            time.sleep(0.05)
        # Meanwhile nobody else writes it; stopped, so that it does not end meanwhile.
        process.send_signal(signal.SIGSTOP)
        self.assertIn("another process writes this file", self.sweep("r.sqlite", code=1))
        process.send_signal(signal.SIGINT)
        process.send_signal(signal.SIGCONT)
        out, err = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 1, out + err)
        self.assertIn("the same command goes on", out)
        self.wait_until_none_plays()
        finished = len(self.rows("r.sqlite"))
        self.assertTrue(0 < finished < RUNS, finished)
        self.assertIn(f"{RUNS - finished} of them now", self.sweep("r.sqlite"))

    def test_the_summary_of_a_run_says_what_it_was(self):
        plan = f"format: seam-sweep/1\nscenario: {SOURCE}/scenarios/ball_distance.yaml\n" + """
set: {duration_s: 0.4}
vary:
  - {path: "robots[0].pose.x_m", name: x_m, values: [-0.6, -1]}
  - {path: "robots[0].camera.model.effects.rolling_shutter.line_delay_s", values: [0, 2.78e-4]}
keep:
  values: [distance_m, {name: distance_m, statistic: count, as: n}]
  expressions: {error_m: distance_m + x_m}
"""
        (self.here / "plan.yaml").write_text(plan)
        self.sweep("r.sqlite")
        row = self.rows("r.sqlite")[3]
        self.seam("run", SOURCE / "scenarios/ball_distance.yaml", "--set", "duration_s=0.4", "--set", "robots[0].pose.x_m=-1",
                  "--set", "robots[red1].camera.model.effects.rolling_shutter.line_delay_s=2.78e-4", "--json", "run.json")
        run = json.loads((self.here / "run.json").read_text())
        self.assertEqual(run["format"], "seam-run/1")
        self.assertEqual(run["fingerprint"], row["fingerprint"])
        self.assertEqual(run["frames"], int(row["frames"]))
        self.assertEqual(run["values"]["red1"]["distance_m"], float(row["distance_m"]))
        self.assertAlmostEqual(float(row["error_m"]), float(row["distance_m"]) - 1, places=15)
        self.assertGreater(int(float(row["n"])), 3)
        self.assertEqual(run["changes"][1], {"path": "robots[0].pose.x_m", "value": "-1"})
        self.assertEqual((run["scenario"]["name"], run["seed"], run["end"]), ("ball_distance", 1, "finished"))
        self.assertEqual(run["models"][0]["name"], "ers210")
        self.assertIn("seam", run["versions"])
        self.seam("sweep", "status", "r.sqlite", "--json", "status.json")
        self.check_schema("run.json", "status.json")

        # Drawn, with an interval a point.
        self.seam("sweep", "plot", "r.sqlite", "--value", "error_m", "--over", "x_m", "--csv", "curve.csv", "--out", "c.png")
        with open(self.here / "curve.csv", newline="") as file:
            points = list(csv.DictReader(file))
        errors = [float(r["error_m"]) for r in self.rows("r.sqlite")]
        self.assertAlmostEqual(float(points[1]["mean"]), (errors[2] + errors[3]) / 2, places=12)
        half = 12.706204736 * abs(errors[2] - errors[3]) / 2  # Student's t of one degree of freedom.
        self.assertAlmostEqual(float(points[1]["high"]) - float(points[1]["mean"]), half, places=9)
        self.assertEqual((self.here / "c.png").read_bytes()[:4], b"\x89PNG")
        for name, start in (("c.svg", b"<?xml"), ("c.pdf", b"%PDF")):
            self.seam("sweep", "plot", "r.sqlite", "--value", "error_m", "--over", "x_m", "--out", name)
            self.assertEqual((self.here / name).read_bytes()[:len(start)], start)
        self.assertRegex((self.here / "c.svg").read_text(), r"rgb\( *0, *114, *178\)")  # The reports' blue.
        self.assertIn("mean of error (m)", (self.here / "c.svg").read_text())
        self.assertIn("fill-opacity", (self.here / "c.svg").read_text())  # The interval is a band.
        self.seam("sweep", "plot", "r.sqlite", "--value", "error_m", "--over", "x_m", "--out", "c.jpg", code=2)

    def check_schema(self, *files):
        try:
            import jsonschema
        except ImportError:
            return
        schema = json.loads((SOURCE / "docs/reference/schemas/results.schema.json").read_text())
        for file in files:
            result = json.loads((self.here / file).read_text())
            jsonschema.validate(result, schema)
            for key in result:
                if key != "format":
                    break
            spoilt = {name: value for name, value in result.items() if name != key}
            with self.assertRaises(jsonschema.ValidationError, msg=f"{file} without {key}"):
                jsonschema.validate(spoilt, schema)

    def test_bad_input_is_told(self):
        self.assertIn("did you mean 'seeds'", self.refused("seads: [1, 2]"))
        self.assertIn("has 1000000000 runs, expected at most", self.refused("seeds: [1, 1000000000]"))
        self.assertIn("did you mean 'line_delay_s'", self.refused(
            'set: {"robots[0].camera.model.effects.rolling_shutter.line_delay": 0}'))
        self.assertIn("no behaviour 'nobody'", self.refused('set: {"robots[0].behaviour.command": [nobody]}'))
        self.seam("sweep", "plan.yaml", code=2)
        self.seam("sweep", "plan.yaml", "--out", "plan.yaml", code=2)
        self.seam("sweep", "plan.yaml", "--out", "r.sqlite", "--shard", "4/3", code=2)
        self.assertIn("is no SQLite file", self.seam("sweep", "status", "plan.yaml", code=1))
        self.sweep("part.sqlite", "--shard", "1/30")
        self.assertIn("holds shard 1/30", self.sweep("part.sqlite", code=1))
        (self.here / "plan.yaml").write_text(PLAN.replace("[1, 2]", "[1, 3]"))
        self.assertIn("another plan", self.sweep("part.sqlite", "--shard", "1/30", code=1))

    def refused(self, line):
        (self.here / "bad.yaml").write_text(f"format: seam-sweep/1\nscenario: swing.yaml\n{line}\n")
        message = self.sweep("bad.sqlite", plan="bad.yaml", code=1)
        self.assertFalse((self.here / "bad.sqlite").exists(), line)
        return message

    def test_a_run_that_fails_is_told_and_tried_again(self):
        behaviour = self.here / "behaviour.sh"
        behaviour.write_text("#!/bin/sh\n[ -e fail ] && exit 3\nexec \"$@\"\n")
        behaviour.chmod(0o755)
        command = f"[{behaviour}, {BUILD}/behaviours/head_swing, --no-frames]"
        (self.here / "plan.yaml").write_text(
            f'format: seam-sweep/1\nscenario: swing.yaml\nset: {{"robots[0].behaviour.command": {command}}}\nseeds: [1, 3]\n')
        (self.here / "fail").write_text("")
        self.assertIn("3 failed", self.sweep("r.sqlite", code=1))
        self.assertIn("ended with exit code 3", self.seam("sweep", "status", "r.sqlite"))
        self.assertIn("ended with exit code 3", self.rows("r.sqlite")[0]["error"])
        (self.here / "fail").unlink()
        self.assertIn("3 of 3 runs are finished, 3 of them now; 0 failed", self.sweep("r.sqlite"))
        self.assertEqual({row["error"] for row in self.rows("r.sqlite")}, {""})

    def test_a_full_disk_is_an_error_and_the_rest_goes_on(self):
        (self.here / "plan.yaml").write_text(PLAN.replace("seeds: [1, 2]", "seeds: [1, 40]"))
        self.sweep("r.sqlite", "--shard", "1/300")  # The file, and two runs.
        limit = (self.here / "r.sqlite").stat().st_size + 12000

        def small_files():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

        message = self.sweep("r.sqlite", "--shard", "1/300", preexec_fn=small_files)
        self.assertIn("0 of them now", message)
        message = self.sweep("full.sqlite", code=1, preexec_fn=small_files)
        self.assertIn("is the disk full?", message)
        self.wait_until_none_plays()
        done = len(self.rows("full.sqlite"))
        self.assertGreater(done, 0)
        (self.here / "plan.yaml").write_text(PLAN.replace("seeds: [1, 2]", "seeds: [1, 40]"))
        status = self.seam("sweep", "status", "full.sqlite")
        self.assertIn(f"{done} of 600 runs are finished, 0 failed", status)

    def test_a_cluster_makes_the_same_table(self):
        self.sweep("whole.sqlite")
        programs = self.here / "bin"
        programs.mkdir()
        (programs / "sbatch").write_text(SBATCH)
        (programs / "sbatch").chmod(0o755)
        message = self.seam("sweep", "submit", "plan.yaml", "--slurm", "--shards", 4, "--minutes", 30, "--out", "it's.sqlite",
                            env=self.environment(PATH=f"{programs}:{os.environ['PATH']}"))
        self.assertIn("submitted: job array 17 of 4 tasks, then job 17", message)
        self.assertIn("--dependency=afterok:17", (programs / "submitted").read_text())
        self.assertIn("#SBATCH --time=30", (self.here / "it's.sqlite.shards/shards.sbatch").read_text())
        self.assertEqual(self.table("it's.sqlite"), self.table("whole.sqlite"))

        message = self.seam("sweep", "submit", "plan.yaml", "--slurm", "--only-write", "--shards", 2, "--out", "b.sqlite")
        self.assertIn("not submitted", message)
        self.assertIn("the plan has 30 runs", self.seam("sweep", "submit", "plan.yaml", "--slurm", "--shards", 31, "--out",
                                                        "c.sqlite", code=1))
        self.seam("sweep", "submit", "plan.yaml", "--shards", 2, "--out", "b.sqlite", code=2)

    def test_snakemake_makes_the_same_table(self):
        message = self.seam("sweep", "submit", "plan.yaml", "--snakemake", "--shards", 3, "--out", "a b.sqlite")
        snakefile = self.here / "a b.sqlite.shards" / "Snakefile"
        self.assertIn(str(snakefile), message)
        snakemake = shutil.which("snakemake")
        if snakemake is None:
            self.skipTest("no snakemake here")
        self.sweep("whole.sqlite")
        done = subprocess.run([snakemake, "--snakefile", snakefile, "--cores", "2"], cwd=self.here, capture_output=True,
                              text=True, timeout=LIMIT_S)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(self.table("a b.sqlite"), self.table("whole.sqlite"))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=2)
