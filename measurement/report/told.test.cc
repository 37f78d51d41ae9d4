#include "measurement/report/told.h"

#include <gtest/gtest.h>

#include <limits>

#include "measurement/judge/doubted.h"
#include "measurement/problem/made_problem.h"
#include "measurement/report/headline.h"
#include "measurement/report/results.h"
#include "measurement/report/target_told.h"
#include "measurement/search/looked_for.h"

namespace seam::measurement {
namespace {

const effects::Parameter kShift{.name = "forward_m", .min = -0.01, .max = 0.01, .scale = 1e-3};

std::string told_as(double value, std::optional<double> sigma) {
  return told_value(kShift, {.value = value, .sigma = sigma, .free = true});
}

TEST(ToldValue, SaysWhatIsNotDeterminedAndWhatStandsAtABound) {
  EXPECT_EQ(told_as(0.003, 1e-4), "0.003 +- 0.0001");
  EXPECT_EQ(told_as(-9e-7, 4.5e-5), "0 within +- 4.5e-05");
  EXPECT_EQ(told_as(-9e-7, 4.5e-4), "not determined (+- 0.00045)");
  EXPECT_EQ(told_as(0.003, 0.003), "not determined (+- 0.003)");
  EXPECT_EQ(told_as(0.003, std::nullopt), "not determined");
  // Left where it was: the data did not ask for it.
  EXPECT_EQ(told_as(0, 0), "0");
  EXPECT_EQ(told_as(0.01, 1e-4), "0.01, at the upper end of its range");
  EXPECT_EQ(told_as(-0.01, 1e-4), "-0.01, at the lower end of its range");
  // What no fit changed has no error, wherever it stands.
  EXPECT_EQ(told_value(kShift, {.value = 0.01}), "0.01");
  // A bound that is neutral is no end of anything: there is no such effect.
  const effects::Parameter sigma{.name = "sigma_s", .min = 0, .max = 1, .scale = 1};
  EXPECT_EQ(told_value(sigma, {.value = 0, .sigma = 0.1, .free = true}), "not determined (+- 0.1)");
  // A limit that never binds is infinite where it is absent.
  const effects::Parameter limit{.name = "limit",
                                 .neutral = std::numeric_limits<double>::infinity(),
                                 .min = 1e-3,
                                 .max = 1e9,
                                 .fit_reciprocal = true};
  EXPECT_EQ(told_value(limit, {.value = 200, .sigma = 200, .free = true}),
            "not determined (+- 200)");
  EXPECT_EQ(told_value(limit, {.value = 200, .sigma = 2, .free = true}), "200 +- 2");
}

class Room : public MadeProblem {
 public:
  Room() : MadeProblem({0, 1}, 0.15, [](const std::vector<double>&, double) { return 0.0; }) {
    facts_.channels = {{.name = "u_px", .noise = 0.15}};
    facts_.covariates = {{.name = "row"},
                         {.name = "pan_rate"},
                         {.name = "time"},
                         {.name = "frame", .type = Covariate::Type::category}};
  }
  std::vector<PlacedPoint> placed_points(const Model&) const override { return points; }
  std::vector<PlacedPoint> points;
};

Structure of_u(const std::string& covariate, double strength = 8.024, double p = 1e-300) {
  return {.residual = "u_px",
          .moment = "mean",
          .covariate = covariate,
          .strength = strength,
          .p_value = p};
}

TEST(ToldStructure, HasUnitsNoiseAndOneCutP) {
  const Room room;
  const std::string text = structure_lines(
      room, {}, {of_u("row*pan_rate"), of_u("sign(pan_rate)", 1.5), of_u("frame", 0.3, 2e-9)});
  EXPECT_EQ(text,
            "  mean of u_px varies with row x pan rate: 8.02 px, 53 x noise, p < 1e-300\n"
            "  mean of u_px varies with sign of pan rate: 1.5 px, 10 x noise\n"
            "  mean of u_px differs from frame to frame: 0.3 px, 2 x noise, p = 2e-09\n");
  Structure torque = of_u("time", 0.041, 2e-9);
  torque.residual = "effort_nm";
  EXPECT_THAT(structure_lines(room, {}, {torque}), testing::HasSubstr("time: 0.041 N m"));
  torque.residual = "gravity_mps2";
  EXPECT_THAT(structure_lines(room, {}, {torque}), testing::HasSubstr("time: 0.041 m/s^2"));
  EXPECT_EQ(told_structure(room.facts(), of_u("constant")), "mean of u_px is not 0");
  EXPECT_EQ(told_structure(room.facts(), of_u("neighbour")), "u_px is correlated in time");
}

// A label, the neighbour and a constant are nothing that a user can vary.
TEST(Advice, NamesWhatCanBeVaried) {
  const Room room;
  const Facts& facts = room.facts();
  for (const char* label : {"constant", "neighbour", "frame", "frame*time"})
    EXPECT_EQ(what_to_vary(facts, label), "") << label;
  EXPECT_EQ(what_to_vary(facts, "sign(pan_rate)"), "vary pan rate while all else stays as it is");
  EXPECT_NE(
      what_to_vary(facts, "row*pan_rate").find("other places in the image, and vary pan rate"),
      std::string::npos);
  SearchResult result;
  result.verdict = "unexplained_structure";
  result.remaining = {of_u("neighbour"), of_u("frame"), of_u("pan_rate")};
  EXPECT_EQ(advice_for(room, result),
            "No known effect explains that mean of u_px varies with pan rate: vary pan rate while "
            "all else stays as it is, or write an effect for it (seam diagnose --suggest).");
  result.remaining.pop_back();
  EXPECT_EQ(advice_for(room, result).find("vary "), std::string::npos);
}

TEST(Headline, SaysThatNoKnownEffectExplainsItAndWhatComesNearest) {
  const Room room;
  SearchResult result;
  result.verdict = "unexplained_structure";
  result.remaining = {of_u("time", 0.225)};
  result.base.assessment.error = 3.1;
  result.best.assessment.error = 1.52;
  result.steps = {{.effect = "focal_length_error"}};
  EXPECT_EQ(headline(room, result, 0),
            "No known effect explains this: mean of u_px varies with time (1.5 x noise). Nearest: "
            "focal_length_error, which leaves 1.52 of 3.1.\n");
  // What leaves as much comes near to nothing.
  result.best.assessment.error = 3.1;
  EXPECT_EQ(headline(room, result, 0).find("Nearest"), std::string::npos);
  result.steps.clear();
  EXPECT_EQ(headline(room, result, 0),
            "No known effect explains this: mean of u_px varies with time (1.5 x noise).\n");
}

// Beside a cause without a name nothing is established but what moves far more than that does.
TEST(Headline, CallsNothingMissingBesideACauseThatDoesAboutAsMuch) {
  const Room room;
  SearchResult result;
  result.verdict = "unexplained_structure";
  result.unnamed.emplace();
  result.unnamed->depends_on = {{"row"}};
  result.unnamed->noise_units = 2;
  result.steps = {{.effect = "focal_length_error", .moved = 12}};
  EXPECT_NE(headline(room, result, 0)
                .find("focal_length_error (12 x noise) helps, which "
                      "establishes nothing while a cause is unexplained"),
            std::string::npos)
      << headline(room, result, 0);
  result.steps[0].moved = 25;
  EXPECT_NE(headline(room, result, 0).find("Beside it: focal_length_error is missing"),
            std::string::npos)
      << headline(room, result, 0);
}

// A shape that another effect scales is no cause of its own.
TEST(Headline, CallsNothingMissingOfWhichTheDataTellNoValue) {
  const Room room;
  SearchResult result;
  result.verdict = "missing_effect";
  Assessment& best = result.best.assessment;
  best.model = made_model(made_effect("warp", {kShift}), {1e-5});
  best.model.add_neutral(made_effect("flex", {kShift}));
  best.model.set_value("flex", 0, 4e-3);
  best.unknowns = {{"warp", 0}, {"flex", 0}};
  best.fit.value = {1e-5, 4e-3}, best.fit.sigma = {1e-4, 1e-4};
  result.steps = {{.effect = "warp", .moved = 1}, {.effect = "flex", .moved = 3}};
  const std::string told = headline(room, result, 0);
  EXPECT_NE(
      told.find("What matters: flex is missing; it moves predictions by 3 x noise; warp is in "
                "the model for the others alone: the data determine no value of it"),
      std::string::npos)
      << told;
}

// A value at the end of its range is no cause established, whatever it gains.
TEST(Headline, CallsNothingMissingThatStandsAtABound) {
  const Room room;
  const auto found = [&](double value) {
    SearchResult result;
    result.verdict = "missing_effect";
    const auto effect = made_effect("pupil", {kShift});
    result.best.assessment.model = made_model(effect, {value});
    result.best.assessment.unknowns = {{"pupil", 0}};
    result.best.assessment.fit.sigma = {1e-4};
    result.steps = {{.effect = "pupil", .moved = 2}};
    result.steps[0].doubts = doubts_of(room, result.best.assessment, {"pupil"})[0];
    return headline(room, result, 0);
  };
  EXPECT_NE(found(0.003).find("What matters: pupil is missing; it moves predictions by 2 x noise"),
            std::string::npos);
  EXPECT_EQ(found(0.01).find("is missing"), std::string::npos) << found(0.01);
  EXPECT_NE(found(0.01).find("pupil (forward_m = 0.01 is at the end of its range) fits best, which "
                             "establishes no cause: look for another"),
            std::string::npos)
      << found(0.01);
}

// Before it is known what the columns mean, no result is one.
TEST(Headline, AsksWhatTheColumnsMeanFirst) {
  EXPECT_EQ(with_questions("A is missing\n", {"warning: few rows"}), "A is missing\n");
  EXPECT_EQ(with_questions("A is missing\n", {"warning: few rows", "question: metres?"}),
            "First: metres? As the set stands: A is missing\n");
}

TEST(LookedFor, SaysOfEachWhatCameOfItAndWhyItWasNotTested) {
  const Room room;
  SearchResult result;
  result.remaining = {of_u("time")};
  result.remaining_traces = {of_u("row")};
  result.functions = {{.covariates = {"row", "time"}, .log_evidence = 40},
                      {.covariates = {"pan_rate"}, .is_testable = false}};
  result.unnamed.emplace();
  result.unnamed->depends_on = {{"row", "time"}};
  const auto list = looked_for(room, result);
  const auto outcome = [&](const std::string& what, const std::vector<std::string>& covariates) {
    for (const LookedFor& entry : list) {
      if (entry.what == what && entry.covariates == covariates) return entry.outcome;
    }
    return std::string("none");
  };
  EXPECT_EQ(outcome("smooth function", {"row", "time"}), "found");
  EXPECT_EQ(outcome("smooth function", {"pan_rate"}), "not tested");
  EXPECT_EQ(outcome("formula", {}), "not tested");
  EXPECT_EQ(outcome("mean and spread", {"time"}), "found");
  EXPECT_EQ(outcome("mean and spread", {"row"}), "trace");
  EXPECT_EQ(outcome("mean and spread", {"pan_rate"}), "nothing");
  EXPECT_EQ(outcome("mean of each label", {"frame"}), "nothing");
  EXPECT_EQ(outcome("neighbours in time", {}), "not tested");
  EXPECT_EQ(outcome("gross errors", {}), "nothing");
  for (const LookedFor& entry : list)
    EXPECT_EQ(entry.outcome == "not tested" && entry.why.empty(), false) << entry.what;
  EXPECT_NE(looked_for_text(list).find("2 found"), std::string::npos) << looked_for_text(list);
}

TEST(LookedFor, AKindWithoutCovariatesListsWhatItsOwnTestsFound) {
  const MadeProblem flats({0, 1}, 0.15, [](const std::vector<double>&, double) { return 0.0; });
  SearchResult result;
  result.remaining = {of_u("row"), of_u("row")};
  result.remaining_traces = {of_u("column*illumination")};
  const std::string text = looked_for_text(looked_for(flats, result));
  EXPECT_NE(text.find("1 found: mean and spread of row, 1 trace"), std::string::npos) << text;
}

TEST(Headline, NamesATraceOnce) {
  const Room room;
  Candidate trace;
  trace.effect = made_effect("stribeck_friction", {kShift});
  EXPECT_EQ(traces_text(room.facts(), {}, {trace, trace}),
            "traces, significant but not material: stribeck_friction\n");
}

TEST(TargetText, SaysHowTheBoardIsBent) {
  Room room;
  for (const double z : {0.3e-3, -0.28e-3})
    room.points.push_back({.name = "0", .shift_m = {2.3e-18, 0, z}});
  EXPECT_EQ(target_text(room, {}), "The board is bent: 0.29 mm rms out of its plane.\n");
  room.points[0].shift_m.x = 0.2e-3;
  EXPECT_EQ(target_text(room, {}),
            "The board's 2 points are displaced: 0.14 mm rms along x, 0 along y, 0.29 out of its "
            "plane.\n");
}

}  // namespace
}  // namespace seam::measurement
