// Results as a table of text: the same bytes for the same results, whatever order they came in.
#pragma once

#include <string>
#include <vector>

#include "app/sweep/results.h"

namespace seam::app {

// Columns: run, repetition where a plan has any, what varies, summary, what is kept, error.
std::vector<std::string> table_columns(const SweepPlan& plan);
// The cells of a run; blank where there is no number.
std::vector<std::string> table_cells(const SweepPlan& plan, const RunRecord& record);
// A line of CSV with its end.
std::string csv_line(const std::vector<std::string>& cells);

}  // namespace seam::app
