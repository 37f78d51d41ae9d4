#include "open_r/robot/primitives.h"

#include <array>

#include "open_r/library/system.h"

namespace seam::open_r {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180;

constexpr Primitive joint(std::string_view locator, int index, JointGain gain, double speed,
                          double min_deg, double max_deg) {
  return {locator, Quantity::joint, index, gain, speed, min_deg * kDegree, max_deg * kDegree};
}
constexpr Primitive other(std::string_view locator, Quantity quantity, int index = -1) {
  return {.locator = locator, .quantity = quantity, .index = index};
}

// Ranges are those of the software, speeds those of models/robot_ers210.yaml.
constexpr JointGain kTilt{0x0a, 0x08, 0x0c}, kPan{0x0d, 0x08, 0x0b}, kRoll{0x0a, 0x08, 0x0c},
    kRotator{0x16, 0x04, 0x08}, kElevator{0x14, 0x04, 0x06}, kKnee{0x23, 0x04, 0x05},
    kMouth{0x0e, 0x08, 0x10, 0x0f, 0x02, 0x0f}, kTail{0x0a, 0x00, 0x18};
constexpr double kRotatorSpeed = 2.814, kElevatorSpeed = 2.498, kKneeSpeed = 2.836,
                 kTiltSpeed = 2.104867, kPanSpeed = 3.010693, kSmallSpeed = 10;

constexpr std::array<Primitive, 45> kErs210 = {
    // The first 31 have the places of the sensor vector.
    joint("PRM:/r1/c1-Joint2:j1", 0, kTilt, kTiltSpeed, -82, 43),
    joint("PRM:/r1/c1/c2-Joint2:j2", 1, kPan, kPanSpeed, -89.6, 89.6),
    joint("PRM:/r1/c1/c2/c3-Joint2:j3", 2, kRoll, kPanSpeed, -29, 29),
    other("PRM:/r1/c1/c2/c3/f1-Sensor:f1", Quantity::touch),
    other("PRM:/r1/c1/c2/c3/f2-Sensor:f2", Quantity::touch),
    other("PRM:/r1/c1/c2/c3/p1-Sensor:p1", Quantity::distance),
    joint("PRM:/r1/c1/c2/c3/c4-Joint2:j4", -1, kMouth, kSmallSpeed, -47, -3),
    other("PRM:/r1/c1/c2/c3/c4/s5-Sensor:s5", Quantity::touch),
    joint("PRM:/r2/c1-Joint2:j1", 3, kRotator, kRotatorSpeed, -117, 117),
    joint("PRM:/r2/c1/c2-Joint2:j2", 4, kElevator, kElevatorSpeed, -11, 89),
    joint("PRM:/r2/c1/c2/c3-Joint2:j3", 5, kKnee, kKneeSpeed, -27, 147),
    other("PRM:/r2/c1/c2/c3/c4-Sensor:s4", Quantity::paw, 0),
    joint("PRM:/r3/c1-Joint2:j1", 9, kRotator, kRotatorSpeed, -117, 117),
    joint("PRM:/r3/c1/c2-Joint2:j2", 10, kElevator, kElevatorSpeed, -11, 89),
    joint("PRM:/r3/c1/c2/c3-Joint2:j3", 11, kKnee, kKneeSpeed, -27, 147),
    other("PRM:/r3/c1/c2/c3/c4-Sensor:s4", Quantity::paw, 2),
    joint("PRM:/r4/c1-Joint2:j1", 6, kRotator, kRotatorSpeed, -117, 117),
    joint("PRM:/r4/c1/c2-Joint2:j2", 7, kElevator, kElevatorSpeed, -11, 89),
    joint("PRM:/r4/c1/c2/c3-Joint2:j3", 8, kKnee, kKneeSpeed, -27, 147),
    other("PRM:/r4/c1/c2/c3/c4-Sensor:s4", Quantity::paw, 1),
    joint("PRM:/r5/c1-Joint2:j1", 12, kRotator, kRotatorSpeed, -117, 117),
    joint("PRM:/r5/c1/c2-Joint2:j2", 13, kElevator, kElevatorSpeed, -11, 89),
    joint("PRM:/r5/c1/c2/c3-Joint2:j3", 14, kKnee, kKneeSpeed, -27, 147),
    other("PRM:/r5/c1/c2/c3/c4-Sensor:s4", Quantity::paw, 3),
    joint("PRM:/r6/c1-Joint2:j1", -1, kTail, kSmallSpeed, -22, 22),
    joint("PRM:/r6/c2-Joint2:j2", -1, kTail, kSmallSpeed, -22, 22),
    other("PRM:/r6/t1-Sensor:t1", Quantity::temperature),
    other("PRM:/r6/s1-Sensor:s1", Quantity::touch),
    other("PRM:/a1-Sensor:a1", Quantity::acceleration, 0),
    other("PRM:/a2-Sensor:a2", Quantity::acceleration, 1),
    other("PRM:/a3-Sensor:a3", Quantity::acceleration, 2),
    // What is sent nothing.
    other("PRM:/r1/c1/c2/c3/i1-FbkImageSensor:F1", Quantity::camera),
    other("PRM:/r1/c1/c2/c3/s1-Speaker:S1", Quantity::speaker),
    other("PRM:/r1/c1/c2/c3/m1-Mic:M1", Quantity::microphone),
    other("PRM:/r1/c1/c2/c3/e1-Joint3:j5", Quantity::ear),
    other("PRM:/r1/c1/c2/c3/e2-Joint3:j6", Quantity::ear),
    other("PRM:/r1/c1/c2/c3/l1-LED2:l1", Quantity::led),
    other("PRM:/r1/c1/c2/c3/l2-LED2:l2", Quantity::led),
    other("PRM:/r1/c1/c2/c3/l3-LED2:l3", Quantity::led),
    other("PRM:/r1/c1/c2/c3/l4-LED2:l4", Quantity::led),
    other("PRM:/r1/c1/c2/c3/l5-LED2:l5", Quantity::led),
    other("PRM:/r1/c1/c2/c3/l6-LED2:l6", Quantity::led),
    other("PRM:/r1/c1/c2/c3/l7-LED2:l7", Quantity::led),
    other("PRM:/r6/l1-LED2:l1", Quantity::led),
    other("PRM:/r6/l2-LED2:l2", Quantity::led),
};
constexpr int kErs210Sensors = 31;

// An ERS-7's gains and ranges are those of the ERS-210's joints that it drives: the simulated body
// is an ERS-210's. Its second tilt of the neck is not modelled.
constexpr std::array<Primitive, 70> kErs7 = {
    // The first 34 have the places of the sensor vector.
    joint("PRM:/r1/c1/c2/c3/c4-Joint2:14", -1, kMouth, kSmallSpeed, -58, -3),
    other("PRM:/r1/c1/c2/c3/c4/s5-Sensor:s5", Quantity::touch),
    joint("PRM:/r1/c1/c2/c3-Joint2:13", -1, kTilt, kTiltSpeed, -20, 50),
    other("PRM:/r1/c1/c2/c3/t1-Sensor:t1", Quantity::touch),
    other("PRM:/r1/c1/c2/c3/p1-Sensor:p1", Quantity::distance),
    other("PRM:/r1/c1/c2/c3/p2-Sensor:p2", Quantity::distance),
    joint("PRM:/r1/c1/c2-Joint2:12", 1, kPan, kPanSpeed, -93, 93),
    joint("PRM:/r1/c1-Joint2:11", 0, kTilt, kTiltSpeed, -79, 2),
    other("PRM:/r2/c1/c2/c3/c4-Sensor:24", Quantity::paw, 0),
    joint("PRM:/r2/c1/c2/c3-Joint2:23", 5, kKnee, kKneeSpeed, -30, 127),
    joint("PRM:/r2/c1/c2-Joint2:22", 4, kElevator, kElevatorSpeed, -15, 93),
    joint("PRM:/r2/c1-Joint2:21", 3, kRotator, kRotatorSpeed, -120, 135),
    other("PRM:/r3/c1/c2/c3/c4-Sensor:34", Quantity::paw, 2),
    joint("PRM:/r3/c1/c2/c3-Joint2:33", 11, kKnee, kKneeSpeed, -30, 127),
    joint("PRM:/r3/c1/c2-Joint2:32", 10, kElevator, kElevatorSpeed, -15, 93),
    joint("PRM:/r3/c1-Joint2:31", 9, kRotator, kRotatorSpeed, -135, 120),
    other("PRM:/r4/c1/c2/c3/c4-Sensor:44", Quantity::paw, 1),
    joint("PRM:/r4/c1/c2/c3-Joint2:43", 8, kKnee, kKneeSpeed, -30, 127),
    joint("PRM:/r4/c1/c2-Joint2:42", 7, kElevator, kElevatorSpeed, -15, 93),
    joint("PRM:/r4/c1-Joint2:41", 6, kRotator, kRotatorSpeed, -120, 135),
    other("PRM:/r5/c1/c2/c3/c4-Sensor:54", Quantity::paw, 3),
    joint("PRM:/r5/c1/c2/c3-Joint2:53", 14, kKnee, kKneeSpeed, -30, 127),
    joint("PRM:/r5/c1/c2-Joint2:52", 13, kElevator, kElevatorSpeed, -15, 93),
    joint("PRM:/r5/c1-Joint2:51", 12, kRotator, kRotatorSpeed, -135, 120),
    joint("PRM:/r6/c1-Joint2:61", -1, kTail, kSmallSpeed, 0, 65),
    joint("PRM:/r6/c2-Joint2:62", -1, kTail, kSmallSpeed, -59, 59),
    other("PRM:/a1-Sensor:a1", Quantity::acceleration, 0),
    other("PRM:/a2-Sensor:a2", Quantity::acceleration, 1),
    other("PRM:/a3-Sensor:a3", Quantity::acceleration, 2),
    other("PRM:/p1-Sensor:p1", Quantity::distance),
    other("PRM:/b1-Sensor:b1", Quantity::touch),
    other("PRM:/t2-Sensor:t2", Quantity::touch),
    other("PRM:/t3-Sensor:t3", Quantity::touch),
    other("PRM:/t4-Sensor:t4", Quantity::touch),
    // What is sent nothing.
    other("PRM:/r1/c1/c2/c3/i1-FbkImageSensor:F1", Quantity::camera),
    other("PRM:/s1-Speaker:S1", Quantity::speaker),
    other("PRM:/r1/c1/c2/c3/m1-Mic:M1", Quantity::microphone),
    other("PRM:/r1/c1/c2/c3/e5-Joint4:15", Quantity::ear),
    other("PRM:/r1/c1/c2/c3/e6-Joint4:16", Quantity::ear),
    other("PRM:/r1/c1/c2/c3/l1-LED2:l1", Quantity::led),
    other("PRM:/r1/c1/c2/c3/l2-LED2:l2", Quantity::led),
    other("PRM:/r1/c1/c2/c3/l3-LED2:l3", Quantity::led),
    other("PRM:/r1/c1/c2/c3/l4-LED2:l4", Quantity::led),
    other("PRM:/r1/c1/c2/c3/l5-LED2:l5", Quantity::led),
    other("PRM:/r1/c1/c2/c3/l6-LED2:l6", Quantity::led),
    other("PRM:/r1/c1/c2/c3/la-LED3:la", Quantity::led),
    other("PRM:/r1/c1/c2/c3/lb-LED3:lb", Quantity::led),
    other("PRM:/r1/c1/c2/c3/lc-LED3:lc", Quantity::led),
    other("PRM:/r1/c1/c2/c3/ld-LED3:ld", Quantity::led),
    other("PRM:/r1/c1/c2/c3/le-LED3:le", Quantity::led),
    other("PRM:/r1/c1/c2/c3/lf-LED3:lf", Quantity::led),
    other("PRM:/r1/c1/c2/c3/lg-LED3:lg", Quantity::led),
    other("PRM:/r1/c1/c2/c3/lh-LED3:lh", Quantity::led),
    other("PRM:/r1/c1/c2/c3/li-LED3:li", Quantity::led),
    other("PRM:/r1/c1/c2/c3/lj-LED3:lj", Quantity::led),
    other("PRM:/r1/c1/c2/c3/lk-LED3:lk", Quantity::led),
    other("PRM:/r1/c1/c2/c3/ll-LED3:ll", Quantity::led),
    other("PRM:/r1/c1/c2/c3/lm-LED3:lm", Quantity::led),
    other("PRM:/r1/c1/c2/c3/ln-LED3:ln", Quantity::led),
    other("PRM:/lu-LED3:lu", Quantity::led),
    other("PRM:/lv-LED3:lv", Quantity::led),
    other("PRM:/lw-LED3:lw", Quantity::led),
    other("PRM:/lx-LED3:lx", Quantity::led),
    other("PRM:/ly-LED3:ly", Quantity::led),
    other("PRM:/lz-LED3:lz", Quantity::led),
    other("PRM:/lp-LED2:lp", Quantity::led),
    other("PRM:/lq-LED2:lq", Quantity::led),
    other("PRM:/lr-LED2:lr", Quantity::led),
    other("PRM:/ls-LED2:ls", Quantity::led),
    other("PRM:/lt-LED2:lt", Quantity::led),
};
constexpr int kErs7Sensors = 34;

std::vector<int> first(int count) {
  std::vector<int> numbers;
  for (int i = 0; i < count; ++i) numbers.push_back(i);
  return numbers;
}

}  // namespace

const RobotDesign& robot_design(std::string_view name) {
  static const RobotDesign ers210{"ERS-210", kErs210, first(kErs210Sensors)};
  static const RobotDesign ers7{"ERS-7", kErs7, first(kErs7Sensors)};
  if (name == ers210.name) return ers210;
  if (name == ers7.name) return ers7;
  throw Fault("no robot design '" + std::string(name) + "', expected ERS-210 or ERS-7");
}

int find_primitive(const RobotDesign& design, std::string_view locator) {
  for (size_t i = 0; i < design.primitives.size(); ++i)
    if (design.primitives[i].locator == locator) return static_cast<int>(i);
  return -1;
}

}  // namespace seam::open_r
