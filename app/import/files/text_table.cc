#include "app/import/files/text_table.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <limits>

#include "app/import/files/source_file.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

constexpr size_t kMaxColumns = 1000;
__extension__ using Wide = __int128;  // Holds a product of any two 64-bit numbers.

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r";
  const size_t first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

std::string_view unquoted(std::string_view text) {
  const bool quoted = text.size() >= 2 && text.front() == '"' && text.back() == '"';
  return quoted ? text.substr(1, text.size() - 2) : text;
}

std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

// The words of a line; blanks separate by any number of them.
std::vector<std::string_view> words_of(std::string_view line, char separator) {
  std::vector<std::string_view> words;
  if (separator != ' ') {
    for (size_t start = 0; start <= line.size() && words.size() <= kMaxColumns;) {
      const size_t end = std::min(line.find(separator, start), line.size());
      words.push_back(unquoted(trimmed(line.substr(start, end - start))));
      start = end + 1;
    }
    return words;
  }
  constexpr std::string_view kBlank = " \t\r";
  for (size_t start = line.find_first_not_of(kBlank);
       start != std::string_view::npos && words.size() <= kMaxColumns;) {
    const size_t end = std::min(line.find_first_of(kBlank, start), line.size());
    words.push_back(unquoted(line.substr(start, end - start)));
    start = line.find_first_not_of(kBlank, end);
  }
  return words;
}

char separator_of(std::string_view line) {
  for (const char c : {',', ';', '\t'}) {
    if (line.find(c) != std::string_view::npos) return c;
  }
  return ' ';
}

bool is_header(const std::vector<std::string_view>& words) {
  double value = 0;
  return std::none_of(words.begin(), words.end(),
                      [&](std::string_view word) { return parse_number(word, value); }) &&
         std::any_of(words.begin(), words.end(), [](std::string_view word) {
           return !word.empty() && word != "-" && lower(word) != "nan";
         });
}

}  // namespace

bool parse_number(std::string_view text, double& value) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() && std::isfinite(value);
}

bool parse_time_ns(std::string_view text, int64_t unit_ns, int64_t& ns) {
  constexpr int64_t kMost = std::numeric_limits<int64_t>::max();
  bool plain = !text.empty();
  const bool negative = plain && text.front() == '-';
  std::string_view digits = text;
  if (plain && (text.front() == '-' || text.front() == '+')) digits.remove_prefix(1);
  const size_t dot = std::min(digits.find('.'), digits.size());
  Wide whole = 0, fraction = 0, below = 1;
  for (size_t i = 0; i < digits.size() && plain; ++i) {
    if (i == dot) continue;
    plain = digits[i] >= '0' && digits[i] <= '9';
    const int digit = digits[i] - '0';
    if (i < dot) {
      whole = whole * 10 + digit;
      plain = plain && whole <= kMost;
    } else if (below < 1'000'000'000'000'000) {
      fraction = fraction * 10 + digit, below *= 10;
    }
  }
  if (plain && digits.size() > (dot < digits.size() ? 1u : 0u)) {
    const Wide all = whole * unit_ns + (2 * fraction * unit_ns + below) / (2 * below);
    if (all > kMost) return false;
    ns = static_cast<int64_t>(negative ? -all : all);
    return true;
  }
  double value = 0;
  if (!parse_number(text, value)) return false;
  value *= static_cast<double>(unit_ns);
  if (!(std::abs(value) < 9.2e18)) return false;
  ns = std::llround(value);
  return true;
}

TextTable TextTable::read(const std::filesystem::path& path) {
  return from_text(read_source(path), path.string());
}

TextTable TextTable::from_text(std::string text, const std::string& name) {
  TextTable table;
  table.file_ = name;
  table.text_ = std::make_unique<const std::string>(std::move(text));
  const std::string_view all = *table.text_;
  if (all.find('\0') != std::string_view::npos)
    throw InputError(fmt::format("{}: found binary data, expected a table as text", name));
  size_t position = all.starts_with("\xEF\xBB\xBF") ? 3 : 0;
  char separator = 0;
  std::string_view comment;
  for (int number = 1; position < all.size(); ++number) {
    const size_t end = std::min(all.find('\n', position), all.size());
    const std::string_view line = trimmed(all.substr(position, end - position));
    position = end + 1;
    if (line.empty()) continue;
    if (line.front() == '#' || line.front() == '%') {
      comment = line.substr(line.find_first_not_of("#% ") == std::string_view::npos
                                ? line.size()
                                : line.find_first_not_of("#% "));
      continue;
    }
    const bool first = separator == 0;
    if (first) separator = separator_of(line);
    const auto words = words_of(line, separator);
    if (words.size() > kMaxColumns)
      throw InputError(fmt::format("{}:{}: more than {} columns", name, number, kMaxColumns));
    if (first) {
      table.width_ = words.size();
      if (is_header(words)) {
        table.take_header({words.begin(), words.end()});
        continue;
      }
      const auto named = words_of(comment, separator_of(comment));
      if (named.size() == words.size() && is_header(named))
        table.take_header({named.begin(), named.end()});
    }
    // A separator at the end of each row makes no column.
    const size_t count =
        words.size() == table.width_ + 1 && words.back().empty() ? table.width_ : words.size();
    if (count != table.width_)
      throw InputError(
          fmt::format("{}:{}: found {} cells, expected {}", name, number, count, table.width_));
    table.cells_.insert(table.cells_.end(), words.begin(),
                        words.begin() + static_cast<std::ptrdiff_t>(count));
    table.lines_.push_back(number);
  }
  if (table.rows() == 0) throw InputError(fmt::format("{}: found no rows of data", name));
  return table;
}

void TextTable::take_header(const std::vector<std::string>& words) {
  columns_ = words;
  // "p_RS_R_x [m]": the unit stands beside the name.
  for (std::string& name : columns_) {
    const size_t bracket = name.find(" [");
    if (bracket != std::string::npos && name.back() == ']') name.resize(bracket);
  }
}

int TextTable::find(const std::vector<std::string>& names) const {
  for (const std::string& name : names) {
    for (size_t i = 0; i < columns_.size(); ++i) {
      if (lower(columns_[i]) == lower(name)) return static_cast<int>(i);
    }
  }
  return -1;
}

std::string_view TextTable::cell(size_t row, size_t column) const {
  return cells_[row * width_ + column];
}

double TextTable::number(size_t row, size_t column) const {
  double value = 0;
  if (!parse_number(cell(row, column), value)) fail(row, column, "a finite number");
  return value;
}

double TextTable::number_or_blank(size_t row, size_t column) const {
  const std::string_view text = cell(row, column);
  if (text.empty() || text == "-" || lower(text) == "nan")
    return std::numeric_limits<double>::quiet_NaN();
  return number(row, column);
}

int64_t TextTable::time_ns(size_t row, size_t column, int64_t unit_ns) const {
  int64_t ns = 0;
  if (!parse_time_ns(cell(row, column), unit_ns, ns)) fail(row, column, "a time");
  return ns;
}

std::string TextTable::column_name(size_t column) const {
  return column < columns_.size() ? columns_[column] : fmt::format("{}", column + 1);
}

void TextTable::fail(size_t row, size_t column, std::string_view expected) const {
  throw InputError(fmt::format("{}:{}: column {}: found '{}', expected {}", file_, line(row),
                               column_name(column), cell(row, column), expected));
}

}  // namespace seam::app
