#include "app/trust/program_consent.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "sim_core/base/error.h"

namespace seam::app {
namespace {

using ::testing::HasSubstr;

const std::vector<std::string> kPrograms = {"red1: rm -rf /", "blue1: \\x1b[2J"};

// What the user is shown, or the error's text; empty where the programs may start without a word.
std::string asked(bool agreed, bool terminal, const std::string& answer) {
  std::istringstream in(answer);
  std::ostringstream out;
  try {
    require_consent(kPrograms, agreed, terminal, in, out);
  } catch (const UsageError& error) {
    return std::string("refused: ") + error.what();
  }
  return out.str();
}

TEST(ProgramConsent, WithoutATerminalTheOptionIsNeeded) {
  EXPECT_EQ(asked(true, false, ""), "");
  EXPECT_THAT(asked(false, false, "y\n"), HasSubstr("--run-programs"));
  EXPECT_THAT(asked(false, false, "y\n"), HasSubstr("red1: rm -rf /"));
}

TEST(ProgramConsent, AtATerminalTheUserSeesThemAndSaysYes) {
  EXPECT_THAT(asked(false, true, "y\n"), HasSubstr("red1: rm -rf /\n  blue1"));
  for (const char* no : {"", "\n", "n\n", "Y?\n"})
    EXPECT_THAT(asked(false, true, no), HasSubstr("refused: "));
}

TEST(ProgramConsent, OfARunWithoutProgramsNobodyIsAsked) {
  std::istringstream in;
  std::ostringstream out;
  EXPECT_NO_THROW(require_consent({}, false, false, in, out));
}

TEST(ProgramConsent, ShowsWhatATerminalWouldObey) {
  Scenario scenario = Scenario::from_file(SEAM_SOURCE_DIR "/scenarios/head_swing.yaml");
  scenario.robots.resize(1);
  scenario.robots[0].behaviour.command = {"bot", "\x1b[2J"};
  EXPECT_EQ(programs_of(scenario),
            std::vector<std::string>{scenario.robots[0].id + ": bot \\x1b[2J"});
}

}  // namespace
}  // namespace seam::app
