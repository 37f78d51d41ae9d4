#!/usr/bin/env python3
"""OPEN-R programs as a user builds and runs them: open_r_test.py SEAM SOURCE_DIR [unittest arguments]

The three examples of open_r/examples are built by `seam open-r build` from their own folders with the user's compiler, run in
scenarios, and their logs are verified; what a program lacks is named; a program that crashes is a client that crashes.
"""
import json
import os
import re
import shutil
import subprocess
import sys
import unittest

from open_r_case import Case, LIMIT_S, SEAM, SOURCE, seam

EXAMPLES = SOURCE / "open_r" / "examples"

# What `seam open-r stub` would make, as programs before it had it: functions, entries and the table by hand.
BY_HAND = {
    "def.h": "const int numOfSubject = 1, sbjMove = 0, numOfObserver = 1;\n",
    "entry.h": """#include <OPENR/OPENR.h>
static const char* const subjectService[] = {"SwingHead.Move.OCommandVectorData.S"};
static const char* const observerService[] = {"SwingHead.Nothing.DoNotConnect.O"};
static const Selector Entry_Control[] = {4}, Entry_Ready[] = {5}, Entry_Connect[] = {6}, Entry_Notify[] = {7};
""",
    "SwingHeadStub.cc": """#include <MCOOP.h>
#include <ObjectEntryTable.h>
#include <apsys.h>
#include "SwingHead.h"
SwingHead Self;
#define REASON(NAME) \\
  extern "C" void NAME##Stub(OReasonMessage* m) { Self.NAME(OSystemEvent(m->reason, m->param, m->paramSize)); Return(); }
REASON(Init) REASON(Start) REASON(Stop) REASON(Destroy)
extern "C" void ControlStub(OControlMessage* m) { Self.subject[0]->ControlHandler(*m); Return(); }
extern "C" void ReadyStub(OReadyMessage* m) {
  Self.subject[0]->ReadyHandler(*m);
  Self.MoveOn(OReadyEvent(0, m->observerID, m->command));
  Return();
}
extern "C" void ConnectStub(OConnectMessage* m) { Self.observer[0]->ConnectHandler(*m); Return(); }
GEN_ENTRY(InitEntry, InitStub);
GEN_ENTRY(StartEntry, StartStub);
GEN_ENTRY(StopEntry, StopStub);
GEN_ENTRY(DestroyEntry, DestroyStub);
GEN_ENTRY(ControlEntry, ControlStub);
GEN_ENTRY(ReadyEntry, ReadyStub);
GEN_ENTRY(ConnectEntry, ConnectStub);
ObjectEntry ObjectEntryTable[] = {
    {oentryINIT, (Entry)InitEntry}, {oentrySTART, (Entry)StartEntry}, {oentrySTOP, (Entry)StopEntry},
    {oentryDESTROY, (Entry)DestroyEntry}, {4, (Entry)ControlEntry}, {5, (Entry)ReadyEntry}, {6, (Entry)ConnectEntry},
    {UNDEF, (Entry)ENTRY_UNDEF}};
""",
}


