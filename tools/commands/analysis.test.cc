// Which error speaks for doubts about a set, the command after a formula, and files of effects.
#include "tools/commands/analysis.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <limits>

#include "sim_core/base/error.h"
#include "sim_core/base/output.h"

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

// One of two maps of effects would be left out without a word.
TEST(EffectsNamed, NoKeyOfAFileStandsTwice) {
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "twice.yaml";
  const std::string effects =
      "effects: {slip: {stage: geometry, u: u + k, parameters: {k: {neutral: 0}}}}\n";
  write_file_atomically(file, effects);
  EXPECT_EQ(effects_named(file.string()).size(), 1u);
  write_file_atomically(file, effects + "effects: {}\n");
  EXPECT_THAT([&] { effects_named(file.string()); },
              testing::ThrowsMessage<InputError>(testing::HasSubstr("key 'effects' stands twice")));
}

}  // namespace
}  // namespace seam::tools
