#include "sim_core/signals/half_made.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <set>
#include <string>

#include "sim_core/base/output.h"

namespace seam {
namespace {

namespace fs = std::filesystem;

class HalfMadeFiles : public testing::Test {
 public:
  HalfMadeFiles() {
    folder_ = fs::temp_directory_path() / ("seam-half-made-" + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  ~HalfMadeFiles() override { fs::remove_all(folder_); }
  fs::path at(const std::string& name) const { return folder_ / name; }
  // How a process ended that did this.
  static int status_of(void (*work)(const HalfMadeFiles&), const HalfMadeFiles& files) {
    const pid_t process = ::fork();
    if (process == 0) {
      remove_half_made_on_signals();
      work(files);
      ::_exit(0);
    }
    int status = 0;
    ::waitpid(process, &status, 0);
    return status;
  }
  fs::path folder_;
};

TEST_F(HalfMadeFiles, ASignalRemovesThemAndEndsTheProgramAsEver) {
  const int status = status_of(
      [](const HalfMadeFiles& files) {
        OutputFile whole(files.at("whole")), half(files.at("half"));
        whole.fill("all of it");
        half.write("some of it");
        fs::create_directories(files.at("folder/in/side"));
        std::ofstream(files.at("folder/in/side/file")) << "x";
        std::ofstream(files.at("folder/file")) << "x";
        fs::create_directory_symlink(files.at("kept"), files.at("folder/link"));
        const HalfMade folder(files.at("folder"));
        { const HalfMade made(files.at("kept")); }
        fs::create_directories(files.at("kept"));
        std::ofstream(files.at("kept/file")) << "x";
        ::raise(SIGTERM);
      },
      *this);
  EXPECT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(WTERMSIG(status), SIGTERM);
  std::set<std::string> left;
  for (const auto& entry : fs::directory_iterator(folder_)) left.insert(entry.path().filename());
  EXPECT_EQ(left, (std::set<std::string>{"whole", "kept"}));
  EXPECT_TRUE(fs::exists(at("kept/file"))) << "a link is removed, not what it leads to";
}

TEST_F(HalfMadeFiles, AForkedProcessLeavesThoseOfItsParentAlone) {
  const int status = status_of(
      [](const HalfMadeFiles& files) {
        const HalfMade folder(files.at("folder"));
        fs::create_directories(files.at("folder"));
        const pid_t child = ::fork();
        if (child == 0) ::raise(SIGINT);
        int ended = 0;
        ::waitpid(child, &ended, 0);
        ::_exit(fs::exists(files.at("folder")) && WIFSIGNALED(ended) ? 7 : 1);
      },
      *this);
  EXPECT_EQ(WEXITSTATUS(status), 7);
}

TEST_F(HalfMadeFiles, ASignalWaitsUntilWhatIsMadeIsKnown) {
  const int status = status_of(
      [](const HalfMadeFiles& files) {
        {
          const SignalsWait outer;
          {
            const SignalsWait inner;
            std::ofstream(files.at("file")) << "x";
            ::raise(SIGTERM);
          }
          if (fs::exists(files.at("file"))) std::ofstream(files.at("went on")) << "x";
          is_half_made(files.at("file"));
        }
        ::_exit(1);
      },
      *this);
  EXPECT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(WTERMSIG(status), SIGTERM);
  EXPECT_FALSE(fs::exists(at("file")));
  EXPECT_TRUE(fs::exists(at("went on")));
}

TEST_F(HalfMadeFiles, AnIgnoredSignalStaysIgnored) {
  const int status = status_of(
      [](const HalfMadeFiles&) {
        ::signal(SIGHUP, SIG_IGN);
        remove_half_made_on_signals();
        ::raise(SIGHUP);
        ::_exit(7);
      },
      *this);
  EXPECT_EQ(WEXITSTATUS(status), 7);
}

}  // namespace
}  // namespace seam
