#include "measurement/sets/set.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "sim_core/base/error.h"
#include "sim_core/input/schema_testing.h"

namespace seam::measurement {
namespace {

std::string message_of(auto action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(CsvTable, NumbersTextsAndBlanks) {
  const CsvTable table = CsvTable::from_text("a, b,c\r\n1,+2.5e-3,x\n3,,y\n\n", "t.csv");
  ASSERT_EQ(table.rows(), 2u);
  EXPECT_EQ(table.numbers("a"), (std::vector<double>{1, 3}));
  EXPECT_EQ(table.numbers_or_blank("b")[0], 2.5e-3);
  EXPECT_TRUE(std::isnan(table.numbers_or_blank("b")[1]));
  EXPECT_EQ(table.texts("c"), (std::vector<std::string>{"x", "y"}));
  EXPECT_EQ(message_of([&] { table.numbers("b"); }),
            "t.csv:3: column b: found '', expected a finite number");
}

TEST(CsvTable, ErrorsNameTheLine) {
  EXPECT_NE(message_of([] { CsvTable::from_text("a,b\n1\n", "t.csv"); }).find("t.csv:2"),
            std::string::npos);
  EXPECT_NE(message_of([] { CsvTable::from_text("a,a\n1,2\n", "t.csv"); }).find("twice"),
            std::string::npos);
  EXPECT_NE(message_of([] { CsvTable::from_text("", "t.csv"); }).find("empty"), std::string::npos);
  for (const char* bad : {"nan", "inf", "1e999", "0x10", "1,5", "abc"}) {
    const std::string text = std::string("a\n") + bad + "\n";
    EXPECT_NE(message_of([&] { CsvTable::from_text(text, "t.csv").numbers("a"); }).find("t.csv:2"),
              std::string::npos)
        << bad;
  }
}

TEST(CsvTable, EpochTimesKeepNanoseconds) {
  const CsvTable table =
      CsvTable::from_text("t\n1248272278.000000001\n-0.5\n1.25e1\n0.0000000005\n", "t.csv");
  EXPECT_EQ(table.times_ns("t"),
            (std::vector<int64_t>{1248272278000000001, -500000000, 12500000000, 1}));
}

TEST(CsvTable, ColumnsAreBounded) {
  std::string wide = "a0";
  for (int i = 1; i < 2'000'000; ++i) wide += ",a" + std::to_string(i);
  EXPECT_EQ(message_of([&] { CsvTable::from_text(wide + "\n", "t.csv"); }),
            "t.csv:1: more than 1000 columns");
}

// Of a set of joints with these further lines, from the third on.
std::string error_of_set(const std::string& lines) {
  const auto folder = std::filesystem::path(testing::TempDir()) / "refused_set";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "measurement.yaml") << "format: seam-measurement/1\nkind: joints\n"
                                             << lines;
  const std::string error = message_of([&] { MeasurementSet::open(folder); });
  std::filesystem::remove_all(folder);
  return error;
}

// Files that lie outside of a set are not read, wherever it names them.
TEST(MeasurementSet, NamesStayInsideTheFolder) {
  const auto error_of = [](const std::string& file) {
    return error_of_set("files: {joints: " + file + "}\n");
  };
  EXPECT_EQ(error_of("joints.csv"), "no error");
  EXPECT_NE(error_of("../joints.csv").find("measurement.yaml:3: files.joints: found '../joints"),
            std::string::npos);
  EXPECT_NE(error_of("/etc/passwd").find("files.joints"), std::string::npos);
  EXPECT_NE(error_of("\"a\\0b\"").find("measurement.yaml:3"), std::string::npos);
}

TEST(MeasurementSet, MisspeltTablesAreRefused) {
  EXPECT_EQ(error_of_set("files: {imu: imu.csv, attitudes: a.csv, weather: w.csv}\n"), "no error");
  EXPECT_NE(error_of_set("files: {imu: imu.csv, attitude: a.csv}\n")
                .find("unknown table 'attitude', did you mean 'attitudes'?"),
            std::string::npos);
}

TEST(MeasurementSet, NoiseOfNoSensorIsRefused) {
  const auto error_of = [](const std::string& sigma) {
    return error_of_set("noise: {measured_rad: " + sigma + "}\nfiles: {joints: joints.csv}\n");
  };
  EXPECT_EQ(error_of("0.001"), "no error");
  EXPECT_EQ(error_of("0"), "no error");
  for (const char* sigma : {"1e-160", "1e300"})
    EXPECT_NE(error_of(sigma).find("measurement.yaml:3: noise: measured_rad: found"),
              std::string::npos);
}

TEST(MeasurementSet, OneJointAloneIsRead) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::path(testing::TempDir()) / "one-joint";
  fs::create_directories(folder);
  std::ofstream(folder / "joints.csv") << "time_s,joint,command_rad,measured_rad\n"
                                          "0,hip,1,2\n0,knee,3,4\n1,hip,5,6\n";
  const auto set_of = [&](const std::string& joint) {
    const fs::path yaml = folder / "one.yaml";  // In the place of measurement.yaml.
    std::ofstream(yaml) << "format: seam-measurement/1\nkind: joints\njoint: " << joint
                        << "\nfiles: {joints: joints.csv}\n";
    return MeasurementSet::open(yaml);
  };
  const CsvTable knee = set_of("knee").table("joints");
  ASSERT_EQ(knee.rows(), 1u);
  EXPECT_EQ(knee.line(0), 3);
  EXPECT_EQ(set_of("hip").table("joints").numbers("measured_rad"), (std::vector<double>{2, 6}));
  const std::string message = message_of([&] { set_of("knees").table("joints"); });
  EXPECT_NE(message.find("one.yaml:3: joint:"), std::string::npos) << message;
  EXPECT_NE(message.find("did you mean 'knee'"), std::string::npos) << message;
  fs::remove_all(folder);
}

TEST(MeasurementSet, SchemaFileIsCurrent) {
  expect_page_is(std::string(SEAM_SOURCE_DIR) + "/docs/reference/schemas/measurement.schema.json",
                 MeasurementSet::schema());
}

TEST(HeldOutGroups, ThirtyPerCentRoundedUp) {
  for (const size_t count : {4u, 5u, 10u, 200u}) {
    std::vector<std::string> ids;
    for (size_t i = 0; i < count; ++i) ids.push_back(std::to_string(i));
    const std::vector<char> held_out = held_out_groups(ids);
    EXPECT_EQ(std::count(held_out.begin(), held_out.end(), 1),
              static_cast<long>(std::ceil(0.3 * count)));
    EXPECT_EQ(held_out, held_out_groups(ids));
  }
}

// One blank cell leaves a whole column out: that is said, with its line; a column of words is none.
TEST(CsvTable, SaysWhichColumnLacksANumber) {
  const CsvTable table = CsvTable::from_text(
      "u_px,temperature_c,remark\n1,20.5,\n2,,warm\n3,21,\n4,21.5,7\n", "points.csv");
  const std::vector<std::string> notes = table.incomplete_columns({"u_px"});
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_EQ(notes[0],
            "points.csv:3: column temperature_c is left out: found '', expected a number in every "
            "row (1 of 4 have none)");
  EXPECT_TRUE(table.incomplete_columns({"u_px", "temperature_c"}).empty());
}

}  // namespace
}  // namespace seam::measurement
