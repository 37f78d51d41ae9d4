// Further numeric columns of a measurement set, which formulas read by their names.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

namespace seam::effects {

struct FurtherColumns {
  std::vector<std::string> names;
  std::vector<std::vector<double>> values;  // By column and row.
};

// Their values in one row. Sets that lack a column are refused before; without a set (the
// simulator) each is 0, or what the reader says.
struct RowColumns {
  const std::vector<std::string>* names = nullptr;
  const std::vector<std::vector<double>>* values = nullptr;
  size_t row = 0;

  RowColumns() = default;
  RowColumns(const std::vector<std::string>& of, const std::vector<std::vector<double>>& by_row,
             size_t at)
      : names(&of), values(&by_row), row(at) {}
  RowColumns(const FurtherColumns& further, size_t at)
      : RowColumns(further.names, further.values, at) {}

  double value(const std::string& name, double without = 0) const {
    if (names == nullptr) return without;
    const auto found = std::find(names->begin(), names->end(), name);
    return found == names->end() ? without
                                 : (*values)[static_cast<size_t>(found - names->begin())][row];
  }
};

}  // namespace seam::effects
