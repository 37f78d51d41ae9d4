// Walks by a gait from a file: postures of the twelve joints of the legs, one each 32 ms, over and
// over again.
#ifndef GAIT_WALKER_H
#define GAIT_WALKER_H

#include <OPENR/OObject.h>
#include <OPENR/OObserver.h>
#include <OPENR/OSubject.h>

#include <vector>

#include "def.h"

class GaitWalker : public OObject {
 public:
  GaitWalker();

  OSubject* subject[numOfSubject];
  OObserver* observer[numOfObserver];

  virtual OStatus DoInit(const OSystemEvent& event);
  virtual OStatus DoStart(const OSystemEvent& event);
  virtual OStatus DoStop(const OSystemEvent& event);
  virtual OStatus DoDestroy(const OSystemEvent& event);

  void StepOn(const OReadyEvent& event);

 private:
  enum { kJoints = 12, kCommands = 2, kFrames = 4 };
  struct Posture {
    double deg[kJoints];
  };

  bool ReadGait(const char* path);
  void Send(RCRegion* command);

  bool running_;
  OPrimitiveID joints_[kJoints];
  RCRegion* commands_[kCommands];
  std::vector<Posture> gait_;
  size_t next_;
};

#endif
