// Makes a set of outcomes: the statistics of runs with this model, with the errors that so many
// runs have.
#include <algorithm>
#include <cmath>
#include <filesystem>

#include "measurement/kinds/outcomes/outcomes.h"
#include "measurement/kinds/outcomes/scatter_of_runs.h"
#include "sim_core/base/error.h"
#include "sim_core/base/output.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

// A statistic that is the same in all runs was still read off something: where the set does not say
// how well, to a thousandth of what the runs' values are.
double told_sigma(const RunTable& made, size_t column, double variance, double reading) {
  if (reading > 0) return std::hypot(std::sqrt(variance), reading);
  constexpr double kReading = 1e-3;
  double square = 0, count = 0;
  for (const std::vector<double>& run : made.runs) {
    if (std::isfinite(run[column])) square += run[column] * run[column], ++count;
  }
  const double size = std::sqrt(square / std::max(1.0, count));
  return std::max({std::sqrt(variance), kReading * size, 1e-9});
}

}  // namespace

// Runs have seeds of their own, which no prediction has; without noise, those of the plan.
void measure_outcomes(const Model& truth, const MeasurementSet& protocol,
                      const MeasureOptions& options, const Instruments& instruments) {
  const OutcomeSettings settings = read_settings(protocol);
  const auto runs = open_runs(protocol, settings, instruments);
  const CsvTable table = protocol.table("outcomes");
  const auto rows = read_outcomes(table, settings.runs, *runs, Measured::to_be_made);
  const uint64_t draw = options.noise ? options.seed + 1 : 0;
  const RandomStream reading = RandomStream{.seed = options.seed}.child("reading");
  std::vector<double> measured(rows.size()), sigma(rows.size());
  for (size_t plan = 0; plan < settings.runs.plans.size(); ++plan) {
    std::vector<ColumnStatistic> wanted;
    std::vector<size_t> places;
    for (size_t row = 0; row < rows.size(); ++row) {
      if (rows[row].plan == plan) wanted.push_back(rows[row].statistic), places.push_back(row);
    }
    if (wanted.empty()) continue;
    const RunTable made = runs->make(plan, truth, draw);
    const StatisticsOfRuns statistics = statistics_of(made.runs, runs->alike(plan), wanted);
    const Scatter scatter =
        scatter_of(settings.runs, *runs, plan, truth, made, wanted, /*stream=*/1);
    for (size_t i = 0; i < places.size(); ++i) {
      const size_t row = places[i];
      const auto k = static_cast<Eigen::Index>(i);
      measured[row] = statistics.value[i];
      sigma[row] = told_sigma(made, wanted[i].column, scatter.covariance(k, k), rows[row].reading);
      if (options.noise) measured[row] += rows[row].reading * normal(reading, row);
      if (!std::isfinite(measured[row])) {
        throw InputError(fmt::format(
            "{}:{}: with model '{}' fewer than half of the runs give this value{}{}", table.file(),
            table.line(row), truth.name(), made.first_error.empty() ? "" : ": ", made.first_error));
      }
    }
  }
  copy_protocol(protocol, options.out, {"outcomes"});
  for (size_t plan = 0; plan < settings.runs.plans.size(); ++plan) {
    const std::filesystem::path beside =
        std::filesystem::relative(settings.runs.plans[plan].file, protocol.folder).parent_path();
    for (const auto& [name, text] : runs->files(plan))
      write_file_atomically(written_path(options.out, (beside / name).string()), text);
  }
  write_table_with(table, {"measured", "sigma"}, {measured, sigma},
                   written_path(options.out, protocol.files.at("outcomes")));
}

}  // namespace seam::measurement
