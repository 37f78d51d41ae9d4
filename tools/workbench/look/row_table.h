// Rows of a set with the residuals of a model, as columns for the page.
#pragma once

#include <map>
#include <string>

#include "measurement/problem/problem.h"
#include "measurement/problem/residual_view.h"
#include "measurement/report/columns/data_columns.h"
#include "tools/workbench/look/columns.h"

namespace seam::tools {

// Where each row of the table is in a view: a table has all rows of the set, a view lacks those
// that are left out.
class RowTable {
 public:
  // `all` is the same set with no row left out, or the same problem.
  RowTable(const measurement::Problem& all, const measurement::Problem& used);

  // Lines, groups, covariates, residuals and what was measured (columns `d:NAME`); before any
  // `residuals`.
  std::string rows(const measurement::ResidualView& of_all, const measurement::ResidualView& view,
                   const measurement::DataColumns& data);
  // Residuals alone, with this head; a stated error as `rows` has it is left out, since most models
  // change none.
  std::string residuals(const measurement::ResidualView& view, nlohmann::json head) const;

 private:
  std::vector<float> column_of(const measurement::ResidualView::Channel& channel,
                               const std::vector<double>& values) const;
  std::vector<std::string> channels(const measurement::ResidualView& view) const;
  size_t place_of(int row) const {
    return places_.empty() ? static_cast<size_t>(row) : places_[static_cast<size_t>(row)];
  }

  const measurement::Problem& all_;
  const measurement::Problem& used_;
  std::vector<size_t> places_;  // By row of the used set; empty: as they are.
  size_t rows_ = 0;
  std::map<std::string, std::vector<float>> stated_;  // By channel, as `rows` has it.
};

}  // namespace seam::tools
