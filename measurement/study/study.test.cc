// A quick form of the studies, and proposals of formulas.
#include "measurement/study/study.h"

#include <gtest/gtest.h>

#include <cmath>

#include "measurement/kinds/kinds.h"
#include "measurement/suggest/term.h"
#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

void silent(const std::string&) {}

// All jobs in this process.
bool one_by_one(uint64_t first, uint64_t last, const std::function<std::string(uint64_t)>& work,
                const std::function<void(uint64_t, const std::string&)>& done) {
  for (uint64_t job = first; job < last; ++job) done(job, work(job));
  return true;
}

std::filesystem::path scratch(const std::string& name) {
  return std::filesystem::path(testing::TempDir()) / name;
}

TEST(Rate, WilsonsInterval) {
  // Brown, Cai and DasGupta (2001): no successes in 10 trials give 0 to 0.2775.
  EXPECT_NEAR((Rate{0, 10}.low()), 0, 1e-12);
  EXPECT_NEAR((Rate{0, 10}.high()), 0.2775, 1e-4);
  EXPECT_NEAR((Rate{95, 100}.low()), 0.8882, 1e-3);
}

TEST(Study, TwoSeedsOfEachKind) {
  for (const auto& [kind, effect] :
       {std::pair("points", "frame_latency"), std::pair("landmarks", "range_scale"),
        std::pair("joints", "gravity_sag"), std::pair("odometry", "odometry_scale"),
        std::pair("photometry", "vignetting")}) {
    const StudyPlan plan{
        .kind = kind, .effect = effect, .sizes = {12}, .seeds = 2, .folder = scratch("study")};
    const StudyResult result = study(plan, one_by_one);
    EXPECT_GT(result.residuals, 500u) << kind;
    EXPECT_LT(result.residuals, kind == std::string("photometry") ? 10000u : 2000u) << kind;
    ASSERT_EQ(result.rows.size(), 1u);
    EXPECT_EQ(result.rows[0].first.hits, 2) << study_text(plan, result);
    EXPECT_NEAR(result.rows[0].error, 1.0, 0.15) << kind;
  }
}

// The first row of a servo log holds the start that is fitted to it, and nothing else.
TEST(Study, StartsOfServoLogsAreNoStructure) {
  const StudyPlan plan{.kind = "joints", .seeds = 3, .folder = scratch("study-none")};
  const StudyResult result = study(plan, one_by_one);
  EXPECT_EQ(result.rows.at(0).alarms.hits, 0) << study_text(plan, result);
}

// Fewer groups leave fewer residuals; a smooth misfit of five hundredths is seen by nobody who
// asks for what matters, errors that wander are told for what they are.
TEST(Study, SetsLikeRecordings) {
  StudyPlan plan{.kind = "landmarks",
                 .material = 0.1,
                 .conditions = {.groups = 4, .uneven = true, .misfit = 0.05},
                 .seeds = 2,
                 .folder = scratch("study-conditions")};
  const StudyResult quiet = study(plan, one_by_one);
  EXPECT_EQ(quiet.residuals, 4u * 20 * 3 * 2);
  EXPECT_EQ(quiet.rows.at(0).alarms.hits, 0) << study_text(plan, quiet);
  plan.conditions = {.wander = 2};
  const StudyResult wandering = study(plan, one_by_one);
  EXPECT_EQ(wandering.rows.at(0).noises.hits, 2) << study_text(plan, wandering);
  EXPECT_EQ(wandering.rows.at(0).alarms.hits, 0) << study_text(plan, wandering);
  EXPECT_EQ(wandering.rows.at(0).adds.hits, 0) << study_text(plan, wandering);
  EXPECT_NE(study_text(plan, wandering).find("the wandering named 2/2"), std::string::npos);
  // Half the noise widens the whole by 12 %: a little more than what matters.
  plan.conditions = {.wander = 0.5};
  const StudyResult faint = study(plan, one_by_one);
  EXPECT_EQ(faint.rows.at(0).noises.hits, 1) << study_text(plan, faint);
  EXPECT_EQ(faint.rows.at(0).alarms.hits, 0) << study_text(plan, faint);
  plan.conditions = {.bursts = true};
  const StudyResult bursts = study(plan, one_by_one);
  EXPECT_NEAR(bursts.rows.at(0).error, 1, 0.2) << study_text(plan, bursts);
}

