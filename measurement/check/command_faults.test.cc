// A joint that counts the other way, and rows without a drive, are asked for; good logs are not.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <numbers>

#include "measurement/check/faults.h"

namespace seam::measurement {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class CommandFaults : public testing::Test {
 protected:
  CommandFaults() { fs::create_directories(folder_); }
  ~CommandFaults() override { fs::remove_all(folder_); }

  struct Sample {
    double command_rad, measured_rad;
    bool enabled = true;
  };
  // A servo that lags behind a sum of sines by 50 ms, unless `change` makes it another.
  MeasurementSet servo(const std::function<void(int, Sample&)>& change) const {
    std::string text = "run,time_s,joint,command_rad,measured_rad,torque_enable\n";
    for (int k = 0; k < 400; ++k) {
      const auto path = [](double t) { return 0.5 * std::sin(2 * t) + 0.2 * std::sin(5 * t); };
      Sample sample{path(0.01 * k), path(0.01 * k - 0.05)};
      change(k, sample);
      text += fmt::format("a,{:.2f},pan,{:.9f},{:.9f},{:d}\n", 0.01 * k, sample.command_rad,
                          sample.measured_rad, sample.enabled);
    }
    std::ofstream(folder_ / "joints.csv") << text;
    std::ofstream(folder_ / "measurement.yaml")
        << "format: seam-measurement/1\nkind: joints\nfiles: {joints: joints.csv}\n";
    return MeasurementSet::open(folder_);
  }

  const fs::path folder_ =
      fs::path(testing::TempDir()) / testing::UnitTest::GetInstance()->current_test_info()->name();
};

TEST_F(CommandFaults, AJointThatCountsTheOtherWayIsTold) {
  const auto told = ElementsAre(testing::AllOf(
      HasSubstr("joints.csv:2 (run a, joint pan)"), HasSubstr("joint pan follows its command with"),
      HasSubstr("does one of the two columns count the other way?"), HasSubstr("--reverse pan")));
  const auto turned = servo([](int, Sample& s) { s.measured_rad *= -1; });
  EXPECT_THAT(faults_of_values(turned), told);
  // An encoder that counts down from a whole turn, coarse and noisy.
  const auto down = servo([](int k, Sample& s) {
    s.command_rad += 3;
    s.measured_rad = 2 * std::numbers::pi - 3 - s.measured_rad + 0.02 * std::sin(17 * k);
  });
  EXPECT_THAT(faults_of_values(down), told);
  // Steps, some of which the joint does not reach.
  const auto steps = servo([](int k, Sample& s) {
    s.command_rad = k / 40 % 2 == 0 ? 0.5 : -0.3;
    s.measured_rad = -s.command_rad * (1 - std::exp(-0.05 * (k % 40)));
  });
  EXPECT_THAT(faults_of_values(steps), told);
  // As it is in good data: a late and weak servo, noise of a joint that does not move.
  const auto late = servo([](int k, Sample& s) {
    s.measured_rad = 0.5 * std::sin(0.02 * k - 1) + 0.2 * std::sin(0.05 * k - 2);
  });
  EXPECT_THAT(faults_of_values(late), IsEmpty());
  // A sine whose half period looks more alike, turned over, than a lag between two rows.
  const auto sine = servo([](int k, Sample& s) {
    s.command_rad = 0.5 * std::sin(0.2 * k), s.measured_rad = 0.48 * std::sin(0.2 * k - 0.1);
  });
  EXPECT_THAT(faults_of_values(sine), IsEmpty());
  const auto still =
      servo([](int k, Sample& s) { s.measured_rad = 1e-4 * std::sin(37.0 * k * k); });
  EXPECT_THAT(faults_of_values(still), IsEmpty());
}

// A log whose command reads 0 where nothing drives the joint.
TEST_F(CommandFaults, ACommandOfZeroWhereTheDriveIsOffIsAskedFor) {
  const auto is_off = [](int k) { return k % 100 > 60; };
  const auto off = [&](bool marked) {
    return faults_of_values(servo([&](int k, Sample& s) {
      const int held = is_off(k) ? k / 100 * 100 + 60 : k;
      s.measured_rad = 2 + 0.5 * std::sin(0.02 * held - 0.1);
      s.command_rad = is_off(k) ? 0 : 2 + 0.5 * std::sin(0.02 * k);
      s.enabled = !(marked && is_off(k));
    }));
  };
  EXPECT_THAT(off(false), ElementsAre(testing::AllOf(
                              HasSubstr("command_rad is 0 in 156 rows"),
                              HasSubstr("(lines 63-101, 163-201, 263-301, 363-401)"),
                              HasSubstr("torque_enable 0"), HasSubstr("--off-where command=0"))));
  // Marked, the rows are nobody's fault.
  EXPECT_THAT(off(true), IsEmpty());
  // A servo that is commanded to 0 and goes there, at once or slowly, up to the log's last rows.
  for (const double slow : {0.3, 0.02}) {
    double q = 0;
    const auto goes = servo([&](int k, Sample& s) {
      s.command_rad = k / 100 % 2 == 0 && k < 395 ? 0.8 : 0;
      s.measured_rad = q;
      q += slow * (s.command_rad - q);
    });
    EXPECT_THAT(faults_of_values(goes), IsEmpty()) << slow;
  }
}

}  // namespace
}  // namespace seam::measurement
