// What a table holds beside the columns that its kind knows, for formulas and as covariates.
#pragma once

#include <string>
#include <vector>

#include "effects/row_columns.h"
#include "measurement/sets/csv.h"

namespace seam::measurement {

// Of finite numbers in every row.
inline effects::FurtherColumns further_columns(const CsvTable& table,
                                               const std::vector<std::string>& known) {
  effects::FurtherColumns further{table.extra_numeric_columns(known), {}};
  for (const std::string& name : further.names) further.values.push_back(table.numbers(name));
  return further;
}

}  // namespace seam::measurement
