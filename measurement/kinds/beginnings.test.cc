// Long groups have beginnings, which say of themselves what the whole set says of them, and lead a
// fit to where all rows say.
#include "measurement/kinds/beginnings.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>

#include "effects/registry.h"

namespace seam::measurement {
namespace {

namespace fs = std::filesystem;

constexpr int kRuns = 2, kRows = 9000;

void write(const fs::path& file, const std::string& text) {
  std::ofstream(file) << text;
}

Model model_of(const std::string& effects) {
  return Model::from_config(
      ConfigNode::from_text("format: seam-model/1\neffects: {" + effects + "}\n", "model"));
}

struct LongSet {
  std::string kind, files, noise, nominal, hidden;
  Unknown unknown;
};

const LongSet kSets[] = {
    {"joints",
     "joints: joints.csv",
     "measured_rad: 0.0006",
     "ideal_servo: {}",
     "servo_lag: {tau_s: 0.04}",
     {"servo_lag", 0}},
    {"odometry",
     "odometry: odometry.csv",
     "x_m: 0.002, y_m: 0.002, theta_rad: 0.003",
     "ideal_odometry: {}",
     "odometry_scale: {vx_scale: 0.02}",
     {"odometry_scale", 0}},
    {"landmarks",
     "observations: observations.csv, landmarks: landmarks.csv, poses: poses.csv",
     "range_m: 0.03, bearing_rad: 0.006",
     "ideal_detector: {}",
     "range_scale: {scale: 0.04}",
     {"range_scale", 0}},
};

// Two runs of 9,000 rows, their rows mixed, and measured with the hidden effect; servos and walks
// may rest at first.
fs::path made(const LongSet& set, int resting_rows = 0) {
  const fs::path folder = fs::path(testing::TempDir()) / ("beginnings_" + set.kind);
  fs::remove_all(folder);
  fs::create_directories(folder / "protocol");
  std::string joints = "run,time_s,joint,command_rad\n";
  std::string walks = "run,time_s,vx_cmd_mps,vy_cmd_mps,omega_cmd_radps\n";
  std::string seen = "run,time_s,landmark\n", poses = "run,time_s,x_m,y_m,theta_rad\n";
  for (int i = 0; i < kRows; ++i) {
    for (int run = 0; run < kRuns; ++run) {
      const double t = 0.016 * i;
      const double swing = i < resting_rows ? 0 : std::sin((0.9 + 0.2 * run) * t);
      joints += fmt::format("{},{:.4f},pan,{:.6f}\n", run, t, 0.7 * swing);
      walks += fmt::format("{},{:.4f},{:.5f},0,{:.5f}\n", run, t, 0.1 + 0.1 * swing, 0.5 * swing);
      seen += fmt::format("{},{:.4f},{}\n", run, t, (i / 40) % 4);
      if (i % 2 == 0)
        poses += fmt::format("{},{:.4f},{:.6f},{:.6f},{:.6f}\n", run, t, 0.5 * swing,
                             0.4 * std::cos(0.3 * t), 0.6 * swing);
    }
  }
  for (int run = 0; run < kRuns; ++run)
    poses += fmt::format("{},{:.4f},0,0,0\n", run, 0.016 * kRows);
  const fs::path protocol = folder / "protocol";
  write(protocol / "joints.csv", joints);
  write(protocol / "odometry.csv", walks);
  write(protocol / "observations.csv", seen);
  write(protocol / "poses.csv", poses);
  write(protocol / "landmarks.csv", "landmark,x_m,y_m\n0,2,0\n1,0,2\n2,-2,0\n3,0,-2\n");
  write(protocol / "measurement.yaml",
        fmt::format("format: seam-measurement/1\nkind: {}\ntitle: long\ngroup: run\n"
                    "files: {{{}}}\nnoise: {{{}}}\n",
                    set.kind, set.files, set.noise));
  measure_set(model_of(set.nominal + ", " + set.hidden), MeasurementSet::open(protocol),
              {.seed = 3, .out = folder / "data"});
  return folder / "data";
}

TEST(Beginnings, ArePredictedAsInTheWholeSet) {
  for (const LongSet& set : kSets) {
    SCOPED_TRACE(set.kind);
    const auto problem = open_problem(made(set));
    const Model model = model_of(set.nominal + ", " + set.hidden);
    problem->prepare(model);
    ASSERT_TRUE(problem->beginnings());
    const Problem& first = *problem->beginnings();
    EXPECT_EQ(first.facts().rows(), 6600u);
    std::map<std::pair<int, int>, double> whole;
    const auto visit = [&](const Problem& of, const auto& call) {
      const Evaluation there = of.evaluate(model, of.all_groups());
      const Facts& facts = of.facts();
      for (size_t i = 0; i < facts.scalars(); ++i)
        call({facts.line_of_row[facts.row_of[i]], facts.channel_of[i]}, there.residual[i]);
    };
    visit(*problem, [&](std::pair<int, int> place, double r) { whole[place] = r; });
    int far = 0;
    visit(first, [&](std::pair<int, int> place, double r) {
      // A run's start is fitted to the rows that are there.
      far += std::abs(whole.at(place) - r) >
             0.2 * first.facts().channels[static_cast<size_t>(place.second)].noise;
    });
    EXPECT_EQ(far, 0);
  }
}

TEST(Beginnings, AreNoneWhereNothingGoesOnAtFirst) {
  const auto rows = [](int resting) -> size_t {
    const auto problem = open_problem(made(kSets[0], resting));
    return problem->beginnings() ? problem->beginnings()->facts().rows() : 0;
  };
  EXPECT_EQ(rows(0), 6600u);
  EXPECT_EQ(rows(5000), 0u) << "6,600 rows of each run would be most of them";
}

TEST(Beginnings, LeadAFitToWhereAllRowsSay) {
  for (const LongSet& set : kSets) {
    SCOPED_TRACE(set.kind);
    const fs::path data = made(set);
    Model start = model_of(set.nominal);
    start.add_neutral(effects::find_effect(set.unknown.effect));
    const auto fitted = [&](bool with_beginnings) {
      const auto problem = open_problem(data);
      if (!with_beginnings) problem->have_beginnings({});
      problem->prepare(start);
      return problem->fit(start, {set.unknown}, problem->all_groups());
    };
    const Fit led = fitted(true), alone = fitted(false);
    EXPECT_NEAR(led.value[0], alone.value[0], 0.05 * alone.sigma[0]);
    EXPECT_NEAR(led.sigma[0], alone.sigma[0], 0.05 * alone.sigma[0]);
  }
}

TEST(Beginnings, AreWithoutTheOutliersOfTheWholeSet) {
  const auto problem = open_problem(made(kSets[0]));
  std::vector<char> out(problem->facts().scalars(), 0);
  const int line = problem->beginnings()->facts().line_of_row[100];
  for (size_t i = 0; i < out.size(); ++i)
    out[i] = problem->facts().line_of_row[problem->facts().row_of[i]] == line;
  problem->leave_out(out);
  const Problem& first = *problem->beginnings();
  for (size_t i = 0; i < first.facts().scalars(); ++i)
    EXPECT_EQ(first.left_out(i), first.facts().line_of_row[first.facts().row_of[i]] == line);
  problem->leave_out({});
  EXPECT_FALSE(first.left_out(100));
}

}  // namespace
}  // namespace seam::measurement
