// Keeps an orange ball in the middle of the image: the colour table finds it, and the sensors of
// the image's own frame say where the head looked.
#ifndef BALL_TRACKER_H
#define BALL_TRACKER_H

#include <OPENR/OFbkImage.h>
#include <OPENR/OObject.h>
#include <OPENR/OObserver.h>
#include <OPENR/OSubject.h>

#include <list>
#include <string>

#include "def.h"

class BallTracker : public OObject {
 public:
  BallTracker();

  OSubject* subject[numOfSubject];
  OObserver* observer[numOfObserver];

  virtual OStatus DoInit(const OSystemEvent& event);
  virtual OStatus DoStart(const OSystemEvent& event);
  virtual OStatus DoStop(const OSystemEvent& event);
  virtual OStatus DoDestroy(const OSystemEvent& event);

  void KeepSensors(const ONotifyEvent& event);
  void SeeImage(const ONotifyEvent& event);

 private:
  enum { kTilt, kPan, kJoints };
  enum { kCommands = 4, kFrames = 5, kVectors = 8 };

  bool SetColours();
  bool HeadAt(longword frame, double* tilt_deg, double* pan_deg) const;
  void TurnTo(double tilt_deg, double pan_deg);

  OPrimitiveID joints_[kJoints], camera_;
  int places_[kJoints];  // In the sensor vector; -1: not looked for yet.
  RCRegion* commands_[kCommands];
  std::list<RCRegion*> sensors_;  // The newest vectors.
  double last_deg_[kJoints];
  int seen_, matched_;  // Images with the ball, and those whose frame the sensors had.
};

#endif
