#!/usr/bin/env python3
"""Mistakes that people make in behaviours, and how each of them is reported: by `seam run`, by `seam sweep`, and by `seam
check` where the program itself cannot be started.

Usage: behaviour_mistakes_test.py BUILD_DIR SOURCE_DIR PYTHON [unittest arguments]; PYTHON is the interpreter that has gRPC.
"""
import pathlib
import re
import subprocess
import sys
import tempfile
import time
import unittest

import by_hand

BUILD, SOURCE, PYTHON = by_hand.arguments("build", "source", "python")
SEAM = BUILD / "seam"
LIMIT_S = 60

PROLOGUE = f"""#!{PYTHON}
import math, os, signal, sys, time
sys.path.insert(0, {str(BUILD / "python")!r})
import seam_sdk
robot = seam_sdk.Robot()
"""


def cpp(mistake):
    """The C++ behaviour that makes this mistake at its third turn."""
    return [str(BUILD / "tests" / "mistaken_behaviour"), mistake]


def each(order):
    """A Python behaviour that gives the same order at each of its turns."""
    return PROLOGUE + f"for seen in robot.observations():\n    {order}\n"


def third(act):
    """One that does this at its third turn."""
    return PROLOGUE + f"for seen in robot.observations():\n    robot.head()\n    if seen.sequence == 3:\n        {act}\n"


REFUSED = r"(?m)^r0: (\d+) of \1 decisions were refused and did nothing; the first at 0\.000 s: "
ONE_REFUSED = r"(?m)^r0: 1 of \d+ decisions were refused and did nothing; the first at 0\.\d+ s: "
TOO_LONG = r"decision: found 300\d+ bytes, expected at most 262144 with all that is logged and sent"
ENDED = "the run was aborted: r0: abort at 0.[0-9]+ s: its behaviour "
SLOW = r"the run was aborted: r0: abort at 0\.[0-9]+ s: no answer within 0\.5 s of wall time"

# Name: the program, the exit code of a run, and what it gets. A list is a command in place of a program.
WHILE_IT_RUNS = {
    "exception": (third("raise KeyError('pan')"), 1, [r"(?m)^0\.\d+ s r0: KeyError: 'pan'$", ENDED + "ended with exit code 1"]),
    "exception before the first turn": (PROLOGUE + "import no_such_module\n", 1,
                                        [r"r0: ModuleNotFoundError: No module named 'no_such_module'", ENDED]),
    "syntax": (PROLOGUE + "for seen in robot.observations()\n", 1, [r"r0: SyntaxError: expected ':'", ENDED]),
    "endless loop": (third("while True: pass"), 1, [SLOW]),
    "sleeping": (third("time.sleep(60)"), 1, [SLOW]),
    "early end": (third("break"), 1, [ENDED + "ended with exit code 0"]),
    "exit code": (third("sys.exit(7)"), 1, [ENDED + "ended with exit code 7"]),
    "signal": (third("os.kill(os.getpid(), signal.SIGSEGV)"), 1, [ENDED + "was ended by signal 11"]),
    "no client at all": ("#!/bin/sh\nexit 3\n", 1, [ENDED + "ended with exit code 3"]),
    "joint's name": (each("robot.joints([seam_sdk.JointTarget('pann', 0.1)])"), 1,
                     [r"r0: ValueError: no joint 'pann', expected one of: tilt pan roll"]),
    "exception in C++": (cpp("exception"), 1, [r"(?m)^0\.\d+ s r0: r0: map::at$", ENDED + "ended with exit code 1"]),
    "no exception in C++": (cpp("throw"), 1, [r"terminate called after throwing an instance of 'int'", ENDED + "was ended by signal 6"]),
    "endless loop in C++": (cpp("loop"), 1, [SLOW]),
    "sleeping in C++": (cpp("sleep"), 1, [SLOW]),
    "early end in C++": (cpp("exit"), 1, [ENDED + "ended with exit code 0"]),
    "exit code in C++": (cpp("code"), 1, [ENDED + "ended with exit code 7"]),
    "abort in C++": (cpp("abort"), 1, [ENDED + "was ended by signal 6"]),
    "signal in C++": (cpp("signal"), 1, [ENDED + "was ended by signal 11"]),
    "joint's name in C++": (cpp("joint"), 1, [r"(?m)^0\.\d+ s r0: r0: no joint 'pann', expected one of: tilt pan roll", ENDED]),
    "joint's number in C++": (cpp("number"), 0, [ONE_REFUSED + r"joints\[0\]\.targets\[0\]\.joint: found 20, expected a number below 15"]),
    "no number in C++": (cpp("nan"), 0, [ONE_REFUSED + r"head\.pan_rad: found nan, expected a number"]),
    "flood of output in C++": (cpp("flood"), 0, [r"\(\d+ lines left out: more than 16384 bytes a simulated second\)"]),
    "long decision in C++": (cpp("long"), 0, [ONE_REFUSED + TOO_LONG, "r0: r0: the decision at 0.0[0-9]+ s was refused: " + TOO_LONG]),
    "long decision": (each("robot.log_text('all', 'x' * 300000)"), 0, [REFUSED + TOO_LONG]),
    "joint's number": (each("robot.joints([seam_sdk.JointTarget(20, 0.1)])"), 0,
                       [REFUSED + r"joints\[0\]\.targets\[0\]\.joint: found 20, expected a number below 15"]),
    "degrees": (each("robot.head(pan_rad=45)"), 0, [r"(?m)^0\.000 s r0: warning: pan: 45 rad is out of its range, -1\.564 to 1\.564 "
                                                    r"rad, and is clamped to it; did you mean degrees\? 45 degrees are 0\.7854 rad$"]),
    "degrees in C++": (cpp("degrees"), 0, [r"(?m)^0\.000 s r0: warning: pan: 45 rad is out of its range, .*did you mean degrees\?"]),
    "no number": (each("robot.head(pan_rad=math.nan)"), 0, [REFUSED + r"head\.pan_rad: found nan, expected a number"]),
    "too fast": (each("robot.head(max_speed_rad_s=360)"), 0, [REFUSED + r"head\.max_speed_rad_s: found 360, expected a number from 0 to 100"]),
    "millimetres": (each("robot.walk(vx_m_s=250)"), 0, [REFUSED + r"walk\.vx_m_s: found 250, expected a number from -10 to 10"]),
    "long message": (each("robot.send(bytes(100000))"), 0, [REFUSED + r"messages\[0\]: found 100000 bytes, expected at most"]),
    "much logged": (each("[robot.log_text('a', 'x' * 1000) for i in range(60)]"), 0,
                    [r"r0: \d+ of \d+ decisions were refused and did nothing; the first at 0\.\d+ s: debug: beyond the budget"]),
    "flood of output": (each("robot.head(); [print('x' * 100) for i in range(3000)]"), 0,
                        [r"\(\d+ lines left out: more than 16384 bytes a simulated second\)"]),
}
# Of these a sweep's words are looked at, too.
IN_SWEEPS = {"exception", "endless loop", "sleeping", "early end", "signal", "degrees", "no number", "joint's name",
             "flood of output", "exception in C++", "endless loop in C++", "early end in C++", "signal in C++", "joint's name in C++",
             "degrees in C++", "flood of output in C++", "long decision in C++"}
