#include "open_r/programs/makefile.h"

#include <sstream>

namespace seam::open_r {
namespace {

// A variable that names itself never ends.
constexpr int kDeepest = 20;

std::string trimmed(std::string_view text) {
  const size_t begin = text.find_first_not_of(" \t\r");
  if (begin == std::string_view::npos) return "";
  return std::string(text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1));
}

std::string expanded(const std::map<std::string, std::string>& variables, std::string_view text,
                     int depth) {
  std::string result;
  for (size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '$' || i + 1 == text.size()) {
      result += text[i];
      continue;
    }
    const char open = text[++i];
    if (open != '(' && open != '{') {
      result += "$" + std::string(1, open);  // $@, $<, $^: the caller's.
      continue;
    }
    const size_t close = text.find(open == '(' ? ')' : '}', i);
    if (close == std::string_view::npos) return result;
    const std::string name(text.substr(i + 1, close - i - 1));
    i = close;
    const auto found = variables.find(name);
    if (found != variables.end() && depth < kDeepest)
      result += expanded(variables, found->second, depth + 1);
  }
  return result;
}

}  // namespace

std::vector<std::string> words_of(std::string_view text) {
  std::istringstream stream{std::string(text)};
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

std::string Makefile::expand(std::string_view text) const {
  return expanded(variables_, text, 0);
}

Makefile Makefile::read(std::string_view text, std::map<std::string, std::string> given) {
  Makefile result;
  result.given_ = std::move(given);
  result.variables_ = result.given_;
  std::istringstream stream{std::string(text)};
  std::string whole;
  for (std::string line; std::getline(stream, line);) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (!line.empty() && line.back() == '\\') {
      whole += line.substr(0, line.size() - 1) + " ";
      continue;
    }
    result.take(whole + line);
    whole.clear();
  }
  if (!whole.empty()) result.take(whole);
  return result;
}

void Makefile::take(const std::string& line) {
  if (line.starts_with('\t')) {
    if (!rules_.empty()) rules_.back().commands.push_back(trimmed(line));
    return;
  }
  const std::string text = trimmed(line.substr(0, line.find('#')));
  const size_t equals = text.find('='), colon = text.find(':');
  if (equals != std::string::npos && (colon == std::string::npos || equals <= colon + 1)) {
    size_t end = equals;
    const char kind = end > 0 ? text[end - 1] : ' ';
    if (kind == '?' || kind == '+' || kind == ':') --end;
    const std::string name = trimmed(text.substr(0, end)), value = trimmed(text.substr(equals + 1));
    if (kind == '+')
      variables_[name] += " " + value;
    else if (kind != '?' || !given_.contains(name))
      variables_[name] = value;
    return;
  }
  if (colon == std::string::npos) return;
  rules_.push_back(
      {words_of(expand(text.substr(0, colon))), words_of(expand(text.substr(colon + 1))), {}});
}

}  // namespace seam::open_r
