#include "app/import/files/text_table.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <chrono>
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

// A name with underscores for blanks, without a unit at its end.
std::string without_unit(const std::string& name) {
  std::string text = lower(name);
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == ' ' || c == '-'; }, '_');
  const size_t last = text.rfind('_');
  if (last == std::string::npos || last == 0) return text;
  const std::string end = text.substr(last + 1);
  for (const char* unit : {"s", "ms", "us", "ns", "m", "cm", "mm", "um", "deg", "rad", "px"}) {
    if (end == unit) return text.substr(0, last);
  }
  return text;
}

// Where a cell ends that begins here; what stands in quotes may hold separators.
size_t end_of_cell(std::string_view line, size_t start, char separator) {
  const size_t first = line.find_first_not_of(" \t", start);
  if (first != std::string_view::npos && line[first] == '"') {
    size_t quote = line.find('"', first + 1);
    while (quote != std::string_view::npos && quote + 1 < line.size() && line[quote + 1] == '"')
      quote = line.find('"', quote + 2);
    if (quote != std::string_view::npos) start = quote + 1;
  }
  return std::min(line.find(separator, start), line.size());
}

// The words of a line; blanks separate by any number of them.
std::vector<std::string_view> words_of(std::string_view line, char separator) {
  std::vector<std::string_view> words;
  if (separator != ' ') {
    for (size_t start = 0; start <= line.size() && words.size() <= kMaxColumns;) {
      const size_t end = end_of_cell(line, start, separator);
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
  for (const char c : {';', '\t', ','}) {
    if (line.find(c) != std::string_view::npos) return c;
  }
  return ' ';
}

bool is_digit(char c) {
  return std::isdigit(static_cast<unsigned char>(c)) != 0;
}

// Programs of some countries write 0,5 for a half, with semicolons or tabulators between cells.
void put_decimal_points(std::string& text) {
  const size_t line = text.find_first_not_of("\r\n");
  if (line == std::string::npos) return;
  const char separator = separator_of(std::string_view(text).substr(line, text.find('\n', line)));
  if (separator != ';' && separator != '\t') return;
  const auto between_digits = [&](size_t at) {
    return at > 0 && at + 1 < text.size() && is_digit(text[at - 1]) && is_digit(text[at + 1]);
  };
  for (size_t at = text.find('.'); at != std::string::npos; at = text.find('.', at + 1)) {
    if (between_digits(at)) return;
  }
  for (size_t at = text.find(','); at != std::string::npos; at = text.find(',', at + 1)) {
    if (between_digits(at)) text[at] = '.';
  }
}

// Digits at `at` and behind them `after`; moves on behind both.
bool take_number(std::string_view text, size_t& at, size_t digits, char after, int& value) {
  if (at + digits > text.size()) return false;
  value = 0;
  for (const char c : text.substr(at, digits)) {
    if (!is_digit(c)) return false;
    value = value * 10 + (c - '0');
  }
  at += digits;
  if (after == 0) return true;
  return at < text.size() && text[at++] == after;
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
  double parsed = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), parsed);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(parsed))
    return false;
  value = parsed;
  return true;
}

