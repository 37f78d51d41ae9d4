#include "open_r/programs/makefile.h"

#include <algorithm>
#include <optional>
#include <sstream>

#include "open_r/files/fault.h"

namespace seam::open_r {
namespace {

constexpr int kDeepest = 200;
constexpr size_t kMostBytes = size_t{4} << 20;  // That a Makefile's variables may become.

std::string trimmed(std::string_view text) {
  const size_t begin = text.find_first_not_of(" \t\r");
  if (begin == std::string_view::npos) return "";
  return std::string(text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1));
}

// "%.cc": a word that fits, and what % stands for.
std::optional<std::string> stem_in(std::string_view pattern, std::string_view word) {
  const size_t any = pattern.find('%');
  if (any == std::string_view::npos)
    return pattern == word ? std::optional<std::string>("") : std::nullopt;
  const std::string_view before = pattern.substr(0, any), after = pattern.substr(any + 1);
  if (word.size() < before.size() + after.size() || !word.starts_with(before) ||
      !word.ends_with(after))
    return std::nullopt;
  return std::string(word.substr(before.size(), word.size() - before.size() - after.size()));
}

// Where the bracket that opens at `at` is closed.
size_t closing(std::string_view text, size_t at) {
  const char open = text[at], close = open == '(' ? ')' : '}';
  for (int depth = 0; at < text.size(); ++at) {
    if (text[at] == open) ++depth;
    if (text[at] == close && --depth == 0) return at;
  }
  return std::string_view::npos;
}

class Expansion {
 public:
  Expansion(const std::string& file, const std::map<std::string, std::string>& variables,
            const std::map<std::string, std::string>& places, size_t& spent)
      : file_(file), variables_(variables), places_(places), spent_(spent) {}

  std::string of(std::string_view text) {
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
      const size_t close = closing(text, i);
      if (close == std::string_view::npos) break;
      if (++depth_ > kDeepest) fail("variables within variables, deeper than can be read");
      const std::string value = value_of(text.substr(i + 1, close - i - 1));
      --depth_;
      spend(value.size() + 1);
      result += value;
      i = close;
    }
    return result;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    const auto place = active_.empty() ? places_.end() : places_.find(active_.back());
    throw Fault((place == places_.end() ? file_ : place->second) + ": " + what);
  }

  void spend(size_t bytes) {
    spent_ += bytes;
    if (spent_ > kMostBytes)
      fail("variables grow to more than " + std::to_string(kMostBytes) + " bytes");
  }

  // Each word that fits `from` becomes `to`; the others stay.
  std::string replaced(std::string_view from, const std::string& to, std::string_view text) {
    std::string result;
    for (const std::string& word : words_of(text)) {
      const std::optional<std::string> stem = stem_in(from, word);
      std::string made = stem ? to : word;
      if (const size_t any = made.find('%'); stem && any != std::string::npos)
        made.replace(any, 1, *stem);
      spend(made.size());
      result += (result.empty() ? "" : " ") + made;
    }
    return result;
  }

  // What `$(...)` stands for: a variable, one whose words end otherwise, `$(SRCS:.cc=.o)`, or one
  // of the functions by which Makefiles name the objects of sources. Another function stands for
  // nothing.
  std::string value_of(std::string_view inner) {
    const size_t blank = inner.find(' ');
    if (blank != std::string_view::npos)
      return function_of(inner.substr(0, blank), inner.substr(blank + 1));
    const size_t colon = inner.find(':'), equals = inner.find('=', colon);
    const auto found = variables_.find(std::string(inner.substr(0, colon)));
    if (found == variables_.end()) return "";
    const bool is_open = std::find(active_.begin(), active_.end(), found->first) != active_.end();
    active_.push_back(found->first);
    if (is_open) fail("the variable " + found->first + " names itself, expected := or +=");
    const std::string value = of(found->second);
    active_.pop_back();
    if (colon == std::string_view::npos || equals == std::string_view::npos) return value;
    std::string from(inner.substr(colon + 1, equals - colon - 1)), to(inner.substr(equals + 1));
    if (from.find('%') == std::string::npos) {
      from = "%" + from;
      to = "%" + to;
    }
    return replaced(from, to, value);
  }

  std::string function_of(std::string_view function, std::string_view rest) {
    const size_t first = rest.find(','), second = rest.find(',', first + 1);
    if (first == std::string_view::npos) return "";
    const auto whole = [&](std::string_view part) { return of(trimmed(part)); };
    const std::string from = whole(rest.substr(0, first));
    if (function == "filter") {
      std::string kept;
      for (const std::string& word : words_of(whole(rest.substr(first + 1))))
        if (stem_in(from, word)) kept += word + " ";
      return kept;
    }
    if (function != "patsubst" || second == std::string_view::npos) return "";
    return replaced(from, whole(rest.substr(first + 1, second - first - 1)),
                    whole(rest.substr(second + 1)));
  }

  const std::string& file_;
  const std::map<std::string, std::string>&variables_, &places_;
  size_t& spent_;
  std::vector<std::string> active_;  // The variables within which this is.
  int depth_ = 0;
};

}  // namespace

std::vector<std::string> words_of(std::string_view text) {
  std::istringstream stream{std::string(text)};
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

std::string Makefile::expand(std::string_view text) const {
  return Expansion(file_, variables_, places_, spent_).of(text);
}

Makefile Makefile::read(std::string file, std::string_view text,
                        std::map<std::string, std::string> given) {
  Makefile result;
  result.file_ = std::move(file);
  result.given_ = std::move(given);
  result.variables_ = result.given_;
  std::istringstream stream{std::string(text)};
  std::string whole;
  for (std::string line; std::getline(stream, line);) {
    ++result.line_;
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
    if (kind == '?' && given_.contains(name)) return;
    // `:=` stands for what the text is now, so that it may name the variable itself.
    if (kind == ':') expanded_.insert(name);
    if (kind != ':' && kind != '+') expanded_.erase(name);
    const std::string now = expanded_.contains(name) ? expand(value) : value;
    if (kind == '+')
      variables_[name] += " " + now;
    else
      variables_[name] = now;
    places_[name] = file_ + ":" + std::to_string(line_);
    return;
  }
  if (colon == std::string::npos) return;
  rules_.push_back(
      {words_of(expand(text.substr(0, colon))), words_of(expand(text.substr(colon + 1))), {}});
}

}  // namespace seam::open_r
