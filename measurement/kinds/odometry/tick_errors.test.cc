// Encoders of few ticks a turn, by a simulation of its own: wheels that roll evenly, counts that
// are rounded, poses that are not.
#include "measurement/kinds/odometry/tick_errors.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "measurement/kinds/kinds.h"
#include "measurement/kinds/odometry/odometry.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

namespace fs = std::filesystem;

constexpr double kTick_m = 0.006, kBase_m = 0.25, kDt_s = 0.05, kSlip_s = 0.08;
constexpr double kXySigma_m = 0.0008, kThetaSigma_rad = 0.002;

Model drive_of(const std::string& beside) {
  return Model::from_config(ConfigNode::from_text(
      fmt::format("format: seam-model/1\neffects: {{differential_drive: {{metres_per_tick: {}, "
                  "base_m: {}}}{}}}\n",
                  kTick_m, kBase_m, beside),
      "model"));
}

// Speeds of the wheels, m/s: straight on, turns and rests, none of them for long.
std::array<double, 2> speeds_at(double t, int run) {
  const double v = 0.25 * std::max(0.0, std::sin(0.7 * t + run)) + 0.02 * std::sin(5 * t);
  const double omega = std::sin(0.41 * t) > 0 ? 0.8 * std::sin(1.3 * t + 2 * run) : 0;
  return {v - 0.5 * kBase_m * omega, v + 0.5 * kBase_m * omega};
}

class CoarseCounts : public testing::Test {
 protected:
  CoarseCounts() {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    std::ofstream(folder_ / "measurement.yaml") << fmt::format(
        "format: seam-measurement/1\nkind: odometry\nnoise: {{x_m: {0}, y_m: {0}, "
        "theta_rad: {1}}}\ngroup: run\nfiles: {{odometry: drive.csv}}\n",
        kXySigma_m, kThetaSigma_rad);
    std::ofstream drive(folder_ / "drive.csv");
    drive << "run,time_s,left_ticks,right_ticks,x_m,y_m,theta_rad\n";
    const RandomStream random{7, 0};
    uint64_t drawn = 0;
    const auto noise = [&](double sigma) { return sigma * normal(random, drawn++); };
    constexpr int kFine = 50, kRows = 500;
    for (int run = 0; run < 6; ++run) {
      std::array<double, 2> rolled = {0.001 * run, 0.0017 * run};  // Anywhere within a tick.
      std::array<double, 2> counted = rounded(rolled);
      double x = 0, y = 0, theta = 0;
      for (int k = 0; k < kRows; ++k) {
        const auto now = rounded(rolled);
        drive << fmt::format("{},{:.2f},{},{},{:.6f},{:.6f},{:.6f}\n", run, kDt_s * k,
                             now[0] - counted[0], now[1] - counted[1], x + noise(kXySigma_m),
                             y + noise(kXySigma_m),
                             std::remainder(theta + noise(kThetaSigma_rad), 6.283185307179586));
        counted = now;
        for (int i = 0; i < kFine; ++i) {
          const double h = kDt_s / kFine;
          const auto speed = speeds_at(kDt_s * k + (i + 0.5) * h, run);
          const double omega = (speed[1] - speed[0]) / kBase_m;
          const double v = 0.5 * (speed[0] + speed[1]) * (1 - kSlip_s * std::abs(omega));
          x += v * h * std::cos(theta + 0.5 * omega * h);
          y += v * h * std::sin(theta + 0.5 * omega * h);
          theta += omega * h;
          for (size_t wheel = 0; wheel < 2; ++wheel) rolled[wheel] += h * speed[wheel];
        }
      }
    }
  }
  ~CoarseCounts() override { fs::remove_all(folder_); }

  static std::array<double, 2> rounded(const std::array<double, 2>& rolled) {
    return {std::round(rolled[0] / kTick_m), std::round(rolled[1] / kTick_m)};
  }

  const fs::path folder_ = fs::path(testing::TempDir()) / "coarse_counts";
};

TEST_F(CoarseCounts, AreAKnownNoiseThatDoesNotGather) {
  const auto problem = open_problem(folder_);
  const Score score = problem->score(
      drive_of(fmt::format(", wheel_slip: {{per_radps: {}}}", kSlip_s)), problem->all_groups());
  // By itself the rounding of counts is 9.8 mrad of heading, five times the noise of the poses; of
  // the way that all counts tell a third of it is left.
  EXPECT_GT(score.native[2], 1.3 * kThetaSigma_rad);
  EXPECT_LT(score.native[2], 2 * kThetaSigma_rad);
  EXPECT_NEAR(score.error(), 1, 0.05);
  const Model start = drive_of(", wheel_slip: {per_radps: 0.05}, base_scale: {}");
  const Fit fit =
      problem->fit(start, {{"wheel_slip", 0}, {"base_scale", 0}}, problem->all_groups());
  // Counts as coarse as these tell the rate of turning to a hundredth, by which the wheels slip.
  EXPECT_NEAR(fit.value[0], kSlip_s, 0.02 * kSlip_s);
  EXPECT_NEAR(fit.value[1], 0, 3 * fit.sigma[1]);
  EXPECT_LT(fit.sigma[0], 0.01);
  EXPECT_LT(fit.sigma[1], 0.002);
}