# Programs that cannot be started: what is written into the file, its mode, and what is said.
FILES = {
    "missing": (None, 0, r"behaviour '\S*/behaviour' is not there"),
    "not executable": (each("robot.head()"), 0o644, r"behaviour '\S*/behaviour' is not executable: chmod \+x makes it so"),
    "no shebang": ("import seam_sdk\n", 0o755, r"has no #! in its first line, expected #!/usr/bin/python3"),
    "shebang": ("#!/usr/bin/pyhton3\n", 0o755, r"names in its #! line '/usr/bin/pyhton3', which is no program"),
    "shebang of env": ("#!/usr/bin/env -S pyhton3 -u\n", 0o755, r"names in its #! line 'pyhton3', which env finds nowhere in PATH"),
    "shebang from another system": (f"#!{PYTHON}\r\nimport seam_sdk\r\n", 0o755, r"ends its #! line as Windows does, with a carriage return: sed"),
    "folder": ("", None, r"behaviour '\S*/behaviour' is no file, expected a program"),
}


class Mistakes(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.here = pathlib.Path(folder.name)
        self.program = self.here / "behaviour"
        self.path = self.here / "scenario.yaml"

    def write(self, command, silence="wait"):
        self.path.write_text(
            f"format: seam-scenario/1\nname: mistakes\nduration_s: 0.3\nseed: 5\nfield: {SOURCE}/models/field_2002.yaml\n"
            "robots:\n  - id: r0\n    team: red\n    pose: {x_m: -0.9, y_m: 0.4}\n"
            f"    body: {SOURCE}/models/robot_ers210.yaml\n    behaviour: {{command: {command}, silence: {silence}, wall_limit_s: 0.5}}\n")

    def seam(self, *arguments):
        done = subprocess.run([SEAM, *map(str, arguments)], cwd=self.here, capture_output=True, text=True, timeout=LIMIT_S)
        return done.returncode, done.stdout + done.stderr

    def sweep(self):
        (self.here / "plan.yaml").write_text("format: seam-sweep/1\nscenario: scenario.yaml\nseeds: [1, 1]\nlimits: {wall_s: 20}\n")
        (self.here / "results.sqlite").unlink(missing_ok=True)
        code, said = self.seam("sweep", "plan.yaml", "--out", "results.sqlite", "--jobs", "1")
        return code, said + (self.seam("sweep", "status", "results.sqlite")[1] if code else "")

    def expect(self, words, said):
        self.assertLess(len(said), 60_000)
        for word in words:
            if not re.search(word, said):
                self.fail(f"no {word} in\n{said[:2000]} ... {said[-500:]}")

    def test_while_it_runs(self):
        for name, (program, code, words) in WHILE_IT_RUNS.items():
            with self.subTest(name):
                if isinstance(program, str):
                    self.program.write_text(program)
                    self.program.chmod(0o755)
                self.write(program if isinstance(program, list) else [str(self.program)],
                           "abort" if SLOW in words else "wait")
                found, said = self.seam("run", "scenario.yaml")
                self.assertEqual(found, code, said)
                self.expect(words, said)
                if name not in IN_SWEEPS:
                    continue
                found, said = self.sweep()
                self.assertEqual(found, code, said)
                # The first line of an error names the abort without the words of `seam run`.
                # What a run that is finished printed is not kept.
                self.expect([word.replace("(?m)^", "").replace("the run was aborted: ", "").replace("^", "")
                             for word in words[:1] if "flood" not in name], said)

    def test_programs_that_cannot_be_started(self):
        for name, (text, mode, words) in FILES.items():
            with self.subTest(name):
                if mode is None:
                    self.program.unlink(missing_ok=True)
                    self.program.mkdir()
                elif text is not None:
                    self.program.write_bytes(text.encode())
                    self.program.chmod(mode)
                self.write([str(self.program)])
                for command in (("check", "scenario.yaml"), ("run", "scenario.yaml")):
                    code, said = self.seam(*command)
                    self.assertEqual(code, 1, said)
                    self.assertRegex(said, r"seam: (scenario\.yaml: )?robot 'r0': " + r".*" + words)
                code, said = self.sweep()
                self.assertEqual(code, 1, said)
                self.assertRegex(said, words)
        self.write(["ball_wacther"])
        code, said = self.seam("check", "scenario.yaml")
        self.assertEqual(code, 1)
        self.assertRegex(said, r"scenario\.yaml: robot 'r0': no behaviour 'ball_wacther' in \S+ or PATH")

    def test_what_a_behaviour_started_ends_with_the_run(self):
        for last in ("", "    os._exit(0)\n"):  # The behaviour ends with the run, or before it.
            started = "import subprocess\nopen('child', 'w').write(str(subprocess.Popen(['sleep', '600']).pid))\n"
            self.program.write_text(each("robot.head()").replace("robot = ", started + "robot = ") + last)
            self.program.chmod(0o755)
            self.write([str(self.program)])
            self.seam("run", "scenario.yaml")
            child = pathlib.Path("/proc", (self.here / "child").read_text(), "cmdline")
            end = time.monotonic() + 5
            while child.exists() and child.read_bytes() and time.monotonic() < end:  # Of a zombie it is empty.
                time.sleep(0.02)
            self.assertFalse(child.exists() and child.read_bytes())

    def test_seeds_beyond_those_of_a_scenario_are_wrong_use(self):
        self.write(["head_swing"])
        for wrong in (str(1 << 63), "9" * 29, "-1", ""):
            code, said = self.seam("run", "scenario.yaml", f"--seed={wrong}") if wrong else self.seam("run", "scenario.yaml", "--seed", "")
            self.assertEqual(code, 2, said)
            self.assertIn(f"--seed: found '{wrong}', expected a whole number from 0 to {(1 << 63) - 1}", said)
        self.assertEqual(self.seam("run", "scenario.yaml", "--seed", str((1 << 63) - 1))[0], 0)

    def test_a_check_names_all_of_them(self):
        self.write(["ball_wacther"])
        head, robot = re.fullmatch(r"(?s)(.*robots:\n)(.*)", self.path.read_text()).groups()
        self.path.write_text(head + robot + robot.replace("r0", "r1").replace("-0.9", "-0.2").replace("ball_wacther", "ball_watcher")
                             + robot.replace("r0", "r2").replace("-0.9", "0.6").replace("ball_wacther", "./none.py"))
        code, said = self.seam("check", "scenario.yaml")
        self.assertEqual(code, 1)
        self.assertEqual(re.findall(r"(?m)^seam: scenario\.yaml: robot '(\w+)': ", said), ["r0", "r2"], said)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]])
