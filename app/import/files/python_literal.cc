#include "app/import/files/python_literal.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/import/files/text_table.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

using nlohmann::json;

constexpr int kMaxDepth = 32;

class Literal {
 public:
  Literal(const std::string& text, const std::string& name) : text_(text), name_(name) {}

  json whole() {
    json value = read(0);
    skip();
    if (at_ < text_.size()) fail("expected the end");
    return value;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    const auto end = text_.begin() + static_cast<std::ptrdiff_t>(std::min(at_, text_.size()));
    throw InputError(fmt::format("{}:{}: {}, found {}", name_,
                                 1 + std::count(text_.begin(), end, '\n'), what,
                                 at_ < text_.size() ? fmt::format("'{}'", text_.substr(at_, 12))
                                                    : "the end of the file: cut?"));
  }

  void skip() {
    while (at_ < text_.size()) {
      if (text_[at_] == '#') {
        at_ = std::min(text_.find('\n', at_), text_.size());
      } else if (std::string_view(" \t\r\n\\").find(text_[at_]) != std::string_view::npos) {
        ++at_;
      } else {
        return;
      }
    }
  }

  bool take(char c) {
    skip();
    if (at_ >= text_.size() || text_[at_] != c) return false;
    ++at_;
    return true;
  }

  json list(char end, int depth) {
    json values = json::array();
    while (!take(end)) {
      values.push_back(read(depth + 1));
      if (take(end)) break;
      if (!take(',')) fail(fmt::format("expected ',' or '{}'", end));
    }
    return values;
  }

  json dictionary(int depth) {
    json values = json::object();
    while (!take('}')) {
      const json key = read(depth + 1);
      if (!key.is_string()) fail("expected a text for a key before this");
      if (!take(':')) fail("expected ':'");
      values[key.get<std::string>()] = read(depth + 1);
      if (take('}')) break;
      if (!take(',')) fail("expected ',' or '}'");
    }
    return values;
  }

  bool at_text() {
    skip();
    if (at_ >= text_.size()) return false;
    if (text_[at_] == '\'' || text_[at_] == '"') return true;
    const bool prefixed = std::string_view("bru").find(text_[at_]) != std::string_view::npos;
    if (!prefixed || at_ + 1 >= text_.size()) return false;
    return text_[at_ + 1] == '\'' || text_[at_ + 1] == '"';
  }

  // Texts beside each other are one.
  std::string text() {
    std::string out;
    while (at_text()) {
      if (text_[at_] != '\'' && text_[at_] != '"') ++at_;
      const char quote = text_[at_++];
      for (;; ++at_) {
        if (at_ >= text_.size() || text_[at_] == '\n') fail("expected the end of a text");
        if (text_[at_] == quote) break;
        if (text_[at_] == '\\' && at_ + 1 < text_.size()) {
          const char c = text_[++at_];
          out += c == 'n' ? '\n' : c == 't' ? '\t' : c;
        } else {
          out += text_[at_];
        }
      }
      ++at_;
    }
    return out;
  }

  json read(int depth) {
    if (depth > kMaxDepth) fail("nested too deep");
    if (take('{')) return dictionary(depth);
    if (take('[')) return list(']', depth);
    if (take('(')) return list(')', depth);
    if (at_text()) return text();
    skip();
    const size_t end = std::min(text_.find_first_of(" \t\r\n,:]})#", at_), text_.size());
    const std::string word = text_.substr(at_, end - at_);
    double value = 0;
    json found;
    if (word == "True" || word == "False") {
      found = word == "True";
    } else if (parse_number(word, value)) {
      found = value;
    } else if (word != "None") {
      fail("expected a value");
    }
    at_ = end;
    return found;
  }

  const std::string& text_;
  const std::string& name_;
  size_t at_ = 0;
};

}  // namespace

nlohmann::json python_literal(const std::string& text, const std::string& name) {
  return Literal(text, name).whole();
}

}  // namespace seam::app
