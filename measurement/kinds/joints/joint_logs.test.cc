#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>

#include "effects/registry.h"
#include "measurement/kinds/joints/joints.h"
#include "measurement/kinds/joints/joints_testing.h"
#include "measurement/kinds/kinds.h"
#include "sim_core/base/error.h"
#include "sim_core/base/output.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

Model model_in_blocks(const std::string& effects) {
  return Model::from_config(
      ConfigNode::from_text("format: seam-model/1\neffects:\n" + effects, "test.yaml"));
}

JointLogs logs_of(const std::string& rows) {
  return read_joint_logs(
      CsvTable::from_text("run,time_s,joint,command_rad,measured_rad\n" + rows, "joints.csv"),
      "run", true);
}

TEST(JointLogs, AStepUnderALagIsTheClosedForm) {
  // Times since an epoch keep their precision.
  const JointLogs set = logs_of(
      "0,1200000000.000,arm,0.2,0.2\n0,1200000000.010,arm,1.2,0.2\n"
      "0,1200000000.025,arm,1.2,0.2\n0,1200000000.075,arm,1.2,0.2\n");
  const auto angles =
      predict_joint_log(model_in_blocks("  servo_lag: {tau_s: 0.05}"), set, set.logs[0], 0.2);
  EXPECT_DOUBLE_EQ(angles[0], 0.2);
  EXPECT_DOUBLE_EQ(angles[1], 0.2);
  EXPECT_NEAR(angles[2], 1.2 - std::exp(-0.015 / 0.05), 1e-9);
  EXPECT_NEAR(angles[3], 1.2 - std::exp(-0.065 / 0.05), 1e-9);
}

// Eight rows of a joint that begins to fall lie on a cubic by luck, as if it had moved before; the
// scatter of the other logs says that they do.
TEST(JointLogs, RowsOnACurveByLuckAreNoRate) {
  const double mrad[] = {0.884, 0.288, -0.355, -1.454, -4.245, -9.195, -17.445, -29.258};
  std::string rows;
  for (size_t k = 0; k < std::size(mrad); ++k)
    rows += fmt::format("0,{:.2f},arm,0,{}\n", 0.01 * static_cast<double>(k), 1e-3 * mrad[k]);
  EXPECT_LT(logs_of(rows).logs[0].start_radps, -0.05);  // Alone it says so.
  const double rests[] = {0.4, -0.4, -0.4, 0.4, 0.4, -0.4, 0.4, -0.4};
  for (const int run : {1, 2, 3}) {
    for (size_t k = 0; k < std::size(rests); ++k)
      rows +=
          fmt::format("{},{:.2f},arm,0,{}\n", run, 0.01 * static_cast<double>(k), 1e-3 * rests[k]);
  }
  EXPECT_EQ(logs_of(rows).logs[0].start_radps, 0);
}

// Where no residual is left there is no spread that could vary.
TEST(JointLogs, AServoThatNeverErrsHasNoStructure) {
  const auto folder = std::filesystem::path(testing::TempDir()) / "never-errs";
  std::filesystem::create_directories(folder);
  std::string rows = "run,time_s,joint,command_rad,measured_rad\n";
  for (int k = 0; k < 240; ++k) rows += fmt::format("{},{:.2f},pan,0,0\n", k / 60, 0.01 * (k % 60));
  write_file_atomically(folder / "joints.csv", rows);
  write_file_atomically(folder / "measurement.yaml",
                        "format: seam-measurement/1\nkind: joints\nnoise: {measured_rad: 0.001}\n"
                        "files: {joints: joints.csv}\n");
  const auto problem = open_problem(folder);
  const Model model = model_in_blocks("  ideal_servo: {}");
  problem->prepare(model);
  EXPECT_THAT(problem->structure(model, problem->all_groups(), 0), testing::IsEmpty());
}

TEST(JointLogs, EncodersLogTheInverse) {
  const JointLogs set = logs_of("0,0,arm,0.5,0.4\n0,0.01,arm,0.5,0.4\n");
  const auto angles =
      predict_joint_log(model_in_blocks("  ideal_servo: {}\n  encoder_offset: {pan_rad: 0.1}\n"
                                        "  encoder_scale: {pan_scale: 0.25}"),
                        set, set.logs[0], 0.4);
  EXPECT_NEAR(angles[1] * 1.25 + 0.1, 0.5, 1e-12);
}

