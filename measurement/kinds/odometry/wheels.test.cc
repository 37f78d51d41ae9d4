// Wheels whose ticks are logged, poses with gaps and a clock of their own.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "effects/registry.h"
#include "measurement/kinds/odometry/odometry.h"
#include "sim_core/base/error.h"

namespace seam::measurement {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const std::string kBase = "differential_drive: {metres_per_tick: 0.0005, base_m: 0.25}";

Model model_of(const std::string& effects) {
  return Model::from_config(
      ConfigNode::from_text("format: seam-model/1\neffects: {" + effects + "}\n", "model"));
}

// Ticks of a row, ten a second: a drive straight on, turns both ways, a rest.
std::array<int, 2> ticks_of(int run, int k) {
  if (k % 50 < 8) return {0, 0};
  if (k % 50 < 30) return {60 + run, 60 + run};
  return (k / 50 + run) % 2 == 0 ? std::array<int, 2>{20, 45} : std::array<int, 2>{50, 10};
}

constexpr size_t kLeft = 2, kX = 4, kY = 5, kTheta = 6;  // Columns of a made set.

class Wheels : public testing::Test {
 protected:
  Wheels() {
    fs::remove_all(folder_);
    fs::create_directories(folder_ / "protocol");
    std::ofstream(folder_ / "protocol/measurement.yaml")
        << "format: seam-measurement/1\nkind: odometry\nnoise: {x_m: 0.001, y_m: 0.001, theta_rad: "
           "0.002}\ngroup: run\nfiles: {odometry: drive.csv}\n";
    std::ofstream drive(folder_ / "protocol/drive.csv");
    drive << "run,time_s,left_ticks,right_ticks\n";
    for (int run = 0; run < 6; ++run) {
      for (int k = 0; k < 200; ++k) {
        const auto ticks = ticks_of(run, k);
        drive << fmt::format("{},{:.1f},{},{}\n", run, 0.1 * k, k ? ticks[0] : 0, k ? ticks[1] : 0);
      }
    }
  }
  ~Wheels() override { fs::remove_all(folder_); }

  fs::path made(const std::string& effects, bool noise = true) const {
    const fs::path out = folder_ / "set";
    fs::remove_all(out);
    measure_set(model_of(kBase + effects), MeasurementSet::open(folder_ / "protocol"),
                {.seed = 3, .noise = noise, .out = out});
    return out;
  }

  template <typename Change>
  void rewrite(const fs::path& set, const Change& change) const {
    const CsvTable table = CsvTable::read(set / "drive.csv");
    CsvWriter out(table.columns());
    for (size_t row = 0; row < table.rows(); ++row) {
      std::vector<std::string> cells;
      for (const std::string& column : table.columns()) cells.emplace_back(table.cell(row, column));
      change(row, cells);
      out.row(cells);
    }
    out.write(set / "drive.csv");
  }

