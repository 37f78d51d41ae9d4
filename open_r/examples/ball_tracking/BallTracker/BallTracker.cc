#include "BallTracker.h"

#include <OPENR/OPENRAPI.h>
#include <OPENR/OSyslog.h>
#include <OPENR/OUnits.h>
#include <OPENR/core_macro.h>
#include <stdio.h>

static const char* const kLocators[] = {"PRM:/r1/c1-Joint2:j1", "PRM:/r1/c1/c2-Joint2:j2"};
static const char* const kCamera = "PRM:/r1/c1/c2/c3/i1-FbkImageSensor:F1";
static const double kWidth_deg = 57.6, kHeight_deg = 47.8;
static const int kFewPixels = 6;
static const double kMostTurn_deg = 4;  // In the five frames of an image.

BallTracker::BallTracker() : camera_(oprimitiveID_UNDEF), seen_(0), matched_(0) {
  for (int i = 0; i < kJoints; ++i) places_[i] = -1, last_deg_[i] = 0;
}

OStatus BallTracker::DoInit(const OSystemEvent&) {
  NEW_ALL_SUBJECT_AND_OBSERVER;
  REGISTER_ALL_ENTRY;
  SET_ALL_READY_AND_NOTIFY_ENTRY;
  for (int i = 0; i < kJoints; ++i) {
    if (OPENR::OpenPrimitive(kLocators[i], &joints_[i]) != oSUCCESS) return oFAIL;
    OPENR::EnableJointGain(joints_[i]);
    OPENR::SetDefaultJointGain(joints_[i]);
  }
  if (OPENR::OpenPrimitive(kCamera, &camera_) != oSUCCESS || !SetColours()) return oFAIL;
  for (int i = 0; i < kCommands; ++i) {
    MemoryRegionID id;
    OCommandVectorData* data;
    OPENR::NewCommandVectorData(kJoints, &id, &data);
    commands_[i] = new RCRegion(data->vectorInfo.memRegionID, data->vectorInfo.offset, data,
                                data->vectorInfo.totalSize);
  }
  return OPENR::SetMotorPower(opowerON);
}

OStatus BallTracker::DoStart(const OSystemEvent&) {
  ENABLE_ALL_SUBJECT;
  ASSERT_READY_TO_ALL_OBSERVER;
  return oSUCCESS;
}

OStatus BallTracker::DoStop(const OSystemEvent&) {
  DISABLE_ALL_SUBJECT;
  DEASSERT_READY_TO_ALL_OBSERVER;
  OSYSPRINT(
      ("BallTracker: saw the ball in %d images, %d matched a sensor frame\n", seen_, matched_));
  return oSUCCESS;
}

OStatus BallTracker::DoDestroy(const OSystemEvent&) {
  DELETE_ALL_SUBJECT_AND_OBSERVER;
  return oSUCCESS;
}

// A line of the file: from which segment of Y to which, Cr max and min, Cb max and min.
bool BallTracker::SetColours() {
  ODesignDataID id;
  byte* text;
  size_t size;
  if (OPENR::FindDesignData("COLOURS", &id, &text, &size) != oSUCCESS) return false;
  MemoryRegionID region;
  OCdtVectorData* table;
  OPENR::NewCdtVectorData(&region, &table);
  table->SetNumData(1);
  table->GetInfo(0)->Init(camera_, ocdtCHANNEL0);
  const std::string lines(reinterpret_cast<char*>(text), size);
  for (size_t at = 0; at < lines.size(); at = lines.find('\n', at) + 1) {
    int first, last, cr_max, cr_min, cb_max, cb_min;
    if (sscanf(lines.c_str() + at, "%d %d %d %d %d %d", &first, &last, &cr_max, &cr_min, &cb_max,
               &cb_min) == 6)
      for (int y = first; y <= last; ++y) table->GetInfo(0)->Set(y, cr_max, cr_min, cb_max, cb_min);
    if (lines.find('\n', at) == std::string::npos) break;
  }
  const OStatus status = OPENR::SetCdtVectorData(region);
  OPENR::DeleteCdtVectorData(region);
  OPENR::DeleteDesignData(id);
  return status == oSUCCESS;
}

