#include "sim_core/base/config.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>

#include "sim_core/base/error.h"
#include "sim_core/base/files.h"

namespace seam {
namespace {

constexpr uint64_t kMaxConfigBytes = 16 << 20;
constexpr int kMaxDepth = 64;
constexpr int kMaxUnfoldedDepth = 4 * kMaxDepth;  // Brackets, dashes and indentation may add up.
constexpr size_t kMostByAliases = 100'000;        // Values beyond those that are written.
// Of a map: yaml-cpp looks through all keys for each one.
constexpr size_t kMostKeys = 5000;

// yaml-cpp recurses over nesting, so that depth must be bounded before it parses: brackets for flow
// style, indentation for block style (a "- - - -" line nests without indentation, hence both).
void refuse_hostile_nesting(const std::string& text, const std::string& name) {
  int line = 1, flow_depth = 0, dashes = 0;
  size_t indent = 0;
  bool at_indent = true;
  char quote = 0;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '\n') {
      ++line, indent = 0, dashes = 0, at_indent = true;
      continue;
    }
    if (quote != 0) {
      if (c == quote) quote = 0;
      continue;
    }
    if (at_indent && c == ' ') {
      ++indent;
    } else if (at_indent && (c == '-' || c == '?' || c == ':') && i + 1 < text.size() &&
               text[i + 1] == ' ') {
      ++dashes;
    } else {
      at_indent = at_indent && c == '\t';
      if ((c == '"' || c == '\'') &&
          (i == 0 || !std::isalnum(static_cast<unsigned char>(text[i - 1]))))
        quote = c;
      if (c == '#' && (i == 0 || text[i - 1] == ' ' || text[i - 1] == '\n')) {
        while (i + 1 < text.size() && text[i + 1] != '\n') ++i;
      }
      if (c == '[' || c == '{') ++flow_depth;
      if (c == ']' || c == '}') --flow_depth;
    }
    if (flow_depth > kMaxDepth || dashes > kMaxDepth || indent > 8 * kMaxDepth) {
      throw InputError(fmt::format("{}:{}: nested deeper than {} levels", name, line, kMaxDepth));
    }
  }
}

// Aliases let a few lines stand for billions of values, and for themselves.
void refuse_hostile_aliases(const YAML::Node& node, const std::string& name, int depth,
                            size_t& left) {
  if (depth > kMaxUnfoldedDepth)
    throw InputError(fmt::format("{}:{}: nested deeper than {} levels, by aliases", name,
                                 node.Mark().line + 1, kMaxUnfoldedDepth));
  if (left-- == 0)
    throw InputError(fmt::format("{}:{}: aliases unfold to more values than a file may have", name,
                                 node.Mark().line + 1));
  if (!node.IsMap() && !node.IsSequence()) return;
  for (const auto& item : node) {
    if (node.IsMap()) refuse_hostile_aliases(item.first, name, depth + 1, left);
    refuse_hostile_aliases(node.IsMap() ? item.second : item, name, depth + 1, left);
  }
}

// The library reads the first document alone, and may not end where it is asked for all.
void refuse_second_document(const std::string& text, const std::string& name) {
  bool began = false;
  int number = 0;
  for (size_t at = 0; at < text.size();) {
    const size_t end = std::min(text.find('\n', at), text.size());
    const std::string_view line(text.data() + at, end - at);
    ++number, at = end + 1;
    const bool marks = line.starts_with("---") && line.find_first_not_of(" \t\r", 3) != 3;
    if (marks && began)
      throw InputError(
          fmt::format("{}:{}: a second document begins, expected one in a file", name, number));
    const size_t first = line.find_first_not_of(" \t\r");
    began |= marks || (first != std::string_view::npos && line[first] != '#' && line[0] != '%');
  }
}

// Names go into messages, formulas, tables and names of files.
bool has_control_characters(std::string_view text) {
  return std::any_of(text.begin(), text.end(), [](char c) {
    const auto code = static_cast<unsigned char>(c);
    return code < 0x20 || code == 0x7F;
  });
}