TEST(JointLogs, BadRowsAreNamed) {
  const std::pair<const char*, const char*> bad[] = {
      {"0,0.1,arm,0,0\n0,0.1,arm,0,0\n",
       "joints.csv:3: column time_s: found '0.1', expected a later time than the row before it in "
       "its run"},
      {"0,0.1,arm,nan,0\n",
       "joints.csv:2: column command_rad: found 'nan', expected a finite number"},
      {"0,0.1,,0,0\n", "joints.csv:2: column joint: found '', expected the joint's name"},
      {"0,0.1,arm,0,1e9\n",
       "joints.csv:2: column measured_rad: found '1e9', expected an angle in radians"}};
  for (const auto& [rows, expected] : bad) {
    try {
      logs_of(rows);
      ADD_FAILURE() << rows;
    } catch (const InputError& error) {
      EXPECT_TRUE(std::string(error.what()).starts_with(expected)) << error.what();
    }
  }
}

// Noise makes a log that rests within its dead band fit several rows by where it starts: that is
// worth what remains when the start takes all values, summed here in small steps.
TEST(JointLogs, AStartThatHoldsOnIsNoGain) {
  constexpr double kNoise = 0.001;
  const std::vector<double> rest = {0.0012, -0.0004, 0.0009, 0.0017, 0.0001};
  std::string rows = "run,time_s,joint,command_rad,measured_rad\n";
  for (size_t k = 0; k < 10; ++k) {
    rows += fmt::format("0,{:.2f},arm,{},{}\n", 0.01 * static_cast<double>(k), k < 4 ? 0 : 0.5,
                        k < rest.size() ? rest[k] : 0.5);
  }
  const auto folder = std::filesystem::path(testing::TempDir()) / "joint-start";
  std::filesystem::create_directories(folder);
  write_file_atomically(folder / "joints.csv", rows);
  write_file_atomically(folder / "measurement.yaml",
                        "format: seam-measurement/1\nkind: joints\nfiles: {joints: joints.csv}\n"
                        "group: run\nnoise: {measured_rad: 0.001}\n");
  const JointsProblem problem(MeasurementSet::open(folder));
  const auto likelihood = [&](const std::string& effects) {
    return problem.score(model_in_blocks(effects), problem.all_groups()).log_likelihood;
  };
  double held = 0, free = 0;  // Over all starts: of all five rows, of the first alone.
  for (double start = -0.01; start < 0.01; start += 1e-6) {
    double misses = 0;
    for (const double r : rest) misses += std::pow((r - start) / kNoise, 2);
    held += std::exp(-0.5 * misses);
    free += std::exp(-0.5 * std::pow((rest[0] - start) / kNoise, 2));
  }
  double at_command = 0;
  for (size_t k = 1; k < rest.size(); ++k) at_command += std::pow(rest[k] / kNoise, 2);
  EXPECT_NEAR(likelihood("  ideal_servo: {}\n  stiction: {dead_band_rad: 0.01}") -
                  likelihood("  ideal_servo: {}"),
              std::log(held) - (std::log(free) - 0.5 * at_command), 1e-6);
}

TEST(JointNoise, IsFoundUnderASwing) {
  const RandomStream random{3, 1};
  std::vector<double> t, x;
  for (int k = 0; k < 4000; ++k) {
    t.push_back(0.008 * k + 0.001 * uniform(random, k));
    x.push_back(0.5 * std::sin(12 * t.back()) + 0.001 * normal(random, 10000 + k));
  }
  EXPECT_NEAR(noise_from_neighbours({t}, {x}), 0.001, 0.00006);
}

// Three rows in four repeat a step of the encoder while the joint rests: the rounding of those that
// move is the noise, and none of the file's last digits.
TEST(JointNoise, IsThatOfRowsThatMove) {
  constexpr double kStep_rad = 0.0015;
  std::vector<double> t, x;
  for (int k = 0; k < 4000; ++k) {
    t.push_back(0.005 * k);
    const double q = k % 1000 < 750 ? 0 : 0.5 * std::sin(0.02 * (k % 1000 - 750));
    x.push_back(kStep_rad * std::round(q / kStep_rad));
    if (k % 1000 > 750 && k % 7 == 0) x.back() += 2e-6;  // The file's own rounding.
  }
  EXPECT_NEAR(noise_from_neighbours({t}, {x}), kStep_rad / std::sqrt(12),
              0.2 * kStep_rad / std::sqrt(12));
}

