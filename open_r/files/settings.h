// The settings of a memory stick, in OPEN-R/MW/CONF: which objects there are (OBJECT.CFG), how they
// are connected (CONNECT.CFG), and which files they find by a keyword (DESIGNDB.CFG). Lines behind
// [ERS-210] count for that robot alone, `#` begins a comment.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace seam::open_r {

struct Connection {
  std::string subject;   // "A.Name.Data.S"
  std::string observer;  // "B.Name.Data.O"
};

// The words of the lines that count for a robot, with where they stand.
struct SettingsLine {
  std::string where;  // "CONNECT.CFG:12"
  std::vector<std::string> words;
};
std::vector<SettingsLine> settings_lines(std::string_view file, std::string_view text,
                                         std::string_view design);

// Paths such as "/MS/OPEN-R/MW/OBJS/MOVEHEAD.BIN". Throws Fault for a line that is none.
std::vector<std::string> read_object_settings(std::string_view text, std::string_view design);
std::vector<Connection> read_connections(std::string_view text, std::string_view design);
// The file of each keyword.
std::map<std::string, std::string> read_design_data(std::string_view text, std::string_view design);

}  // namespace seam::open_r