void check_map(const ConfigNode& node) {
  if (!node.yaml().IsMap()) node.fail("expected a map of keys to values");
  if (node.yaml().size() > kMostKeys)
    node.fail(fmt::format("found {} keys, expected {} at most", node.yaml().size(), kMostKeys));
}

}  // namespace

ConfigNode::ConfigNode(const YAML::Node& node, std::string file, std::string path,
                       int line_of_parent, bool has_lines)
    : node_(std::make_shared<const YAML::Node>(node)),
      file_(std::move(file)),
      path_(std::move(path)),
      line_of_parent_(line_of_parent),
      has_lines_(has_lines),
      asked_(std::make_shared<std::set<std::string>>()) {}

bool ConfigNode::is_map() const {
  return node_->IsMap();
}
bool ConfigNode::is_scalar() const {
  return node_->IsScalar();
}
bool ConfigNode::is_null() const {
  return node_->IsNull();
}

ConfigNode ConfigNode::from_file(const std::filesystem::path& path) {
  return from_text(read_file(path, kMaxConfigBytes), path.string());
}

ConfigNode ConfigNode::from_text(const std::string& text, const std::string& name) {
  return parsed(text, name, name.find(": ") == std::string::npos);
}

ConfigNode ConfigNode::from_made_text(const std::string& text, const std::string& name) {
  return parsed(text, name, /*has_lines=*/false);
}

ConfigNode ConfigNode::parsed(const std::string& text, const std::string& name, bool has_lines) {
  if (const size_t at = text.find('\0'); at != std::string::npos)
    throw InputError(fmt::format("{}: byte {} is a NUL: not a text file", name, at + 1));
  refuse_hostile_nesting(text, name);
  refuse_second_document(text, name);
  try {
    const YAML::Node node = YAML::Load(text);
    // Without them no file has more values than characters.
    size_t values = text.size() + kMostByAliases;
    if (text.find('*') != std::string::npos) refuse_hostile_aliases(node, name, 0, values);
    ConfigNode root(node, name, "", 1, has_lines);
    if (!root.node_->IsDefined() || root.node_->IsNull()) root.fail("the file is empty");
    return root;
  } catch (const YAML::Exception& error) {
    throw InputError(fmt::format("{}:{}: {}", name, error.mark.line + 1, error.msg));
  }
}

int ConfigNode::line() const {
  const YAML::Mark mark = node_->Mark();
  return mark.line >= 0 ? mark.line + 1 : line_of_parent_;
}

std::string ConfigNode::where() const {
  const std::string place = has_lines_ ? fmt::format("{}:{}", file_, line()) : file_;
  return path_.empty() ? place : fmt::format("{}: {}", place, path_);
}

void ConfigNode::fail(const std::string& message) const {
  throw InputError(fmt::format("{}: {}", where(), message));
}

bool ConfigNode::has(const std::string& key) const {
  check_map(*this);
  asked_->insert(key);
  return (*node_)[key].IsDefined() && !(*node_)[key].IsNull();
}

std::optional<ConfigNode> ConfigNode::find(const std::string& key) const {
  if (!has(key)) return std::nullopt;
  return ConfigNode((*node_)[key], file_, path_.empty() ? key : path_ + "." + key, line(),
                    has_lines_);
}

ConfigNode ConfigNode::at(const std::string& key) const {
  auto found = find(key);
  if (!found) fail(fmt::format("key '{}' is missing", key));
  return *found;
}

std::vector<std::string> ConfigNode::keys() const {
  check_map(*this);
  std::vector<std::string> keys;
  std::set<std::string> seen;
  for (const auto& entry : *node_) {
    if (!entry.first.IsScalar()) fail("expected plain words as keys");
    const std::string& key = entry.first.Scalar();
    if (has_control_characters(key))
      fail("found a control character in a key, expected plain words");
    if (!seen.insert(key).second) fail(fmt::format("key '{}' stands twice", key));
    keys.push_back(key);
  }
  return keys;
}