// Runs whose hashes say which third is held out: 1, 4, 5 and 13, where nothing else decides.
JointsProblem twelve_runs(const std::string& column,
                          const std::function<int(int run, int row)>& cell) {
  const auto folder = std::filesystem::path(testing::TempDir()) / ("joints-third-" + column);
  std::filesystem::create_directories(folder);
  std::string rows = "run,time_s,joint,command_rad,measured_rad," + column + "\n";
  for (const int run : {0, 1, 2, 3, 4, 5, 6, 7, 12, 13, 14, 15}) {
    for (int k = 0; k < 20; ++k)
      rows += fmt::format("{},{:.2f},arm,0.5,{:.3f},{}\n", run, 0.01 * k, 0.001 * (k % 3),
                          cell(run, k));
  }
  write_file_atomically(folder / "joints.csv", rows);
  write_file_atomically(folder / "measurement.yaml",
                        "format: seam-measurement/1\nkind: joints\ntitle: third\ngroup: run\n"
                        "files: {joints: joints.csv}\n");
  return JointsProblem(MeasurementSet::open(folder));
}

TEST(JointLogs, OfAllRunsWithoutTorqueOneTrains) {
  const JointsProblem problem = twelve_runs("torque_enable", [](int run, int row) {
    return (run == 1 || run == 5 || run == 13) && row > 10 ? 0 : 1;
  });
  ASSERT_EQ(problem.folds().size(), 1u);
  const Groups& held = problem.folds()[0];
  EXPECT_EQ(std::count(held.begin(), held.end(), 1), 4);
  EXPECT_FALSE(held[1]);  // Run 1, the first that falls.
  EXPECT_TRUE(held[5]);
  EXPECT_TRUE(held[9]);  // Run 13.
}

TEST(JointLogs, TheOnlyRunWhoseDutyMaySaturateTrains) {
  const JointsProblem problem = twelve_runs("kp", [](int run, int) { return run == 4 ? 8 : 2; });
  ASSERT_EQ(problem.folds().size(), 1u);
  const Groups& held = problem.folds()[0];
  EXPECT_EQ(std::count(held.begin(), held.end(), 1), 4);
  EXPECT_FALSE(held[4]);
}

// A lag's answer to a command is an exponential: each sample's error is a sum over the commands
// before it of change / tau * exp(-age / tau), times their draws.
TEST(JointLogs, LateCommandsAreWhitenedAsByTheWholeCovarianceOfALag) {
  constexpr double kTau_s = 0.05, kLatency_s = 0.005, kSigma_s = 0.001, kNoise_rad = 0.0005;
  const Model truth = model_of(
      "  ideal_servo: {}\n  servo_lag: {tau_s: 0.05}\n  servo_latency: {latency_s: 0.005}\n"
      "  command_jitter: {sigma_s: 0.001}\n");
  const MadeSet set("late_commands", /*releases=*/false);
  const JointsProblem problem = set.made_by(truth, 7);
  const Evaluation here = problem.evaluate(truth, problem.all_groups(), nullptr);
  const JointLogs logs = read_joint_logs(
      MeasurementSet::open(std::filesystem::path(testing::TempDir()) / "late_commands" / "made")
          .table("joints"),
      "run", true);
  double chi2 = 0, whole_chi2 = 0, white_chi2 = 0;
  for (const JointLog& log : logs.logs) {
    const auto n = static_cast<Eigen::Index>(log.rows.size());
    Eigen::MatrixXd by_draw = Eigen::MatrixXd::Zero(n, n);
    for (Eigen::Index k = 0; k < n; ++k) {
      const double before = k == 0 ? log.measured_rad[0] : log.command_rad[k - 1];
      for (Eigen::Index j = k + 1; j < n; ++j) {
        const double age_s = log.time_s[j] - log.time_s[k] - kLatency_s;
        by_draw(j, k) = (log.command_rad[k] - before) / kTau_s * std::exp(-age_s / kTau_s);
      }
    }
    const Eigen::MatrixXd whole = kSigma_s * kSigma_s * by_draw * by_draw.transpose() +
                                  kNoise_rad * kNoise_rad * Eigen::MatrixXd::Identity(n, n);
    Eigen::VectorXd residual(n);
    for (Eigen::Index k = 0; k < n; ++k) residual[k] = here.residual[log.rows[k]];
    whole_chi2 += residual.dot(whole.llt().solve(residual));
    white_chi2 += residual.squaredNorm() / (kNoise_rad * kNoise_rad);
    for (const size_t row : log.rows) chi2 += here.whitened[row] * here.whitened[row];
  }
  EXPECT_NEAR(chi2, whole_chi2, 0.01 * whole_chi2);
  const double rows = 6 * 300;
  EXPECT_NEAR(chi2, rows, 4 * std::sqrt(2 * rows));
  EXPECT_GT(white_chi2, 5 * rows);
}

