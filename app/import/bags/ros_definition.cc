#include "app/import/bags/ros_definition.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <map>

#include "sim_core/base/error.h"

namespace seam::app {
namespace {

constexpr size_t kMostFields = 2000, kMostDepth = 16;
constexpr size_t kMostElements = size_t{1} << 22;  // Of one message, all lists together.

std::string_view trimmed(std::string_view text) {
  const size_t first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return "";
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

}  // namespace

class RosDefinition::Parser {
 public:
  Parser(RosDefinition& definition, std::string_view text)
      : definition_(definition), sections_(sections_of(definition.type_, text)) {}

  struct Line {
    std::string type, name;
  };
  using Sections = std::map<std::string, std::vector<Line>>;

  Node message(const std::string& type, const std::string& path, size_t depth) {
    const auto found = sections_.find(type);
    if (found == sections_.end() || depth > kMostDepth)
      throw InputError(fmt::format("{}: the definition of '{}' is {}", definition_.type_, type,
                                   depth > kMostDepth ? "nested too deep" : "missing"));
    Node node;
    for (const Line& line : found->second) {
      if (++nodes_ > kMostFields)
        throw InputError(fmt::format("{}: more than {} fields", definition_.type_, kMostFields));
      node.members.push_back(member(type, line, path, depth));
    }
    return node;
  }

 private:
  // Definitions by type: that of the message, then those that it needs, behind "MSG: pkg/Type".
  static Sections sections_of(const std::string& type, std::string_view text) {
    Sections sections;
    std::vector<Line>* lines = &sections[type];
    while (!text.empty()) {
      const size_t end = std::min(text.find('\n'), text.size());
      std::string_view line = text.substr(0, end);
      text.remove_prefix(std::min(end + 1, text.size()));
      line = trimmed(line.substr(0, line.find('#')));
      if (line.starts_with("====") || line.empty()) continue;
      if (line.starts_with("MSG:")) {
        lines = &sections[plain_ros_type(std::string(trimmed(line.substr(4))))];
        continue;
      }
      const size_t blank = line.find_first_of(" \t");
      if (blank == std::string_view::npos)
        throw InputError(fmt::format("{}: found '{}' in the definition, expected TYPE NAME", type,
                                     line.substr(0, 80)));
      const std::string_view rest = trimmed(line.substr(blank));
      const std::string_view name = rest.substr(0, rest.find_first_of(" \t="));
      // NAME=VALUE is a constant, NAME VALUE has a default.
      if (trimmed(rest.substr(name.size())).starts_with('=')) continue;
      lines->push_back({std::string(line.substr(0, blank)), std::string(name)});
    }
    return sections;
  }

  Node member(const std::string& within, const Line& line, const std::string& path, size_t depth) {
    std::string type = line.type;
    List list = List::none;
    uint32_t count = 0;
    if (const size_t bracket = type.find('['); bracket != std::string::npos) {
      const char* end = type.data() + type.size() - 1;
      const auto [stop, error] = std::from_chars(type.data() + bracket + 1, end, count);
      list = error == std::errc() && stop == end && *end == ']' ? List::fixed : List::counted;
      type.resize(bracket);
    }
    type = type.substr(0, type.find("<="));  // string<=10
    const std::string full = path.empty() ? line.name : path + "." + line.name;
    Node node = leaf(type, full);
    if (node.kind == Kind::message) {
      type = plain_ros_type(type);
      if (type == "Header") type = "std_msgs/Header";
      if (type.find('/') == std::string::npos) type = within.substr(0, within.find('/') + 1) + type;
      node = message(type, full, depth + 1);
    }
    node.list = list, node.count = count;
    return node;
  }

