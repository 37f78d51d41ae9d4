#include "measurement/sets/csv.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "sim_core/base/error.h"
#include "sim_core/base/files.h"
#include "sim_core/base/output.h"

namespace seam::measurement {
namespace {

constexpr uint64_t kMaxBytes = uint64_t{2} << 30;
// A header is looked through once a column, so that their number is bounded.
constexpr size_t kMaxColumns = 1000;

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t' || text.back() == '\r'))
    text.remove_suffix(1);
  if (text.size() >= 2 && text.front() == '"' && text.back() == '"')
    text = text.substr(1, text.size() - 2);
  return text;
}

bool parse_number(std::string_view text, double& value) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() && std::isfinite(value);
}

// Plain decimals exactly, rounded to the nanosecond; false where the text is not one.
bool parse_decimal_ns(std::string_view text, int64_t& ns) {
  bool negative = false;
  if (!text.empty() && (text.front() == '-' || text.front() == '+')) {
    negative = text.front() == '-';
    text.remove_prefix(1);
  }
  if (text.empty()) return false;
  const size_t dot = std::min(text.find('.'), text.size());
  int64_t seconds = 0;
  if (dot > 10) return false;
  for (char c : text.substr(0, dot)) {
    if (c < '0' || c > '9') return false;
    seconds = seconds * 10 + (c - '0');
  }
  if (seconds > 9'000'000'000) return false;
  int64_t fraction = 0;
  int64_t unit = 100'000'000;
  bool round_up = false;
  for (size_t i = dot + 1; i < text.size(); ++i) {
    const char c = text[i];
    if (c < '0' || c > '9') return false;
    if (unit == 0) {
      if (i == dot + 10) round_up = c >= '5';
      continue;
    }
    fraction += (c - '0') * unit;
    unit /= 10;
  }
  ns = seconds * 1'000'000'000 + fraction + (round_up ? 1 : 0);
  if (negative) ns = -ns;
  return true;
}

}  // namespace

CsvTable CsvTable::read(const std::filesystem::path& path) {
  return from_text(read_file(path, kMaxBytes), path.string());
}

CsvTable CsvTable::from_text(std::string text, const std::string& name) {
  CsvTable table;
  table.file_ = name;
  table.text_ = std::move(text);
  const std::string& all = table.text_;
  if (all.size() > std::numeric_limits<uint32_t>::max() - 1)
    throw InputError(name + ": larger than 4 GiB");
  size_t position = all.rfind("\xEF\xBB\xBF", 0) == 0 ? 3 : 0;
  for (int line = 1; position < all.size(); ++line) {
    const size_t end = std::min(all.find('\n', position), all.size());
    const std::string_view row(all.data() + position, end - position);
    if (trimmed(row).empty()) {
      position = end + 1;
      continue;
    }
    std::vector<uint32_t> cells{static_cast<uint32_t>(position)};
    for (size_t i = 0; i < row.size() && cells.size() <= kMaxColumns; ++i) {
      if (row[i] == ',') cells.push_back(static_cast<uint32_t>(position + i + 1));
    }
    if (cells.size() > kMaxColumns)
      throw InputError(fmt::format("{}:{}: more than {} columns", name, line, kMaxColumns));
    cells.push_back(static_cast<uint32_t>(end + 1));
    if (table.columns_.empty()) {
      for (size_t i = 0; i + 1 < cells.size(); ++i) {
        const std::string column(
            trimmed(std::string_view(all).substr(cells[i], cells[i + 1] - cells[i] - 1)));
        if (column.empty())
          throw InputError(fmt::format("{}:{}: column {} has no name", name, line, i + 1));
        if (table.has(column))
          throw InputError(fmt::format("{}:{}: column '{}' stands twice", name, line, column));
        table.columns_.push_back(column);
      }
    } else {
      if (cells.size() != table.columns_.size() + 1) {
        throw InputError(fmt::format("{}:{}: found {} cells, expected {}", name, line,
                                     cells.size() - 1, table.columns_.size()));
      }
      table.starts_.insert(table.starts_.end(), cells.begin(), cells.end());
      table.lines_.push_back(line);
      ++table.rows_;
    }
    position = end + 1;
  }
  if (table.columns_.empty()) throw InputError(name + ": the file is empty, expected a header");
  return table;
}

bool CsvTable::has(std::string_view column) const {
  return std::find(columns_.begin(), columns_.end(), column) != columns_.end();
}

size_t CsvTable::index_of(std::string_view column) const {
  const auto found = std::find(columns_.begin(), columns_.end(), column);
  if (found == columns_.end()) {
    throw InputError(fmt::format("{}:1: column '{}' is missing{}", file_, column,
                                 suggestion_for(column, columns_)));
  }
  return found - columns_.begin();
}

void CsvTable::keep_rows(const std::vector<char>& kept) {
  const size_t stride = columns_.size() + 1;
  size_t to = 0;
  for (size_t row = 0; row < rows_; ++row) {
    if (!kept[row]) continue;
    std::copy_n(starts_.begin() + static_cast<std::ptrdiff_t>(row * stride), stride,
                starts_.begin() + static_cast<std::ptrdiff_t>(to * stride));
    lines_[to++] = lines_[row];
  }
  rows_ = to;
  starts_.resize(to * stride);
  lines_.resize(to);
}

