// What a set of kind `outcomes` holds: statistics of whole runs, as they were measured, and the
// plans by which the simulator makes such runs.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "measurement/imaging/run_maker.h"
#include "measurement/kinds/outcomes/run_statistics.h"
#include "measurement/problem/facts.h"
#include "measurement/sets/set.h"

namespace seam::measurement {

// One measured number.
struct OutcomeRow {
  size_t plan = 0;
  ColumnStatistic statistic;
  double measured = 0;
  double sigma = 0;
  double reading = 0;  // Of `sigma`, what reading it off adds to what runs scatter by.
};

// A range in which a fit of a candidate's parameter stays.
struct Bounds {
  double low = 0, high = 0;
};

struct OutcomeSettings {
  RunSpec runs;
  uint64_t most_runs = 0;  // The budget of one command.
  // Names of the effects that are tried, with bounds by parameter; nothing: all of the catalogue.
  std::optional<std::map<std::string, std::map<std::string, Bounds>>> candidates;
};

// The set's own keys; throws InputError naming file, line and key.
OutcomeSettings read_settings(const MeasurementSet& set);

// Which rows the protocol of `seam measure` may leave without measured values.
enum class Measured { needed, to_be_made };
std::vector<OutcomeRow> read_outcomes(const CsvTable& table, const RunSpec& spec,
                                      const RunMaker& runs, Measured measured);

// All of the facts that the table holds.
void describe_outcomes(const MeasurementSet& set, const CsvTable& table,
                       const std::vector<OutcomeRow>& rows, Facts& facts);

}  // namespace seam::measurement
