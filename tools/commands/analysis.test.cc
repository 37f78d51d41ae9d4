// Which error speaks for doubts about a set's units and columns.
#include "tools/commands/analysis.h"

#include <gtest/gtest.h>

#include <limits>

namespace seam::tools {
namespace {

TEST(UnexplainedError, IsTheGivenModelsUnlessWhatWasFoundExplainsTheSet) {
  measurement::SearchResult result;
  result.base.assessment.error = 240;
  for (const double misfit : {20.0, 1.2, std::numeric_limits<double>::quiet_NaN()}) {
    result.best.assessment.error = misfit;
    EXPECT_EQ(unexplained_error(result), 240);
  }
  result.best.assessment.error = 0.96;
  EXPECT_EQ(unexplained_error(result), 0.96);
}

TEST(HowToAdd, BesideEffectsThatTheModelLacksASearchAddsTheFormula) {
  AnalysisFlags flags;
  flags.model = "m.yaml", flags.data = "set";
  measurement::SearchResult result;
  result.suggestion.emplace();
  result.suggestion->effect = "suggested", result.suggestion->error = 1;
  const std::string begin = "to keep the formula: write a name for 'suggested' in f.yaml, then ";
  EXPECT_EQ(how_to_add(flags, "m.yaml", "f.yaml", result),
            begin + "seam add f.yaml --model m.yaml --data set --out with_NAME.yaml\n");
  result.suggestion->beside = {"servo_lag"};
  EXPECT_EQ(
      how_to_add(flags, "m.yaml", "f.yaml", result),
      begin + "seam discover --model m.yaml --data set --candidates f.yaml --out with_NAME.yaml\n");
  EXPECT_EQ(how_to_add(flags, "found.yaml", "f.yaml", result),
            begin + "seam add f.yaml --model found.yaml --data set --out with_NAME.yaml\n");
}

}  // namespace
}  // namespace seam::tools
