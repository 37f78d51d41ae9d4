#!/usr/bin/env python3
"""docs/debug.md with its debuggers and the viewer: a program that is started by hand stops in pdb and in gdb at the decision
that the page names, launch.json fits, and marks stand on the frame that they were made from.

Usage: debugging_test.py BUILD_DIR SOURCE_DIR PYTHON [unittest arguments]; PYTHON is the interpreter that has gRPC.
"""
import ast
import json
import os
import pathlib
import pty
import re
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

from viewing import viewer

import by_hand

BUILD, SOURCE, PYTHON = by_hand.arguments("build", "source", "python")
SEAM = BUILD / "seam"
PAGE = (SOURCE / "docs/debug.md").read_text(encoding="utf-8")
WHEN = re.search(r"(?m)^seam replay find run\.mcap --when '(.*?)'", PAGE)[1]
LIMIT_S = 60
SKIPPED = 77


class Debugging(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        root = pathlib.Path(cls.scratch.name)
        cls.here = root / "docs" / "debug"
        shutil.copytree(SOURCE / "docs/debug", cls.here)
        (root / "models").symlink_to(SOURCE / "models")
        program = cls.here / "watch.py"
        program.write_text(program.read_text().replace("#!/usr/bin/python3", f"#!{PYTHON}", 1))
        cls.seam("run", "lost_ball.yaml", "--log", "run.mcap")

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    @classmethod
    def seam(cls, *arguments, code=0):
        done = subprocess.run([SEAM, *arguments], cwd=cls.here, capture_output=True, text=True, timeout=LIMIT_S)
        if done.returncode != code:
            raise AssertionError(f"{arguments}: {done.returncode}\n{done.stdout}{done.stderr}")
        return done

    def by_hand(self, program, commands, feed=("feed", "run.mcap")):
        """What the debugger says to these commands, and how the command that waits for the program ended."""
        file = self.here / "seam.env"
        file.unlink(missing_ok=True)
        waiting = subprocess.Popen([SEAM, "replay", *feed, "--robot", "red1", "--by-hand", file.name], cwd=self.here,
                                   stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        for cleanup in (waiting.stdout.close, waiting.wait, waiting.kill):  # The last one first.
            self.addCleanup(cleanup)
        stop = time.monotonic() + LIMIT_S
        while not file.exists():
            self.assertLess(time.monotonic(), stop, "no environment was written")
            self.assertIsNone(waiting.poll())
            time.sleep(0.02)
        self.assertEqual(file.stat().st_mode & 0o777, 0o600)
        done = subprocess.run(["sh", "-c", 'set -a; . ./seam.env; set +a; exec "$@"', "sh", *program], cwd=self.here,
                              input="\n".join(commands) + "\n", capture_output=True, text=True, timeout=LIMIT_S)
        return done.stdout + done.stderr, waiting

    def test_pdb_stops_at_the_decision(self):
        session = re.search(r"(?s)python3 -m pdb watch\.py\n(.*?)```", PAGE)[1].splitlines()
        commands = [line.removeprefix("(Pdb) ") for line in session if line.startswith("(Pdb)")]
        self.assertEqual(len(commands), 3)
        said, waiting = self.by_hand([PYTHON, "-m", "pdb", "watch.py"], [*commands, "clear 1", "continue", "quit"])
        for line in (session[3], session[-1]):
            self.assertIn(line, said)
        values = ast.literal_eval(session[-1])
        self.assertEqual(values[:3], (0.384, 0, 0))
        # The program went on to the end, and decided what it had decided in the run.
        output = waiting.communicate(timeout=LIMIT_S)[0]
        self.assertEqual(waiting.returncode, 0, output)
        self.assertIn("red1 waits for your program", output)
        self.assertIn("all as in the log", output)

    def test_a_program_that_is_started_again_goes_on(self):
        said, waiting = self.by_hand([PYTHON, "-m", "pdb", "watch.py"], ["break watch.py:38, seen.time_s > 1", "continue", "quit"],
                                     ("whatif", "run.mcap", "--from", "0.5"))
        self.assertIn("watch.py(38)main()", said)
        self.assertIsNone(waiting.poll())
        environment = dict(os.environ, **dict(line.split("=", 1) for line in (self.here / "seam.env").read_text().splitlines()))
        subprocess.run([PYTHON, "watch.py"], cwd=self.here, env=environment, check=True, timeout=LIMIT_S)
        output = waiting.communicate(timeout=LIMIT_S)[0]
        self.assertIn("red1 is driven by your program from 0.5 s on", output)
        self.assertIn("red1 first decides otherwise at 1.", output)

    @unittest.skipUnless(shutil.which("gdb"), "no gdb")
    def test_gdb_stops_while_time_stands_still(self):
        source = (SOURCE / "tests/mistaken_behaviour.cc").read_text().splitlines()
        line = next(n for n, text in enumerate(source, 1) if "robot.head(" in text)
        condition = re.search(r"\(gdb\) break my_behaviour\.cc:\d+ (if .*)", PAGE)[1]
        commands = ["set pagination off", f"break mistaken_behaviour.cc:{line} {condition}", "run", "print seen.time_ns", "kill"]
        said, waiting = self.by_hand(["gdb", "-q", "--args", BUILD / "tests" / "mistaken_behaviour"], [*commands, "quit"])
        if "Operation not permitted" in said:
            self.skipTest("gdb may not trace here")
        self.assertRegex(said, r"\$1 = 384000000")
        self.assertIsNone(waiting.poll(), "the log waits")

    def test_a_program_that_is_started_has_no_terminal(self):
        ours, theirs = pty.openpty()
        try:
            done = subprocess.run([SEAM, "replay", "feed", "run.mcap", "--robot", "red1", "--client", f"{PYTHON} -m pdb watch.py"],
                                  cwd=self.here, stdin=theirs, capture_output=True, text=True, timeout=LIMIT_S)
        finally:
            os.close(ours)
            os.close(theirs)
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        self.assertIn("its behaviour ended with exit code", done.stderr)

    def test_launch_json_names_what_is_there(self):
        launch = json.loads(re.search(r"(?s)```json\n(.*?)```", PAGE)[1])
        for one in launch["configurations"]:
            self.assertEqual(one["envFile"], "${workspaceFolder}/seam.env")
        self.assertIn(launch["configurations"][0]["program"].removeprefix("${workspaceFolder}/"), os.listdir(self.here))
        self.seam("replay", "feed", "run.mcap", "--robot", "red1", "--client", "./watch.py", "--by-hand", "x.env", code=2)
        self.seam("replay", "whatif", "run.mcap", "--robot", "red1", code=2)

    def test_the_page_says_what_the_program_says(self):
        found = self.seam("replay", "find", "run.mcap", "--when", WHEN).stdout
        self.assertIn(f"```\n{found}```", PAGE)
        line = next(n for n, text in enumerate((self.here / "watch.py").read_text().splitlines(), 1) if " side = math" in text)
        self.assertIn(f"break watch.py:{line},", PAGE)
        mended = (self.here / "mended.py")
        subprocess.run(re.search(r"(?m)^sed .*$", PAGE)[0], shell=True, cwd=self.here, check=True)
        diff = subprocess.run(["diff", "-U0", "watch.py", "mended.py"], cwd=self.here, capture_output=True, text=True).stdout
        self.assertIn("```diff\n" + diff.split("@@\n")[1] + "```", PAGE)
        mended.chmod(0o755)
        fed = self.seam("replay", "feed", "run.mcap", "--robot", "red1", "--client", "./mended.py", code=1).stdout.splitlines()
        self.assertIn("\n".join(["```", *fed[1:4], "```"]), PAGE)

    def test_the_viewer_finds_the_moment_and_its_marks_stand_on_their_frames(self):
        with viewer(SEAM, self.here / "run.mcap") as ask:
            items = ask("debug", robot="red1", **{"from": 0, "to": 3})["items"]
            texts = {item["t"]: item["text"] for item in items if item["name"] == "colour"}
            marks = [{"t": item["t"], "robot": "red1", "frame": item["frame"], "u": item["points"][0][0],
                      "v": item["points"][0][1]} for item in items if item["name"] == "ball"]
            self.assertGreater(len(marks), 3)
            done = subprocess.run(["node", SOURCE / "web/tests/marks.mjs", ask.address],
                                  input=json.dumps({"when": WHEN, "marks": marks}), capture_output=True, text=True, timeout=240)
        if done.returncode == SKIPPED:
            self.skipTest(done.stdout.strip())
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        seen = [[int(part) for part in texts[mark["t"]].split()] for mark in marks]
        found = json.loads(done.stdout)
        self.assertEqual(found["colours"], seen)
        # The frame without a ball is newer than all that have one.
        self.assertEqual(found["moment"], "0:00.384")
        self.assertGreater(found["frame"], max(mark["frame"] for mark in marks))
        # Another frame would have another colour there: the ball runs through the image.
        self.assertGreater(abs(marks[1]["u"] - marks[0]["u"]), 8)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]])
