#include "open_r/files/settings.h"

#include <algorithm>
#include <cctype>
#include <sstream>

#include "open_r/files/fault.h"
#include "open_r/files/memory_stick.h"

namespace seam::open_r {
namespace {

// "/MS/OPEN-R/MW/OBJS/MOVEHEAD.BIN": what is built goes there, so that nothing else will do. A
// stick knows no small letters, so that both are written.
bool is_object_path(std::string_view path) {
  const std::string_view name = path.substr(path.rfind('/') + 1);
  return path.starts_with("/MS/") && name.size() > 4 &&
         (name.ends_with(".BIN") || name.ends_with(".bin")) &&
         std::all_of(name.begin(), name.end(), [](unsigned char c) {
           return std::isalnum(c) != 0 || c == '_' || c == '-' || c == '.';
         });
}

}  // namespace

std::vector<SettingsLine> settings_lines(std::string_view file, std::string_view text,
                                         std::string_view design) {
  std::vector<SettingsLine> lines;
  std::istringstream stream{std::string(text)};
  bool counts = true;
  int number = 0;
  for (std::string line; std::getline(stream, line);) {
    ++number;
    std::istringstream words(line.substr(0, line.find('#')));
    SettingsLine found{std::string(file) + ":" + std::to_string(number), {}};
    for (std::string word; words >> word;) found.words.push_back(word);
    if (found.words.empty()) continue;
    const std::string& first = found.words.front();
    if (first.front() == '[') {
      if (first.back() != ']')
        throw Fault(found.where + ": '" + first + "' is not closed, expected such as [ERS-210]");
      counts = std::string_view(first).substr(1, first.size() - 2) == design;
      continue;
    }
    if (counts) lines.push_back(std::move(found));
  }
  return lines;
}

std::vector<std::string> read_object_settings(std::string_view text, std::string_view design) {
  std::vector<std::string> objects;
  const auto file_of = [](std::string_view path) { return path.substr(path.rfind('/') + 1); };
  for (const SettingsLine& line : settings_lines("OBJECT.CFG", text, design)) {
    if (line.words.size() != 1 || !is_object_path(line.words[0]))
      throw Fault(line.where + ": found '" + line.words[0] +
                  "', expected one path such as /MS/OPEN-R/MW/OBJS/NAME.BIN");
    const auto is_same = [&](const std::string& other) {
      return same_name(file_of(other), file_of(line.words[0]));
    };
    if (std::any_of(objects.begin(), objects.end(), is_same))
      throw Fault(line.where + ": " + line.words[0] + " is named twice, expected one line for it");
    objects.push_back(line.words[0]);
  }
  return objects;
}

std::vector<Connection> read_connections(std::string_view text, std::string_view design) {
  std::vector<Connection> connections;
  for (const SettingsLine& line : settings_lines("CONNECT.CFG", text, design)) {
    if (line.words.size() != 2 || !line.words[0].ends_with(".S") || !line.words[1].ends_with(".O"))
      throw Fault(line.where + ": found '" + line.words[0] +
                  "', expected a subject and an observer: A.Name.Data.S B.Name.Data.O");
    connections.push_back({line.words[0], line.words[1]});
  }
  return connections;
}

std::map<std::string, std::string> read_design_data(std::string_view text,
                                                    std::string_view design) {
  std::map<std::string, std::string> files;
  for (const SettingsLine& line : settings_lines("DESIGNDB.CFG", text, design)) {
    if (line.words.size() != 2)
      throw Fault(line.where + ": found '" + line.words[0] +
                  "', expected a keyword and a path such as /MS/OPEN-R/MW/DATA/P/FILE.TXT");
    files[line.words[0]] = line.words[1];
  }
  return files;
}

}  // namespace seam::open_r
