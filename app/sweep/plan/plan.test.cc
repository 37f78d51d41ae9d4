#include "app/sweep/plan/plan.h"

#include <cmath>
#include <set>

#include "app/simulator.h"
#include "app/sweep/sweep_testing.h"

namespace seam::app {
namespace {

std::vector<std::string> row(const SweepPlan& plan, uint64_t run) {
  std::vector<std::string> texts;
  for (const WrittenValue& value : plan.settings(run).values) texts.push_back(value.text);
  return texts;
}

double number(const SweepPlan& plan, uint64_t run, size_t parameter = 0) {
  return std::stod(plan.settings(run).values.at(parameter).text);
}

TEST(SweepPlan, AllCombinationsInTheOrderOfThePlan) {
  const SweepPlan plan = PlanFolder(R"(
set: {duration_s: 0.5}
vary:
  - {path: seed, range: [3, 5]}
  - {path: "robots[0].camera.model.effects.rolling_shutter.line_delay_s", values: [0, 1e-4]})")
                             .plan();
  ASSERT_EQ(plan.runs(), 6);
  EXPECT_THAT(row(plan, 0), testing::ElementsAre("3", "0"));
  EXPECT_THAT(row(plan, 1), testing::ElementsAre("3", "1e-4"));
  EXPECT_THAT(row(plan, 5), testing::ElementsAre("5", "1e-4"));
  const Scenario scenario = plan.scenario(5);
  EXPECT_EQ(scenario.seed, 5);
  EXPECT_EQ(scenario.duration, SimDuration::from_s(0.5));
  EXPECT_EQ(models_of(scenario)[0].find("rolling_shutter")->value("line_delay_s"), 1e-4);
}

// `seeds:` takes a short way, the same settings under `vary` the long one.
TEST(SweepPlan, RunsThatDifferByTheirSeedAreThoseOfTheLongWay) {
  const std::string places = "{path: \"robots[0].pose.x_m\", values: [-0.5, 0.25]}";
  const SweepPlan quick =
      PlanFolder("vary: [" + places + "]\nseeds: [4, 6]\nrepetitions: 2").plan();
  const SweepPlan thorough =
      PlanFolder("vary: [" + places + ", {path: seed, range: [4, 6]}]\nrepetitions: 2").plan();
  ASSERT_EQ(quick.runs(), 12);
  ASSERT_EQ(thorough.runs(), 12);
  for (uint64_t run = 0; run < 12; ++run)
    EXPECT_EQ(quick.scenario(run).to_yaml(), thorough.scenario(run).to_yaml()) << run;
}

TEST(SweepPlan, RangesHoldTheirLastValue) {
  const auto last = [](const std::string& range) {
    const SweepPlan plan =
        PlanFolder("vary: [{path: \"robots[0].pose.x_m\", range: " + range + "}]").plan();
    return std::pair(plan.runs(), row(plan, plan.runs() - 1)[0]);
  };
  EXPECT_EQ(last("[0, 1], step: 0.1"), (std::pair<uint64_t, std::string>(11, "1")));
  EXPECT_EQ(last("[-1, 1], step: 0.3"),
            (std::pair<uint64_t, std::string>(7, "0.7999999999999998")));
  EXPECT_EQ(last("[-2, 2]"), (std::pair<uint64_t, std::string>(5, "2")));
  EXPECT_EQ(last("[1, 6], step: 2"), (std::pair<uint64_t, std::string>(3, "5")));
}

// Their moments and bounds, against those of the distributions.
TEST(SweepPlan, DrawsFollowTheirDistributions) {
  const SweepPlan plan = PlanFolder(R"(
vary:
  - draws: 20000
    seed: 4
    of:
      - {path: "robots[0].pose.x_m", uniform: [-1, 2]}
      - {path: "robots[0].pose.y_m", normal: [0.5, 0.1]}
      - {path: "robots[0].head_speed_radps", log_uniform: [0.01, 10]}
      - {path: "robots[0].number", integer: [1, 6]})")
                             .plan();
  double sum[4] = {}, squares[4] = {};
  std::set<double> wholes;
  for (uint64_t run = 0; run < plan.runs(); ++run) {
    for (size_t p = 0; p < 4; ++p) {
      const double value = p == 2 ? std::log(number(plan, run, p)) : number(plan, run, p);
      sum[p] += value, squares[p] += value * value;
    }
    EXPECT_TRUE(number(plan, run, 0) > -1 && number(plan, run, 0) < 2);
    wholes.insert(number(plan, run, 3));
  }
  const double n = 20000;
  const double means[4] = {0.5, 0.5, 0.5 * (std::log(0.01) + std::log(10)), 3.5};
  const double variances[4] = {9.0 / 12, 0.01, std::pow(std::log(1000), 2) / 12, 35.0 / 12};
  for (size_t p = 0; p < 4; ++p) {
    EXPECT_NEAR(sum[p] / n, means[p], 5 * std::sqrt(variances[p] / n)) << p;
    EXPECT_NEAR(squares[p] / n - std::pow(sum[p] / n, 2), variances[p], 0.05 * variances[p]) << p;
  }
  EXPECT_THAT(wholes, testing::ElementsAre(1, 2, 3, 4, 5, 6));
}

TEST(SweepPlan, ADrawDependsOnItsSeedPathAndNumberAlone) {
  const std::string draw = R"({path: "robots[0].pose.x_m", uniform: [0, 1])";
  const SweepPlan alone = PlanFolder("vary: [" + draw + ", draws: 10, seed: 2}]").plan();
  const SweepPlan beside = PlanFolder(
                               "vary: [{draws: 50, seed: 2, of: [{path: "
                               "\"robots[0].pose.y_m\", uniform: [0, 1]}, " +
                               draw + "}]}]")
                               .plan();
  const SweepPlan other = PlanFolder("vary: [" + draw + ", draws: 10, seed: 3}]").plan();
  for (uint64_t run = 0; run < 10; ++run) {
    EXPECT_EQ(row(alone, run)[0], row(beside, run)[1]);
    EXPECT_NE(row(beside, run)[0], row(beside, run)[1]);
    EXPECT_NE(row(alone, run)[0], row(other, run)[0]);
  }
}

TEST(SweepPlan, SeedsAndRepetitions) {
  const SweepPlan plan = PlanFolder("seeds: [5, 6]\nrepetitions: 3").plan();
  ASSERT_EQ(plan.runs(), 6);
  std::set<int64_t> seeds;
  for (uint64_t run = 0; run < 6; ++run) {
    EXPECT_EQ(plan.settings(run).repetition, run % 3);
    seeds.insert(plan.scenario(run).seed);
  }
  EXPECT_EQ(plan.scenario(0).seed, 5);
  EXPECT_EQ(plan.scenario(3).seed, 6);
  EXPECT_EQ(seeds.size(), 6);
  EXPECT_GE(*seeds.begin(), 0);
}

TEST(SweepPlan, TablesAndFilesComeFromBesideThePlan) {
  const PlanFolder folder(R"(
vary:
  - {table: poses.csv, columns: {x: "robots[0].pose.x_m", cam: "robots[0].camera.model"}}
  - {path: [seed, "robots[0].number"], name: both, values: [3, 4]})");
  folder.write("poses.csv", "x,duration_s,cam\n-0.5,1,m.yaml\n0.25,2,m.yaml\n");
  folder.write("m.yaml",
               "format: seam-model/1\nname: mine\neffects: {pinhole: {fx_px: 100, "
               "fy_px: 100, cx_px: 88, cy_px: 72}}\n");
  const SweepPlan plan = folder.plan();
  ASSERT_EQ(plan.runs(), 4);
  const Scenario scenario = plan.scenario(3);
  EXPECT_EQ(scenario.robots[0].pose.x_m, 0.25);
  EXPECT_EQ(scenario.duration, SimDuration::from_s(2));
  EXPECT_EQ(scenario.seed, 4);
  EXPECT_EQ(scenario.robots[0].number, 4);
  EXPECT_EQ(models_of(scenario)[0].name(), "mine");
  // From its texts alone, wherever the files went.
  std::filesystem::remove(folder.path("m.yaml"));
  std::filesystem::remove(folder.path("poses.csv"));
  const SweepPlan again = SweepPlan::from_texts(plan.texts());
  EXPECT_EQ(again.scenario(3).to_yaml(), scenario.to_yaml());
  EXPECT_EQ(again.fingerprint(), plan.fingerprint());
}

TEST(SweepPlan, FingerprintsKnowWhatCounts) {
  const auto print = [](const std::string& lines) {
    return PlanFolder(lines).plan().fingerprint();
  };
  const uint64_t plain = print("vary: [{path: seed, range: [1, 3]}]");
  EXPECT_EQ(print("# A remark.\nvary:\n  - path: seed\n    range: [1, 3]"),
            print("vary:\n  - path: seed\n    range: [1, 3]"));
  EXPECT_NE(print("vary: [{path: seed, range: [1, 4]}]"), plain);
  EXPECT_NE(print("vary: [{path: seed, range: [1, 3]}]\nkeep: {logs: true}"), plain);
}

TEST(SweepPlan, SecretsStayOutOfIt) {
  const PlanFolder folder("");
  folder.write("s.yaml",
               "format: seam-scenario/1\nname: s\nduration_s: 1\nsupervisor_token: "
               "topsecret\nrobots: []\n");
  folder.write("plan.yaml", "format: seam-sweep/1\nscenario: s.yaml\n");
  EXPECT_THAT(folder.plan().texts().scenario, testing::Not(testing::HasSubstr("topsecret")));
}

TEST(SweepPlan, SlipsAreToldBeforeAnythingRuns) {
  const auto why = [](const std::string& lines) { return PlanFolder(lines).why_not(); };
  EXPECT_THAT(why("varry: []"), testing::HasSubstr("did you mean 'vary'?"));
  EXPECT_THAT(why("vary: [{path: sead, range: [1, 2]}]"), testing::HasSubstr("'seed'"));
  EXPECT_THAT(why("vary: [{path: seed, rang: [1, 2]}]"), testing::HasSubstr("'range'"));
  EXPECT_THAT(why("vary: [{path: seed, range: [2, 1]}]"), testing::HasSubstr("found 1"));
  EXPECT_THAT(why("vary: [{path: seed, range: [1, 2], values: [3]}]"), testing::HasSubstr("both"));
  EXPECT_THAT(why("vary: [{path: seed, draws: 3, unifrom: [1, 2]}]"),
              testing::HasSubstr("'uniform'"));
  EXPECT_THAT(why("vary: [{path: duration_s, values: [1, long]}]"),
              testing::HasSubstr("expected a number"));
  EXPECT_THAT(why("vary: [{path: \"robots[0].camera.model\", values: [no.yaml]}]"),
              testing::HasSubstr("no.yaml"));
  EXPECT_THAT(why("vary: [{path: seed, range: [1, 1000000000]}]"),
              testing::HasSubstr("has 1000000000 runs, expected at most 10000000"));
  EXPECT_THAT(why("vary: [{path: seed, range: [1, 1000000000000]}, {path: \"robots[0].number\", "
                  "range: [1, 1000000000000]}]"),
              testing::HasSubstr("expected at most 10000000"));
  EXPECT_THAT(why("vary: [{path: \"robots[0].number\", name: end, values: [1]}]"),
              testing::HasSubstr("two columns would be called 'end'"));
  EXPECT_THAT(why("keep: {values: [x], expressions: {y: xx + 1}}"),
              testing::HasSubstr("unknown name 'xx'"));
  EXPECT_THAT(why("keep: {values: [x], expressions: {y: x +}}"), testing::HasSubstr("keep"));
  EXPECT_THAT(why("keep: {values: [{name: x, statistic: man}]}"), testing::HasSubstr("'mean'"));
  EXPECT_THAT(why("keep: {summary: [frams]}"), testing::HasSubstr("'frames'"));
  EXPECT_EQ(why("vary: [{path: seed, range: [1, 200]}]"), "");
}

}  // namespace
}  // namespace seam::app
