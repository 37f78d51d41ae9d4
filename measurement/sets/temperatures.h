// Temperatures of a table, which effects read by one name in every kind.
#pragma once

#include <vector>

#include "measurement/sets/csv.h"

namespace seam::measurement {

inline constexpr const char* kTemperature = "temperature_c";

// Throws an error with the row's line where a value is none of a motor or a camera: another unit.
inline void check_temperatures(const CsvTable& table, const std::vector<double>& values) {
  constexpr double kColdest_c = -100, kHottest_c = 250;  // A room in kelvin is above.
  for (size_t row = 0; row < values.size(); ++row) {
    if (!(values[row] > kColdest_c && values[row] < kHottest_c))
      table.fail(row, kTemperature, table.cell(row, kTemperature),
                 "a temperature in degrees Celsius, above -100 and below 250");
  }
}

}  // namespace seam::measurement
