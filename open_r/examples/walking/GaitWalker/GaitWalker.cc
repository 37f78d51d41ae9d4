#include "GaitWalker.h"

#include <OPENR/OPENRAPI.h>
#include <OPENR/OSyslog.h>
#include <OPENR/OUnits.h>
#include <OPENR/core_macro.h>
#include <stdio.h>

// Left front, right front, left hind, right hind; each rotator, elevator, knee.
static const char* const kLegs[] = {"r2", "r4", "r3", "r5"};
static const char* const kOfLeg[] = {"c1-Joint2:j1", "c1/c2-Joint2:j2", "c1/c2/c3-Joint2:j3"};
static const char* const kGait = "/MS/OPEN-R/MW/DATA/P/GAIT.TXT";

GaitWalker::GaitWalker() : running_(false), next_(0) {}

bool GaitWalker::ReadGait(const char* path) {
  FILE* file = fopen(path, "r");
  if (file == 0) return false;
  Posture posture;
  int joint = 0;
  while (fscanf(file, "%lf", &posture.deg[joint]) == 1) {
    if (++joint < kJoints) continue;
    gait_.push_back(posture);
    joint = 0;
  }
  fclose(file);
  return !gait_.empty() && joint == 0;
}

OStatus GaitWalker::DoInit(const OSystemEvent&) {
  NEW_ALL_SUBJECT_AND_OBSERVER;
  REGISTER_ALL_ENTRY;
  SET_ALL_READY_AND_NOTIFY_ENTRY;
  if (!ReadGait(kGait)) {
    OSYSLOG1((osyslogERROR, "GaitWalker: no gait in %s", kGait));
    return oFAIL;
  }
  for (int i = 0; i < kJoints; ++i) {
    char locator[64];
    snprintf(locator, sizeof locator, "PRM:/%s/%s", kLegs[i / 3], kOfLeg[i % 3]);
    if (OPENR::OpenPrimitive(locator, &joints_[i]) != oSUCCESS) return oFAIL;
  }
  OPENR::EnableJointGain(oprimitiveID_UNDEF);
  OPENR::SetDefaultJointGain(oprimitiveID_UNDEF);
  for (int i = 0; i < kCommands; ++i) {
    MemoryRegionID id;
    OCommandVectorData* data;
    OPENR::NewCommandVectorData(kJoints, &id, &data);
    commands_[i] = new RCRegion(data->vectorInfo.memRegionID, data->vectorInfo.offset, data,
                                data->vectorInfo.totalSize);
  }
  return OPENR::SetMotorPower(opowerON);
}

OStatus GaitWalker::DoStart(const OSystemEvent&) {
  running_ = !gait_.empty();
  for (int i = 0; i < kCommands && running_; ++i) Send(commands_[i]);
  subject[sbjLegs]->NotifyObservers();
  ENABLE_ALL_SUBJECT;
  ASSERT_READY_TO_ALL_OBSERVER;
  return oSUCCESS;
}

OStatus GaitWalker::DoStop(const OSystemEvent&) {
  running_ = false;
  DISABLE_ALL_SUBJECT;
  DEASSERT_READY_TO_ALL_OBSERVER;
  return oSUCCESS;
}

OStatus GaitWalker::DoDestroy(const OSystemEvent&) {
  DELETE_ALL_SUBJECT_AND_OBSERVER;
  return oSUCCESS;
}

void GaitWalker::StepOn(const OReadyEvent& event) {
  if (!running_ || !event.IsAssert()) return;
  for (int i = 0; i < kCommands; ++i) {
    if (commands_[i]->NumberOfReference() != 1) continue;
    Send(commands_[i]);
    subject[sbjLegs]->NotifyObservers();
    return;
  }
}

// From one posture to the next in four frames.
void GaitWalker::Send(RCRegion* command) {
  const Posture& from = gait_[next_];
  next_ = (next_ + 1) % gait_.size();
  const Posture& to = gait_[next_];
  OCommandVectorData* vector = reinterpret_cast<OCommandVectorData*>(command->Base());
  vector->SetNumData(kJoints);
  for (int i = 0; i < kJoints; ++i) {
    vector->GetInfo(i)->Set(odataJOINT_COMMAND2, joints_[i], kFrames);
    for (int k = 0; k < kFrames; ++k)
      vector->GetData(i)->value[k].value[0] =
          oradians(from.deg[i] + (to.deg[i] - from.deg[i]) * (k + 1) / kFrames);
  }
  subject[sbjLegs]->SetData(command);
}
