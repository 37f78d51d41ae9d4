// Landmarks above the plane: a range is the distance in space where heights are stated.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "effects/questions.h"
#include "effects/registry.h"
#include "measurement/check/faults.h"
#include "measurement/kinds/kinds.h"
#include "sim_core/base/error.h"

namespace seam::measurement {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

Model model_with_heights(const std::string& effects) {
  return Model::from_config(
      ConfigNode::from_text("format: seam-model/1\neffects: {" + effects + "}\n", "model"));
}

struct Place {
  double x, y, z;
};
const std::map<std::string, Place> kBeacons = {
    {"A", {6, 0, 2.2}}, {"B", {0, 5, 2.2}}, {"C", {-4, -1, 1.4}}};

Place robot_at(double t) {
  return {0.3 * t, 0.8 * std::sin(0.8 * t), 0.5 + 0.4 * std::sin(0.5 * t)};
}

// A robot that rises and sinks among beacons; ranges by the law of Pythagoras.
class LandmarkHeights : public testing::Test {
 protected:
  ~LandmarkHeights() override { fs::remove_all(folder_); }

  fs::path set(bool heights, bool of_poses, double off_m = 0) const {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    std::ofstream(folder_ / "measurement.yaml")
        << "format: seam-measurement/1\nkind: landmarks\nnoise: {range_m: 0.01}\n"
           "files: {observations: seen.csv, landmarks: map.csv, poses: walk.csv}\n";
    std::ofstream map(folder_ / "map.csv"), walk(folder_ / "walk.csv"), seen(folder_ / "seen.csv");
    map << "landmark,x_m,y_m" << (heights ? ",z_m" : "") << "\n";
    for (const auto& [name, p] : kBeacons)
      map << name << "," << p.x << "," << p.y << (heights ? fmt::format(",{}", p.z) : "") << "\n";
    walk << "time_s,x_m,y_m,theta_rad" << (of_poses ? ",z_m" : "") << "\n";
    seen << "time_s,landmark,range_m\n";
    for (int k = 0; k <= 400; ++k) {
      const double t = 0.02 * k;
      const Place at = robot_at(t);
      walk << fmt::format("{:.3f},{:.9f},{:.9f},0", t, at.x, at.y)
           << (of_poses ? fmt::format(",{:.9f}", at.z) : "") << "\n";
      const std::string name(1, "ABC"[k % 3]);
      const Place& to = kBeacons.at(name);
      const double dx = to.x - at.x, dy = to.y - at.y, dz = to.z - (of_poses ? at.z : 0.0) - off_m;
      seen << fmt::format("{:.3f},{},{:.9f}\n", t, name, std::sqrt(dx * dx + dy * dy + dz * dz));
    }
    return folder_;
  }

  double worst(const fs::path& set, const std::string& effects = "ideal_detector: {}") const {
    const auto problem = open_problem(set);
    const Evaluation evaluation =
        problem->evaluate(model_with_heights(effects), problem->all_groups(), nullptr);
    double most = 0;
    for (const double residual : evaluation.residual) most = std::max(most, std::abs(residual));
    return most;
  }

  const fs::path folder_ =
      fs::path(testing::TempDir()) /
      ("landmark_heights_" +
       std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
};

TEST_F(LandmarkHeights, RangesAreDistancesInSpace) {
  EXPECT_LT(worst(set(true, false)), 1e-6);
  EXPECT_LT(worst(set(true, true)), 1e-6);
  EXPECT_TRUE(faults_of_values(MeasurementSet::open(set(true, true))).empty());
  // What the plane makes of them.
  EXPECT_GT(worst(set(false, false)), 0.3);
}

// A model may say how far above the robot's origin the sensor stands; the set's heights are not
// fitted.
TEST_F(LandmarkHeights, TheSensorMayStandHigher) {
  const fs::path with = set(true, true, 0.25);
  EXPECT_LT(worst(with, "mount_offset: {z_m: 0.25}"), 1e-6);
  EXPECT_GT(worst(with), 0.05);
  const effects::EffectDefinition offset = *effects::find_effect("mount_offset");
  EXPECT_THAT(effects::reason_against(offset, 2, open_problem(with)->facts().set),
              HasSubstr("heights are taken as the set states them"));
}

TEST_F(LandmarkHeights, PosesAloneWithHeightsAreTold) {
  const auto problem = open_problem(set(false, true));
  EXPECT_THAT(problem->facts().notes,
              testing::Contains(HasSubstr("poses state heights (z_m) and landmarks do not")));
}

TEST_F(LandmarkHeights, MadeSetsKeepThem) {
  const fs::path out = folder_.string() + "_made";
  fs::remove_all(out);
  measure_set(model_with_heights("range_scale: {scale: 0.1}"),
              MeasurementSet::open(set(true, true)), {.seed = 5, .noise = false, .out = out});
  EXPECT_LT(worst(out, "range_scale: {scale: 0.1}"), 1e-6);
  fs::remove_all(out);
}

TEST_F(LandmarkHeights, BlankHeightsAreRefused) {
  const fs::path with = set(true, false);
  std::ofstream(with / "map.csv") << "landmark,x_m,y_m,z_m\nA,6,0,2.2\nB,0,5,\nC,-4,-1,1.4\n";
  try {
    open_problem(with);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("map.csv:3"));
    EXPECT_THAT(error.what(), HasSubstr("z_m"));
  }
}

}  // namespace
}  // namespace seam::measurement
