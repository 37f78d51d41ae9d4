#!/usr/bin/env python3
"""OPEN-R programs as a user builds and runs them: open_r_test.py SEAM SOURCE_DIR [unittest arguments]

The three examples of open_r/examples are built by `seam open-r build` from their own folders with the user's compiler, run in
scenarios, and their logs are verified; what a program lacks is named; a program that crashes is a client that crashes.
"""
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

import by_hand

SEAM, SOURCE = by_hand.arguments("seam", "source")
EXAMPLES = SOURCE / "open_r" / "examples"
LIMIT_S = 240  # A hang is a failure.


def seam(*words, code=0):
    done = subprocess.run([SEAM, *map(str, words)], capture_output=True, text=True, timeout=LIMIT_S)
    said = done.stdout + done.stderr
    assert done.returncode == code, f"seam {' '.join(map(str, words))}: exit code {done.returncode}\n{said}"
    return said


class OpenR(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.here = pathlib.Path(folder.name)

    def build(self, program, *more):
        out = self.here / "out"
        return out, seam("open-r", "build", program, "--out", out, *more)

    def run_for(self, out, duration_s, *more):
        """The summary of a run of the scenario that was written, what it said, and its log, verified."""
        log, summary = self.here / "run.mcap", self.here / "run.json"
        said = seam("run", out / "scenario.yaml", "--set", f"duration_s={duration_s}", "--log", log, "--json", summary, "--force",
                    *more)
        seam("replay", "verify", log)
        return json.loads(summary.read_text()), said, log

    def copy_of(self, example):
        program = self.here / example
        shutil.copytree(EXAMPLES / example, program)
        return program

    def joint_angles(self, log, joint):
        folder = self.here / "joints"
        seam("import", "log", log, "--part", "joints", "--out", folder)
        rows = [line.split(",") for line in (folder / "joints.csv").read_text().splitlines()[1:]]
        return {float(row[1]): float(row[4]) for row in rows if row[2] == joint}

    def test_moving_head(self):
        out, said = self.build(EXAMPLES / "moving_head")
        self.assertIn("SWINGHD.BIN from", said)
        summary, said, log = self.run_for(out, 3)
        self.assertEqual(summary["end"], "finished")
        self.assertRegex(said, r"SwingHead: swung for \d+ ms")
        pan = self.joint_angles(log, "pan")
        # 60 degrees x sin in 4 s: to one end after 1 s, to the other after 3 s; the servo lags a little.
        self.assertAlmostEqual(pan[min(pan, key=lambda t: abs(t - 1))], 1.047, delta=0.02)
        self.assertAlmostEqual(pan[min(pan, key=lambda t: abs(t - 2.96))], -1.045, delta=0.02)
        # The same seed, the same bits.
        again, _, _ = self.run_for(out, 3)
        self.assertEqual(again["fingerprint"], summary["fingerprint"])

    def test_ball_tracking(self):
        out, _ = self.build(EXAMPLES / "ball_tracking")
        _, said, log = self.run_for(out, 2)
        seen, matched = map(int, re.search(r"saw the ball in (\d+) images, (\d+) matched", said).groups())
        self.assertGreater(seen, 40)
        self.assertEqual(matched, seen, "an image's frame number is that of a sensor frame")
        pan = self.joint_angles(log, "pan")
        # The ball is at 10.6 degrees to the left of a robot 0.8 m away.
        self.assertAlmostEqual(pan[max(pan)], 0.2, delta=0.08)

    def test_walking(self):
        out, _ = self.build(EXAMPLES / "walking")
        _, _, log = self.run_for(out, 4)
        said = seam("replay", "show", log, "--at", "3.9")
        x_m = float(re.search(r"aibo.*?x_m[^-\d]*(-?[\d.]+)", said, re.S).group(1))
        # A trot of 0.1 m/s for four seconds, from -0.2 m.
        self.assertGreater(x_m, 0)

    def test_a_build_says_what_is_lacking(self):
        program = self.copy_of("moving_head")
        source = program / "SwingHead" / "SwingHead.cc"
        source.write_text(source.read_text().replace("#include <math.h>", "#include <math.h>\n#include <ERA201D1.h>"))
        said = seam("open-r", "build", program, "--out", self.here / "out", code=1)
        self.assertIn("ERA201D1 is refused", said)
        (program / "MS/OPEN-R/MW/CONF/OBJECT.CFG").write_text("/MS/OPEN-R/MW/OBJS/SWINGHD.BIN\n/MS/OPEN-R/MW/OBJS/POWERMON.BIN\n")
        source.write_text((EXAMPLES / "moving_head" / "SwingHead" / "SwingHead.cc").read_text())
        said = seam("open-r", "build", program, "--out", self.here / "out")
        self.assertIn("OBJECT.CFG names POWERMON.BIN, which no folder makes: give its folder, too", said)
        said = seam("open-r", "build", self.here / "nowhere", code=1)
        self.assertIn("no folder", said)

    def test_a_program_that_crashes_is_a_client_that_crashes(self):
        program = self.copy_of("moving_head")
        source = program / "SwingHead" / "SwingHead.cc"
        source.write_text(source.read_text().replace("if (command == 0) return;", "*(volatile int*)0 = 1;"))
        out, _ = self.build(program)
        said = seam("run", out / "scenario.yaml", code=1)
        self.assertIn("was ended by signal 11", said)

    def test_a_stub(self):
        seam("open-r", "stub", EXAMPLES / "walking/GaitWalker/stub.cfg", "--out", self.here)
        self.assertIn("const int sbjLegs = 0;", (self.here / "def.h").read_text())
        self.assertIn("GaitWalker Self;", (self.here / "GaitWalkerStub.cc").read_text())
        bad = self.here / "stub.cfg"
        bad.write_text("ObjectName GaitWalker\n")
        self.assertIn("stub.cfg:1: found", seam("open-r", "stub", bad, "--out", self.here, code=1))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