void ConfigNode::finish() const {
  for (const std::string& key : keys()) {
    if (asked_->contains(key)) continue;
    const std::vector<std::string> known(asked_->begin(), asked_->end());
    const auto value = ConfigNode((*node_)[key], file_, path_, line(), has_lines_);
    value.fail(fmt::format("unknown key '{}'{}", key, suggestion_for(key, known)));
  }
}

void ConfigNode::finish_with_notes() const {
  const std::vector<std::string> known(asked_->begin(), asked_->end());
  for (const std::string& key : keys()) {
    if (asked_->contains(key)) continue;
    const std::string hint = suggestion_for(key, known);
    if (hint.find("did you mean") != std::string::npos) at(key).fail("unknown key" + hint);
  }
}

std::vector<ConfigNode> ConfigNode::items() const {
  if (!node_->IsSequence()) fail("expected a list");
  std::vector<ConfigNode> items;
  for (size_t i = 0; i < node_->size(); ++i) {
    items.push_back(
        ConfigNode((*node_)[i], file_, fmt::format("{}[{}]", path_, i), line(), has_lines_));
  }
  return items;
}

double ConfigNode::number() const {
  double value = 0;
  if (!node_->IsScalar()) fail("expected a number");
  try {
    value = node_->as<double>();
  } catch (const YAML::Exception&) {
    fail(fmt::format("found '{}', expected a number", node_->Scalar()));
  }
  if (!std::isfinite(value))
    fail(fmt::format("found '{}', expected a finite number", node_->Scalar()));
  return value;
}

double ConfigNode::number(Range range) const {
  const double value = number();
  if (value < range.min || value > range.max) {
    fail(fmt::format("found {}, expected a number from {} to {}", value, range.min, range.max));
  }
  return value;
}

int64_t ConfigNode::integer(int64_t min, int64_t max) const {
  if (!node_->IsScalar()) fail("expected a whole number");
  const std::string& text = node_->Scalar();
  int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) {
    fail(fmt::format("found '{}', expected a whole number", text));
  }
  if (value < min || value > max) {
    fail(fmt::format("found {}, expected a whole number from {} to {}", value, min, max));
  }
  return value;
}

bool ConfigNode::boolean() const {
  try {
    return node_->as<bool>();
  } catch (const YAML::Exception&) {
    fail("expected true or false");
  }
}

std::string ConfigNode::text() const {
  if (!node_->IsScalar()) fail("expected text");
  // Other control characters are shown as they are written (sim_core/input/shown_text.h); a NUL
  // ends a text for many a library.
  if (node_->Scalar().find('\0') != std::string::npos) fail("found a NUL, expected plain text");
  return node_->Scalar();
}

size_t ConfigNode::choice(const std::vector<std::string>& words) const {
  const std::string word = text();
  for (size_t i = 0; i < words.size(); ++i) {
    if (words[i] == word) return i;
  }
  fail(fmt::format("found '{}'{}", word, suggestion_for(word, words)));
}

std::vector<double> ConfigNode::numbers(size_t count) const {
  const auto nodes = items();
  if (nodes.size() != count)
    fail(fmt::format("found {} numbers, expected {}", nodes.size(), count));
  std::vector<double> values;
  for (const ConfigNode& node : nodes) values.push_back(node.number());
  return values;
}

Vec3 ConfigNode::vec3() const {
  const auto values = numbers(3);
  return {values[0], values[1], values[2]};
}

double ConfigNode::number_or(const std::string& key, double fallback, Range range) const {
  const auto node = find(key);
  return node ? node->number(range) : fallback;
}

int64_t ConfigNode::integer_or(const std::string& key, int64_t fallback, int64_t min,
                               int64_t max) const {
  const auto node = find(key);
  return node ? node->integer(min, max) : fallback;
}

bool ConfigNode::boolean_or(const std::string& key, bool fallback) const {
  const auto node = find(key);
  return node ? node->boolean() : fallback;
}

std::string ConfigNode::text_or(const std::string& key, const std::string& fallback) const {
  const auto node = find(key);
  return node ? node->text() : fallback;
}

}  // namespace seam
