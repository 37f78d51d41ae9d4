#include "open_r/files/settings.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "open_r/files/fault.h"
#include "open_r/files/memory_stick.h"

namespace seam::open_r {
namespace {

TEST(StickSettings, SectionsCountForTheirRobot) {
  constexpr char kObjects[] =
      "# All robots\n/MS/OPEN-R/MW/OBJS/ONE.BIN\n[ERS-210]\n/MS/OPEN-R/MW/OBJS/TWO.BIN\n"
      "[ERS-7]\n/MS/OPEN-R/MW/OBJS/SEVEN.BIN\n";
  EXPECT_EQ(read_object_settings(kObjects, "ERS-210"),
            (std::vector<std::string>{"/MS/OPEN-R/MW/OBJS/ONE.BIN", "/MS/OPEN-R/MW/OBJS/TWO.BIN"}));
  EXPECT_EQ(
      read_object_settings(kObjects, "ERS-7"),
      (std::vector<std::string>{"/MS/OPEN-R/MW/OBJS/ONE.BIN", "/MS/OPEN-R/MW/OBJS/SEVEN.BIN"}));
}

TEST(StickSettings, NamesInSmallLettersAreObjectsToo) {
  EXPECT_EQ(read_object_settings("/MS/OPEN-R/MW/OBJS/vision.bin\n", "ERS-7"),
            std::vector<std::string>{"/MS/OPEN-R/MW/OBJS/vision.bin"});
}

TEST(StickSettings, ConnectionsAndFiles) {
  const auto connections = read_connections("\n#\nA.M.D.S  B.N.D.O\n", "ERS-210");
  ASSERT_EQ(connections.size(), 1u);
  EXPECT_EQ(connections[0].subject, "A.M.D.S");
  EXPECT_EQ(connections[0].observer, "B.N.D.O");
  const auto files = read_design_data("[ERS-210]\nWORD /MS/OPEN-R/MW/DATA/P/X.TXT\n", "ERS-210");
  EXPECT_EQ(files.at("WORD"), "/MS/OPEN-R/MW/DATA/P/X.TXT");
}

TEST(StickSettings, FaultsNameTheLine) {
  const auto fault = [](auto read, const char* text) -> std::string {
    try {
      read(text, "ERS-210");
    } catch (const Fault& found) {
      return found.what();
    }
    return "";
  };
  EXPECT_EQ(fault(read_connections, "A.M.D.O B.N.D.O\n").substr(0, 14), "CONNECT.CFG:1:");
  EXPECT_EQ(fault(read_object_settings, "\nOPEN-R/ONE.BIN\n").substr(0, 13), "OBJECT.CFG:2:");
  EXPECT_EQ(fault(read_object_settings, "[ERS-210\n").substr(0, 13), "OBJECT.CFG:1:");
  // A section of another robot may name it again.
  const std::string head = "/MS/OPEN-R/MW/OBJS/HEAD.BIN\n";
  EXPECT_EQ(read_object_settings(head + "[ERS-7]\n" + head, "ERS-210").size(), 1u);
  EXPECT_EQ(
      fault(read_object_settings, (head + "/MS/OPEN-R/MW/OBJS/head.bin\n").c_str()).substr(0, 13),
      "OBJECT.CFG:2:");
}

// A stick knows no small letters; nothing lies outside of it.
TEST(MemoryStickFolder, FindsFilesWhateverTheirLetters) {
  namespace fs = std::filesystem;
  const fs::path root = fs::temp_directory_path() / "open_r_stick_test";
  fs::create_directories(root / "OPEN-R" / "Data");
  std::ofstream(root / "OPEN-R" / "Data" / "Gait.txt") << "1";
  const MemoryStick stick(root);
  EXPECT_EQ(stick.find("/MS/open-r/DATA/GAIT.TXT"), root / "OPEN-R" / "Data" / "Gait.txt");
  EXPECT_EQ(stick.find("/MS/OPEN-R/Data/NEW.TXT"), root / "OPEN-R" / "Data" / "NEW.TXT");
  EXPECT_EQ(stick.find("/MS/../OPEN-R"), root / "OPEN-R");
  EXPECT_EQ(stick.find("other.txt"), "other.txt");
  fs::remove_all(root);
}

}  // namespace
}  // namespace seam::open_r