// What rounding takes from a row it gives to the next, so that half way between them counts are
// nearer to the truth: beside ways that are told by single counts, these asked for 5 ms.
TEST_F(CoarseCounts, AskForNoLatency) {
  const auto problem = open_problem(folder_);
  const Model start =
      drive_of(fmt::format(", wheel_slip: {{per_radps: {}}}, frame_latency: {{}}", kSlip_s));
  const Fit fit = problem->fit(start, {{"frame_latency", 0}}, problem->all_groups());
  EXPECT_NEAR(fit.value[0], 0, 3 * fit.sigma[0]);
  EXPECT_LT(fit.sigma[0], 0.001);
}

TEST_F(CoarseCounts, TellAnEvenMotionBetweenThem) {
  const auto runs = read_walk_runs(CsvTable::read(folder_ / "drive.csv"), "run", true);
  double by_counts = 0, by_ways = 0;
  for (const WalkRun& run : runs) {
    std::array<double, 2> off{};
    for (size_t k = 1; k < run.ticks.size(); ++k) {
      const auto speed = speeds_at(kDt_s * (static_cast<double>(k) - 0.5), std::stoi(run.name));
      const double turned = (speed[1] - speed[0]) * kDt_s / kTick_m;
      by_counts += std::pow(run.ticks[k][1] - run.ticks[k][0] - turned, 2);
      by_ways += std::pow(run.rolled_ticks[k][1] - run.rolled_ticks[k][0] - turned, 2);
      for (size_t wheel = 0; wheel < 2; ++wheel) {
        off[wheel] += run.rolled_ticks[k][wheel] - run.ticks[k][wheel];
        EXPECT_LE(std::abs(off[wheel]), 1.0) << k;
      }
    }
  }
  EXPECT_LT(by_ways, 0.1 * by_counts);
}

// A body that turns, goes straight on, and turns again, by ways that begin anywhere in a count: it
// would slip by whatever it is thought to turn more than that.
TEST(SlipTicks, AStraightBetweenTurnsTurnsLittle) {
  constexpr double kTurn = 1.3;  // Ticks a row, by which wheels differ.
  const auto is_straight = [](size_t k) { return k > 40 && k <= 80; };
  std::vector<WalkRun> runs;
  for (int begin = 0; begin < 20; ++begin) {
    WalkRun run{.name = std::to_string(begin)};
    std::array<double, 2> rolled = {0.05 * begin, 0.31}, counted = {};
    for (size_t k = 0; k < 121; ++k) {
      const double turn = is_straight(k) ? 0 : kTurn;
      if (k > 0) rolled[0] += 7.37 - 0.5 * turn, rolled[1] += 7.37 + 0.5 * turn;
      const std::array<double, 2> now = {std::round(rolled[0]), std::round(rolled[1])};
      run.rows.push_back(k);
      run.time_s.push_back(0.05 * static_cast<double>(k));
      run.ticks.push_back({now[0] - counted[0], now[1] - counted[1]});
      counted = now;
    }
    runs.push_back(run);
  }
  find_ways(runs);
  double straight = 0, turned = 0;
  for (const WalkRun& run : runs) {
    for (size_t k = 1; k < run.ticks.size(); ++k) {
      const double turn = std::abs(run.slip_ticks[k][1] - run.slip_ticks[k][0]) / 20;
      (is_straight(k) ? straight : turned) += turn;
    }
  }
  EXPECT_NEAR(turned, 80 * kTurn, 1);
  EXPECT_NEAR(straight + turned, 80 * kTurn, 1);
}

TEST(CountErrors, AreThoseOfCountsAlone) {
  WalkRun run{.name = "0"};
  for (size_t k = 0; k < 60; ++k) {
    run.rows.push_back(k);
    run.time_s.push_back(0.1 * static_cast<double>(k));
    run.ticks.push_back({7, 7});
  }
  std::vector<WalkRun> runs = {run, run};
  runs[1].ticks[3][0] = 0.5;
  find_ways(runs);
  EXPECT_FALSE(count_errors(runs[0]).empty());
  EXPECT_TRUE(count_errors(runs[1]).empty());
}

}  // namespace
}  // namespace seam::measurement
