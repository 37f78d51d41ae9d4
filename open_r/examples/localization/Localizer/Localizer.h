// Finds where the robot stands, while the head turns from side to side: colours of the image, and
// the head's angles in the sensor frame that has the image's number.
#ifndef LOCALIZER_H
#define LOCALIZER_H

#include <OPENR/OObject.h>
#include <OPENR/OObserver.h>
#include <OPENR/OSubject.h>

#include <map>

#include "def.h"
#include "robot_sdk/localization/particle_filter.h"

class Localizer : public OObject {
 public:
  Localizer();

  OSubject* subject[numOfSubject];
  OObserver* observer[numOfObserver];

  OStatus DoInit(const OSystemEvent& event) override;
  OStatus DoStart(const OSystemEvent& event) override;
  OStatus DoStop(const OSystemEvent& event) override;
  OStatus DoDestroy(const OSystemEvent& event) override;

  void MoveOn(const OReadyEvent& event);
  void KeepSensors(const ONotifyEvent& event);
  void SeeImage(const ONotifyEvent& event);

 private:
  enum { kTilt, kPan, kRoll, kJoints };
  static constexpr int kCommands = 2, kFrames = 4;

  bool SetColours();
  void Send(RCRegion* command);

  OPrimitiveID joints_[kJoints], camera_ = oprimitiveID_UNDEF;
  RCRegion* commands_[kCommands];
  double time_s_ = 0;                               // Where the swing is.
  std::map<longword, seam::sdk::HeadAngles> head_;  // Of the newest frames, by number.
  seam::sdk::ParticleFilter filter_;
  int images_ = 0, matched_ = 0;
};

#endif
