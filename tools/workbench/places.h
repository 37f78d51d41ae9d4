// What the page may open: what was named at the terminal and what lies below it, and what was
// opened so before.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace seam::tools {

// Text as names of files may have it: letters, digits, - and _.
std::string name_in_files(std::string text);

class Places {
 public:
  // `named`: at the terminal. `session`: of the first of them; empty: NAME.session in this folder.
  Places(const std::vector<std::string>& named, const std::string& session);

  // The folder of a set that the page names. Throws Refusal where it may not be opened.
  std::filesystem::path to_open(const std::string& path) const;
  // Where the session of this set is.
  std::filesystem::path session_of(const std::filesystem::path& data) const;
  // Remembers it among the sets that were opened last.
  void remember(const std::filesystem::path& data, const nlohmann::json& set) const;
  nlohmann::json recent() const;
  // What was named at the terminal: folders below it may be opened by their names.
  nlohmann::json named() const;
  // The folder that sessions are put into.
  std::filesystem::path beside() const;

 private:
  bool was_open(const std::filesystem::path& data) const;

  std::vector<std::filesystem::path> roots_;
  std::filesystem::path first_, session_;
};

}  // namespace seam::tools
