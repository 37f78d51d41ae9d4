// How far statistics of a plan's runs scatter, where the plan has too few runs to tell: from
// further runs with other seeds. Four runs know their own scatter to 40 %, and a misfit in units of
// it is as large as Student's t: nothing is found by it and much is alarmed at.
#pragma once

#include <cstdint>
#include <vector>

#include "measurement/imaging/run_maker.h"
#include "measurement/kinds/outcomes/run_statistics.h"

namespace seam::measurement {

// So many further tables of runs tell a plan's scatter; 0: it has enough, or no seeds to change.
uint64_t further_tables(const RunSpec& spec, const RunMaker& runs, size_t plan);

struct Scatter {
  Eigen::MatrixXd covariance;  // Of the statistics of one table.
  // What the statistics of all tables are in the mean, less those of the first: other models, whose
  // runs have the seeds of the first, miss by about as much.
  std::vector<double> beyond;
  size_t tables = 1;
};

// `first` is a table of this model that is there already; `stream` tells the seeds of one use from
// those of another.
Scatter scatter_of(const RunSpec& spec, RunMaker& runs, size_t plan, const effects::Model& model,
                   const RunTable& first, const std::vector<ColumnStatistic>& wanted,
                   uint64_t stream);

// What `given` says of another model's scatter: its correlations, and variances that follow those
// of a table of the other model, by the same seeds, as far as so many runs can be believed.
Eigen::MatrixXd scatter_beside(const Eigen::MatrixXd& given, const Eigen::MatrixXd& given_by_table,
                               const Eigen::MatrixXd& by_table, size_t runs);

}  // namespace seam::measurement
