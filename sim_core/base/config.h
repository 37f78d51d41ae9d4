// Reading configuration from YAML with errors that name file, line and key. A key that nobody
// asked for is an error (`finish`), so a misspelt parameter is found at the door.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "sim_core/base/pose.h"

namespace YAML {
class Node;
}

namespace seam {

struct Range {
  double min;
  double max;
};

// A node of a configuration file together with where it stands.
class ConfigNode {
 public:
  // Parses a file; throws InputError with file and line. Limits: 16 MiB, nesting depth 64.
  static ConfigNode from_file(const std::filesystem::path& path);
  // A name with ": " in it is a place in another document, "match.yaml:7: robots[0].camera.model":
  // no line is given then, for the text's own lines stand in no file.
  static ConfigNode from_text(const std::string& text, const std::string& name);
  // A text that a program wrote: errors name the key without a line.
  static ConfigNode from_made_text(const std::string& text, const std::string& name);

  bool is_map() const;
  bool is_scalar() const;
  bool is_null() const;

  // Maps. `at` throws when the key is missing; both mark the key as known.
  bool has(const std::string& key) const;
  ConfigNode at(const std::string& key) const;
  std::optional<ConfigNode> find(const std::string& key) const;
  std::vector<std::string> keys() const;  // In the file's order; marks none.
  // Throws for a key that was never asked for, with the nearest known one.
  void finish() const;
  // The same where people add notes of their own: only a key near to a known one is an error.
  void finish_with_notes() const;

  // Lists.
  std::vector<ConfigNode> items() const;

  // Scalars; throw when the value is of another type, not finite, or out of range.
  double number() const;
  double number(Range range) const;
  int64_t integer(int64_t min, int64_t max) const;
  bool boolean() const;
  std::string text() const;
  // One of the given words; returns its place.
  size_t choice(const std::vector<std::string>& words) const;
  Vec3 vec3() const;
  std::vector<double> numbers(size_t count) const;

  // Shorthands for `at(key)` or the default where the key is missing.
  double number_or(const std::string& key, double fallback, Range range) const;
  int64_t integer_or(const std::string& key, int64_t fallback, int64_t min, int64_t max) const;
  bool boolean_or(const std::string& key, bool fallback) const;
  std::string text_or(const std::string& key, const std::string& fallback) const;

  // "file:line: path.to.key: message"; without the line where the text stands in no file.
  [[noreturn]] void fail(const std::string& message) const;
  std::string where() const;
  const std::string& file() const { return file_; }
  int line() const;
  const YAML::Node& yaml() const { return *node_; }

 private:
  static ConfigNode parsed(const std::string& text, const std::string& name, bool has_lines);
  ConfigNode(const YAML::Node& node, std::string file, std::string path, int line_of_parent,
             bool has_lines);

  // Behind a pointer, so that the files that read configuration need not compile the parser's
  // headers.
  std::shared_ptr<const YAML::Node> node_;
  std::string file_;
  std::string path_;
  int line_of_parent_ = 0;
  bool has_lines_ = true;
  // Shared by copies of the same node, so that what one copy asked for is known to `finish`.
  std::shared_ptr<std::set<std::string>> asked_;
};

}  // namespace seam
