#include "open_r/files/stub_settings.h"

#include <algorithm>
#include <cctype>
#include <sstream>

#include "open_r/files/fault.h"

namespace seam::open_r {
namespace {

std::string trimmed(std::string_view text) {
  const size_t begin = text.find_first_not_of(" \t\r");
  if (begin == std::string_view::npos) return "";
  return std::string(text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1));
}

bool is_name(std::string_view text) {
  return !text.empty() && std::isdigit(static_cast<unsigned char>(text[0])) == 0 &&
         std::all_of(text.begin(), text.end(),
                     [](unsigned char c) { return std::isalnum(c) != 0 || c == '_'; });
}

class Reader {
 public:
  Reader(std::string_view file, std::string_view text) : file_(file), text_(text) {}

  StubSettings read() {
    std::istringstream stream{std::string(text_)};
    for (std::string line; std::getline(stream, line);) {
      ++line_;
      line = trimmed(line.substr(0, std::min(line.find("//"), line.find('#'))));
      if (!line.empty()) take(line);
    }
    line_ = 0;
    if (settings_.object.empty()) fail("no 'ObjectName : NAME'", "one");
    check("NumOfOSubject", subjects_, settings_.subjects.size());
    check("NumOfOObserver", observers_, settings_.observers.size());
    return settings_;
  }

 private:
  [[noreturn]] void fail(const std::string& found, const std::string& expected) const {
    throw Fault(file_ + (line_ > 0 ? ":" + std::to_string(line_) : "") + ": found " + found +
                ", expected " + expected);
  }

  void take(const std::string& line) {
    const size_t colon = line.find(':');
    const std::string key = trimmed(line.substr(0, colon));
    const std::string value = colon == std::string::npos ? "" : trimmed(line.substr(colon + 1));
    if (key == "ObjectName") {
      if (!is_name(value)) fail("'" + value + "'", "the name of a class");
      settings_.object = value;
    } else if (key == "NumOfOSubject") {
      subjects_ = count(value);
    } else if (key == "NumOfOObserver") {
      observers_ = count(value);
    } else if (key == "Service") {
      take_service(value);
    } else if (key == "Extra") {
      settings_.extras.push_back(function(value));
    } else {
      fail("'" + key + "'", "ObjectName, NumOfOSubject, NumOfOObserver, Service or Extra");
    }
  }

  int count(const std::string& text) const {
    if (text.empty() || text.size() > 4 ||
        !std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isdigit(c); }))
      fail("'" + text + "'", "a number");
    return std::stoi(text);
  }

  // "Ready()", or "null" for none.
  std::string function(const std::string& text) const {
    if (text == "null") return "";
    const size_t end = text.find('(');
    const std::string name = trimmed(text.substr(0, end));
    if (end == std::string::npos || trimmed(text.substr(end)) != "()" || !is_name(name))
      fail("'" + text + "'", "a function such as Ready(), or null");
    return name;
  }

  void take_service(const std::string& text) {
    const size_t close = text.find('"', 1);
    if (text.empty() || text[0] != '"' || close == std::string::npos)
      fail("'" + text + "'", "\"Object.Name.Data.S\", a function or null, a function or null");
    StubService service;
    service.name = text.substr(1, close - 1);
    std::vector<std::string> parts, functions;
    std::istringstream name(service.name), rest(text.substr(close + 1));
    for (std::string part; std::getline(name, part, '.');) parts.push_back(part);
    for (std::string part; std::getline(rest, part, ',');) functions.push_back(trimmed(part));
    if (parts.size() != 4 || (parts[3] != "S" && parts[3] != "O") || !is_name(parts[1]))
      fail("'" + service.name + "'", "Object.Name.Data.S of a subject, .O of an observer");
    if (functions.size() != 3 || !functions[0].empty())
      fail("'" + text + "'", "two functions behind the name, each null or such as Ready()");
    service.subname = parts[1];
    service.connection = function(functions[1]);
    service.message = function(functions[2]);
    auto& services = parts[3] == "S" ? settings_.subjects : settings_.observers;
    services.push_back(std::move(service));
  }

  void check(const char* key, int stated, size_t found) const {
    if (stated < 1) fail("no " + std::string(key), "at least 1; a dummy counts");
    if (static_cast<size_t>(stated) != found)
      fail(std::string(key) + " : " + std::to_string(stated),
           std::to_string(found) + ", as many as there are services of it");
  }

  std::string file_, text_;
  int line_ = 0;
  int subjects_ = 0, observers_ = 0;
  StubSettings settings_;
};

}  // namespace

StubSettings read_stub_settings(std::string_view file, std::string_view text) {
  return Reader(file, text).read();
}

}  // namespace seam::open_r
