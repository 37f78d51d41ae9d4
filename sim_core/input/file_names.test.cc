#include "sim_core/input/file_names.h"

#include <gtest/gtest.h>

#include <fstream>

#include "sim_core/base/error.h"

namespace seam {
namespace fs = std::filesystem;
namespace {

class FileNames : public testing::Test {
 protected:
  FileNames() {
    fs::remove_all(folder_);
    fs::create_directories(folder_ / "set" / "frames");
    std::ofstream(folder_ / "outside.csv") << "a\n1\n";
    std::ofstream(folder_ / "set" / "inside.csv") << "a\n1\n";
  }
  ~FileNames() override { fs::remove_all(folder_); }

  std::string why(const std::string& name) const { return why_not_inside(folder_ / "set", name); }

  const fs::path folder_ = fs::path(testing::TempDir()) / "file_names";
};

TEST_F(FileNames, PathsInsideAreTaken) {
  EXPECT_EQ(path_inside(folder_ / "set", "inside.csv"), folder_ / "set" / "inside.csv");
  EXPECT_EQ(why("frames/0000.png"), "");
  EXPECT_EQ(why("./frames/a..b.png"), "");
  EXPECT_EQ(why("not made yet/deep/file.csv"), "");
  EXPECT_EQ(why("Kalibrierung äöü.csv"), "");
}

TEST_F(FileNames, WhatLeadsOutIsRefused) {
  EXPECT_NE(why(""), "");
  EXPECT_NE(why("/etc/passwd").find("relative"), std::string::npos);
  for (const char* name : {"..", "../outside.csv", "frames/../../outside.csv", "frames/.."})
    EXPECT_NE(why(name).find("out of the folder"), std::string::npos) << name;
  EXPECT_THROW(path_inside(folder_ / "set", "../outside.csv"), InputError);
}

TEST_F(FileNames, ControlCharactersAreRefusedAndShown) {
  using std::string_literals::operator""s;
  EXPECT_NE(why(std::string("a\0b.csv", 7)).find("a\\x00b.csv"), std::string::npos);
  EXPECT_NE(why("\x1b[2J.csv").find("\\x1b[2J.csv"), std::string::npos);
  EXPECT_NE(why("a\nb.csv"), "");
}

TEST_F(FileNames, LinksMayStayInsideButNotLeadOut) {
  fs::create_symlink("inside.csv", folder_ / "set" / "link.csv");
  fs::create_symlink("../outside.csv", folder_ / "set" / "escape.csv");
  fs::create_directory_symlink("..", folder_ / "set" / "up");
  fs::create_directory_symlink("set", folder_ / "link_to_set");
  EXPECT_EQ(why("link.csv"), "");
  EXPECT_NE(why("escape.csv").find("link"), std::string::npos);
  EXPECT_NE(why("up/outside.csv").find("link"), std::string::npos);
  // Nothing is at its end yet: what is written there would be made outside.
  fs::create_symlink("../not_made_yet.csv", folder_ / "set" / "dangling.csv");
  EXPECT_NE(why("dangling.csv").find("link"), std::string::npos);
  fs::create_symlink(fs::canonical(folder_) / "set" / "inside.csv", folder_ / "set" / "whole.csv");
  EXPECT_EQ(why("whole.csv"), "");
  fs::create_symlink("round.csv", folder_ / "set" / "round.csv");
  EXPECT_NE(why("round.csv"), "");
  // The folder itself may be a link: it is what the user named.
  EXPECT_EQ(why_not_inside(folder_ / "link_to_set", "inside.csv"), "");
}

}  // namespace
}  // namespace seam
