#include "app/command_line.h"

#include <gtest/gtest.h>

#include "sim_core/base/error.h"

namespace seam::app {
namespace {

// A program with two commands, one of which has a command of its own.
int run(const std::vector<std::string>& arguments, std::string* done = nullptr) {
  std::string name, seed;
  return parse_and_run("A test", "tool", "tool 1", arguments, [&](Command app) {
    app.require_subcommand();
    Command walk = app.add_subcommand("walk", "Walks");
    walk.add_option("NAME", name, "Who").required();
    walk.add_option("--seed", seed, "Seed of the walk");
    walk.callback([&] {
      if (done) *done = "walk " + name + " " + seed;
    });
    Command replay = app.add_subcommand("replay", "Replays");
    replay.require_subcommand();
    replay.add_subcommand("show", "Shows").callback([] {});
  });
}

std::string refused(const std::vector<std::string>& arguments) {
  try {
    return "exit code " + std::to_string(run(arguments));
  } catch (const UsageError& error) {
    return std::string(error.what()).substr(0, std::string(error.what()).find('\n'));
  }
}

std::string printed(const std::vector<std::string>& arguments) {
  testing::internal::CaptureStdout();
  EXPECT_EQ(run(arguments), 0);
  return testing::internal::GetCapturedStdout();
}

TEST(CommandLine, RunsTheCommandNamed) {
  std::string done;
  EXPECT_EQ(run({"walk", "anna", "--seed", "3"}, &done), 0);
  EXPECT_EQ(done, "walk anna 3");
}

TEST(CommandLine, MisspeltCommandsAndOptionsGetTheNearest) {
  EXPECT_EQ(refused({"wlak", "anna"}), "unknown command 'wlak', did you mean 'walk'?");
  EXPECT_EQ(refused({"replay", "shwo"}), "unknown command 'shwo', did you mean 'show'?");
  EXPECT_EQ(refused({"walk", "anna", "--sede", "3"}),
            "unknown option '--sede', did you mean '--seed'?");
  // Whatever else is missing beside it.
  EXPECT_EQ(refused({"walk", "--sede=3"}), "unknown option '--sede', did you mean '--seed'?");
  EXPECT_EQ(refused({"dance"}), "unknown command 'dance', known: walk, replay, help");
  EXPECT_EQ(refused({"help", "wlak"}), "unknown command 'wlak', did you mean 'walk'?");
}

TEST(CommandLine, OtherWrongUseHasExitCode2) {
  EXPECT_EQ(refused({}), "exit code 2");
  EXPECT_EQ(refused({"walk"}), "exit code 2");
  EXPECT_EQ(refused({"walk", "anna", "--seed", ""}), "exit code 2");
}

TEST(CommandLine, HelpCommandIsTheHelpOption) {
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{}, {"walk"}, {"replay"}, {"replay", "show"}}) {
    std::vector<std::string> option = command, word = command;
    option.push_back("--help");
    word.insert(word.begin(), "help");
    EXPECT_EQ(printed(word), printed(option));
  }
  const std::string page = printed({"help", "--markdown"});
  for (const char* title : {"# Commands", "## `tool walk`", "## `tool replay show`"})
    EXPECT_NE(page.find(title), std::string::npos) << page;
  EXPECT_NE(page.find(printed({"walk", "--help"})), std::string::npos) << page;
}

}  // namespace
}  // namespace seam::app
