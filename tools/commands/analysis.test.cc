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

}  // namespace
}  // namespace seam::tools
