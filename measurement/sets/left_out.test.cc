#include "measurement/sets/left_out.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "measurement/sets/set.h"
#include "sim_core/base/error.h"

namespace seam::measurement {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

class LeftOutRowsOfSet : public testing::Test {
 protected:
  LeftOutRowsOfSet() : folder_(std::filesystem::path(testing::TempDir()) / "left-out") {
    std::filesystem::create_directories(folder_);
    // A blank line: rows keep the numbers that an editor shows.
    std::ofstream(folder_ / "a.csv") << "time_s,x\n0,1\n\n1,2\n2,3\n";
    std::ofstream(folder_ / "b.csv") << "time_s,y\n0,4\n";
    std::ofstream(folder_ / "measurement.yaml")
        << "format: seam-measurement/1\nkind: odometry\nfiles: {a: a.csv, b: b.csv}\n";
  }
  ~LeftOutRowsOfSet() override { std::filesystem::remove_all(folder_); }

  MeasurementSet set() const { return MeasurementSet::open(folder_); }
  LeftOut read(const std::string& text) const {
    std::ofstream(folder_ / "left.csv") << text;
    return read_left_out(folder_ / "left.csv", set(), "a");
  }

  std::filesystem::path folder_;
};

TEST_F(LeftOutRowsOfSet, LinesOfTheFileGo) {
  MeasurementSet set = this->set();
  const std::string whole = set.fingerprint();
  set.left_out = read("row,reason\n4,late\n2,early\n");
  const CsvTable table = set.table("a");
  ASSERT_EQ(table.rows(), 1u);
  EXPECT_EQ(table.line(0), 5);
  EXPECT_EQ(set.table("b").rows(), 1u);
  EXPECT_EQ(set.left_out.sentence(), "2 rows left out by choice: 1 late, 1 early");
  EXPECT_NE(set.fingerprint(), whole);
  set.left_out = read("row,reason\n2,early\n");
  EXPECT_EQ(set.left_out.sentence(), "1 row left out by choice: 1 early");
  set.left_out = read("row,reason\n");
  EXPECT_TRUE(set.left_out.empty());
  EXPECT_EQ(set.fingerprint(), whole);
}

TEST_F(LeftOutRowsOfSet, ReasonsAreShownNotSent) {
  const LeftOut left = read("row,reason\n2,\x1b[2J\xff\n");
  ASSERT_EQ(left.reasons.size(), 1u);
  EXPECT_EQ(left.reasons[0].reason, "\\x1b[2J\\xff");
}

TEST_F(LeftOutRowsOfSet, WhatIsWrongIsWrongUse) {
  const auto refused = [&](const std::string& text, const std::string& said) {
    EXPECT_THAT([&] { read(text); }, ThrowsMessage<UsageError>(HasSubstr(said))) << text;
  };
  refused("row,reason\n3,x\n", "left.csv:2: column row: found '3', expected a line of");
  refused("row,reason\n2,x\n4,y\n2,z\n", "left.csv:4: column row: found '2', expected each row");
  refused("row,reason\n2,x\n4,x\n5,x\n", "leaves out every row of");
  refused("file,row,reason\nb,2,x\n", "leaves out every row of");
  refused("file,row,reason\nc,2,x\n", "left.csv:2: column file: found 'c', expected a name under");
  refused("row;reason\n2;x\n", "left.csv:1: column 'row' is missing");
}

}  // namespace
}  // namespace seam::measurement
