// The primitives of a robot design: what a locator names, and where it stands in the sensor vector.
#pragma once

#include <OPENR/ODataFormats.h>

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace seam::open_r {

enum class Quantity {
  none,
  joint,
  led,
  ear,  // One of two positions.
  touch,
  paw,
  distance,
  acceleration,
  temperature,
  camera,
  speaker,
  microphone,
};

struct JointGain {
  word p = 0, i = 0, d = 0;
  word p_shift = 0x0e, i_shift = 0x02, d_shift = 0x0f;
};

struct Primitive {
  std::string_view locator;
  Quantity quantity = Quantity::none;
  // Of a joint its number in the simulator, of a paw its leg, of an acceleration its axis. -1: a
  // joint that the simulator does not have: it goes where it is sent at once.
  int index = -1;
  JointGain gain;          // Of a joint.
  double speed_radps = 0;  // Of a joint: its top speed.
  double min_rad = 0, max_rad = 0;
};

struct RobotDesign {
  std::string_view name;  // "ERS-210"
  std::span<const Primitive> primitives;
  // Numbers of primitives in the order of the sensor vector's places.
  std::vector<int> sensors;
};

// Throws Fault for a design that is not known.
const RobotDesign& robot_design(std::string_view name);

// The number of the primitive with this locator, -1 where there is none.
int find_primitive(const RobotDesign& design, std::string_view locator);

}  // namespace seam::open_r