  // A message's kind where it is no leaf.
  Node leaf(const std::string& type, const std::string& path) {
    static const std::map<std::string, std::pair<Kind, size_t>> kLeaves = {
        {"bool", {Kind::boolean, 1}},   {"byte", {Kind::natural, 1}},
        {"char", {Kind::natural, 1}},   {"uint8", {Kind::natural, 1}},
        {"uint16", {Kind::natural, 2}}, {"uint32", {Kind::natural, 4}},
        {"uint64", {Kind::natural, 8}}, {"int8", {Kind::whole, 1}},
        {"int16", {Kind::whole, 2}},    {"int32", {Kind::whole, 4}},
        {"int64", {Kind::whole, 8}},    {"float32", {Kind::real, 4}},
        {"float64", {Kind::real, 8}},   {"string", {Kind::text, 0}},
        {"time", {Kind::time, 0}},      {"duration", {Kind::time, 0}},
    };
    std::string plain = plain_ros_type(type);
    if (plain == "builtin_interfaces/Time") plain = "time";
    if (plain == "builtin_interfaces/Duration") plain = "duration";
    const auto found = kLeaves.find(plain);
    if (found == kLeaves.end()) return {};
    const auto [kind, bytes] = found->second;
    definition_.fields_.push_back(
        {.path = path, .is_text = kind == Kind::text, .is_real = kind == Kind::real});
    return {.kind = kind,
            .bytes = bytes,
            .field = definition_.fields_.size() - 1,
            .is_stamp = path == "header.stamp"};
  }

  RosDefinition& definition_;
  Sections sections_;
  size_t nodes_ = 0;
};

RosDefinition::RosDefinition(const std::string& type, std::string_view text) : type_(type) {
  root_ = Parser(*this, text).message(type, "", 0);
}

std::string plain_ros_type(const std::string& type) {
  const size_t middle = type.find("/msg/");
  return middle == std::string::npos ? type : type.substr(0, middle) + type.substr(middle + 4);
}

int RosDefinition::find(const std::string& path) const {
  const auto found = std::find_if(fields_.begin(), fields_.end(),
                                  [&](const Field& field) { return field.path == path; });
  return found == fields_.end() ? -1 : static_cast<int>(found - fields_.begin());
}

RosDefinition::Values RosDefinition::read(std::string_view bytes, RosForm form,
                                          const std::string& name) const {
  Values values;
  values.numbers.resize(fields_.size()), values.texts.resize(fields_.size());
  RosMessage message(bytes, form, name);
  read_one(root_, message, values);
  return values;
}

void RosDefinition::read_node(const Node& node, RosMessage& message, Values& values) const {
  uint32_t count = 1;
  if (node.list == List::counted) count = message.count(1);
  if (node.list == List::fixed) count = node.count;
  values.elements += count;
  if (values.elements > kMostElements)
    throw InputError(
        fmt::format("{}: a message of more than {} elements: damaged", type_, kMostElements));
  for (uint32_t i = 0; i < count; ++i) read_one(node, message, values);
}

void RosDefinition::read_one(const Node& node, RosMessage& message, Values& values) const {
  if (node.kind == Kind::message) {
    // ROS 2 gives an empty message a byte.
    if (node.members.empty() && message.form() == RosForm::cdr) message.byte();
    for (const Node& member : node.members) read_node(member, message, values);
    return;
  }
  if (node.kind == Kind::text) return values.texts[node.field].push_back(message.text());
  std::vector<double>& numbers = values.numbers[node.field];
  if (node.kind == Kind::time) {
    const int64_t ns = message.time_ns();
    if (node.is_stamp) values.stamp_ns = ns;
    return numbers.push_back(1e-9 * static_cast<double>(ns));
  }
  const uint64_t bits = message.word(node.bytes);
  if (node.kind == Kind::real) {
    numbers.push_back(node.bytes == 8 ? std::bit_cast<double>(bits)
                                      : std::bit_cast<float>(static_cast<uint32_t>(bits)));
  } else if (node.kind == Kind::whole) {
    const int unused = 64 - 8 * static_cast<int>(node.bytes);
    numbers.push_back(static_cast<double>(static_cast<int64_t>(bits << unused) >> unused));
  } else {
    numbers.push_back(static_cast<double>(bits));
  }
}

}  // namespace seam::app
