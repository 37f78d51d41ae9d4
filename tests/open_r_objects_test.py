#!/usr/bin/env python3
"""Several OPEN-R objects in one behaviour process: open_r_objects_test.py SEAM SOURCE_DIR [unittest arguments]

A program of three objects is written here: Clock counts sensor frames, Planner makes angles of them, and Driver sends these to
the robot; a fourth one, of another robot's section, is left out. Its log is that of any behaviour, and whichever of the objects
crashes, blocks or floods, it is the robot's behaviour that did.
"""
import json
import unittest
import sys

from open_r_case import Case, SEAM, seam

HEADER = """#include <OPENR/OObject.h>
#include <OPENR/OObserver.h>
#include <OPENR/OSubject.h>
#include "def.h"
class %(name)s : public OObject {
 public:
  OSubject* subject[numOfSubject];
  OObserver* observer[numOfObserver];
  int count;
  OPrimitiveID pan;
  RCRegion* region[2];
  virtual OStatus DoInit(const OSystemEvent&);
  virtual OStatus DoStart(const OSystemEvent&);
  virtual OStatus DoStop(const OSystemEvent&);
  virtual OStatus DoDestroy(const OSystemEvent&);
  void Notified(const ONotifyEvent& event);
  void Ready(const OReadyEvent& event);
};
"""
SOURCE_TEXT = """#include "%(name)s.h"
#include <OPENR/OPENRAPI.h>
#include <OPENR/OSyslog.h>
#include <OPENR/OUnits.h>
#include <OPENR/core_macro.h>
OStatus %(name)s::DoInit(const OSystemEvent&) {
  count = 0;
  NEW_ALL_SUBJECT_AND_OBSERVER;
  REGISTER_ALL_ENTRY;
  SET_ALL_READY_AND_NOTIFY_ENTRY;
  OSYSPRINT(("%(name)s: init\\n"));
  %(init)s
  return oSUCCESS;
}
OStatus %(name)s::DoStart(const OSystemEvent&) {
  OSYSPRINT(("%(name)s: start\\n"));
  ENABLE_ALL_SUBJECT;
  ASSERT_READY_TO_ALL_OBSERVER;
  return oSUCCESS;
}
OStatus %(name)s::DoStop(const OSystemEvent&) {
  OSYSPRINT(("%(name)s: %%d notified\\n", count));
  DISABLE_ALL_SUBJECT;
  DEASSERT_READY_TO_ALL_OBSERVER;
  return oSUCCESS;
}
OStatus %(name)s::DoDestroy(const OSystemEvent&) {
  DELETE_ALL_SUBJECT_AND_OBSERVER;
  return oSUCCESS;
}
void %(name)s::Ready(const OReadyEvent&) {}
void %(name)s::Notified(const ONotifyEvent& event) {
  ++count;
  %(mistake)s
  %(act)s
  observer[event.ObsIndex()]->AssertReady(event.SenderID());
}
"""
STUB = """ObjectName : %(name)s
NumOfOSubject   : 1
NumOfOObserver  : 1
Service : "%(name)s.%(out)s.S", null, Ready()
Service : "%(name)s.%(in)s.O", null, Notified()
"""
OBJECTS = {
    "Clock": {"in": "Sensors.OSensorFrameVectorData", "out": "Ticks.int", "init": "",
              "act": "subject[0]->SetData(&count, sizeof count); subject[0]->NotifyObservers();"},
    # A region of its own for each angle: the last who holds it frees it.
    "Planner": {"in": "Ticks.int", "out": "Angle.double", "init": "",
                "act": """const int tick = *static_cast<const int*>(event.Data(0));
  RCRegion* out = new RCRegion(sizeof(double));
  *reinterpret_cast<double*>(out->Base()) = tick % 40 < 20 ? 0.6 : -0.6;
  subject[0]->SetData(out);
  out->RemoveReference();
  subject[0]->NotifyObservers();"""},
    "Driver": {"in": "Angle.double", "out": "Move.OCommandVectorData",
               "init": """OPENR::OpenPrimitive("PRM:/r1/c1/c2-Joint2:j2", &pan);
  OPENR::EnableJointGain(pan);
  OPENR::SetDefaultJointGain(pan);
  for (int i = 0; i < 2; ++i) {
    MemoryRegionID id;
    OCommandVectorData* data;
    OPENR::NewCommandVectorData(1, &id, &data);
    region[i] = new RCRegion(data->vectorInfo.memRegionID, data->vectorInfo.offset, data, data->vectorInfo.totalSize);
  }
  OPENR::SetMotorPower(opowerON);""",
               "act": """RCRegion* out = region[0]->NumberOfReference() == 1 ? region[0] : region[1];
  OCommandVectorData* vector = reinterpret_cast<OCommandVectorData*>(out->Base());
  vector->SetNumData(1);
  vector->GetInfo(0)->Set(odataJOINT_COMMAND2, pan, 4);
  OJointCommandValue2* frames = reinterpret_cast<OJointCommandValue2*>(vector->GetData(0)->value);
  for (int k = 0; k < 4; ++k) frames[k].value = static_cast<slongword>(1e6 * *static_cast<const double*>(event.Data(0)));
  subject[0]->SetData(out);
  subject[0]->NotifyObservers();"""},
}
OBJECT_CFG = """# In the order in which they are started.
/MS/OPEN-R/MW/OBJS/CLOCK.BIN
/MS/OPEN-R/MW/OBJS/planner.bin
[ERS-210]
/MS/OPEN-R/MW/OBJS/DRIVER.BIN
[ERS-7]
/MS/OPEN-R/MW/OBJS/DRIVER7.BIN
"""
CONNECT_CFG = """OVirtualRobotComm.Sensor.OSensorFrameVectorData.S Clock.Sensors.OSensorFrameVectorData.O
Clock.Ticks.int.S Planner.Ticks.int.O
Planner.Angle.double.S Driver.Angle.double.O
Driver.Move.OCommandVectorData.S OVirtualRobotComm.Effector.OCommandVectorData.O
"""


