#include "app/import/files/storage.h"

#include <tinyxml2.h>

#include <charconv>
#include <cmath>
#include <limits>

#include "app/import/files/source_file.h"
#include "app/import/files/text_table.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

constexpr size_t kMaxBytes = size_t{16} << 20;

std::vector<std::string> words_of(const std::string& text) {
  std::vector<std::string> words;
  for (size_t start = text.find_first_not_of(" \t\r\n"); start != std::string::npos;) {
    const size_t end = std::min(text.find_first_of(" \t\r\n", start), text.size());
    words.push_back(text.substr(start, end - start));
    start = text.find_first_not_of(" \t\r\n", end);
  }
  return words;
}

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c == '\n' || c == '\t' || c == '\r' ? ' ' : c;
  }
  return out + '"';
}

// XML as YAML in flow style whose lines are those of the XML.
class XmlAsYaml {
 public:
  std::string take(const tinyxml2::XMLElement& root) {
    write(root);
    return std::move(yaml_);
  }

 private:
  void go_to(int line) {
    while (line_ < line) yaml_ += '\n', ++line_;
  }

  void write(const tinyxml2::XMLElement& element) {
    go_to(element.GetLineNum());
    const auto* first = element.FirstChildElement();
    if (first == nullptr) return write_text(element.GetText());
    const bool list = std::string_view(first->Name()) == "_";
    yaml_ += list ? "[" : "{";
    for (const auto* child = first; child != nullptr; child = child->NextSiblingElement()) {
      go_to(child->GetLineNum());
      if (child != first) yaml_ += ", ";
      if (!list) yaml_ += quoted(child->Name()) + ": ";
      write(*child);
    }
    yaml_ += list ? "]" : "}";
  }

  void write_text(const char* text) {
    const auto words = words_of(text == nullptr ? "" : text);
    double value = 0;
    const bool numbers = !words.empty() && std::all_of(words.begin(), words.end(), [&](auto& word) {
      return parse_number(word, value) || word == ".Nan" || word == "nan" || word == "-nan";
    });
    if (!numbers) {
      yaml_ += quoted(text == nullptr ? "" : text);
    } else if (words.size() == 1) {
      yaml_ += words[0];
    } else {
      yaml_ += "[";
      for (size_t i = 0; i < words.size(); ++i) yaml_ += (i > 0 ? ", " : "") + words[i];
      yaml_ += "]";
    }
  }

  std::string yaml_;
  int line_ = 1;
};

void collect(const ConfigNode& node, bool holes, std::vector<double>& numbers) {
  if (node.is_map()) {
    if (!node.has("data")) node.fail("expected numbers");
    return collect(node.at("data"), holes, numbers);
  }
  if (!node.is_scalar()) {
    for (const ConfigNode& item : node.items()) collect(item, holes, numbers);
    return;
  }
  const std::string text = node.text();
  double value = 0;
  if (parse_number(text, value)) {
    numbers.push_back(value);
  } else if (holes && (text == ".Nan" || text == ".nan" || text == "nan" || text == "-nan")) {
    numbers.push_back(std::numeric_limits<double>::quiet_NaN());
  } else {
    node.fail(fmt::format("found '{}', expected a finite number", text));
  }
}

}  // namespace

ConfigNode read_storage(const std::filesystem::path& path) {
  return storage_of_text(read_source(path, kMaxBytes), path.string());
}

ConfigNode storage_of_text(const std::string& text, const std::string& name) {
  const size_t first = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  if (first != std::string::npos && text[first] == '<') {
    tinyxml2::XMLDocument document;
    if (document.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS)
      throw InputError(fmt::format("{}:{}: found no well-formed XML: damaged or cut", name,
                                   document.ErrorLineNum()));
    const tinyxml2::XMLElement* root = document.RootElement();
    if (root == nullptr || std::string_view(root->Name()) != "opencv_storage")
      throw InputError(fmt::format("{}: expected <opencv_storage>", name));
    return ConfigNode::from_text(XmlAsYaml().take(*root), name);
  }
  // "%YAML:1.0" is OpenCV's own; YAML has a blank there.
  std::string yaml = text;
  if (first != std::string::npos && text.compare(first, 6, "%YAML:") == 0) yaml[first] = '#';
  return ConfigNode::from_text(yaml, name);
}

std::vector<double> numbers_in(const ConfigNode& node, bool holes) {
  std::vector<double> numbers;
  collect(node, holes, numbers);
  return numbers;
}

bool is_matrix(const ConfigNode& node) {
  return node.is_map() && node.has("rows") && node.has("cols") && node.has("data");
}

int matrix_rows(const ConfigNode& node) {
  const int64_t rows = node.at("rows").integer(0, 100'000'000);
  const int64_t columns = node.at("cols").integer(0, 100'000'000);
  const auto count = static_cast<int64_t>(numbers_in(node, true).size());
  if (rows * columns == 0 ? count != 0 : count % (rows * columns) != 0)
    node.fail(
        fmt::format("found {} numbers, expected those of {} x {}: cut?", count, rows, columns));
  return static_cast<int>(rows);
}

}  // namespace seam::app