class OpenR(Case):
    def build(self, program, *more, code=0):
        out = self.here / "out"
        return out, seam("open-r", "build", program, "--out", out, *more, code=code)

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

    def changed(self, old, new):
        """A program like moving_head, but for one place."""
        program = self.here / f"changed_{len(list(self.here.iterdir()))}"
        shutil.copytree(EXAMPLES / "moving_head", program)
        source = program / "SwingHead" / "SwingHead.cc"
        text = source.read_text()
        self.assertIn(old, text)
        source.write_text(text.replace(old, new))
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
        self.assertRegex(said, r"SwingHead: sent commands for \d+ ms")
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
        said = seam("open-r", "build", program, "--out", self.here / "out", code=1)
        self.assertIn("OBJECT.CFG names POWERMON.BIN, which no folder makes: give its folder, too", said)
        self.assertIn("1 of 2 objects were built", said)
        self.assertTrue((self.here / "out/scenario.yaml").exists(), "the other object may be tried")
        said = seam("open-r", "build", self.here / "nowhere", code=1)
        self.assertIn("no folder", said)

    def test_a_program_that_crashes_is_a_client_that_crashes(self):
        out, _ = self.build(self.changed("if (command == 0) return;", "*(volatile int*)0 = 1;"))
        said = seam("run", out / "scenario.yaml", code=1)
        self.assertIn("was ended by signal 11", said)

    def test_a_program_that_blocks_is_silent_for_its_robot(self):
        program = self.changed("if (command == 0) return;", "for (;;) {}")
        out, _ = self.build(program)
        scenario = out / "scenario.yaml"
        clock = "clock: {period_s: 0.008}"
        scenario.write_text(scenario.read_text().replace(clock, clock + ", silence: abort, wall_limit_s: 3"))
        self.assertIn("no answer within 3 s of wall time", seam("run", scenario, code=1))

    def test_floods_are_bounded(self):
        program = self.changed("if (command == 0) return;", 'for (int i = 0; i < 3000; ++i) OSYSPRINT(("%0100d\\n", i));')
        out, _ = self.build(program)
        _, said, _ = self.run_for(out, 0.5)
        self.assertRegex(said, r"\(\d+ lines left out: more than 16384 bytes a simulated second\)")
        # Objects that answer each other without end.
        program = self.changed("if (!running_ || !event.IsAssert()) return;",
                               "static OObserver self; self.SetNotifyEntry(OServiceEntry(myOID_, 5));\n"
                               "  self.AssertReady(SubjectID(myOID_, 5));")
        out, _ = self.build(program)
        said = seam("run", out / "scenario.yaml", code=1)
        self.assertIn("messages within one frame of 8 ms, the last one to SWINGHD", said)

    def test_logs_are_those_of_any_behaviour(self):
        """Two runs differ where their seeds do; a changed program is tried against a recorded run."""
        out, _ = self.build(EXAMPLES / "moving_head")
        logs = {name: self.here / f"{name}.mcap" for name in ("first", "again", "other")}
        for (name, log), seed in zip(logs.items(), (1, 1, 2)):
            seam("run", out / "scenario.yaml", "--set", "duration_s=1", "--set", f"seed={seed}", "--log", log)
        seam("replay", "diff", logs["first"], logs["again"])
        seam("replay", "diff", logs["first"], logs["other"], code=1)
        whatif = ("replay", "whatif", logs["first"], "--robot", "aibo", "--from", "0", "--json", self.here / "diff.json", "--force")
        same = seam(*whatif, "--client", f"open_r {out / 'MS'}")
        self.assertTrue(json.loads((self.here / "diff.json").read_text())["equal"], same)
        changed = self.changed("kAmplitude_deg = 60", "kAmplitude_deg = 30")
        seam("open-r", "build", changed, "--out", self.here / "changed")
        seam(*whatif, "--client", f"open_r {self.here / 'changed' / 'MS'}")
        self.assertFalse(json.loads((self.here / "diff.json").read_text())["equal"])

    def test_a_stub_by_hand(self):
        program = self.copy_of("moving_head")
        folder = program / "SwingHead"
        (folder / "stub.cfg").unlink()
        for name, text in BY_HAND.items():
            (folder / name).write_text(text)
        out, _ = self.build(program)
        _, said, _ = self.run_for(out, 1)
        self.assertRegex(said, r"SwingHead: sent commands for \d+ ms")
        (folder / "SwingHeadStub.cc").write_text(BY_HAND["SwingHeadStub.cc"].replace("ObjectEntryTable[]", "Table[]"))
        out, _ = self.build(program)
        self.assertIn("has no ObjectEntryTable", seam("run", out / "scenario.yaml", code=1))

    def test_what_is_refused_says_why(self):
        source = self.changed("#include <math.h>", "#include <math.h>\n#include <OPENR/ODataArchive.h>\n"
                              "static ODataArchiveID id;\nOStatus Open() { return ODataArchive::New(0, 0, &id); }\n"
                              'void Old() { asm("mfc0 $2, $12"); }')
        said = seam("open-r", "build", source, "--out", self.here / "out", code=1)
        self.assertIn("lacks ODataArchive::New is refused: read the file of the archive", said)
        program = self.changed("#include <math.h>", '#include <math.h>\nvoid Old() { asm("mfc0 $2, $12"); }')
        self.assertIn("lacks a MIPS processor", seam("open-r", "build", program, "--out", self.here / "out", code=1))

    def test_a_file_that_is_no_log_stays(self):
        notes = self.here / "notes.txt"
        notes.write_text("of a long night")
        self.assertIn("exists and is no log", self.build(EXAMPLES / "moving_head", "--log", notes, code=1)[1])
        self.assertEqual(notes.read_text(), "of a long night")
        log = self.here / "head.mcap"
        for _ in range(2):
            self.build(EXAMPLES / "moving_head", "--log", log)
        self.assertTrue(log.read_bytes().startswith(b"\x89MCAP0"))

    def test_an_unknown_robot_is_refused(self):
        out, _ = self.build(EXAMPLES / "moving_head")
        said = self.build(EXAMPLES / "moving_head", "--scenario", out / "scenario.yaml", "--robot", "nobody", code=2)[1]
        self.assertIn("--robot nobody: not in the scenario, whose robots are: aibo", said)
        self.assertIn("give --scenario, too", self.build(EXAMPLES / "moving_head", "--robot", "aibo", code=2)[1])

    def test_a_good_object_outlives_a_build_that_fails(self):
        program = self.copy_of("moving_head")
        objects, settings = program / "MS/OPEN-R/MW/OBJS", program / "MS/OPEN-R/MW/CONF/OBJECT.CFG"
        objects.mkdir()
        (objects / "swinghd.bin").write_text("for a MIPS processor")
        out, _ = self.build(program)
        made = out / "MS/OPEN-R/MW/OBJS/SWINGHD.BIN"
        good = made.read_bytes()
        self.assertEqual([made], list(made.parent.iterdir()))
        source = program / "SwingHead/SwingHead.cc"
        text = source.read_text()
        source.write_text(text + "nonsense")
        self.build(program, code=1)
        self.assertEqual(made.read_bytes(), good)
        source.write_text(text)
        settings.write_text("/MS/OPEN-R/MW/OBJS/SWINGHD.BIN\n/MS/OPEN-R/MW/OBJS/swinghd.BIN\n")
        said = self.build(program, code=1)[1]
        self.assertIn("OBJECT.CFG:2: /MS/OPEN-R/MW/OBJS/swinghd.BIN is named twice", said)
        self.assertEqual(made.read_bytes(), good)

    def test_makefiles_without_end(self):
        program = self.copy_of("moving_head")
        makefile = program / "SwingHead/Makefile"
        for name, other in ("AB", "BA"):
            (program / name).mkdir()
            (program / name / "Makefile").write_text(f"lib{name}.a: {name}.o ../{other}/lib{other}.a\n")
            (program / name / f"{name}.cc").write_text(f"int of_{name} = 1;\n")
        makefile.write_text("swing.bin: SwingHead.o ../A/libA.a $^\n\tgzip -c $^ > swing.bin SWINGHD.BIN\n")
        self.build(program)
        made = {path.name for path in (self.here / "out/objects").rglob("*.o")}
        self.assertEqual(made, {"0_SwingHead.o", "1_A.o", "2_B.o", "3_SwingHeadStub.o"})
        makefile.write_text("swing.bin: SwingHead.o\nCXXFLAGS = $(CXXFLAGS) $(CXXFLAGS) -O2\n")
        self.assertIn("Makefile:2: the variable CXXFLAGS names itself", self.build(program, code=1)[1])

    def test_settings_are_files(self):
        program = self.copy_of("moving_head")
        settings = program / "MS/OPEN-R/MW/CONF"
        out, _ = self.build(program)
        connections = out / "MS/OPEN-R/MW/CONF/CONNECT.CFG"
        connections.unlink()
        self.assertIn("CONNECT.CFG: is not there, expected a file", seam("run", out / "scenario.yaml", code=1))
        connections.mkdir()
        self.assertIn("CONNECT.CFG: is a folder, expected a file", seam("run", out / "scenario.yaml", code=1))
        connections.rmdir()
        (settings / "OBJECT.CFG").unlink()
        os.mkfifo(settings / "OBJECT.CFG")
        self.assertIn("OBJECT.CFG: is a pipe, expected a file", self.build(program, code=1)[1])
        (settings / "OBJECT.CFG").unlink()
        (settings / "OBJECT.CFG").symlink_to("/dev/zero")
        self.assertIn("OBJECT.CFG: is a device, expected a file", self.build(program, code=1)[1])

    def test_names_that_yaml_would_read_otherwise(self):
        out = self.here / "a, b # [c] 'd'"
        seam("open-r", "build", EXAMPLES / "moving_head", "--out", out)
        self.run_for(out, 0.1)

    def test_a_build_in_the_own_folder(self):
        program = self.copy_of("moving_head")
        for name in ("open_r_program", "other", "other"):
            subprocess.run([SEAM, "open-r", "build", ".", "--out", name], cwd=program, check=True, timeout=LIMIT_S)
        for out in (program, program / "MS", program / "MS/OPEN-R/new"):
            said = seam("open-r", "build", program, "--out", out, code=1)
            self.assertIn("its stick would be that of the program", said)
        self.assertFalse((program / "MS/OPEN-R/new").exists())

    def test_links_stay_in_the_stick(self):
        program = self.copy_of("moving_head")
        link = program / "MS/secret.txt"
        (program / "MS/file.txt").write_text("of the program")
        link.symlink_to("file.txt")
        out, _ = self.build(program)
        self.assertEqual((out / "MS/secret.txt").read_text(), "of the program")
        for target in ("/etc/passwd", "../SwingHead", "nowhere"):
            link.unlink()
            link.symlink_to(target)
            self.assertIn("secret.txt: a link that leaves the stick", self.build(program, code=1)[1])

    def test_a_stub(self):
        seam("open-r", "stub", EXAMPLES / "walking/GaitWalker/stub.cfg", "--out", self.here)
        self.assertIn("const int sbjLegs = 0;", (self.here / "def.h").read_text())
        self.assertIn("GaitWalker Self;", (self.here / "GaitWalkerStub.cc").read_text())
        bad = self.here / "stub.cfg"
        bad.write_text("ObjectName GaitWalker\n")
        self.assertIn("stub.cfg:1: found", seam("open-r", "stub", bad, "--out", self.here, code=1))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
