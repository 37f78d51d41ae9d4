// CSV tables of measurement sets: a header, comma-separated, UTF-8, `.` for decimals. Cells stay
// text until somebody asks for a column, so that an error can name file, line and column.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace seam::measurement {

class CsvTable {
 public:
  // Throws InputError for a missing file, an empty header, a repeated column or a ragged row.
  static CsvTable read(const std::filesystem::path& path);
  static CsvTable from_text(std::string text, const std::string& name);

  size_t rows() const { return rows_; }
  const std::vector<std::string>& columns() const { return columns_; }
  bool has(std::string_view column) const;
  const std::string& file() const { return file_; }
  // Line in the file (1 is the header).
  int line(size_t row) const { return lines_[row]; }

  std::string_view cell(size_t row, std::string_view column) const;
  // A column of finite numbers; throws for anything else, naming line and column.
  std::vector<double> numbers(std::string_view column) const;
  // The same with NaN for blank cells.
  std::vector<double> numbers_or_blank(std::string_view column) const;
  std::vector<std::string> texts(std::string_view column) const;
  // Exact decimal seconds as integer nanoseconds: epoch times of 1.2e9 s keep their precision.
  std::vector<int64_t> times_ns(std::string_view column) const;

  // Leaves out the rows whose flag is 0; lines stay those of the file.
  void keep_rows(const std::vector<char>& kept);

  // Columns outside `known` that hold finite numbers in every row: extra covariates.
  std::vector<std::string> extra_numeric_columns(const std::vector<std::string>& known) const;
  // Of those that hold numbers in half of the rows or more and not in all, a sentence each: they
  // are left out.
  std::vector<std::string> incomplete_columns(const std::vector<std::string>& known) const;

  // Reads each of two columns as the other, where both are there: to try whether they were mixed
  // up.
  void exchange(std::string_view a, std::string_view b);

  [[noreturn]] void fail(size_t row, std::string_view column, std::string_view found,
                         std::string_view expected) const;

 private:
  std::vector<size_t> rows_without_number(size_t column) const;
  size_t index_of(std::string_view column) const;
  std::string_view at(size_t row, size_t column) const;

  std::string file_;
  std::string text_;
  std::vector<std::string> columns_;
  std::vector<uint32_t> starts_;  // Of each cell in `text_`, with one more a row for its end.
  std::vector<int> lines_;
  size_t rows_ = 0;
};

// Writes rows with a header; numbers must be formatted by the caller.
class CsvWriter {
 public:
  explicit CsvWriter(const std::vector<std::string>& columns);
  void row(const std::vector<std::string>& cells);
  void write(const std::filesystem::path& path) const;

 private:
  size_t width_;
  std::string text_;
};

// Writes the table with the named columns replaced, or appended where it lacks them; `values` by
// column and row, NaN for a blank cell.
void write_table_with(const CsvTable& table, const std::vector<std::string>& names,
                      const std::vector<std::vector<double>>& values,
                      const std::filesystem::path& path);

}  // namespace seam::measurement