std::string_view CsvTable::at(size_t row, size_t column) const {
  const size_t first = row * (columns_.size() + 1) + column;
  return trimmed(
      std::string_view(text_).substr(starts_[first], starts_[first + 1] - starts_[first] - 1));
}

std::string_view CsvTable::cell(size_t row, std::string_view column) const {
  return at(row, index_of(column));
}

std::vector<double> CsvTable::numbers(std::string_view column) const {
  const size_t index = index_of(column);
  std::vector<double> values(rows_);
  for (size_t row = 0; row < rows_; ++row) {
    if (!parse_number(at(row, index), values[row]))
      fail(row, column, at(row, index), "a finite number");
  }
  return values;
}

std::vector<double> CsvTable::numbers_or_blank(std::string_view column) const {
  const size_t index = index_of(column);
  std::vector<double> values(rows_, std::numeric_limits<double>::quiet_NaN());
  for (size_t row = 0; row < rows_; ++row) {
    const std::string_view text = at(row, index);
    if (!text.empty() && !parse_number(text, values[row]))
      fail(row, column, text, "a finite number or nothing");
  }
  return values;
}

std::vector<std::string> CsvTable::texts(std::string_view column) const {
  const size_t index = index_of(column);
  std::vector<std::string> values(rows_);
  for (size_t row = 0; row < rows_; ++row) values[row] = at(row, index);
  return values;
}

std::vector<int64_t> CsvTable::times_ns(std::string_view column) const {
  const size_t index = index_of(column);
  std::vector<int64_t> values(rows_);
  for (size_t row = 0; row < rows_; ++row) {
    const std::string_view text = at(row, index);
    if (parse_decimal_ns(text, values[row])) continue;
    double seconds = 0;  // Exponents: a double holds what they can say.
    if (!parse_number(text, seconds) || std::abs(seconds) > 9e9)
      fail(row, column, text, "a time in seconds");
    values[row] = std::llround(std::floor(seconds)) * 1'000'000'000 +
                  std::llround((seconds - std::floor(seconds)) * 1e9);
  }
  return values;
}

std::vector<size_t> CsvTable::rows_without_number(size_t column) const {
  std::vector<size_t> rows;
  double value = 0;
  for (size_t row = 0; row < rows_; ++row) {
    if (!parse_number(at(row, column), value)) rows.push_back(row);
  }
  return rows;
}

std::vector<std::string> CsvTable::extra_numeric_columns(
    const std::vector<std::string>& known) const {
  std::vector<std::string> extra;
  for (size_t column = 0; column < columns_.size(); ++column) {
    if (std::find(known.begin(), known.end(), columns_[column]) != known.end()) continue;
    if (rows_ > 0 && rows_without_number(column).empty()) extra.push_back(columns_[column]);
  }
  return extra;
}

std::vector<std::string> CsvTable::incomplete_columns(const std::vector<std::string>& known) const {
  std::vector<std::string> notes;
  for (size_t column = 0; column < columns_.size(); ++column) {
    if (std::find(known.begin(), known.end(), columns_[column]) != known.end()) continue;
    const std::vector<size_t> bad = rows_without_number(column);
    if (bad.empty() || 2 * bad.size() > rows_) continue;
    notes.push_back(fmt::format(
        "{}:{}: column {} is left out: found '{}', expected a number in every row ({} of {} have "
        "none)",
        file_, lines_[bad.front()], columns_[column], at(bad.front(), column), bad.size(), rows_));
  }
  return notes;
}

void CsvTable::exchange(std::string_view a, std::string_view b) {
  if (has(a) && has(b)) std::swap(columns_[index_of(a)], columns_[index_of(b)]);
}

void CsvTable::fail(size_t row, std::string_view column, std::string_view found,
                    std::string_view expected) const {
  throw InputError(fmt::format("{}:{}: column {}: found '{}', expected {}", file_, lines_[row],
                               column, found, expected));
}

CsvWriter::CsvWriter(const std::vector<std::string>& columns) : width_(columns.size()) {
  for (size_t i = 0; i < columns.size(); ++i) text_ += (i ? "," : "") + columns[i];
  text_ += "\n";
}

void CsvWriter::row(const std::vector<std::string>& cells) {
  SEAM_CHECK(cells.size() == width_, "{} cells for {} columns", cells.size(), width_);
  for (size_t i = 0; i < cells.size(); ++i) {
    if (i) text_ += ',';
    text_ += cells[i];
  }
  text_ += '\n';
}

void CsvWriter::write(const std::filesystem::path& path) const {
  write_file_atomically(path, text_);
}

void write_table_with(const CsvTable& table, const std::vector<std::string>& names,
                      const std::vector<std::vector<double>>& values,
                      const std::filesystem::path& path) {
  std::vector<std::string> columns = table.columns();
  for (const std::string& name : names) {
    if (!table.has(name)) columns.push_back(name);
  }
  CsvWriter out(columns);
  for (size_t row = 0; row < table.rows(); ++row) {
    std::vector<std::string> cells;
    for (const std::string& column : columns) {
      const auto made = std::find(names.begin(), names.end(), column);
      if (made == names.end()) {
        cells.emplace_back(table.cell(row, column));
        continue;
      }
      const double value = values[made - names.begin()][row];
      cells.push_back(std::isnan(value) ? "" : fmt::format("{:.9g}", value));
    }
    out.row(cells);
  }
  out.write(path);
}

}  // namespace seam::measurement
