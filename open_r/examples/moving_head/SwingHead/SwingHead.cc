#include "SwingHead.h"

#include <OPENR/OPENRAPI.h>
#include <OPENR/OSyslog.h>
#include <OPENR/OUnits.h>
#include <OPENR/core_macro.h>
#include <math.h>

static const char* const kLocators[] = {"PRM:/r1/c1-Joint2:j1", "PRM:/r1/c1/c2-Joint2:j2",
                                        "PRM:/r1/c1/c2/c3-Joint2:j3"};
static const double kAmplitude_deg = 60, kPeriod_s = 4, kFrame_s = 0.008;
static const double kTurn = 2 * 3.14159265358979323846;

SwingHead::SwingHead() : running_(false), time_s_(0) {}

OStatus SwingHead::DoInit(const OSystemEvent&) {
  NEW_ALL_SUBJECT_AND_OBSERVER;
  REGISTER_ALL_ENTRY;
  SET_ALL_READY_AND_NOTIFY_ENTRY;
  for (int i = 0; i < kJoints; ++i) {
    if (OPENR::OpenPrimitive(kLocators[i], &joints_[i]) != oSUCCESS) return oFAIL;
    OPENR::EnableJointGain(joints_[i]);
    OPENR::SetDefaultJointGain(joints_[i]);
  }
  for (int i = 0; i < kCommands; ++i) {
    MemoryRegionID id;
    OCommandVectorData* data;
    OPENR::NewCommandVectorData(kJoints, &id, &data);
    commands_[i] = new RCRegion(data->vectorInfo.memRegionID, data->vectorInfo.offset, data,
                                data->vectorInfo.totalSize);
  }
  return OPENR::SetMotorPower(opowerON);
}

OStatus SwingHead::DoStart(const OSystemEvent&) {
  running_ = true;
  // Two commands at once: one is put out while the next is made.
  for (int i = 0; i < kCommands; ++i) Send(commands_[i]);
  subject[sbjMove]->NotifyObservers();
  ENABLE_ALL_SUBJECT;
  ASSERT_READY_TO_ALL_OBSERVER;
  return oSUCCESS;
}

OStatus SwingHead::DoStop(const OSystemEvent&) {
  running_ = false;
  DISABLE_ALL_SUBJECT;
  DEASSERT_READY_TO_ALL_OBSERVER;
  OSYSPRINT(("SwingHead: sent commands for %d ms\n", static_cast<int>(time_s_ * 1000)));
  return oSUCCESS;
}

OStatus SwingHead::DoDestroy(const OSystemEvent&) {
  DELETE_ALL_SUBJECT_AND_OBSERVER;
  return oSUCCESS;
}

void SwingHead::MoveOn(const OReadyEvent& event) {
  if (!running_ || !event.IsAssert()) return;
  RCRegion* command = FreeCommand();
  if (command == 0) return;
  Send(command);
  subject[sbjMove]->NotifyObservers();
}

// A command that nobody else holds was put out.
RCRegion* SwingHead::FreeCommand() {
  for (int i = 0; i < kCommands; ++i)
    if (commands_[i]->NumberOfReference() == 1) return commands_[i];
  return 0;
}

void SwingHead::Send(RCRegion* command) {
  OCommandVectorData* vector = reinterpret_cast<OCommandVectorData*>(command->Base());
  vector->SetNumData(kJoints);
  for (int i = 0; i < kJoints; ++i) {
    vector->GetInfo(i)->Set(odataJOINT_COMMAND2, joints_[i], ocommandMAX_FRAMES);
    OJointCommandValue2* frames = reinterpret_cast<OJointCommandValue2*>(vector->GetData(i)->value);
    for (size_t k = 0; k < ocommandMAX_FRAMES; ++k) {
      const double angle = kTurn * (time_s_ + k * kFrame_s) / kPeriod_s;
      frames[k].value = i == kPan ? oradians(kAmplitude_deg * sin(angle)) : 0;
    }
  }
  time_s_ += ocommandMAX_FRAMES * kFrame_s;
  subject[sbjMove]->SetData(command);
}