  std::string error(const fs::path& set) const {
    try {
      open_problem(set);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }

  const fs::path folder_ = fs::path(testing::TempDir()) / "wheel_sets";
};

// The definition, of ticks that count nothing off, by many small straight steps of each wheel,
// written apart from the program: at `at_s` after the first row.
WalkPose rolled_in_small_steps(int run, double at_s, double left_scale, double right_scale,
                               double base_scale, double slip) {
  double x = 0, y = 0, theta = 0;
  const int steps = 400;
  const double h = 0.1 / steps;
  for (int k = 1; k < 200; ++k) {
    const auto ticks = ticks_of(run, k);
    const double left = 0.9 * ticks[0] * 0.0005 / 0.1 * (1 + left_scale),
                 right = 0.9 * ticks[1] * 0.0005 / 0.1 * (1 + right_scale);
    const double omega = (right - left) / (0.25 * (1 + base_scale));
    const double v = (left + right) / 2 * (1 - slip * std::abs(omega));
    for (int i = 0; i < steps; ++i) {
      if (0.1 * (k - 1) + (i + 0.5) * h > at_s) return {x, y, theta};
      x += v * h * std::cos(theta + omega * h / 2);
      y += v * h * std::sin(theta + omega * h / 2);
      theta += omega * h;
    }
  }
  return {x, y, theta};
}

TEST_F(Wheels, MakeTheWayThatTheirTicksSay) {
  rewrite(folder_ / "protocol", [](size_t, std::vector<std::string>& cells) {
    for (const size_t wheel : {kLeft, kLeft + 1})
      cells[wheel] = fmt::format("{}", 0.9 * std::stoi(cells[wheel]));
  });
  const fs::path set = made(
      ", wheel_scale: {left: 0.03, right: -0.02}, base_scale: {scale: 0.05}, wheel_slip: "
      "{per_radps: 0.1}, frame_latency: {latency_s: 0.04}",
      /*noise=*/false);
  const CsvTable table = CsvTable::read(set / "drive.csv");
  const auto x = table.numbers("x_m"), y = table.numbers("y_m"), theta = table.numbers("theta_rad");
  for (const int run : {0, 3}) {
    for (const int k : {5, 60, 130, 198}) {
      const size_t row = 200 * static_cast<size_t>(run) + static_cast<size_t>(k);
      const WalkPose there = rolled_in_small_steps(run, 0.1 * k + 0.04, 0.03, -0.02, 0.05, 0.1);
      EXPECT_NEAR(x[row], there[0], 1e-5) << run << " " << k;
      EXPECT_NEAR(y[row], there[1], 1e-5) << run << " " << k;
      EXPECT_NEAR(std::remainder(theta[row] - there[2], 2 * std::acos(-1.0)), 0, 1e-5);
    }
  }
}

TEST_F(Wheels, TheirErrorsAreFittedBack) {
  const auto problem = open_problem(
      made(", wheel_scale: {left: 0.03, right: -0.02}, base_scale: {scale: 0.05}, wheel_slip: "
           "{per_radps: 0.1}, frame_latency: {latency_s: -0.03}"));
  const Model start = model_of(kBase +
                               ", wheel_scale: {}, base_scale: {}, wheel_slip: {per_radps: 0.01}, "
                               "frame_latency: {}");
  problem->check_model(start);
  problem->prepare(model_of(kBase));
  const std::vector<Unknown> unknowns = {{"wheel_scale", 0},
                                         {"wheel_scale", 1},
                                         {"base_scale", 0},
                                         {"wheel_slip", 0},
                                         {"frame_latency", 0}};
  const std::vector<double> truth = {0.03, -0.02, 0.05, 0.1, -0.03};
  const Fit fit = problem->fit(start, unknowns, problem->all_groups());
  for (size_t i = 0; i < truth.size(); ++i) {
    EXPECT_NEAR(fit.value[i], truth[i], 4 * fit.sigma[i]) << unknowns[i].effect;
    EXPECT_LT(fit.sigma[i], 0.1 * std::abs(truth[i])) << unknowns[i].effect;
  }
  EXPECT_NEAR(problem->score(fit.model, problem->all_groups()).error(), 1, 0.05);
}

// What `measure` draws of counts that round off is what the likelihood expects of them.
TEST_F(Wheels, CoarseCountsAreDrawnAsTheyAreExpected) {
  rewrite(folder_ / "protocol", [](size_t, std::vector<std::string>& cells) {
    for (const size_t wheel : {kLeft, kLeft + 1})
      cells[wheel] = std::to_string(std::stoi(cells[wheel]) / 20);
  });
  const std::string coarse = "differential_drive: {metres_per_tick: 0.01, base_m: 0.25}";
  fs::remove_all(folder_ / "set");
  measure_set(model_of(coarse), MeasurementSet::open(folder_ / "protocol"),
              {.seed = 5, .out = folder_ / "set"});
  const auto problem = open_problem(folder_ / "set");
  const Score score = problem->score(model_of(coarse), problem->all_groups());
  EXPECT_NEAR(score.error(), 1, 0.05);
  EXPECT_GT(score.native[2], 0.008);  // Radians, of which the poses' noise is 0.002.
}

// Cells of poses that are blank weigh as if they had been left out; the wheels roll on.
TEST_F(Wheels, GapsOfPosesTakeNoPart) {
  const Model wandering = model_of(kBase + ", walk_noise: {xy_sigma: 0.004, theta_sigma: 0.01}");
  const fs::path set = made("");
  const auto is_blank = [](size_t row, size_t column) {
    const size_t k = row % 200;
    return (k >= 70 && k < 110) || (column == kTheta && k % 9 == 4) || (column == kX && k == 31);
  };
  const auto whole = open_problem(set);
  std::vector<char> out;
  for (size_t i = 0; i < whole->facts().scalars(); ++i)
    out.push_back(
        is_blank(whole->facts().row_of[i], kX + static_cast<size_t>(whole->facts().channel_of[i])));
  whole->leave_out(out);
  rewrite(set, [&](size_t row, std::vector<std::string>& cells) {
    for (const size_t column : {kX, kY, kTheta}) {
      if (is_blank(row, column)) cells[column].clear();
    }
  });
  const auto blank = open_problem(set);
  for (const Model& model : {model_of(kBase), wandering}) {
    const Score a = whole->score(model, whole->all_groups()),
                b = blank->score(model, blank->all_groups());
    EXPECT_EQ(a.n, b.n);
    EXPECT_NEAR(a.log_likelihood, b.log_likelihood, 1e-8 * std::abs(a.log_likelihood));
  }
}

// A run without walk noise is least squares in closed form; walk noise that does nothing takes the
// filter's way to the same likelihood, from a first pose that is blank, too.
TEST_F(Wheels, TheLikelihoodWithoutWalkNoiseIsThatOfTheFilter) {
  for (const bool blank : {false, true}) {
    const fs::path set = made("");
    rewrite(set, [&](size_t row, std::vector<std::string>& cells) {
      if (blank && row % 200 == 0) cells[kX].clear(), cells[kTheta].clear();
      if (row % 200 > 150 && row % 7 == 0) cells[kY].clear();
    });
    const auto problem = open_problem(set);
    for (const char* beside :
         {", base_scale: {scale: 0}",
          ", pose_noise: {xy_sigma_m: 0.002, theta_sigma_rad: 0.001, per_mps: 3}"}) {
      const std::string effects = kBase + beside;
      const Score alone = problem->score(model_of(effects), problem->all_groups());
      const Score filtered =
          problem->score(model_of(effects + ", walk_noise: {xy_sigma: 1e-9, theta_sigma: 1e-9}"),
                         problem->all_groups());
      ASSERT_TRUE(alone.valid);
      EXPECT_EQ(alone.n, filtered.n) << beside;
      EXPECT_NEAR(alone.log_likelihood, filtered.log_likelihood, 0.02) << beside;
      EXPECT_NEAR(alone.chi2, filtered.chi2, 0.02) << beside;
    }
  }
}

TEST_F(Wheels, ATrackWithoutHeadingsHasTwoChannels) {
  const fs::path set = made(", base_scale: {scale: 0.05}");
  rewrite(set, [](size_t row, std::vector<std::string>& cells) {
    cells[kTheta].clear();
    if (row % 200 < 3) cells[kX].clear();
  });
  const auto problem = open_problem(set);
  ASSERT_EQ(problem->facts().channels.size(), 2u);
  const Model start = model_of(kBase + ", base_scale: {}");
  const Fit fit = problem->fit(start, {{"base_scale", 0}}, problem->all_groups());
  EXPECT_NEAR(fit.value[0], 0.05, 4 * fit.sigma[0]);
  EXPECT_NEAR(problem->score(fit.model, problem->all_groups()).error(), 1, 0.05);
}

TEST_F(Wheels, FreePredictionsAreNotCorrectedOnTheirWay) {
  // Straight on at 0.3 m/s with wheels that are larger by 2 %: 6 mm in a second.
  std::ofstream drive(folder_ / "protocol/drive.csv");
  drive << "run,time_s,left_ticks,right_ticks\n";
  for (int run = 0; run < 2; ++run) {
    for (int k = 0; k <= 100; ++k) drive << fmt::format("{},{:.1f},60,60\n", run, 0.1 * k);
  }
  drive.close();
  const auto problem =
      open_problem(made(", wheel_scale: {left: 0.02, right: 0.02}", /*noise=*/false));
  const auto errors = problem->free_prediction(model_of(kBase), problem->all_groups());
  ASSERT_EQ(errors.size(), 4u);
  EXPECT_EQ(errors[0].over, "1 s");
  EXPECT_EQ(errors[0].residual, "position_m");
  EXPECT_NEAR(errors[0].rms, 0.006, 1e-9);
  EXPECT_EQ(errors[0].count, 2 * 91);
  EXPECT_NEAR(errors[1].rms, 0, 1e-9);
  EXPECT_EQ(errors[2].over, "run");
  // The start is where the first second's poses say: their middle is half a second on.
  EXPECT_NEAR(errors[2].last, 0.006 * 9.5, 1e-4);
  // Walk noise explains such errors as wandering, and predicts no better for it.
  const Model wandering = model_of(kBase + ", walk_noise: {xy_sigma: 0.05}");
  EXPECT_NEAR(problem->free_prediction(wandering, problem->all_groups())[0].rms, 0.006, 1e-9);
}

TEST_F(Wheels, MakingASetKeepsItsGaps) {
  const fs::path set = made("");
  rewrite(set, [](size_t row, std::vector<std::string>& cells) {
    if (row % 200 > 150) cells[kX].clear(), cells[kY].clear(), cells[kTheta].clear();
  });
  const fs::path again = folder_ / "again";
  measure_set(model_of(kBase), MeasurementSet::open(set), {.out = again});
  const CsvTable table = CsvTable::read(again / "drive.csv");
  for (size_t row = 0; row < table.rows(); ++row)
    EXPECT_EQ(table.cell(row, "x_m").empty(), row % 200 > 150) << row;
}

TEST_F(Wheels, RowsOfOneTimeCountOnceAndLoseNoTicks) {
  const fs::path set = made("", /*noise=*/false);
  const Score before = open_problem(set)->score(model_of(kBase), {1, 1, 1, 1, 1, 1});
  // A row is split in two of one time, the first with no ticks.
  const CsvTable table = CsvTable::read(set / "drive.csv");
  CsvWriter out(table.columns());
  for (size_t row = 0; row < table.rows(); ++row) {
    std::vector<std::string> cells;
    for (const std::string& column : table.columns()) cells.emplace_back(table.cell(row, column));
    if (row == 40) {
      out.row(cells);
      cells[kLeft] = "5", cells[kLeft + 1] = "5", cells[kX] = "9";
    }
    if (row == 41) {
      cells[kLeft] = std::to_string(std::stoi(cells[kLeft]) - 5);
      cells[kLeft + 1] = std::to_string(std::stoi(cells[kLeft + 1]) - 5);
    }
    out.row(cells);
  }
  out.write(set / "drive.csv");
  const auto problem = open_problem(set);
  EXPECT_THAT(problem->facts().notes, testing::ElementsAre(HasSubstr("1 of 1201 rows say the time "
                                                                     "of the row before them")));
  const Score after = problem->score(model_of(kBase), problem->all_groups());
  EXPECT_EQ(after.n, before.n);
  EXPECT_NEAR(after.chi2, before.chi2, 1e-6);
}

TEST_F(Wheels, CountersThatAreNoDifferencesAreRefused) {
  // Counters that go on, with a reset on the way, too.
  for (const bool reset : {false, true}) {
    const fs::path set = made("");
    std::array<int, 2> sum = {0, 0};
    rewrite(set, [&](size_t row, std::vector<std::string>& cells) {
      if (row % 200 == 0 || (reset && row % 200 == 90)) sum = {0, 0};
      for (size_t wheel = 0; wheel < 2; ++wheel) {
        sum[wheel] += std::stoi(cells[kLeft + wheel]);
        cells[kLeft + wheel] = std::to_string(sum[wheel]);
      }
    });
    EXPECT_THAT(error(set), HasSubstr("drive.csv:201: column left_ticks: found '"));
    EXPECT_THAT(error(set), HasSubstr("counters that go on. Write each row less the row before"));
  }
  // One wheel alone, whose counter began before the log.
  for (const size_t wheel : {0, 1}) {
    const fs::path set = made("");
    int sum = 7000, found = 0;
    rewrite(set, [&](size_t row, std::vector<std::string>& cells) {
      sum += std::stoi(cells[kLeft + wheel]);
      cells[kLeft + wheel] = std::to_string(sum);
      if (row == 199) found = sum;
    });
    EXPECT_THAT(error(set), HasSubstr(fmt::format("drive.csv:201: column {}: found '{}'",
                                                  kTickColumns[wheel], found)));
    EXPECT_THAT(error(set), HasSubstr(fmt::format("as {} has; here the body moves as the "
                                                  "differences of rows say: a counter that goes on",
                                                  kTickColumns[1 - wheel])));
  }
  const auto with = [&](int ticks) {
    const fs::path set = made("");
    rewrite(set, [&](size_t row, std::vector<std::string>& cells) {
      if (row == 260) cells[kLeft] = std::to_string(ticks);
    });
    return error(set);
  };
  EXPECT_THAT(with(40 - 65536), HasSubstr("drive.csv:262: column left_ticks: found '-65496', "
                                          "expected ticks since the row before"));
  EXPECT_THAT(with(40 - 65536), HasSubstr("a counter of 16 bits that wrapped around"));
  int counted = 0;
  for (int k = 1; k < 60; ++k) counted += ticks_of(1, k)[0];
  EXPECT_THAT(with(-counted), HasSubstr("a counter that was reset at"));
  EXPECT_EQ(with(150), "no error");
}

TEST_F(Wheels, TicksAskForABaseOfWheels) {
  const auto problem = open_problem(made(""));
  EXPECT_NO_THROW(problem->check_model(model_of(kBase)));
  for (const std::string& wrong :
       {std::string("ideal_odometry: {}"), kBase + ", ideal_odometry: {}"})
    EXPECT_THROW(problem->check_model(model_of(wrong)), InputError) << wrong;
  problem->prepare(model_of(kBase));
  EXPECT_FALSE(problem->acts(*effects::find_effect("odometry_scale")));
  EXPECT_FALSE(problem->acts(*effects::find_effect("walk_lag")));
  for (const char* name :
       {"wheel_scale", "base_scale", "wheel_slip", "frame_latency", "walk_noise"})
    EXPECT_TRUE(problem->acts(*effects::find_effect(name))) << name;
}

}  // namespace
}  // namespace seam::measurement