// Nothing can be left out of one level of light: it is both fitted and scored.
TEST(Study, OneGroupOfFlatFields) {
  const StudyPlan plan{.kind = "photometry",
                       .conditions = {.groups = 1},
                       .seeds = 2,
                       .folder = scratch("study-one-level")};
  const StudyResult result = study(plan, one_by_one);
  EXPECT_EQ(result.rows.at(0).alarms.hits, 0) << study_text(plan, result);
  EXPECT_NEAR(result.rows.at(0).error, 1, 0.2) << study_text(plan, result);
}

// Enough of them are left out as gross errors for the rest to show nothing.
TEST(Study, LargeErrorsOneByOneAreAnEffect) {
  const StudyPlan plan{.kind = "points",
                       .hidden = "{point_scatter: {fraction: 0.03, sigma_px: 1.5}}",
                       .material = 0.1,
                       .seeds = 1,
                       .first_seed = 2,
                       .folder = scratch("study-scatter")};
  const StudyResult result = study(plan, one_by_one);
  EXPECT_EQ(result.rows.at(0).exact.hits, 1) << study_text(plan, result);
}

TEST(Study, SeveralEffectsAtOnce) {
  const StudyPlan plan{.kind = "landmarks",
                       .hidden = "{range_scale: {scale: 0.05}, frame_latency: {latency_s: 0.05}}",
                       .material = 0.1,
                       .seeds = 1,
                       .folder = scratch("study-two")};
  const StudyResult result = study(plan, one_by_one);
  EXPECT_EQ(result.rows.at(0).exact.hits, 1) << study_text(plan, result);
  EXPECT_EQ(result.rows.at(0).first.hits, 1);
}

TEST(Study, WrongUseIsNamed) {
  EXPECT_THROW(study({.kind = "walls", .folder = scratch("bad")}, one_by_one), InputError);
  EXPECT_THROW(
      study({.kind = "points", .effect = "frame_latancy", .folder = scratch("bad")}, one_by_one),
      InputError);
  EXPECT_THROW(
      study({.kind = "points", .effect = "vignetting", .sizes = {5}, .folder = scratch("bad")},
            one_by_one),
      InputError);
}

// In any order, and where somebody stops it with what is finished.
TEST(Study, StopsWithTheSetsThatAreFinished) {
  const StudyPlan plan{.kind = "odometry", .seeds = 50, .folder = scratch("study-stopped")};
  const auto last_two = [&](uint64_t first, uint64_t last,
                            const std::function<std::string(uint64_t)>& work,
                            const std::function<void(uint64_t, const std::string&)>& done) {
    EXPECT_EQ(last - first, 50u);
    for (const uint64_t job : {last - 1, last - 2}) done(job, work(job));
    return false;
  };
  const StudyResult result = study(plan, last_two);
  EXPECT_TRUE(result.stopped);
  ASSERT_EQ(result.rows.size(), 1u);
  EXPECT_EQ(result.rows[0].sets, 2);
  EXPECT_EQ(result.rows[0].alarms.trials, 2);
  EXPECT_NEAR(result.rows[0].error, 1.0, 0.15);
  EXPECT_NE(study_text(plan, result).find("stopped"), std::string::npos);
}

