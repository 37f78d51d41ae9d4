#include "Localizer.h"

#include <OPENR/OFbkImage.h>
#include <OPENR/OPENRAPI.h>
#include <OPENR/OUnits.h>
#include <OPENR/core_macro.h>

#include <cmath>
#include <sstream>
#include <string>
#include <vector>

using seam::sdk::ColourMask;
using seam::sdk::HeadAngles;

namespace {

const char* const kLocators[] = {"PRM:/r1/c1-Joint2:j1", "PRM:/r1/c1/c2-Joint2:j2",
                                 "PRM:/r1/c1/c2/c3-Joint2:j3"};
const char* const kCamera = "PRM:/r1/c1/c2/c3/i1-FbkImageSensor:F1";
constexpr double kAmplitude_rad = 1.5, kPeriod_s = 4.0373, kFrame_s = 0.008;
constexpr double kTurn_rad = 6.283185307179586;
constexpr int kWidth_px = 178, kHeight_px = 144;  // Of the camera that the SDK believes in.
constexpr int kLeastArea_px = 4;
constexpr size_t kMemory = 64;  // Frames.

}  // namespace

Localizer::Localizer() : filter_({.particles = 1000, .seed = 1}, seam::sdk::standard_landmarks()) {}

OStatus Localizer::DoInit(const OSystemEvent&) {
  NEW_ALL_SUBJECT_AND_OBSERVER;
  REGISTER_ALL_ENTRY;
  SET_ALL_READY_AND_NOTIFY_ENTRY;
  for (int i = 0; i < kJoints; ++i) {
    if (OPENR::OpenPrimitive(kLocators[i], &joints_[i]) != oSUCCESS) return oFAIL;
    OPENR::EnableJointGain(joints_[i]);
    OPENR::SetDefaultJointGain(joints_[i]);
  }
  if (OPENR::OpenPrimitive(kCamera, &camera_) != oSUCCESS || !SetColours()) return oFAIL;
  for (RCRegion*& command : commands_) {
    MemoryRegionID id;
    OCommandVectorData* data;
    OPENR::NewCommandVectorData(kJoints, &id, &data);
    command = new RCRegion(id, 0, data, data->vectorInfo.totalSize);
  }
  return OPENR::SetMotorPower(opowerON);
}

OStatus Localizer::DoStart(const OSystemEvent&) {
  for (RCRegion* command : commands_) Send(command);
  subject[sbjMove]->NotifyObservers();
  ENABLE_ALL_SUBJECT;
  ASSERT_READY_TO_ALL_OBSERVER;
  return oSUCCESS;
}

OStatus Localizer::DoStop(const OSystemEvent&) {
  const seam::sdk::PoseEstimate at = filter_.estimate();
  OSYSPRINT(("Localizer: %d images, %d matched a sensor frame\n", images_, matched_));
  OSYSPRINT(("Localizer: at %.5f %.5f %.6f from %.5f %.5f %.6f to %.5f %.5f %.6f\n", at.mean.x_m,
             at.mean.y_m, at.mean.theta_rad, at.low.x_m, at.low.y_m, at.low.theta_rad, at.high.x_m,
             at.high.y_m, at.high.theta_rad));
  return oSUCCESS;
}

OStatus Localizer::DoDestroy(const OSystemEvent&) {
  DELETE_ALL_SUBJECT_AND_OBSERVER;
  return oSUCCESS;
}

// A line of the file: channel, segment of Y, Cr max and min, Cb max and min.
bool Localizer::SetColours() {
  ODesignDataID id;
  byte* text;
  size_t size;
  if (OPENR::FindDesignData("COLOURS", &id, &text, &size) != oSUCCESS) return false;
  MemoryRegionID region;
  OCdtVectorData* table;
  OPENR::NewCdtVectorData(&region, &table);
  table->SetNumData(ocdtNUM_CHANNELS);
  for (int c = 0; c < ocdtNUM_CHANNELS; ++c) table->GetInfo(c)->Init(camera_, 1u << c);
  std::istringstream lines(std::string(reinterpret_cast<char*>(text), size));
  for (std::string line; std::getline(lines, line);) {
    int c, y, cr_max, cr_min, cb_max, cb_min;
    std::istringstream words(line);
    if (words >> c >> y >> cr_max >> cr_min >> cb_max >> cb_min)
      table->GetInfo(c)->Set(y, static_cast<byte>(cr_max), static_cast<byte>(cr_min),
                             static_cast<byte>(cb_max), static_cast<byte>(cb_min));
  }
  const OStatus status = OPENR::SetCdtVectorData(region);
  OPENR::DeleteCdtVectorData(region);
  OPENR::DeleteDesignData(id);
  return status == oSUCCESS;
}

void Localizer::MoveOn(const OReadyEvent&) {
  for (RCRegion* command : commands_) {
    if (command->NumberOfReference() > 1) continue;
    Send(command);
    subject[sbjMove]->NotifyObservers();
  }
}

void Localizer::Send(RCRegion* command) {
  auto* vector = reinterpret_cast<OCommandVectorData*>(command->Base());
  vector->SetNumData(kJoints);
  for (int i = 0; i < kJoints; ++i) {
    vector->GetInfo(i)->Set(odataJOINT_COMMAND2, joints_[i], kFrames);
    for (int k = 0; k < kFrames; ++k) {
      const double angle = kTurn_rad * (time_s_ + (k + 1) * kFrame_s) / kPeriod_s;
      // In single precision the sine has the same bits on every machine.
      const double pan_rad = kAmplitude_rad * std::sin(static_cast<float>(angle));
      vector->GetData(i)->value[k].value[0] = i == kPan ? micro(pan_rad) : 0;
    }
  }
  time_s_ += kFrames * kFrame_s;
  subject[sbjMove]->SetData(command);
}

void Localizer::KeepSensors(const ONotifyEvent& event) {
  auto* data = reinterpret_cast<OSensorFrameVectorData*>(event.RCData(0)->Base());
  const OSensorFrameInfo* info = data->GetInfo(0);
  for (size_t k = 0; k < info->numFrames; ++k) {
    const auto angle = [&](int place) {
      return 1e-6f * static_cast<float>(data->GetData(place)->frame[k].value);
    };
    // The head's joints have the first three places of an ERS-210's vector.
    head_[info->frameNumber + static_cast<longword>(k)] = {angle(kTilt), angle(kPan), angle(kRoll)};
  }
  while (head_.size() > kMemory) head_.erase(head_.begin());
  observer[event.ObsIndex()]->AssertReady();
}

void Localizer::SeeImage(const ONotifyEvent& event) {
  auto* data = reinterpret_cast<OFbkImageVectorData*>(event.RCData(0)->Base());
  OFbkImageInfo* info = data->GetInfo(ofbkimageLAYER_C);
  const OFbkImage colours(info, data->GetData(ofbkimageLAYER_C), ofbkimageBAND_CDT);
  ++images_;
  const auto head = head_.find(info->frameNumber);
  if (head != head_.end()) {
    ++matched_;
    const int width = colours.Width(), height = colours.Height();
    std::vector<uint8_t> bits(colours.Pointer(), colours.Pointer() + width * height);
    std::fill(bits.end() - width, bits.end(), 0);  // The last line is no picture.
    const seam::sdk::CameraBelief camera =
        seam::sdk::CameraBelief().of_colours(kWidth_px, kHeight_px, width, height);
    filter_.move(0, 0, 0);
    filter_.observe(seam::sdk::find_landmarks(
        ColourMask{width, height, bits}, [&](float) { return head->second; }, camera, {},
        kLeastArea_px));
  }
  observer[event.ObsIndex()]->AssertReady();
}
