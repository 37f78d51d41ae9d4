#include "sim_core/base/output.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <csignal>
#include <fstream>

#include "sim_core/base/error.h"
#include "sim_core/base/files.h"

namespace seam {
namespace {

namespace fs = std::filesystem;

class Output : public testing::Test {
 protected:
  Output() {
    folder_ = fs::temp_directory_path() / fmt::format("seam-output-{}", ::getpid());
    fs::create_directories(folder_);
  }
  ~Output() override { fs::remove_all(folder_); }
  fs::path at(const std::string& name) const { return folder_ / name; }
  size_t files() const {
    return static_cast<size_t>(
        std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }

  fs::path folder_;
};

TEST_F(Output, AppearsWholeOrNotAtAll) {
  {
    OutputFile out(at("a"));
    EXPECT_EQ(files(), 0u) << "a claim leaves nothing, should the computation be killed";
    out.write("half");
    EXPECT_FALSE(fs::exists(at("a")));
  }
  EXPECT_EQ(files(), 0u);
  OutputFile(at("a")).fill("whole");
  EXPECT_EQ(read_file(at("a")), "whole");
  OutputFile(at("a")).fill("");
  EXPECT_EQ(read_file(at("a")), "");
  EXPECT_EQ(files(), 1u);
}

TEST_F(Output, ClaimIsRefusedBeforeAnythingIsComputed) {
  EXPECT_THROW(OutputFile(at("no/such/folder")), InputError);
  EXPECT_THROW(OutputFile{folder_}, InputError);
  OutputFile none("");
  EXPECT_FALSE(none);
  none.fill("nothing happens");
}

TEST_F(Output, KeepsItsRightsAndSecretsAreNeverReadableByOthers) {
  const auto mode = [&](const fs::path& path) {
    struct stat status {};
    stat(path.c_str(), &status);
    return status.st_mode & 0777;
  };
  std::ofstream(at("open")) << "x";
  fs::permissions(at("open"), fs::perms(0640));
  OutputFile(at("open")).fill("y");
  EXPECT_EQ(mode(at("open")), 0640u);
  fs::permissions(at("open"), fs::perms(0644));
  OutputFile(at("open"), {.inputs = {}, .mode = 0600}).fill("token");
  EXPECT_EQ(mode(at("open")), 0600u);
}

TEST_F(Output, LinksLeadToTheirTarget) {
  std::ofstream(at("target")) << "old";
  fs::create_symlink("target", at("link"));
  fs::create_symlink("link", at("second"));
  OutputFile(at("second")).fill("new");
  EXPECT_TRUE(fs::is_symlink(at("link")) && fs::is_symlink(at("second")));
  EXPECT_EQ(read_file(at("target")), "new");
  fs::create_symlink("fresh", at("dangling"));
  OutputFile(at("dangling")).fill("made");
  EXPECT_EQ(read_file(at("fresh")), "made");
  fs::create_symlink("ring", at("ring"));
  EXPECT_THROW(OutputFile(at("ring")), InputError);
}

TEST_F(Output, DevicesAreWrittenThrough) {
  OutputFile("/dev/null").fill("gone");
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
  OutputFile full("/dev/full");
  EXPECT_THROW(full.fill("no room"), InputError);
}

TEST_F(Output, AnInputIsNeverWritten) {
  std::ofstream(at("log")) << "precious";
  fs::create_symlink("log", at("link"));
  fs::create_hard_link(at("log"), at("hard"));
  for (const char* name : {"log", "link", "hard"}) {
    EXPECT_THROW(OutputFile(at(name), {.inputs = {at("log")}}), UsageError) << name;
    EXPECT_THROW(OutputFile(at(name), {.inputs = {at("log")}, .grows = true}), UsageError) << name;
  }
  EXPECT_EQ(read_file(at("log")), "precious");
}

TEST_F(Output, WhatHadNoRoomIsTakenBack) {
  // A limit of this process stands for a disk that is full in the middle of a record.
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto old = std::signal(SIGXFSZ, SIG_IGN);
  OutputFile file(at("log"), {.grows = true});
  file.write("a whole record");
  const rlimit full{20, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &full), 0);
  EXPECT_THROW(file.write("a record that has no room"), InputError);
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, old);
  EXPECT_EQ(read_file(at("log")), "a whole record");
  file.write(", and another");
  file.commit();
  EXPECT_EQ(read_file(at("log")), "a whole record, and another");
}

TEST_F(Output, AGrowingFileHasOneWriterAndIsNotOverwrittenUnasked) {
  const OutputRules grows{.inputs = {}, .grows = true, .overwrite = false};
  {
    OutputFile unused(at("log"), grows);
    EXPECT_TRUE(fs::exists(at("log")));
  }
  EXPECT_FALSE(fs::exists(at("log"))) << "nothing was written: nothing stays";
  OutputFile first(at("log"), grows);
  first.write("survives");
  EXPECT_EQ(read_file(at("log")), "survives");
  OutputRules forced = grows;
  forced.overwrite = true;
  EXPECT_THROW(OutputFile(at("log"), forced), InputError);
  first.commit();
  EXPECT_THROW(OutputFile(at("log"), grows), InputError);
  OutputFile second(at("log"), forced);
  EXPECT_EQ(read_file(at("log")), "survives") << "until the first new byte";
  second.write("new");
  second.commit();
  EXPECT_EQ(read_file(at("log")), "new");
}

}  // namespace
}  // namespace seam