// A study is the same whoever does its jobs, and its sets are those of a longer one.
TEST(Study, AJobDependsOnItsNumberAlone) {
  StudyPlan plan{.kind = "odometry",
                 .effect = "walk_lag",
                 .values = {0.1, 0.2},
                 .seeds = 1,
                 .folder = scratch("study-jobs")};
  std::map<uint64_t, std::string> told;
  const auto backwards = [&](uint64_t first, uint64_t last,
                             const std::function<std::string(uint64_t)>& work,
                             const std::function<void(uint64_t, const std::string&)>& done) {
    for (uint64_t job = last; job-- > first;) {
      const std::string text = work(job);
      EXPECT_TRUE(told.emplace(job, text).second || told[job] == text) << job;
      done(job, text);
    }
    return true;
  };
  study(plan, backwards);
  EXPECT_EQ(told.size(), 2u);
  plan.seeds = 2;
  const StudyResult longer = study(plan, backwards);
  EXPECT_EQ(told.size(), 4u);
  EXPECT_EQ(study_json(plan, longer), study_json(plan, study(plan, one_by_one)));
}

TEST(Study, AnUnknownEffectGetsASuggestion) {
  const StudyPlan plan{.kind = "points", .effect = "frame_latancy", .folder = scratch("bad")};
  try {
    study(plan, one_by_one);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("frame_latency"), std::string::npos) << error.what();
  }
}

// A set whose truth is an effect of no catalogue; what `suggest` makes of it.
std::optional<Suggestion> proposed(const std::string& kind, const std::string& effect,
                                   const std::string& name) {
  const Model nominal = write_study_protocol(kind, scratch(name + "-protocol"));
  const ConfigNode node = ConfigNode::from_text(effect, "truth");
  const auto definition = effects::expression_effect("truth", node);
  Model truth = nominal;
  truth.set(definition, effects::expression_values(*definition, node));
  measure_set(truth, MeasurementSet::open(scratch(name + "-protocol")),
              {.seed = 3, .out = scratch(name)});
  const auto problem = open_problem(scratch(name));
  return search(*problem, nominal, {}, silent).suggestion;
}

TEST(Suggest, ACameraThatTurnsInItsHolderIsOneTerm) {
  const auto found =
      proposed("points",
               "{stage: geometry, u: 'u + k * (cy - v) * t', v: 'v + k * (u - cx) * t', "
               "parameters: {k: 0.03}}",
               "suggest-turn");
  ASSERT_TRUE(found);
  ASSERT_EQ(found->terms.size(), 1u) << found->yaml;
  EXPECT_EQ(found->terms[0], "u: (cy - v) * t, v: (u - cx) * t");
  EXPECT_TRUE(found->beside.empty());
  EXPECT_GT(found->error_before, 2);
  EXPECT_NEAR(found->error, 1.0, 0.1);
  // The file reads back, with the coefficient that was hidden.
  const ConfigNode node =
      ConfigNode::from_text(found->yaml, "yaml").at("effects").at(found->effect);
  const auto effect = effects::expression_effect(found->effect, node);
  EXPECT_NEAR(effects::expression_values(*effect, node)[0].value, 0.03, 0.002);
}

TEST(Suggest, AWaveOverTheRowsHasItsFrequency) {
  const auto found = proposed(
      "points", "{stage: geometry, u: 'u + k * sin(0.21 * v)', v: v, parameters: {k: 0.6}}",
      "suggest-wave");
  ASSERT_TRUE(found);
  const std::string begins = "u: sin(2 * pi * v / ";
  ASSERT_TRUE(found->terms[0].starts_with(begins)) << found->terms[0];
  EXPECT_NEAR(2 * maths::kPi / std::stod(found->terms[0].substr(begins.size())), 0.21, 0.002);
  EXPECT_NEAR(found->error, 1.0, 0.1);
}

TEST(Suggest, NothingWhereTheCatalogueExplains) {
  const Model nominal = write_study_protocol("landmarks", scratch("suggest-none-protocol"));
  measure_set(nominal, MeasurementSet::open(scratch("suggest-none-protocol")),
              {.seed = 3, .out = scratch("suggest-none")});
  const auto problem = open_problem(scratch("suggest-none"));
  EXPECT_FALSE(search(*problem, nominal, {}, silent).suggestion);
}

}  // namespace
}  // namespace seam::measurement
