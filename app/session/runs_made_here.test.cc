#include "app/session/runs_made_here.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "sim_core/base/files.h"
#include "sim_core/base/output.h"

namespace seam::app {
namespace {

namespace fs = std::filesystem;

class MadeHere : public ::testing::Test {
 protected:
  MadeHere() {
    std::string pattern = ::testing::TempDir() + "/seam-runs-XXXXXX";
    folder_ = mkdtemp(pattern.data());
    make_program("bot");
    make_program("other");
  }
  ~MadeHere() override {
    fs::current_path(before_);
    fs::remove_all(folder_);
  }

  void make_program(const std::string& name) const {
    write_file_atomically(folder_ / name, "#!/bin/sh\n");
    fs::permissions(folder_ / name, fs::perms::owner_all);
  }
  Simulator run_of(const std::string& program, int64_t seed = 7) const {
    Scenario scenario = Scenario::from_file(SEAM_SOURCE_DIR "/scenarios/head_swing.yaml");
    scenario.seed = seed;
    scenario.robots.resize(1);
    scenario.robots[0].behaviour.command = {program, "--speed", "2"};
    if (program.empty()) scenario.robots[0].behaviour.command.clear();
    return make_simulator(scheduler::RunHeader{.scenario_text = scenario.to_yaml(),
                                               .scenario_name = "test",
                                               .seed = static_cast<uint64_t>(seed)});
  }
  const fs::path before_ = fs::current_path();
  fs::path folder_;
  RunsMadeHere runs() const { return RunsMadeHere(folder_ / "state" / "seam" / "runs"); }
};

TEST_F(MadeHere, KnowsTheSameProgramsOfTheSameScenarioInTheSameFolderOnly) {
  fs::current_path(folder_);
  EXPECT_FALSE(runs().holds(run_of("./bot")));
  runs().note(run_of("./bot"));
  EXPECT_TRUE(runs().holds(run_of("./bot")));
  EXPECT_FALSE(runs().holds(run_of("./other")));
  EXPECT_FALSE(runs().holds(run_of("./bot", 8)));
  fs::create_directory(folder_ / "elsewhere");
  fs::copy(folder_ / "bot", folder_ / "elsewhere" / "bot");
  fs::current_path(folder_ / "elsewhere");
  EXPECT_FALSE(runs().holds(run_of("./bot")));
}

TEST_F(MadeHere, TheFileIsTheUsersAlone) {
  fs::current_path(folder_);
  runs().note(run_of("./bot"));
  const fs::path file = folder_ / "state" / "seam" / "runs";
  EXPECT_EQ(fs::status(file).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  fs::permissions(file, fs::perms::others_write, fs::perm_options::add);
  EXPECT_FALSE(runs().holds(run_of("./bot")));
  fs::permissions(file, fs::perms::others_write, fs::perm_options::remove);
  EXPECT_TRUE(runs().holds(run_of("./bot")));
  fs::rename(file, folder_ / "real");
  fs::create_symlink(folder_ / "real", file);
  EXPECT_FALSE(runs().holds(run_of("./bot")));
}

TEST_F(MadeHere, ForgetsTheOldestAndNotesNothingTwice) {
  fs::current_path(folder_);
  const fs::path file = folder_ / "state" / "seam" / "runs";
  runs().note(run_of("./bot"));
  runs().note(run_of("./bot"));
  const std::string one = read_file(file);
  EXPECT_EQ(one.size(), 65u);
  std::string full;
  for (int i = 0; i < 4096; ++i) full += i == 0 ? one : std::string(64, 'x') + "\n";
  write_file_atomically(file, full);
  fs::permissions(file, fs::perms::owner_read | fs::perms::owner_write);
  runs().note(run_of("./other"));
  EXPECT_EQ(read_file(file).size(), 65u * 2049);
  EXPECT_TRUE(runs().holds(run_of("./other")));
  EXPECT_FALSE(runs().holds(run_of("./bot")));
}

TEST_F(MadeHere, RunsWithoutProgramsAndPlacesThatCannotBeHadAreNotNoted) {
  fs::current_path(folder_);
  runs().note(run_of(""));
  EXPECT_FALSE(fs::exists(folder_ / "state"));
  runs().note(run_of("./no_such_program"));
  EXPECT_FALSE(fs::exists(folder_ / "state"));
  const RunsMadeHere nowhere(folder_ / "bot" / "runs");
  nowhere.note(run_of("./bot"));
  EXPECT_FALSE(nowhere.holds(run_of("./bot")));
  EXPECT_FALSE(RunsMadeHere(fs::path()).holds(run_of("./bot")));
}

}  // namespace
}  // namespace seam::app