bool parse_date_ns(std::string_view text, int64_t& ns) {
  namespace time = std::chrono;
  size_t at = 0;
  int year = 1970, month = 1, day = 1, hour = 0, minute = 0, second = 0, zone_min = 0;
  if (text.size() > 10 && text[4] == '-') {
    if (!take_number(text, at, 4, '-', year) || !take_number(text, at, 2, '-', month) ||
        !take_number(text, at, 2, 0, day) || (text[at] != 'T' && text[at] != ' '))
      return false;
    ++at;
  }
  if (!take_number(text, at, 2, ':', hour) || !take_number(text, at, 2, ':', minute) ||
      !take_number(text, at, 2, 0, second))
    return false;
  int64_t fraction_ns = 0;
  if (at < text.size() && (text[at] == '.' || text[at] == ',')) {
    int64_t unit = 100'000'000;
    for (++at; at < text.size() && is_digit(text[at]); ++at, unit /= 10)
      fraction_ns += unit * (text[at] - '0');
  }
  if (at < text.size() && (text[at] == '+' || text[at] == '-')) {
    const int sign = text[at++] == '+' ? 1 : -1;
    int hours = 0, minutes = 0;
    if (!take_number(text, at, 2, 0, hours)) return false;
    if (at < text.size() && text[at] == ':') ++at;
    if (at < text.size() && !take_number(text, at, 2, 0, minutes)) return false;
    zone_min = sign * (60 * hours + minutes);
  } else if (at < text.size() && text[at] == 'Z') {
    ++at;
  }
  const time::year_month_day date{time::year(year), time::month(static_cast<unsigned>(month)),
                                  time::day(static_cast<unsigned>(day))};
  const bool holds = at == text.size() && date.ok() && year >= 1900 && year < 2200 && hour < 24 &&
                     minute < 60 && second <= 60;
  if (!holds) return false;
  const int64_t days = time::sys_days(date).time_since_epoch().count();
  ns =
      ((days * 24 + hour) * 3600 + 60 * (minute - zone_min) + second) * 1'000'000'000 + fraction_ns;
  return true;
}

bool parse_time_ns(std::string_view text, int64_t unit_ns, int64_t& ns) {
  if (text.find(':') != std::string_view::npos) return parse_date_ns(text, ns);
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
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF"))
    throw InputError(fmt::format("{}: found text as UTF-16, expected UTF-8: save it so", name));
  put_decimal_points(text);
  table.text_ = std::make_unique<const std::string>(std::move(text));
  const std::string_view all = *table.text_;
  if (all.find('\0') != std::string_view::npos)
    throw InputError(fmt::format("{}: found binary data, expected a table as text", name));
  size_t position = all.starts_with("\xEF\xBB\xBF") ? 3 : 0;
  char separator = 0;
  std::string_view comment;
  int comment_line = 0;
  for (int number = 1; position < all.size(); ++number) {
    const size_t end = std::min(all.find('\n', position), all.size());
    const std::string_view line = trimmed(all.substr(position, end - position));
    position = end + 1;
    if (line.empty()) continue;
    if (line.front() == '#' || line.front() == '%') {
      comment_line = number;
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
        table.take_header({words.begin(), words.end()}, number);
        continue;
      }
      const auto named = words_of(comment, separator_of(comment));
      if (named.size() == words.size() && is_header(named))
        table.take_header({named.begin(), named.end()}, comment_line);
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

void TextTable::take_header(const std::vector<std::string>& words, int line) {
  header_line_ = line;
  columns_ = full_names_ = words;
  for (size_t i = 0; i < columns_.size(); ++i) {
    std::string& name = columns_[i];
    // "p_RS_R_x [m]", "angle (deg)": the unit stands beside the name.
    for (const auto& [open, close] : {std::pair{'[', ']'}, {'(', ')'}}) {
      const size_t bracket = name.find(open);
      if (bracket == std::string::npos || bracket == 0 || name.back() != close) continue;
      name.resize(name.find_last_not_of(" \t", bracket - 1) + 1);
    }
    // The rows' numbers, as tables of statisticians have them.
    if (name.empty()) name = full_names_[i] = fmt::format("column{}", i + 1);
  }
}

std::string TextTable::full_name(size_t column) const {
  return column < full_names_.size() ? full_names_[column] : "";
}

int TextTable::find(const std::vector<std::string>& names) const {
  for (const bool as_it_stands : {true, false}) {
    for (const std::string& name : names) {
      const auto is_it = [&](const std::string& column) {
        return (as_it_stands ? lower(column) : without_unit(column)) == lower(name);
      };
      const auto found = std::find_if(columns_.begin(), columns_.end(), is_it);
      if (found == columns_.end()) continue;
      if (std::find(found + 1, columns_.end(), *found) != columns_.end())
        throw InputError(
            fmt::format("{}:{}: column '{}' stands twice", file_, header_line_, *found));
      return static_cast<int>(found - columns_.begin());
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
  if (!parse_time_ns(cell(row, column), unit_ns, ns))
    fail(row, column, "a time (in another unit? --time-unit)");
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
