// Swings the head from side to side: sixteen frames of 8 ms a command, one command ahead.
#ifndef SWING_HEAD_H
#define SWING_HEAD_H

#include <OPENR/OObject.h>
#include <OPENR/OObserver.h>
#include <OPENR/OSubject.h>

#include "def.h"

class SwingHead : public OObject {
 public:
  SwingHead();

  OSubject* subject[numOfSubject];
  OObserver* observer[numOfObserver];

  virtual OStatus DoInit(const OSystemEvent& event);
  virtual OStatus DoStart(const OSystemEvent& event);
  virtual OStatus DoStop(const OSystemEvent& event);
  virtual OStatus DoDestroy(const OSystemEvent& event);

  // The robot has put out a command and takes the next.
  void MoveOn(const OReadyEvent& event);

 private:
  enum { kTilt, kPan, kRoll, kJoints };
  enum { kCommands = 2 };

  RCRegion* FreeCommand();
  void Send(RCRegion* command);

  bool running_;
  double time_s_;  // Where the swing is.
  OPrimitiveID joints_[kJoints];
  RCRegion* commands_[kCommands];
};

#endif
