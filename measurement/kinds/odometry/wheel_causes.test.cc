// Wheels whose radius depends on speed or load, encoders that are read one after the other, a
// marker that is turned: found by their names in sets that are made here by formulas of their own,
// and not where there are none.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "effects/registry.h"
#include "measurement/kinds/odometry/odometry.h"
#include "measurement/search/search.h"
#include "sim_core/base/output.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

namespace fs = std::filesystem;

struct Causes {
  std::string name;
  double growth = 0, load = 0, right_late_s = 0, yaw_rad = 0;
  double carpet = 0;  // A share of the way, where x is above the start's.
  uint64_t seed = 1;
};

constexpr double kWheelBase_m = 0.3, kWheelTick_m = 5e-5, kFine_s = 0.001;
constexpr size_t kDriveRuns = 6, kDriveRows = 200, kFineInRow = 50;

// Ways and turns that speed up and slow down, by small steps; a row each 50 ms.
class MadeDrive {
 public:
  explicit MadeDrive(const Causes& causes) : causes_(causes) {
    fs::create_directories(folder());
    for (uint64_t run = 0; run < kDriveRuns; ++run) drive(run);
    write_file_atomically(folder() / "odometry.csv", rows_);
    write_file_atomically(folder() / "measurement.yaml",
                          "format: seam-measurement/1\nkind: odometry\nnoise: {x_m: 0.001, y_m: "
                          "0.001, theta_rad: 0.002}\nfiles: {odometry: odometry.csv}\n");
  }
  fs::path folder() const { return fs::path(testing::TempDir()) / ("wheels-" + causes_.name); }

 private:
  void drive(uint64_t run) {
    const auto draw = [&](uint64_t stream, uint64_t k) {
      return normal({causes_.seed, 100 * run + stream}, k);
    };
    const double late_s = causes_.right_late_s;
    const auto late = static_cast<std::ptrdiff_t>(std::lround(late_s / kFine_s));
    const size_t steps = kDriveRows * kFineInRow + 100;
    std::vector<double> left = {0}, right = {0};
    std::vector<std::array<double, 3>> pose = {{0, 0, draw(0, 0)}};
    double v = 0, omega = 0, to_v = 0, to_omega = 0;
    for (size_t k = 0; k < steps; ++k) {
      if (k % 1200 == 300) to_v = 0.2 + 0.12 * draw(1, k), to_omega = 0.7 * draw(2, k);
      v += std::clamp(to_v - v, -0.0005, 0.0005);
      omega += std::clamp(to_omega - omega, -0.003, 0.003);
      const double a = v - 0.5 * kWheelBase_m * omega, b = v + 0.5 * kWheelBase_m * omega;
      left.push_back(left.back() + kFine_s * a), right.push_back(right.back() + kFine_s * b);
      const double inner = causes_.load * v * omega;
      const double on_left = a * (1 + causes_.growth * std::abs(a) + inner);
      const double on_right = b * (1 + causes_.growth * std::abs(b) - inner);
      const double turn = kFine_s * (on_right - on_left) / kWheelBase_m;
      const double rolled = kFine_s * 0.5 * (on_left + on_right);
      const auto [x, y, theta] = pose.back();
      const double way = rolled * (1 + (x > 0 ? causes_.carpet : 0));
      pose.push_back({x + way * std::cos(theta + 0.5 * turn),
                      y + way * std::sin(theta + 0.5 * turn), theta + turn});
    }
    double left_before = 0, right_before = 0;
    for (size_t row = 0; row < kDriveRows; ++row) {
      const auto k = static_cast<std::ptrdiff_t>(row * kFineInRow);
      const double left_now = std::round(left[static_cast<size_t>(k)] / kWheelTick_m);
      const double right_now = std::round(
          right[static_cast<size_t>(std::max<std::ptrdiff_t>(0, k + late))] / kWheelTick_m);
      const auto& [x, y, theta] = pose[static_cast<size_t>(k)];
      rows_ += fmt::format(
          "{},{:.2f},{},{},{:.6f},{:.6f},{:.6f}\n", run, 0.05 * static_cast<double>(row),
          row > 0 ? left_now - left_before : 0, row > 0 ? right_now - right_before : 0,
          x + 0.001 * draw(3, 3 * row), y + 0.001 * draw(3, 3 * row + 1),
          std::remainder(theta + causes_.yaw_rad + 0.002 * draw(3, 3 * row + 2), 2 * M_PI));
      left_before = left_now, right_before = right_now;
    }
  }

  Causes causes_;
  std::string rows_ = "run,time_s,left_ticks,right_ticks,x_m,y_m,theta_rad\n";
};

SearchResult searched_wheels(const Causes& causes) {
  const Model nominal = Model::from_config(ConfigNode::from_text(
      "format: seam-model/1\neffects: {differential_drive: {metres_per_tick: 5.0e-5, base_m: "
      "0.3}}\n",
      "model"));
  const auto problem = open_problem(MadeDrive(causes).folder());
  return search(*problem, nominal, {}, [](const std::string&) {});
}

void expect_alone(const Causes& causes, const std::string& effect, double truth, double within) {
  const SearchResult result = searched_wheels(causes);
  const Model& model = result.best.assessment.model;
  ASSERT_EQ(result.steps.size(), 1u) << model.to_yaml();
  ASSERT_EQ(result.steps[0].effect, effect);
  EXPECT_NEAR(model.find(effect)->values()[0], truth, within);
  EXPECT_NEAR(result.best.assessment.error, 1, 0.08);
}

TEST(WheelCauses, ARadiusThatDependsOnSpeed) {
  expect_alone({.name = "growth", .growth = 0.06, .seed = 1}, "wheel_growth", 0.06, 0.006);
}

TEST(WheelCauses, ARadiusThatDependsOnLoad) {
  expect_alone({.name = "load", .load = 0.08, .seed = 2}, "wheel_load", 0.08, 0.02);
}

TEST(WheelCauses, EncodersThatAreReadOneAfterTheOther) {
  expect_alone({.name = "skew", .right_late_s = 0.008, .seed = 3}, "encoder_skew", 0.008, 0.001);
}

TEST(WheelCauses, AMarkerThatIsTurned) {
  expect_alone({.name = "turned", .yaw_rad = 0.04, .seed = 4}, "tracker_turn", 0.04, 0.004);
}

// A floor on which wheels sink in moves all later poses, as a noise that adds up along the way
// does, which takes as much; it is no noise, since it hangs together with the place.
TEST(WheelCauses, ACarpetIsAFunctionOfThePlaceAndNoNoise) {
  const SearchResult result = searched_wheels({.name = "carpet", .carpet = -0.06, .seed = 6});
  EXPECT_EQ(result.verdict, "unexplained_structure");
  ASSERT_TRUE(result.unnamed);
  EXPECT_TRUE(result.steps.empty()) << result.best.assessment.model.to_yaml();
  EXPECT_EQ(result.unnamed->depends_on[0], std::vector<std::string>{"x_moved"});
  EXPECT_GT(result.unnamed->takes, 0.9);
}

TEST(WheelCauses, AreNotFoundWhereThereAreNone) {
  const SearchResult result = searched_wheels({.name = "none", .seed = 5});
  EXPECT_TRUE(result.steps.empty()) << result.best.assessment.model.to_yaml();
}

}  // namespace
}  // namespace seam::measurement
