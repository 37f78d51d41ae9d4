#include "open_r/robot/virtual_robot.h"

#include <algorithm>
#include <utility>

namespace seam::open_r {
namespace {

VirtualRobot* newest = nullptr;

// Entries of the robot's own objects.
enum Entries : Selector {
  kEffectorConnect = 10,
  kEffectorNotify,
  kSensorControl,
  kSensorReady,
  kImageControl,
  kImageReady,
  kSpeakerConnect,
  kSpeakerNotify,
  kMicrophoneControl,
  kMicrophoneReady,
};
// Data that a subject may have on their way to the robot.
constexpr size_t kMostQueued = MAX_NUM_DATA;
constexpr size_t kMicrophoneBytes = 2048;  // 32 ms of 16 kHz, 16 bits, stereo.

OCommandVectorData& commands_in(RCRegion& region) {
  return *reinterpret_cast<OCommandVectorData*>(region.Base());
}

size_t frames_of(OCommandVectorData& vector, int i) {
  const OCommandInfo& info = *vector.GetInfo(i);
  const size_t frames = std::min(info.numFrames, ocommandMAX_FRAMES);
  if (info.type != odataLED_COMMAND2 && info.type != odataLED_COMMAND3) return frames;
  size_t sum = 0;
  for (size_t k = 0; k < frames; ++k) {
    const OCommandValue& value = vector.GetData(i)->value[k];
    const word period = info.type == odataLED_COMMAND2
                            ? reinterpret_cast<const OLEDCommandValue2&>(value).period
                            : reinterpret_cast<const OLEDCommandValue3&>(value).period;
    sum += std::max<size_t>(1, period);
  }
  return sum;
}

int64_t command_frames(RCRegion& region) {
  OCommandVectorData& vector = commands_in(region);
  size_t most = 1;
  for (size_t i = 0; i < std::min(vector.vectorInfo.numData, vector.vectorInfo.maxNumData); ++i)
    most = std::max(most, frames_of(vector, static_cast<int>(i)));
  return static_cast<int64_t>(most);
}

int64_t sound_frames(RCRegion& region) {
  const auto& vector = *reinterpret_cast<const OSoundVectorData*>(region.Base());
  if (vector.vectorInfo.numData == 0) return 1;
  const OSoundInfo& info = vector.info[0];
  const int64_t rate = info.samplingRate == 0 ? 8000 : info.samplingRate;
  const int64_t bytes = std::max(1, info.bitsPerSample / 8) * std::max<int>(1, info.channel);
  const int64_t ns = static_cast<int64_t>(info.dataSize) * 1'000'000'000 / (rate * bytes);
  return (ns + kFrameNs - 1) / kFrameNs;
}

std::string light_name(std::string_view locator) {
  return std::string(locator.substr(locator.rfind('-') + 1));
}

}  // namespace

VirtualRobot& VirtualRobot::current() {
  if (newest == nullptr) throw Fault("a call of OPENR:: outside of an object");
  return *newest;
}

VirtualRobot::VirtualRobot(System& system, RobotOptions options)
    : system_(system),
      options_(std::move(options)),
      design_(robot_design(options_.design)),
      joints_(design_),
      history_(design_, joints_),
      commands_(keys_, command_frames,
                [this](RCRegion& r, int64_t k, int64_t first) { put_command(r, k, first); }),
      sounds_(keys_, sound_frames, [](RCRegion&, int64_t, int64_t) {}),
      before_(std::exchange(newest, this)) {
  for (auto& channel : colours_) channel.fill(ocdtINIT);
  comm_ = system_.add("OVirtualRobotComm",
                      [this](Selector s, void* message) { handle_comm(s, message); });
  audio_ = system_.add("OVirtualRobotAudioComm",
                       [this](Selector s, void* message) { handle_audio(s, message); });
  effector_.SetNotifyEntry({comm_, kEffectorNotify});
  effector_.SetBufCtrlParam(0, 1, kMostQueued);
  sensor_.SetReadyEntry({comm_, kSensorReady});
  image_.SetReadyEntry({comm_, kImageReady});
  speaker_.SetNotifyEntry({audio_, kSpeakerNotify});
  speaker_.SetBufCtrlParam(0, 1, kMostQueued);
  microphone_.SetReadyEntry({audio_, kMicrophoneReady});
  const auto service = [&](OID object, Selector entry, const char* name) {
    system_.register_service({object, entry}, name);
  };
  service(comm_, kEffectorConnect, "OVirtualRobotComm.Effector.OCommandVectorData.O");
  service(comm_, kSensorControl, "OVirtualRobotComm.Sensor.OSensorFrameVectorData.S");
  service(comm_, kImageControl, "OVirtualRobotComm.FbkImageSensor.OFbkImageVectorData.S");
  service(audio_, kSpeakerConnect, "OVirtualRobotAudioComm.Speaker.OSoundVectorData.O");
  service(audio_, kMicrophoneControl, "OVirtualRobotAudioComm.Mic.OSoundVectorData.S");
}

VirtualRobot::~VirtualRobot() {
  newest = before_;
}

void VirtualRobot::handle_comm(Selector selector, void* message) {
  ONotifyEvent event;
  switch (selector) {
    case kEffectorConnect:
      effector_.ConnectHandler(*static_cast<OConnectMessage*>(message));
      break;
    case kEffectorNotify:
      effector_.NotifyHandler(*static_cast<ONotifyMessage*>(message), &event);
      commands_.receive(event);
      break;
    case kSensorControl:
      sensor_.ControlHandler(*static_cast<OControlMessage*>(message));
      break;
    case kSensorReady:
      sensor_.ReadyHandler(*static_cast<OReadyMessage*>(message));
      break;
    case kImageControl:
      image_.ControlHandler(*static_cast<OControlMessage*>(message));
      break;
    case kImageReady:
      image_.ReadyHandler(*static_cast<OReadyMessage*>(message));
      break;
    default:
      break;
  }
}

void VirtualRobot::handle_audio(Selector selector, void* message) {
  ONotifyEvent event;
  switch (selector) {
    case kSpeakerConnect:
      speaker_.ConnectHandler(*static_cast<OConnectMessage*>(message));
      break;
    case kSpeakerNotify:
      speaker_.NotifyHandler(*static_cast<ONotifyMessage*>(message), &event);
      sounds_.receive(event);
      break;
    case kMicrophoneControl:
      microphone_.ControlHandler(*static_cast<OControlMessage*>(message));
      break;
    case kMicrophoneReady:
      microphone_.ReadyHandler(*static_cast<OReadyMessage*>(message));
      break;
    default:
      break;
  }
}

void VirtualRobot::start() {
  effector_.AssertReady();
  speaker_.AssertReady();
}

void VirtualRobot::look(const sdk::Observation& seen) {
  sensors_ = seen.sensors;
  joints_.sense(seen.sensors.joints);
  system_.set_now_ns(seen.time_ns);
}

// ---- Turns ----

TurnOrders VirtualRobot::turn(const sdk::Observation& seen) {
  const int64_t now = seen.time_ns / kFrameNs;
  // Later turns may be far apart: a robot that was frozen comes back.
  const bool second = last_frame_ >= 0 && last_frame_ == first_frame_;
  if (seen.time_ns % kFrameNs != 0 || now <= last_frame_ || (second && now != last_frame_ + 1))
    throw Fault("a turn at " + std::to_string(seen.time_ns) +
                " ns, expected one each 8 ms: the scenario says behaviour: {clock: {period_s: "
                "0.008}}");
  if (first_frame_ < 0) first_frame_ = now;
  const int64_t first = last_frame_ < 0 ? now : last_frame_ + 1;
  // Frames that passed without a turn, such as while the robot was frozen: sensors, no orders.
  const std::vector<sdk::JointAngles>& log = seen.sensors.joint_log;
  for (int64_t number = first; number <= now; ++number) {
    sensors_ = seen.sensors;
    const auto reading = std::find_if(log.begin(), log.end(), [&](const sdk::JointAngles& r) {
      return r.time_ns / kFrameNs >= number;
    });
    joints_.sense(reading == log.end() ? seen.sensors.joints : *reading);
    history_.sample(number, sensors_);
    system_.set_now_ns(number * kFrameNs);
    frame(number, number == now ? seen.frames : std::vector<sdk::Frame>());
  }
  last_frame_ = now;
  if (!over_) orders_.joints = joints_.take_orders();
  orders_.warnings = joints_.take_warnings();
  return std::exchange(orders_, {});
}

void VirtualRobot::frame(int64_t number, const std::vector<sdk::Frame>& images) {
  commands_.finish(number, effector_);
  sounds_.finish(number, speaker_);
  if (SensorHistory::completes_vector(number)) {
    RCRegion* vector = history_.make_vector();
    sensor_.SetData(vector);
    sensor_.NotifyObservers();
    vector->RemoveReference();
    send_microphone();
  }
  // Behind the sensors: a program that looks up an image's frame finds it.
  for (const sdk::Frame& image : images) send_image(image);
  system_.deliver();
  commands_.put(number);
  sounds_.put(number);
}

void VirtualRobot::put_command(RCRegion& region, int64_t index, int64_t first) {
  OCommandVectorData& vector = commands_in(region);
  const size_t count = std::min(vector.vectorInfo.numData, vector.vectorInfo.maxNumData);
  for (size_t i = 0; i < count; ++i) {
    OCommandInfo& info = *vector.GetInfo(static_cast<int>(i));
    if (info.primitiveID >= design_.primitives.size()) continue;
    const int primitive = static_cast<int>(info.primitiveID);
    const Primitive& spec = design_.primitives[info.primitiveID];
    OCommandData& data = *vector.GetData(static_cast<int>(i));
    const size_t frames = std::min(info.numFrames, ocommandMAX_FRAMES);
    if (index == 0) info.frameNumber = static_cast<longword>(first);
    if (info.type == odataLED_COMMAND2 || info.type == odataLED_COMMAND3) {
      size_t k = 0;
      for (int64_t at = index; k < frames; ++k) {
        at -= std::max<int64_t>(1, reinterpret_cast<OLEDCommandValue2*>(data.value)[k].period);
        if (at < 0) break;
      }
      if (k == frames) continue;
      put_light(primitive, light_name(spec.locator),
                info.type == odataLED_COMMAND2
                    ? reinterpret_cast<OLEDCommandValue2*>(data.value)[k].led
                    : reinterpret_cast<OLEDCommandValue3*>(data.value)[k].intensity);
      continue;
    }
    if (static_cast<size_t>(index) >= frames) continue;
    const slongword value = data.value[index].value[0];
    if (spec.quantity == Quantity::joint && info.type == odataJOINT_COMMAND2)
      joints_.command(primitive, value);
    else if (spec.quantity == Quantity::ear)
      put_light(primitive, light_name(spec.locator), value);
  }
}

void VirtualRobot::put_light(int primitive, const std::string& name, double value) {
  const auto known = lights_.find(primitive);
  if (known != lights_.end() && known->second == value) return;
  lights_[primitive] = value;
  orders_.values[name] = value;
}

void VirtualRobot::send_image(const sdk::Frame& image) {
  if (!wants_images()) return;
  const int camera = static_cast<int>(
      std::find_if(design_.primitives.begin(), design_.primitives.end(),
                   [](const Primitive& p) { return p.quantity == Quantity::camera; }) -
      design_.primitives.begin());
  RCRegion* vector =
      make_image_vector(image, camera_settings, colours_, static_cast<OPrimitiveID>(camera),
                        frame_number_of(image), image_counter_++);
  image_.SetData(vector);
  image_.NotifyObservers();
  vector->RemoveReference();
}

void VirtualRobot::send_microphone() {
  if (microphone_.NumberOfObservers() == 0) return;
  RCRegion* vector = new_vector(sound_layout(1, kMicrophoneBytes));
  auto* data = reinterpret_cast<OSoundVectorData*>(vector->Base());
  data->SetNumData(1);
  OSoundInfo& info = *data->GetInfo(0);
  info.Set(odataSOUND, oprimitiveID_UNDEF, kMicrophoneBytes);
  info.format = osoundformatPCM;
  info.channel = osoundchannelSTEREO;
  info.samplingRate = 16000;
  info.bitsPerSample = 16;
  microphone_.SetData(vector);
  microphone_.NotifyObservers();
  vector->RemoveReference();
}

// ---- Power ----

OPowerStatus VirtualRobot::power_status() const {
  OPowerStatus status;
  status.robotStatus = orsbBATTERY_CONNECTED | orsbBATTERY_CAPACITY_FULL | orsbOPEN_R_POWER_GOOD |
                       orsbPLUNGER | (joints_.power() ? orsbMOTOR_POWER : 0);
  status.batteryStatus = obsbINITIALIZED | obsbDISCHARGING | obsbFULLY_CHARGED;
  status.remainingCapacity = 100;
  status.temperature = 3032;  // 30 degrees Celsius.
  status.fullyChargedCapacity = 1800;
  status.voltage = 8400;
  status.current = joints_.power() ? -1000 : -500;
  status.timeDif = time_difference;
  status.volume = volume;
  return status;
}

void VirtualRobot::report_power(const OPowerStatus& before) {
  const OPowerStatus now = power_status();
  for (const Watch& watch : watches_) {
    const bool reports =
        (before.robotStatus ^ now.robotStatus) & watch.changes.robotStatus ||
        (before.batteryStatus ^ now.batteryStatus) & watch.changes.batteryStatus ||
        (before.volume != now.volume && (watch.changes.volume == opsoVOLUME_NOTIFY_EVERY_CHANGE ||
                                         watch.changes.volume == now.volume)) ||
        (before.timeDif != now.timeDif &&
         (watch.changes.timeDif == opsoTIME_DIF_NOTIFY_EVERY_CHANGE ||
          watch.changes.timeDif == now.timeDif));
    if (!reports) continue;
    auto message = std::make_shared<OPowerStatusMessage>();
    message->powerStatus = now;
    system_.post(watch.entry, message);
  }
}

}  // namespace seam::open_r