class Objects(Case):
    def built(self, mistaken=None, mistake="", connections=CONNECT_CFG):
        """The scenario of the program, one of whose objects makes a mistake with its tenth notification."""
        program, out = self.here / "program", self.here / "out"
        for name, parts in OBJECTS.items():
            texts = {"name": name, "mistake": f"if (count == 10) {{ {mistake} }}" if name == mistaken else "", **parts}
            (program / name).mkdir(parents=True, exist_ok=True)
            (program / name / f"{name}.h").write_text(HEADER % texts)
            (program / name / f"{name}.cc").write_text(SOURCE_TEXT % texts)
            (program / name / "stub.cfg").write_text(STUB % texts)
        settings = program / "MS/OPEN-R/MW/CONF"
        settings.mkdir(parents=True, exist_ok=True)
        (settings / "OBJECT.CFG").write_text(OBJECT_CFG)
        (settings / "CONNECT.CFG").write_text(connections)
        self.said = seam("open-r", "build", program, "--out", out)
        return out / "scenario.yaml"

    def run_of(self, scenario, log, *more, code=0):
        return seam("run", scenario, "--set", "duration_s=2", "--log", self.here / log, "--json", self.here / "run.json", "--force",
                    *more, code=code)

    def test_three_objects_are_one_behaviour(self):
        scenario = self.built()
        for name in ("CLOCK.BIN", "planner.bin", "DRIVER.BIN"):
            self.assertIn(f"{name} from", self.said)
        self.assertNotIn("DRIVER7", self.said)
        said, fingerprints = self.run_of(scenario, "first.mcap"), []
        # Each start follows each init, in the order of OBJECT.CFG.
        places = [said.index(f"{name}: {what}") for what in ("init", "start") for name in OBJECTS]
        self.assertEqual(places, sorted(places))
        # Vectors of 32 ms in 2 s, and what each of them led to within its own turn.
        for name in OBJECTS:
            self.assertRegex(said, rf"{name}: 6[0-3] notified")
        for log in ("first.mcap", "again.mcap"):
            self.run_of(scenario, log)
            fingerprints.append(json.loads((self.here / "run.json").read_text())["fingerprint"])
        self.assertEqual(*fingerprints)
        seam("replay", "verify", self.here / "first.mcap")
        seam("replay", "diff", self.here / "first.mcap", self.here / "again.mcap")
        seam("replay", "whatif", self.here / "first.mcap", "--robot", "aibo", "--from", "0", "--json", self.here / "whatif.json",
             "--client", f"open_r {scenario.parent / 'MS'}")
        self.assertTrue(json.loads((self.here / "whatif.json").read_text())["equal"])
        # The angles that the objects made together reached the head.
        for angle in ("> 0.5", "< -0.5"):
            seam("replay", "find", self.here / "first.mcap", "--when", f"truth.aibo.pan_rad {angle}")

    def test_one_that_crashes_ends_the_behaviour(self):
        for name in OBJECTS:
            scenario = self.built(name, "*(volatile int*)0 = 1;")
            self.assertIn("was ended by signal 11", self.run_of(scenario, "crash.mcap", code=1), name)

    def test_one_that_blocks_makes_the_robot_silent(self):
        scenario = self.built("Planner", "for (;;) {}")
        clock = "clock: {period_s: 0.008}"
        scenario.write_text(scenario.read_text().replace(clock, clock + ", silence: abort, wall_limit_s: 3"))
        self.assertIn("no answer within 3 s of wall time", self.run_of(scenario, "block.mcap", code=1))

    def test_one_that_floods_is_bounded(self):
        scenario = self.built("Planner", 'for (int i = 0; i < 3000; ++i) OSYSPRINT(("%0100d\\n", i));')
        said = self.run_of(scenario, "flood.mcap")
        self.assertRegex(said, r"\(\d+ lines left out: more than 16384 bytes a simulated second\)")
        self.assertRegex(said, r"Driver: 6[0-3] notified")
        seam("replay", "verify", self.here / "flood.mcap")

    def test_messages_without_end_name_who_gets_them(self):
        scenario = self.built("Driver", "for (;;) { subject[0]->SetData(region[0]); subject[0]->NotifyObservers(); "
                                        "if (++count > 100000) break; }")
        # What the robot does not take at once replaces what waits: memory does not grow with it.
        self.assertRegex(self.run_of(scenario, "many.mcap"), r"Driver: 1000\d\d notified")
        scenario = self.built("Planner", "static OObserver self; self.SetNotifyEntry(OServiceEntry(myOID_, 5)); "
                                         "for (int i = 0; i < 1100000; ++i) self.AssertReady(SubjectID(myOID_, 4));")
        self.assertIn("messages within one frame of 8 ms, the last one to planner", self.run_of(scenario, "circle.mcap", code=1))

    def test_what_is_not_connected_is_said(self):
        scenario = self.built(connections=CONNECT_CFG + "Clock.Nothing.int.S Planner.Ticks.int.O\n"
                                                        "Clock.Ticks.int.S Clock.Sensors.OSensorFrameVectorData.O\n")
        said = self.run_of(scenario, "nobody.mcap")
        self.assertIn("no object has the service Clock.Nothing.int.S", said)
        self.assertIn("not connected: the names of their data differ", said)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
