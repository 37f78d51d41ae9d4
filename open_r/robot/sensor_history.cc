#include "open_r/robot/sensor_history.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "open_r/robot/vector_memory.h"

namespace seam::open_r {
namespace {

constexpr double kFarthest_m = 0.9;  // What the distance sensor says of nothing.
constexpr double kTemperature_C = 30;

slongword millionths(double value) {
  return static_cast<slongword>(std::lround(value * 1e6));
}

// Axes 0 to 2: backward, left, down.
double acceleration(const sdk::Vector3d& a, int axis) {
  return axis == 0 ? -a.x : axis == 1 ? a.y : -a.z;
}

ODataType type_of(Quantity quantity) {
  switch (quantity) {
    case Quantity::joint:
      return odataJOINT_VALUE;
    case Quantity::distance:
      return odataLENGTH;
    case Quantity::acceleration:
      return odataACCELERATION;
    case Quantity::temperature:
      return odataTEMPERATURE;
    default:
      return odataSWITCH;
  }
}

}  // namespace

OSensorValue read_sensor(const RobotDesign& design, const JointBoard& joints,
                         const sdk::Sensors& sensors, int primitive) {
  OSensorValue value{};
  const Primitive& spec = design.primitives[static_cast<size_t>(primitive)];
  switch (spec.quantity) {
    case Quantity::joint: {
      const OJointValue joint = joints.value(primitive);
      static_assert(sizeof joint == sizeof value);
      std::memcpy(&value, &joint, sizeof value);
      break;
    }
    case Quantity::distance:
      value.value = millionths(kFarthest_m);
      break;
    case Quantity::acceleration:
      value.value = millionths(acceleration(sensors.acceleration_m_s2, spec.index));
      break;
    case Quantity::temperature:
      value.value = millionths(kTemperature_C);
      break;
    case Quantity::paw:
      value.value = sensors.paw_contact[static_cast<size_t>(spec.index)] ? oswitchON : oswitchOFF;
      value.signal = value.value == 0 ? 0 : 1023;
      break;
    default:
      break;
  }
  return value;
}

void SensorHistory::sample(int64_t frame, const sdk::Sensors& sensors) {
  std::vector<OSensorValue>& values = frames_[static_cast<size_t>(frame % kFramesAVector)];
  values.clear();
  for (const int primitive : design_.sensors)
    values.push_back(read_sensor(design_, joints_, sensors, primitive));
  // A run that begins within a vector has no older frames: they are as the first.
  if (newest_ < 0) frames_.fill(std::vector<OSensorValue>(values));
  newest_ = frame;
}

RCRegion* SensorHistory::make_vector() const {
  const size_t count = design_.sensors.size();
  RCRegion* region = new_vector(sensor_layout(count));
  auto* vector = reinterpret_cast<OSensorFrameVectorData*>(region->Base());
  vector->SetNumData(count);
  for (size_t i = 0; i < count; ++i) {
    OSensorFrameInfo* info = vector->GetInfo(static_cast<int>(i));
    const int primitive = design_.sensors[i];
    info->Set(type_of(design_.primitives[static_cast<size_t>(primitive)].quantity),
              static_cast<OPrimitiveID>(primitive), kFramesAVector);
    info->frameNumber = static_cast<longword>(std::max<int64_t>(0, newest_ - kFramesAVector + 1));
    for (size_t frame = 0; frame < kFramesAVector; ++frame)
      vector->GetData(static_cast<int>(i))->frame[frame] = frames_[frame][i];
  }
  return region;
}

}  // namespace seam::open_r
