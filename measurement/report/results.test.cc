// What compare says first is what matters most.
#include "measurement/report/results.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "measurement/kinds/kinds.h"
#include "measurement/problem/made_problem.h"
#include "measurement/report/headline.h"
#include "measurement/report/told.h"
#include "measurement/search/models/compare.h"

namespace seam::measurement {
namespace {

std::filesystem::path scratch(const std::string& name) {
  return std::filesystem::path(testing::TempDir()) / ("compare-" + name);
}

TEST(StrongestFirst, StrengthDecidesWherePIsCut) {
  Facts facts;
  facts.channels = {{.name = "range_m", .noise = 0.03}, {.name = "bearing_rad", .noise = 0.006}};
  std::vector<Structure> structures = {
      {.residual = "range_m", .covariate = "time", .strength = 0.9, .p_value = 1e-200},
      {.residual = "range_m", .covariate = "range", .strength = 0.06, .p_value = 1e-300},
      {.residual = "bearing_rad", .covariate = "bearing", .strength = 0.03, .p_value = 1e-300},
      {.residual = "range_m", .covariate = "heading", .strength = 0.09, .p_value = 1e-300}};
  strongest_first(facts, structures);
  std::vector<std::string> order;
  for (const Structure& s : structures) order.push_back(s.covariate);
  // 5, 3 and 2 noise units; then what is less sure, however strong.
  EXPECT_EQ(order, (std::vector<std::string>{"bearing", "heading", "range", "time"}));
}

TEST(StrongestFirst, ALabelGivesWayToWhatTakesAsMuch) {
  Facts facts;
  facts.channels = {{.name = "u_px", .noise = 0.1}};
  facts.covariates = {{.name = "frame", .type = Covariate::Type::category}, {.name = "pan"}};
  std::vector<Structure> structures = {
      {.residual = "u_px", .covariate = "frame", .strength = 0.9, .p_value = 1e-300},
      {.residual = "u_px", .covariate = "pan", .strength = 0.8, .p_value = 1e-300}};
  strongest_first(facts, structures);
  EXPECT_EQ(structures.front().covariate, "pan");
  structures.front().strength = 0.3;  // One frame is off, by its number or not.
  strongest_first(facts, structures);
  EXPECT_EQ(structures.front().covariate, "frame");
}

// The tutorial's recording: many tests have the least p, and their strengths fall from line to
// line.
TEST(Compare, ListsTheStrongestFirst) {
  const std::filesystem::path tutorial = std::filesystem::path(SEAM_SOURCE_DIR) / "docs/tutorial";
  const Model nominal = Model::from_file(tutorial / "nominal.yaml");
  measure_set(Model::from_file(tutorial / "robot.yaml"), MeasurementSet::open(tutorial / "room"),
              {.seed = 1, .out = scratch("set")});
  const auto problem = open_problem(scratch("set"));
  const CompareResult result = compare(*problem, nominal);
  size_t cut = 0;
  while (cut < result.structure.size() && result.structure[cut].p_value <= 1e-300) ++cut;
  ASSERT_GT(cut, 4u);
  EXPECT_EQ(result.structure[0].covariate, "row*pan_rate");
  // A label counts for three quarters (the test above).
  const auto counted = [](const Structure& s) {
    return (s.covariate == "frame" || s.covariate == "landmark" ? 0.75 : 1) * s.strength;
  };
  for (size_t i = 1; i < cut; ++i)
    EXPECT_GE(counted(result.structure[i - 1]), counted(result.structure[i]))
        << result.structure[i].residual << " " << result.structure[i].covariate;
  // The text's first line of structure is the JSON's first entry.
  const std::string text = compare_text(*problem, result);
  const std::string lines = text.substr(text.find("structure of the residuals:\n"));
  EXPECT_LT(lines.find(told_structure(problem->facts(), result.structure[0])), lines.find("\n", 30))
      << text;
}

// Three groups of which each alone tells something: all together are at the noise.
TEST(Headline, SaysWhereMoreGroupsAreNeeded) {
  class Three : public MadeProblem {
   public:
    Three()
        : MadeProblem(evenly(-1, 1, 90), 0.5,
                      [](const std::vector<double>& p, double x) { return p[0] * x; }) {
      cut_into(3);
    }
  };
  Three problem;
  const auto line = made_effect("line", {{.name = "slope", .min = -9, .max = 9}});
  problem.observe(made_model(line, {2}), {.seed = 1, .stream = 1});
  const auto said = [&](double slope, double error) {
    CompareResult result;
    result.base.assessment.model = made_model(line, {slope});
    result.base.assessment.error = error;
    return headline(problem, result);
  };
  EXPECT_NE(said(2, 3.57).find("more groups; all 3 together are met to"), std::string::npos);
  EXPECT_NE(said(-2, 3.57).find("nothing that was tested tells why"), std::string::npos);
  EXPECT_NE(said(2, 1).find("Nothing that matters"), std::string::npos);
  for (const double none : {double{NAN}, double{INFINITY}})
    EXPECT_NE(said(2, none).find("predicts no finite number"), std::string::npos);
}

}  // namespace
}  // namespace seam::measurement
