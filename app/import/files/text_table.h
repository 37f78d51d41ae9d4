// Tables of other programs as text: separated by commas, semicolons, tabulators or blanks, with or
// without a header, with comments. Cells stay text until somebody asks for a number, so that an
// error can name file, line and column.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace seam::app {

class TextTable {
 public:
  // Throws InputError for a file without rows and for ragged rows.
  static TextTable read(const std::filesystem::path& path);
  static TextTable from_text(std::string text, const std::string& name);

  const std::string& file() const { return file_; }
  size_t rows() const { return lines_.size(); }
  size_t width() const { return width_; }
  // Of the header, or of the last comment above the rows where it has as many words as they have;
  // empty where neither is there.
  const std::vector<std::string>& columns() const { return columns_; }
  // A column's name with the unit that stands beside it, "time [ms]"; empty where none has names.
  std::string full_name(size_t column) const;
  int line(size_t row) const { return lines_[row]; }

  // The place of the first of these names, -1 where none is there: without regard to case, and
  // where none is there as it stands, to blanks and a unit at its end. Throws where the file has
  // that column twice.
  int find(const std::vector<std::string>& names) const;

  std::string_view cell(size_t row, size_t column) const;
  // A finite number; throws for anything else.
  double number(size_t row, size_t column) const;
  // NaN for a blank cell, "nan" and "-".
  double number_or_blank(size_t row, size_t column) const;
  // A time in units of `unit_ns`, exact where it is a plain decimal.
  int64_t time_ns(size_t row, size_t column, int64_t unit_ns) const;

  std::string column_name(size_t column) const;
  [[noreturn]] void fail(size_t row, size_t column, std::string_view expected) const;

 private:
  void take_header(const std::vector<std::string>& words, int line);

  std::string file_;
  std::unique_ptr<const std::string> text_;  // Stays where it is when the table moves.
  std::vector<std::string> columns_, full_names_;
  std::vector<std::string_view> cells_;  // Into the text.
  std::vector<int> lines_;
  size_t width_ = 0;
  int header_line_ = 0;
};

// A plain decimal number and nothing else, finite; false for anything else, `value` as it was.
bool parse_number(std::string_view text, double& value);
// A decimal in units of `unit_ns`, or a time of the day or of a date (ISO 8601; UTC where it names
// no zone); false where it is neither or beyond what 64 bits hold.
bool parse_time_ns(std::string_view text, int64_t unit_ns, int64_t& ns);
// "2024-05-01T12:00:00.25Z", "2024-05-01 12:00:00", "12:00:00.25"; false for anything else.
bool parse_date_ns(std::string_view text, int64_t& ns);

}  // namespace seam::app
