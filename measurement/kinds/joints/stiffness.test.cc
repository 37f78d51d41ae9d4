// Logs whose controllers differ in gain and do not say so, by a motor integrated here in small
// steps.
#include "measurement/kinds/joints/stiffness.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace seam::measurement {
namespace {

constexpr double kNoise_rad = 0.0005;

// Six runs of steps of a joint that gravity and friction hold, with every other run of either gain;
// `duty` at most.
std::string rows_of(double even_gain, double odd_gain, bool told, double most_duty = 10,
                    unsigned seed = 3) {
  std::ranlux48_base random(seed);
  std::normal_distribution<double> noise(0, kNoise_rad);
  std::uniform_real_distribution<double> angle(-1, 1);
  std::string rows =
      std::string("run,time_s,joint,command_rad,measured_rad") + (told ? ",kp\n" : "\n");
  for (int run = 0; run < 6; ++run) {
    const double gain = run % 2 == 0 ? even_gain : odd_gain;
    double q = 0, w = 0, command = 0;
    for (int k = 0; k < 300; ++k) {
      if (k % 50 == 2) command = angle(random);
      rows += fmt::format("{},{:.2f},arm,{:.4f},{:.6f}{}\n", run, 0.01 * k, command,
                          q + noise(random), told ? fmt::format(",{}", gain) : "");
      constexpr int kSteps = 100;
      for (int step = 0; step < kSteps; ++step) {
        const double duty = std::clamp(gain * (command - q), -most_duty, most_duty);
        const double drive = 20 * duty - 8 * w, load = 12 * std::cos(q - 1.5);
        w += 0.01 / kSteps * (drive - load - 3 * std::tanh(w / 0.005));
        q += 0.01 / kSteps * w;
      }
    }
  }
  return rows;
}

JointLogs logs_of(const CsvTable& table) {
  return read_joint_logs(table, "run", true);
}

std::string note_of(const std::string& rows) {
  const CsvTable table = CsvTable::from_text(rows, "joints.csv");
  return note_of_stiffness(table, logs_of(table), kNoise_rad);
}

TEST(Stiffness, ThatOfEachRunIsItsGain) {
  for (const double most_duty : {10.0, 2.0}) {
    const CsvTable table = CsvTable::from_text(rows_of(4, 12, false, most_duty), "joints.csv");
    const std::vector<double> stiffness = stiffness_of(logs_of(table), kNoise_rad);
    ASSERT_EQ(stiffness.size(), 6u);
    for (size_t run = 0; run < 6; ++run)
      EXPECT_NEAR(stiffness[run] / stiffness[0], run % 2 == 0 ? 1 : 3, run % 2 == 0 ? 0.15 : 0.45)
          << run << ", duty " << most_duty;
  }
}

TEST(Stiffness, GainsThatDifferAreMissedByName) {
  const std::string note = note_of(rows_of(4, 12, false));
  EXPECT_TRUE(
      note.starts_with("joints.csv:1: no column kp, and the data show another stiffness in "
                       "other runs: that of line "))
      << note;
  EXPECT_NE(note.find("expected a column kp with the controller's gain in each row"),
            std::string::npos)
      << note;
  EXPECT_EQ(note_of(rows_of(4, 12, true)), "");
  EXPECT_EQ(note_of(rows_of(6, 6, false)), "");
  EXPECT_EQ(note_of(rows_of(6, 6, false, 1)), "");
}

// A hip with this gain and a knee with that one, which move in other ways.
std::string note_of_two(double hip_gain, double knee_gain) {
  std::string rows = rows_of(hip_gain, hip_gain, false);
  const std::string knee = rows_of(knee_gain, knee_gain, false, 10, 4);
  for (size_t at = rows.find("arm"); at != std::string::npos; at = rows.find("arm"))
    rows.replace(at, 3, "hip");
  const CsvTable table = CsvTable::from_text(rows + knee.substr(knee.find('\n') + 1), "joints.csv");
  return note_of_unlike_joints(table, logs_of(table), kNoise_rad);
}

TEST(Stiffness, JointsThatMoveUnlikeEachOtherAreTold) {
  const std::string note = note_of_two(4, 9);
  EXPECT_TRUE(note.starts_with("joints.csv:1: joints arm, hip move unlike each other")) << note;
  EXPECT_NE(note.find("`joint: arm` in measurement.yaml"), std::string::npos) << note;
  EXPECT_EQ(note_of_two(6, 6), "");
}

}  // namespace
}  // namespace seam::measurement
