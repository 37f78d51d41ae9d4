#include <gmock/gmock.h>

#include <cmath>

#include "effects/registry.h"
#include "measurement/kinds/joints/joints_testing.h"
#include "measurement/kinds/joints/torque/effort.h"
#include "measurement/search/models/add_effects.h"
#include "sim_core/base/error.h"

namespace seam::measurement {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr double kStalls = 200, kSlows = 10, kDutyGain = 0.5, kJointInertia = 0.04;
const std::string kSprungMotor =
    "  motor_servo: {stall_rad_per_s2: 200, back_emf_per_s: 10, gain: 0.5}\n";

fs::path effort_set(
    const std::string& name, const std::string& rows, const std::string& noise,
    const std::string& columns = "run,time_s,joint,command_rad,measured_rad,effort_nm") {
  const fs::path folder = fs::path(testing::TempDir()) / name;
  fs::create_directories(folder);
  write_file_atomically(folder / "joints.csv", columns + "\n" + rows);
  write_file_atomically(folder / "measurement.yaml",
                        "format: seam-measurement/1\nkind: joints\ntitle: made\n" + noise +
                            "group: run\nfiles: {joints: joints.csv}\n");
  return folder;
}

// Steps from rest of a spring with damping, in closed form; torques times `factor`, a blank one in
// each run.
std::string sprung_rows(double factor) {
  const double k = kStalls * kDutyGain, omega = std::sqrt(k - kSlows * kSlows / 4);
  std::string rows;
  for (int run = 0; run < 4; ++run) {
    const double way = 0.5 + 0.3 * run;
    for (int row = 0; row < 60; ++row) {
      const double t = 0.01 * row, fades = std::exp(-kSlows / 2 * t);
      const double q =
          way * (1 - fades * (std::cos(omega * t) + kSlows / 2 / omega * std::sin(omega * t)));
      const double w = way * k / omega * fades * std::sin(omega * t);
      const double torque = kJointInertia * (k * (way - q) - kSlows * w);
      rows += fmt::format("{},{:.2f},arm,{},{:.12f},{}\n", run, t, way, q,
                          row == 7 ? "" : fmt::format("{:.12f}", factor * torque));
    }
  }
  return rows;
}

JointsProblem joints_of(const fs::path& folder) {
  return JointsProblem(MeasurementSet::open(folder));
}

const std::string kNoises = "noise: {measured_rad: 0.001, effort_nm: 0.01}\n";

TEST(Effort, ResidualsAreThoseOfTheDriveInClosedForm) {
  JointsProblem problem = joints_of(effort_set("effort_spring", sprung_rows(1), kNoises));
  ASSERT_EQ(problem.facts().channels.size(), 2u);
  EXPECT_EQ(problem.facts().channels[1].name, "effort_nm");
  // No first rows, no blank ones.
  EXPECT_EQ(problem.facts().scalars(), 4u * (60 + 58));
  const Model truth = model_of(kSprungMotor + "  joint_inertia: {kg_m2: 0.04}\n");
  problem.prepare(truth);
  const Evaluation there = problem.evaluate(truth, problem.all_groups(), nullptr);
  for (size_t i = 0; i < there.residual.size(); ++i) {
    EXPECT_TRUE(there.used[i]);
    EXPECT_NEAR(there.residual[i], 0, 1e-8) << i;
  }
  const Model heavier = model_of(kSprungMotor + "  joint_inertia: {kg_m2: 0.05}\n");
  const Evaluation other = problem.evaluate(heavier, problem.all_groups(), nullptr);
  // The first torque of run 0, 10 ms after its step of 0.5 rad.
  const double omega = std::sqrt(75.0), fades = std::exp(-0.05);
  const double left = 0.5 * fades * (std::cos(0.01 * omega) + 5 / omega * std::sin(0.01 * omega));
  const double w = 0.5 * 100 / omega * fades * std::sin(0.01 * omega);
  EXPECT_NEAR(other.residual[240], (0.04 - 0.05) * (100 * left - 10 * w), 1e-8);
}

TEST(Effort, WithoutAnInertiaTheTorquesSayIt) {
  JointsProblem problem = joints_of(effort_set("effort_says", sprung_rows(1.25), kNoises));
  const Model model = model_of(kSprungMotor);
  problem.prepare(model);
  const auto findings = problem.findings(model);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_NEAR(findings[0].values[0].second, 1.25 * kJointInertia, 1e-8);
  const Evaluation there = problem.evaluate(model, problem.all_groups(), nullptr);
  for (const double r : there.residual) EXPECT_NEAR(r, 0, 1e-7);
}

TEST(Effort, TorquesOfTheOtherSignAreSaid) {
  JointsProblem problem = joints_of(effort_set("effort_sign", sprung_rows(-1), kNoises));
  const Model model = model_of(kSprungMotor);
  problem.prepare(model);
  EXPECT_THAT(problem.findings(model)[0].text, HasSubstr("other sign"));
}

TEST(Effort, AModelWithoutTorqueIgnoresTheColumn) {
  JointsProblem with = joints_of(effort_set("effort_kinematic", sprung_rows(1), kNoises));
  std::string rows = sprung_rows(1), without;
  for (size_t from = 0; from < rows.size();) {
    const size_t to = rows.find('\n', from), comma = rows.rfind(',', to);
    without += rows.substr(from, comma - from) + "\n";
    from = to + 1;
  }
  JointsProblem plain =
      joints_of(effort_set("effort_none", without, "noise: {measured_rad: 0.001}\n",
                           "run,time_s,joint,command_rad,measured_rad"));
  const Model lag = model_of("  ideal_servo: {}\n  servo_lag: {tau_s: 0.05}\n");
  with.prepare(lag), plain.prepare(lag);
  const Score a = with.score(lag, with.all_groups()), b = plain.score(lag, plain.all_groups());
  EXPECT_EQ(a.n, b.n);
  EXPECT_EQ(a.log_likelihood, b.log_likelihood);
  ASSERT_FALSE(with.remarks(lag).empty());
  EXPECT_THAT(with.remarks(lag).back(), HasSubstr("effort_nm takes no part"));
  // What a search from there ends with predicts it, but was not held against it.
  EXPECT_THAT(with.remarks(model_of(kSprungMotor)),
              testing::ElementsAre(HasSubstr("effort_nm took no part")));
  EXPECT_TRUE(with.findings(model_of(kSprungMotor)).empty());
  EXPECT_TRUE(plain.remarks(lag).empty());
}

TEST(Effort, BadTorquesAreErrorsWithTheirPlace) {
  const auto fails = [](const std::string& cell) -> std::string {
    try {
      joints_of(effort_set("effort_bad", "0,0,arm,1,0,0.5\n0,0.01,arm,1,0.1," + cell + "\n", ""));
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(fails("much"), HasSubstr("joints.csv:3: column effort_nm"));
  EXPECT_THAT(fails("nan"), HasSubstr("joints.csv:3: column effort_nm"));
  EXPECT_THAT(fails("2e6"), HasSubstr("N mm is to be divided by 1000"));
}

TEST(Effort, AColumnThatSaysNothingTakesNoPart) {
  const auto notes = [](const std::string& cell) {
    const JointsProblem problem = joints_of(effort_set(
        "effort_flat", fmt::format("0,0,arm,1,0,{0}\n0,0.01,arm,1,0.1,{0}\n", cell), ""));
    EXPECT_EQ(problem.facts().channels.size(), 1u);
    return problem.facts().notes.empty() ? "" : problem.facts().notes.back();
  };
  EXPECT_THAT(notes("0"), HasSubstr("effort_nm is 0 wherever"));
  EXPECT_THAT(notes(""), HasSubstr("effort_nm is blank in all rows"));
}

// Steps at one gain whose duty never saturates: angles have the sum of back-EMF and viscous
// friction alone.
const std::string kAlike =
    "  motor_servo: {stall_rad_per_s2: 800, back_emf_per_s: 12, gain: 0.25}\n"
    "  viscous_friction: {per_s: 6}\n  gravity_torque: {rad_per_s2: 30, level_rad: 0.4}\n"
    "  coulomb_friction: {rad_per_s2: 10}\n";

fs::path made_efforts(const std::string& name, const std::string& truth, const std::string& noise) {
  std::string rows;
  for (int run = 0; run < 4; ++run) {
    for (int k = 0; k < 200; ++k)
      rows += fmt::format("{},{:.2f},arm,{:.4f},0,\n", run, 0.01 * k,
                          0.6 * std::sin(1.7 * run + 2.6 * (k / 40)));
  }
  const fs::path folder = effort_set(name, rows, noise), out = folder / "made";
  fs::remove_all(out);
  measure_joints(model_of(truth), MeasurementSet::open(folder), {.seed = 3, .out = out});
  return out;
}

const std::string kMadeNoise = "noise: {measured_rad: 0.0005, effort_nm: 0.05}\n";

TEST(Effort, TellsBackEmfFromViscousFriction) {
  const auto out =
      made_efforts("effort_alike", kAlike + "  joint_inertia: {kg_m2: 0.05}\n", kMadeNoise);
  const JointsProblem problem = joints_of(out);
  const Model start = model_of(
      "  motor_servo: {stall_rad_per_s2: {value: 780, free: true}, "
      "back_emf_per_s: {value: 9, free: true}, gain: 0.25}\n"
      "  viscous_friction: {per_s: {value: 9, free: true}}\n"
      "  gravity_torque: {rad_per_s2: {value: 28, free: true}, level_rad: {value: 0.4, free: "
      "true}}\n"
      "  coulomb_friction: {rad_per_s2: {value: 9, free: true}}\n"
      "  joint_inertia: {kg_m2: {value: 0.07, free: true}}\n");
  const Fit fit = fitted_to_all(problem, start);
  const auto unknowns = refitted_unknowns(start);
  const auto expect_near = [&](const char* effect, size_t parameter, double truth, double sigma) {
    const size_t i = index_of(unknowns, {effect, parameter}).value();
    EXPECT_NEAR(fit.value[i], truth, 3.5 * fit.sigma[i]) << effect;
    EXPECT_LT(fit.sigma[i], sigma) << effect;
  };
  expect_near("motor_servo", 1, 12, 0.3);
  expect_near("viscous_friction", 0, 6, 0.3);
  expect_near("joint_inertia", 0, 0.05, 0.001);
}

TEST(Effort, AWrongTorqueConstantIsMeasuredWhereTheInertiaIsStated) {
  const auto out = made_efforts("effort_wrong",
                                kAlike +
                                    "  joint_inertia: {kg_m2: 0.05}\n"
                                    "  effort_scale: {scale: 0.15}\n"
                                    "  effort_offset: {nm: 0.2}\n",
                                kMadeNoise);
  JointsProblem problem = joints_of(out);
  const AddResult added =
      add_effects(problem, model_of(kAlike + "  joint_inertia: {kg_m2: 0.05}\n"),
                  {effects::find_effect("effort_scale"), effects::find_effect("effort_offset")});
  EXPECT_NEAR(added.error_after, 1, 0.1);
  for (const auto& [name, value] : added.parameters) {
    const double truth = name == "nm" ? 0.2 : 0.15;
    EXPECT_NEAR(value.value, truth, 4 * value.sigma.value()) << name;
    EXPECT_LT(value.sigma.value(), 0.01) << name;
  }
}

TEST(Effort, AScaleIsNotTestableBesideAnInertiaThatTheTorquesSay) {
  JointsProblem problem = joints_of(effort_set("effort_tied", sprung_rows(1), kNoises));
  const auto scale = effects::find_effect("effort_scale");
  for (const std::string inertia : {"", "  joint_inertia: {kg_m2: {value: 0.04, free: true}}\n"}) {
    const Model model = model_of(kSprungMotor + inertia);
    problem.prepare(model);
    EXPECT_THAT(problem.not_testable(model, *scale, 0), HasSubstr("joint_inertia"));
  }
  const Model known = model_of(kSprungMotor + "  joint_inertia: {kg_m2: 0.04}\n");
  problem.prepare(known);
  EXPECT_EQ(problem.not_testable(known, *scale, 0), "");
}

TEST(Effort, MeasureLeavesBlanksAndMakesNoTorqueWithoutAnInertia) {
  const auto folder =
      effort_set("effort_blanks", "0,0,arm,1,0,\n0,0.01,arm,1,0.1,3\n0,0.02,arm,1,0.1,4\n", "");
  const auto cells = [&](const std::string& truth) {
    fs::remove_all(folder / "made");
    measure_joints(model_of(truth), MeasurementSet::open(folder),
                   {.noise = false, .out = folder / "made"});
    return MeasurementSet::open(folder / "made").table("joints").texts(kEffort);
  };
  const auto made = cells(kSprungMotor + "  joint_inertia: {kg_m2: 0.04}\n");
  EXPECT_EQ(made[0], "");
  EXPECT_NE(made[1], "");
  EXPECT_NE(made[1], "3");
  EXPECT_EQ(cells(kSprungMotor), std::vector<std::string>(3));
}

}  // namespace
}  // namespace seam::measurement
