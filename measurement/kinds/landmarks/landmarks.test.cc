// Ranges or bearings may be blank, in single rows or all of them: what is not there takes no part.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>

#include "effects/registry.h"
#include "measurement/judge/material.h"
#include "measurement/kinds/kinds.h"
#include "measurement/search/candidates.h"
#include "measurement/search/search.h"
#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

Model model_of(const std::string& effects) {
  return Model::from_config(
      ConfigNode::from_text("format: seam-model/1\neffects: {" + effects + "}\n", "model"));
}

class LandmarkSets : public testing::Test {
 protected:
  LandmarkSets() {
    fs::remove_all(folder_);
    fs::create_directories(folder_ / "protocol");
    std::ofstream(folder_ / "protocol/measurement.yaml")
        << "format: seam-measurement/1\nkind: landmarks\nnoise: {range_m: 0.02, bearing_rad: "
           "0.004}\ngroup: run\nfiles: {observations: seen.csv, landmarks: map.csv, poses: "
           "walk.csv}\n";
    std::ofstream(folder_ / "protocol/map.csv") << "landmark,x_m,y_m\nA,4,0\nB,0,5\nC,-4,-1\n";
    std::ofstream walk(folder_ / "protocol/walk.csv");
    walk << "run,time_s,x_m,y_m,theta_rad\n";
    std::ofstream seen(folder_ / "protocol/seen.csv");
    seen << "run,time_s,landmark\n";
    for (int run = 0; run < 6; ++run) {
      for (int k = 0; k <= 60; ++k) {
        const double t = 0.1 * k;
        walk << fmt::format("{},{:.2f},{:.5f},{:.5f},{:.5f}\n", run, t,
                            0.3 * t + 2 * std::cos(2 * run),
                            0.8 * std::sin(0.8 * t + run) + 2 * std::sin(2 * run),
                            0.6 * std::sin(0.7 * t + 2 * run));
        if (k % 2 == 0) seen << fmt::format("{},{:.2f},{}\n", run, t, "ABC"[k / 2 % 3]);
      }
    }
  }
  ~LandmarkSets() override { fs::remove_all(folder_); }

  fs::path made(const std::string& effects, bool noise = true) const {
    const fs::path out = folder_ / "set";
    fs::remove_all(out);
    measure_set(model_of(effects), MeasurementSet::open(folder_ / "protocol"),
                {.seed = 5, .noise = noise, .out = out});
    return out;
  }

  // The made set's observations with cells changed: `change` gets the row's number and its cells.
  template <typename Change>
  void rewrite(const fs::path& set, const Change& change) const {
    const CsvTable table = CsvTable::read(set / "seen.csv");
    CsvWriter out(table.columns());
    for (size_t row = 0; row < table.rows(); ++row) {
      std::vector<std::string> cells;
      for (const std::string& column : table.columns()) cells.emplace_back(table.cell(row, column));
      change(row, cells);
      out.row(cells);
    }
    out.write(set / "seen.csv");
  }