// A joint that dry friction holds where it starts is measured there by its first rows: what late
// commands make of it later says nothing of that.
TEST(JointLogs, ALateCommandDoesNotMoveWhereAStuckJointStarts) {
  constexpr double kNoise_rad = 0.0005;
  const Model truth = model_of(
      "  motor_servo: {stall_rad_per_s2: 800, back_emf_per_s: 20, gain: 0.25}\n"
      "  coulomb_friction: {rad_per_s2: 20}\n  servo_latency: {latency_s: 0.005}\n"
      "  command_jitter: {sigma_s: 0.002}\n");
  const MadeSet set("late_stuck", /*releases=*/false);
  const JointsProblem problem = set.made_by(truth, 11);
  const Evaluation here = problem.evaluate(truth, problem.all_groups(), nullptr);
  double chi2 = 0, white_chi2 = 0;
  for (size_t i = 0; i < here.whitened.size(); ++i) {
    chi2 += here.whitened[i] * here.whitened[i];
    white_chi2 += here.residual[i] * here.residual[i] / (kNoise_rad * kNoise_rad);
  }
  const auto rows = static_cast<double>(here.whitened.size());
  EXPECT_GT(white_chi2, 5 * rows);
  EXPECT_NEAR(chi2, rows, 5 * std::sqrt(2 * rows));
}

TEST(JointLogs, LateCommandsOfAServoThatIsThereAtOnceAreSaidToShowNothing) {
  const std::string at_once = "  ideal_servo: {}\n", late = "  command_jitter: {sigma_s: 0.001}\n";
  EXPECT_THAT(why_late_commands_hide(model_of(at_once + late)),
              testing::HasSubstr("shows nothing"));
  EXPECT_EQ(why_late_commands_hide(model_of(at_once)), "");
  EXPECT_EQ(why_late_commands_hide(model_of(at_once + "  servo_lag: {tau_s: 0.05}\n" + late)), "");
  EXPECT_THAT(why_late_commands_hide(
                  model_of(at_once + "  elastic_joint: {period_s: 0.1, damping: 0.1}\n" + late)),
              testing::HasSubstr("elastic"));
  const MadeSet set("late_at_once", /*releases=*/false);
  const JointsProblem problem = set.made_by(model_of(at_once + late), 3);
  EXPECT_THAT(problem.remarks(model_of(at_once + late)),
              testing::Contains(testing::HasSubstr("command_jitter shows nothing")));
}

// As it is made, its size is found, beside the values of the mean.
TEST(JointLogs, TheScatterOfCommandsHasItsSize) {
  const std::string motor =
      "  motor_servo: {stall_rad_per_s2: 800, back_emf_per_s: 20, gain: 0.25}\n"
      "  servo_latency: {latency_s: 0.005}\n";
  const MadeSet set("late_size", /*releases=*/false);
  const JointsProblem problem =
      set.made_by(model_of(motor + "  command_jitter: {sigma_s: 0.0015}\n"), 9);
  const Model start =
      model_of(motor + "  command_jitter: {sigma_s: {value: 0.0005, free: true}}\n");
  const Fit fit = fitted_to_all(problem, start);
  EXPECT_NEAR(fit.value[0], 0.0015, 3.5 * fit.sigma[0]);
  EXPECT_LT(fit.sigma[0], 0.0005);
}

