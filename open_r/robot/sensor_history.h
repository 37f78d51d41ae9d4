// What the robot sensed, in frames of 8 ms, and the vectors of four frames that programs get.
#pragma once

#include <OPENR/ODataFormats.h>
#include <OPENR/RCRegion.h>

#include <array>
#include <vector>

#include "open_r/robot/joint_board.h"

namespace seam::open_r {

inline constexpr int kFramesAVector = 4;

// A reading of one sensor now.
OSensorValue read_sensor(const RobotDesign& design, const JointBoard& joints,
                         const sdk::Sensors& sensors, int primitive);

class SensorHistory {
 public:
  SensorHistory(const RobotDesign& design, const JointBoard& joints)
      : design_(design), joints_(joints) {}

  void sample(int64_t frame, const sdk::Sensors& sensors);
  // Whether `frame` was the last one of a vector.
  static bool completes_vector(int64_t frame) {
    return frame % kFramesAVector == kFramesAVector - 1;
  }
  // The vector that ends with the newest frame, with one reference; the caller's.
  RCRegion* make_vector() const;

 private:
  const RobotDesign& design_;
  const JointBoard& joints_;
  int64_t newest_ = -1;
  std::array<std::vector<OSensorValue>, kFramesAVector> frames_;  // By frame modulo 4.
};

}  // namespace seam::open_r