  std::string error(const fs::path& set) const {
    try {
      open_problem(set);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }

  const fs::path folder_ =
      fs::path(testing::TempDir()) /
      ("landmark_sets_" +
       std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
};

constexpr size_t kRange = 3, kBearing = 4;  // Columns of a made set.

// Blank scalars weigh as if they had been left out, whatever the rows hold beside them.
TEST_F(LandmarkSets, BlankCellsTakeNoPart) {
  const Model model = model_of("range_scale: {scale: 0.03}, frame_jitter: {sigma_s: 0.01}");
  const fs::path set = made("range_scale: {scale: 0.03}");
  const auto whole = open_problem(set);
  const auto is_blank = [](size_t row, int channel) {
    return row % 7 == (channel == 0 ? 2 : 4) || row % 31 == 9;
  };
  std::vector<char> out(whole->facts().scalars(), 0);
  for (size_t i = 0; i < out.size(); ++i)
    out[i] = is_blank(whole->facts().row_of[i], whole->facts().channel_of[i]);
  whole->leave_out(out);
  rewrite(set, [&](size_t row, std::vector<std::string>& cells) {
    if (is_blank(row, 0)) cells[kRange].clear();
    if (is_blank(row, 1)) cells[kBearing].clear();
  });
  const auto blank = open_problem(set);
  EXPECT_LT(blank->facts().scalars(), whole->facts().scalars());
  const Score a = whole->score(model, whole->all_groups()),
              b = blank->score(model, blank->all_groups());
  EXPECT_EQ(a.n, b.n);
  EXPECT_NEAR(a.log_likelihood, b.log_likelihood, 1e-9 * std::abs(a.log_likelihood));
  EXPECT_EQ(a.native_count, b.native_count);
  EXPECT_THAT(blank->facts().notes,
              testing::ElementsAre("6 of 186 observations hold neither range nor bearing"));
}

TEST_F(LandmarkSets, WithoutBearingsThereIsOneChannel) {
  const fs::path set = made("range_scale: {scale: 0.05}");
  rewrite(set, [](size_t, std::vector<std::string>& cells) { cells[kBearing].clear(); });
  const auto problem = open_problem(set);
  ASSERT_EQ(problem->facts().channels.size(), 1u);
  EXPECT_EQ(problem->facts().channels[0].name, "range_m");
  const Model nominal = model_of("ideal_detector: {}");
  problem->prepare(nominal);
  for (const auto& [name, reason] : {std::pair{"bearing_scale", "no bearing was measured"},
                                     {"bearing_offset_per_range", "no bearing was measured"},
                                     {"bearing_noise", "no bearing was measured"},
                                     {"range_scale", ""},
                                     {"range_depth", ""}})
    EXPECT_EQ(problem->not_testable(nominal, *effects::find_effect(name), 0), reason) << name;
  const Grown base{.assessment = assess(*problem, nominal, {})};
  std::vector<NotTestable> reasons;
  const auto found = try_effect(*problem, base, effects::find_effect("range_scale"), reasons);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->grown.assessment.fit.value[0], 0.05, 4 * found->grown.assessment.fit.sigma[0]);
  EXPECT_NEAR(found->grown.assessment.error, 1, 0.15);
}

TEST_F(LandmarkSets, WithoutRangesThereIsOneChannel) {
  const fs::path set = made("bearing_scale: {scale: 0.1}");
  rewrite(set, [](size_t, std::vector<std::string>& cells) { cells[kRange].clear(); });
  const auto problem = open_problem(set);
  ASSERT_EQ(problem->facts().channels.size(), 1u);
  EXPECT_EQ(problem->facts().channels[0].name, "bearing_rad");
  const Model nominal = model_of("ideal_detector: {}");
  problem->prepare(nominal);
  EXPECT_EQ(problem->not_testable(nominal, *effects::find_effect("range_depth"), 0),
            "no range was measured");
  const Model truth = model_of("bearing_scale: {scale: 0.1}");
  EXPECT_LT(problem->score(truth, problem->all_groups()).error(), 1.2);
}

// A column that is not there at all is a blank one.
TEST_F(LandmarkSets, AMissingColumnIsABlankOne) {
  const fs::path set = made("ideal_detector: {}");
  const CsvTable table = CsvTable::read(set / "seen.csv");
  CsvWriter out({"run", "time_s", "landmark", "range_m"});
  for (size_t row = 0; row < table.rows(); ++row) {
    std::vector<std::string> cells;
    for (const char* column : {"run", "time_s", "landmark", "range_m"})
      cells.emplace_back(table.cell(row, column));
    out.row(cells);
  }
  out.write(set / "seen.csv");
  EXPECT_EQ(open_problem(set)->facts().channels.size(), 1u);
}

// The depth of a range whose bearing is blank is that of the predicted bearing.
TEST_F(LandmarkSets, RangesAreDepthsByThePredictedBearing) {
  const fs::path set = made("range_depth: {k: 1}", /*noise=*/false);
  rewrite(set, [](size_t row, std::vector<std::string>& cells) {
    if (row % 2 == 0) cells[kBearing].clear();
  });
  const auto problem = open_problem(set);
  const Score score = problem->score(model_of("range_depth: {k: 1}"), problem->all_groups());
  EXPECT_LT(score.native[0], 1e-6);
  EXPECT_GT(problem->score(model_of("ideal_detector: {}"), problem->all_groups()).native[0], 0.3);
}

TEST_F(LandmarkSets, MakingASetKeepsItsBlanks) {
  const fs::path first = made("ideal_detector: {}");
  rewrite(first, [](size_t row, std::vector<std::string>& cells) {
    cells[kBearing].clear();
    if (row == 3) cells[kRange].clear();
  });
  const fs::path again = folder_ / "again";
  measure_set(model_of("range_offset: {offset_m: 0.5}"), MeasurementSet::open(first),
              {.seed = 1, .noise = false, .out = again});
  const CsvTable table = CsvTable::read(again / "seen.csv");
  for (size_t row = 0; row < table.rows(); ++row) {
    EXPECT_TRUE(table.cell(row, "bearing_rad").empty());
    EXPECT_EQ(table.cell(row, "range_m").empty(), row == 3) << row;
  }
  // Columns that are there and hold nothing at all are to be made.
  rewrite(first, [](size_t, std::vector<std::string>& cells) {
    cells[kRange].clear();
    cells[kBearing].clear();
  });
  fs::remove_all(again);
  measure_set(model_of("ideal_detector: {}"), MeasurementSet::open(first), {.out = again});
  EXPECT_EQ(open_problem(again)->facts().channels.size(), 2u);
}

// A landmark off its place is told with its displacement, by ranges alone, too.
TEST_F(LandmarkSets, PlacesThatAreWrongAreTold) {
  for (const bool bearings : {true, false}) {
    const fs::path set = made("range_offset: {offset_m: 0.1}");
    std::ofstream(set / "map.csv") << "landmark,x_m,y_m\nA,4,0\nB,0.04,4.97\nC,-4,-1\n";
    if (!bearings)
      rewrite(set, [](size_t, std::vector<std::string>& cells) { cells[kBearing].clear(); });
    const auto problem = open_problem(set);
    const Model nominal = model_of("range_offset: {offset_m: {value: 0.1, free: true}}");
    problem->prepare(nominal);
    EXPECT_TRUE(problem->findings(nominal).empty());
    const Grown base{.assessment = assess(*problem, nominal, refitted_unknowns(nominal))};
    std::vector<NotTestable> reasons;
    const auto found =
        try_effect(*problem, base, effects::find_effect("landmark_scatter"), reasons);
    ASSERT_TRUE(found) << bearings << (reasons.empty() ? "" : reasons[0].why);
    const Assessment& after = found->grown.assessment;
    EXPECT_GT(after.total_ll, base.assessment.total_ll + 10);
    EXPECT_LT(after.error, 1.1);
    const std::vector<Finding> told = problem->findings(after.model);
    ASSERT_EQ(told.size(), 1u) << bearings;
    EXPECT_EQ(told[0].name, "B");
    EXPECT_THAT(told[0].text, HasSubstr("landmark B lies "));
    std::map<std::string, double> values(told[0].values.begin(), told[0].values.end());
    EXPECT_NEAR(values["dx_m"], -0.04, 4 * values["dx_sigma_m"]);
    EXPECT_NEAR(values["dy_m"], 0.03, 4 * values["dy_sigma_m"]);
    EXPECT_LT(values["sigma_m"], 0.02);
  }
}

TEST_F(LandmarkSets, FromOneSidePlacesCannotBeTold) {
  std::ofstream(folder_ / "protocol/map.csv") << "landmark,x_m,y_m\nA,40,0\nB,0,50\nC,-40,-9\n";
  const auto problem = open_problem(made("ideal_detector: {}"));
  const Model nominal = model_of("ideal_detector: {}");
  EXPECT_THAT(problem->not_testable(nominal, *effects::find_effect("landmark_scatter"), 0),
              HasSubstr("each landmark is seen from one side alone"));
}

// Drawn places are the same in all runs, and their likelihood is that of the dense covariance.
TEST_F(LandmarkSets, DisplacedPlacesAreOneErrorOfAllRuns) {
  const Model model = model_of("landmark_scatter: {sigma_m: 0.05}");
  const auto problem = open_problem(made("landmark_scatter: {sigma_m: 0.05}"));
  const Groups all = problem->all_groups();
  const Evaluation one = problem->evaluate(model_of("ideal_detector: {}"), all);
  const auto n = static_cast<Eigen::Index>(one.residual.size());
  Eigen::MatrixXd S = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd r(n);
  const CsvTable walk = CsvTable::read(folder_ / "set/walk.csv");
  const std::vector<double> wx = walk.numbers("x_m"), wy = walk.numbers("y_m");
  const double places[3][2] = {{4, 0}, {0, 5}, {-4, -1}};
  std::vector<std::array<double, 2>> slope(one.residual.size());
  std::vector<size_t> landmark(one.residual.size());
  for (size_t i = 0; i < one.residual.size(); ++i) {
    const auto row = static_cast<size_t>(problem->facts().row_of[i]);
    landmark[i] = row % 31 % 3;
    const size_t pose = row / 31 * 61 + row % 31 * 2;
    const double dx = places[landmark[i]][0] - wx[pose], dy = places[landmark[i]][1] - wy[pose];
    const double d2 = dx * dx + dy * dy;
    slope[i] = problem->facts().channel_of[i] == 0
                   ? std::array<double, 2>{dx / std::sqrt(d2), dy / std::sqrt(d2)}
                   : std::array<double, 2>{-dy / d2, dx / d2};
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    r[i] = one.residual[i];
    for (Eigen::Index k = 0; k < n; ++k) {
      if (landmark[i] == landmark[k])
        S(i, k) = 0.0025 * (slope[i][0] * slope[k][0] + slope[i][1] * slope[k][1]);
    }
    S(i, i) += one.sigma[i] * one.sigma[i];
  }
  const Eigen::LLT<Eigen::MatrixXd> factor(S);
  const Eigen::VectorXd z = factor.matrixL().solve(r);
  const Score score = problem->score(model, all);
  EXPECT_NEAR(score.chi2, z.squaredNorm(), 1e-5 * z.squaredNorm());
  const double log_det = 2 * factor.matrixLLT().diagonal().array().log().sum();
  const double expected =
      -0.5 * (z.squaredNorm() + log_det + static_cast<double>(n) * std::log(2 * maths::kPi));
  EXPECT_NEAR(score.log_likelihood, expected, 1e-5 * std::abs(expected));
}

TEST_F(LandmarkSets, BadInputIsSaidWithItsPlace) {
  const auto with = [&](size_t column, const std::string& text) {
    const fs::path set = made("ideal_detector: {}");
    rewrite(set, [&](size_t row, std::vector<std::string>& cells) {
      if (row == 5) cells[column] = text;
    });
    return error(set);
  };
  EXPECT_THAT(with(kRange, "0"), HasSubstr("seen.csv:7: column range_m: found '0', expected a "
                                           "distance above 0, or a blank cell"));
  EXPECT_THAT(with(kRange, "-1.5"), HasSubstr("seen.csv:7: column range_m: found '-1.5'"));
  EXPECT_THAT(with(2, "D"), HasSubstr("seen.csv:7: column landmark: found 'D', expected a "
                                      "landmark with a place in map.csv"));
  const fs::path set = made("ideal_detector: {}");
  rewrite(set, [](size_t, std::vector<std::string>& cells) {
    cells[kRange].clear();
    cells[kBearing].clear();
  });
  EXPECT_THAT(error(set), HasSubstr("seen.csv: found no value in columns range_m and bearing_rad"));
  std::ofstream(set / "map.csv") << "landmark,x_m,y_m\nA,4,0\nB,,5\nC,-4,-1\n";
  EXPECT_THAT(error(set), HasSubstr("map.csv:3: column x_m: found '', expected a finite number"));
}

// Ranges that are too long now and then have a distribution, unless they are too few to tell one.
TEST_F(LandmarkSets, FewGrossRangesAreNoTail) {
  const auto found_with_one_of = [&](size_t each) {
    const fs::path set = made("range_scale: {scale: 0.03}");
    rewrite(set, [&](size_t row, std::vector<std::string>& cells) {
      if (row % each == 3) cells[kRange] = fmt::format("{:.4f}", std::stod(cells[kRange]) + 3);
    });
    return search(*open_problem(set), model_of("range_scale: {scale: 0.03}"), {},
                  [](const auto&) {});
  };
  const SearchResult few = found_with_one_of(60);
  EXPECT_EQ(few.outliers.size(), 8);  // Range and bearing of four rows.
  EXPECT_TRUE(few.steps.empty());
  const SearchResult many = found_with_one_of(10);
  EXPECT_TRUE(many.outliers.empty());
  ASSERT_EQ(many.steps.size(), 1);
  EXPECT_EQ(many.steps[0].effect, "range_tail");
}

// Standard deviations of ranges that are far too long now and then say nothing of how far an offset
// moves the others.
TEST_F(LandmarkSets, FewFarErrorsDoNotMakeAnOffsetSmall) {
  const fs::path set = made("range_offset: {offset_m: 0.05}");
  rewrite(set, [&](size_t row, std::vector<std::string>& cells) {
    if (row % 20 == 3) cells[kRange] = fmt::format("{:.4f}", std::stod(cells[kRange]) + 30);
  });
  const auto problem = open_problem(set);
  const Model without = model_of("range_tail: {fraction: 0.05, scale_m: 15}"),
              with = model_of(
                  "range_tail: {fraction: 0.05, scale_m: 15}, range_offset: {offset_m: 0.05}");
  const Change change =
      change_by(*problem, problem->evaluate_held_out(without, problem->scored_groups()),
                assess_fixed(*problem, without), assess_fixed(*problem, with), false);
  EXPECT_GT(change.moved, 0.5);
}

// Ranges that are too long now and then were left out, given back to an effect that explains them,
// and never left out again though the search that followed ended without it, at 40 times the noise.
TEST_F(LandmarkSets, WhatNoEffectTookInTheEndIsLeftOutAgain) {
  const fs::path set = folder_ / "beacons";
  fs::create_directories(set);
  std::ofstream(set / "measurement.yaml")
      << "format: seam-measurement/1\nkind: landmarks\nnoise: {range_m: 0.0444}\nfiles: "
         "{observations: seen.csv, landmarks: map.csv, poses: walk.csv}\n";
  std::ofstream(set / "map.csv") << "landmark,x_m,y_m\n0,15,-12\n1,-14,9\n2,11,17\n3,-20,-8\n";
  const double places[4][2] = {{15, -12}, {-14, 9}, {11, 17}, {-20, -8}};
  const auto x_m = [](double t) { return 9 * std::sin(0.11 * t) + 5 * std::sin(0.07 * t + 1); };
  const auto y_m = [](double t) {
    return 8 * std::cos(0.09 * t + 0.4) + 5 * std::cos(0.13 * t + 2);
  };
  // Numbers from 0 to 1 that look random.
  const auto mixed = [](int k, int column) {
    const double x = std::sin((k + 1) * 12.9898 + (105 + column) * 78.233) * 43758.5453;
    return x - std::floor(x);
  };
  std::ofstream walk(set / "walk.csv"), seen(set / "seen.csv");
  walk << "time_s,x_m,y_m,theta_rad\n";
  for (int k = 0; k < 1500; ++k)
    walk << fmt::format("{:.3f},{:.6f},{:.6f},0\n", 0.1 * k, x_m(0.1 * k), y_m(0.1 * k));
  seen << "time_s,landmark,range_m,bearing_rad\n";
  for (int k = 0; k < 730; ++k) {
    const double t = 2 + 0.2 * k + 0.05 * mixed(k, 0), late_s = 0.07;
    const int which = static_cast<int>(4 * mixed(k, 1));
    double range =
        std::hypot(places[which][0] - x_m(t + late_s), places[which][1] - y_m(t + late_s));
    for (int i = 0; i < 12; ++i) range += 0.0444 * (mixed(k, 2 + i) - 0.5);
    if (mixed(k, 20) < 1.0 / 70) range += 4 + 11 * mixed(k, 21);
    seen << fmt::format("{:.4f},{},{:.4f},\n", t, which, range);
  }
  walk.close(), seen.close();
  const SearchResult found =
      search(*open_problem(set), model_of("ideal_detector: {}"), {}, [](const auto&) {});
  ASSERT_EQ(found.steps.size(), 1);
  EXPECT_EQ(found.steps[0].effect, "frame_latency");
  EXPECT_EQ(found.outliers.size(), 12);
  EXPECT_LT(found.best.assessment.error, 1.1);
}

}  // namespace
}  // namespace seam::measurement