// Logs with pauses: no motor is followed through hours of them.
const std::string kDriven = "  motor_servo: {stall_rad_per_s2: 300, back_emf_per_s: 20, gain: 4}\n";
const std::string kOnASpring = "  servo_lag: {tau_s: 0.02}\n  elastic_joint: {period_s: 0.1}\n";
const std::string kLagging = "  servo_lag: {tau_s: 0.02}\n";

// Two runs whose rows stand at these times.
std::filesystem::path paused_set(const std::string& name,
                                 const std::function<double(int)>& time_s) {
  const auto folder = std::filesystem::path(testing::TempDir()) / name;
  std::filesystem::create_directories(folder);
  std::string rows = "run,time_s,joint,command_rad,measured_rad\n";
  for (const char* run : {"a", "b"}) {
    for (int k = 0; k < 60; ++k)
      rows += fmt::format("{},{:.3f},arm,{:.4f},{:.4f}\n", run, time_s(k), 0.5 * std::sin(0.2 * k),
                          0.48 * std::sin(0.2 * k - 0.1));
  }
  write_file_atomically(folder / "joints.csv", rows);
  write_file_atomically(folder / "measurement.yaml",
                        "format: seam-measurement/1\nkind: joints\nfiles: {joints: joints.csv}\n");
  return folder;
}

double after_hours(int k) {
  return 0.01 * k + (k < 30 ? 0 : 1e4);
}

void expect_refused(const std::filesystem::path& folder, const std::string& place) {
  const MeasurementSet set = MeasurementSet::open(folder);
  const JointsProblem problem(set);
  for (const std::string& moving : {kDriven, kOnASpring}) {
    const auto told = testing::ThrowsMessage<InputError>(
        testing::AllOf(testing::HasSubstr(place), testing::HasSubstr("expected at most"),
                       testing::HasSubstr("moves the joint all that time")));
    EXPECT_THAT([&] { problem.check_model(model_of(moving)); }, told);
    const MeasureOptions options{.out = folder / "made"};
    EXPECT_THAT([&] { measure_joints(model_of(moving), set, options); }, told);
  }
  EXPECT_NO_THROW(problem.check_model(model_of(kLagging)));
  const Model lag = model_of(kLagging);
  for (const char* name : {"motor_servo", "elastic_joint"})
    EXPECT_THAT(problem.not_testable(lag, *effects::find_effect(name), 0),
                testing::HasSubstr(place));
  EXPECT_EQ(problem.not_testable(lag, *effects::find_effect("speed_limit"), 0), "");
}

TEST(Pauses, OfHoursAreNoRunOfAMotor) {
  expect_refused(paused_set("pause_of_hours", after_hours),
                 "joints.csv:32: rows of one run are up to");
}

TEST(Pauses, RowsThatAreAllFarApartShowNoMotor) {
  expect_refused(paused_set("rows_far_apart", [](int k) { return 50.0 * k; }),
                 "joints.csv: rows of a run are 50 s apart in the mean");
}

TEST(Pauses, NoSetIsMadeOfAMotorThatCannotBeFollowed) {
  const auto folder = paused_set("too_stiff", [](int k) { return 0.01 * k + (k < 30 ? 0 : 40); });
  const std::string swinging = "  motor_servo: {stall_rad_per_s2: 1e6, gain: 1e5}\n";
  EXPECT_THAT(
      [&] {
        measure_joints(model_of(swinging), MeasurementSet::open(folder), {.out = folder / "made"});
      },
      testing::ThrowsMessage<InputError>(testing::HasSubstr("joints.csv:")));
  EXPECT_FALSE(std::filesystem::exists(folder / "made"));
}

TEST(Pauses, OfSecondsAreFollowed) {
  const auto folder =
      paused_set("pause_of_seconds", [](int k) { return 0.01 * k + (k < 30 ? 0 : 20); });
  const JointsProblem problem(MeasurementSet::open(folder));
  EXPECT_NO_THROW(problem.check_model(model_of(kDriven)));
  EXPECT_EQ(problem.not_testable(model_of(kLagging), *effects::find_effect("motor_servo"), 0), "");
}

}  // namespace
}  // namespace seam::measurement