void BallTracker::KeepSensors(const ONotifyEvent& event) {
  RCRegion* vector = event.RCData(0);
  OSensorFrameVectorData* data = reinterpret_cast<OSensorFrameVectorData*>(vector->Base());
  for (int i = 0; i < kJoints && places_[i] < 0; ++i)
    for (size_t k = 0; k < data->vectorInfo.numData; ++k)
      if (data->GetInfo(k)->primitiveID == joints_[i]) places_[i] = k;
  if (sensors_.size() == kVectors) {
    sensors_.front()->RemoveReference();
    sensors_.pop_front();
  }
  vector->AddReference();
  sensors_.push_back(vector);
  observer[event.ObsIndex()]->AssertReady();
}

// Where the head looked in a frame, by the vector that has it.
bool BallTracker::HeadAt(longword frame, double* tilt_deg, double* pan_deg) const {
  std::list<RCRegion*>::const_iterator at;
  for (at = sensors_.begin(); at != sensors_.end(); ++at) {
    OSensorFrameVectorData* data = reinterpret_cast<OSensorFrameVectorData*>((*at)->Base());
    const OSensorFrameInfo* info = data->GetInfo(places_[kTilt]);
    if (frame < info->frameNumber || frame >= info->frameNumber + info->numFrames) continue;
    const size_t k = frame - info->frameNumber;
    *tilt_deg = degrees(data->GetData(places_[kTilt])->frame[k].value * 1e-6);
    *pan_deg = degrees(data->GetData(places_[kPan])->frame[k].value * 1e-6);
    return true;
  }
  return false;
}

void BallTracker::SeeImage(const ONotifyEvent& event) {
  OFbkImageVectorData* data = reinterpret_cast<OFbkImageVectorData*>(event.RCData(0)->Base());
  OFbkImageInfo* info = data->GetInfo(ofbkimageLAYER_C);
  OFbkImage colours(info, data->GetData(ofbkimageLAYER_C), ofbkimageBAND_CDT);
  int n = 0, x = 0, y = 0;
  for (int v = 0; v + 1 < colours.Height(); ++v)  // The last line is no picture.
    for (int u = 0; u < colours.Width(); ++u)
      if (colours.Pixel(u, v) & ocdtCHANNEL0) ++n, x += u, y += v;
  double tilt_deg, pan_deg;
  if (n >= kFewPixels) ++seen_;
  if (n >= kFewPixels && HeadAt(info->frameNumber, &tilt_deg, &pan_deg)) {
    ++matched_;
    TurnTo(tilt_deg - kHeight_deg * (1.0 * y / n / colours.Height() - 0.5),
           pan_deg - kWidth_deg * (1.0 * x / n / colours.Width() - 0.5));
  }
  observer[event.ObsIndex()]->AssertReady();
}

static double Limited(double wanted, double from) {
  const double way = wanted - from;
  return from + (way > kMostTurn_deg ? kMostTurn_deg : way < -kMostTurn_deg ? -kMostTurn_deg : way);
}

void BallTracker::TurnTo(double tilt_deg, double pan_deg) {
  RCRegion* command = 0;
  for (int i = 0; i < kCommands && command == 0; ++i)
    if (commands_[i]->NumberOfReference() == 1) command = commands_[i];
  if (command == 0) return;
  const double wanted[] = {tilt_deg, pan_deg};
  OCommandVectorData* vector = reinterpret_cast<OCommandVectorData*>(command->Base());
  vector->SetNumData(kJoints);
  for (int i = 0; i < kJoints; ++i) {
    const double target = Limited(wanted[i], last_deg_[i]);
    vector->GetInfo(i)->Set(odataJOINT_COMMAND2, joints_[i], kFrames);
    for (int k = 0; k < kFrames; ++k)
      vector->GetData(i)->value[k].value[0] =
          oradians(last_deg_[i] + (target - last_deg_[i]) * (k + 1) / kFrames);
    last_deg_[i] = target;
  }
  subject[sbjMove]->SetData(command);
  subject[sbjMove]->NotifyObservers();
}
