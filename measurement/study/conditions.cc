#include "measurement/study/conditions.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <vector>

#include "measurement/kinds/kinds.h"
#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

constexpr double kWanderTime_s = 1;     // Of an error that wanders.
constexpr double kMisfitPeriods = 2.5;  // Of the smooth misfit, in the time of a series.
constexpr double kBurstNoises = 30;     // Of a gross error, in noise units.
constexpr int kBurstRows = 3;
constexpr double kBurstShare = 0.01;     // Of all rows.
constexpr double kMostUneven = 1.0 / 3;  // Of the time to the next row.

struct Rows {
  CsvTable table;
  std::filesystem::path file;
  std::vector<double> time_s;
  std::vector<std::vector<size_t>> series;  // Rows in the order of time.
};

Rows rows_of(const MeasurementSet& set, const std::vector<std::string>& keys) {
  const std::string name = find_kind(set.kind).observations.file;
  Rows rows{.table = set.table(name), .file = set.file(name)};
  rows.time_s = rows.table.numbers("time_s");
  std::map<std::string, size_t> place;
  for (size_t row = 0; row < rows.table.rows(); ++row) {
    std::string label;
    for (const std::string& key : keys) {
      if (rows.table.has(key)) label += std::string(rows.table.cell(row, key)) + "/";
    }
    const auto [at, is_new] = place.try_emplace(label, rows.series.size());
    if (is_new) rows.series.emplace_back();
    rows.series[at->second].push_back(row);
  }
  for (auto& series : rows.series)
    std::stable_sort(series.begin(), series.end(),
                     [&](size_t a, size_t b) { return rows.time_s[a] < rows.time_s[b]; });
  return rows;
}

void keep_groups(const MeasurementSet& set, int count) {
  const std::string name = find_kind(set.kind).observations.file;
  CsvTable table = set.table(name);
  std::vector<std::string> names;
  const std::vector<int> group = number_groups(table.texts(set.group), names);
  if (static_cast<size_t>(count) > names.size())
    throw InputError(fmt::format("the protocol of {} has {} groups, {} were wished", set.kind,
                                 names.size(), count));
  std::vector<char> kept(table.rows());
  for (size_t row = 0; row < table.rows(); ++row) kept[row] = group[row] < count;
  table.keep_rows(kept);
  write_table_with(table, {}, {}, set.file(name));
}

void make_uneven(const MeasurementSet& set) {
  const Rows rows = rows_of(set, {set.group});
  std::vector<double> moved = rows.time_s;
  for (size_t s = 0; s < rows.series.size(); ++s) {
    const auto& series = rows.series[s];
    for (size_t k = 0; k < series.size(); ++k) {
      // Rows of one time stay together.
      size_t next = k;
      while (next < series.size() && rows.time_s[series[next]] == rows.time_s[series[k]]) ++next;
      const double step =
          next < series.size() ? rows.time_s[series[next]] - rows.time_s[series[k]] : 0;
      const double by =
          kMostUneven * step * uniform(RandomStream{.seed = 9, .stream = 1}.child(s), next);
      moved[series[k]] = rows.time_s[series[k]] + by;
    }
  }
  write_table_with(rows.table, {"time_s"}, {moved}, rows.file);
}

// A first-order process of unit variance along a series.
std::vector<double> wandering(const Rows& rows, const std::vector<size_t>& series,
                              RandomStream stream) {
  std::vector<double> values;
  for (size_t k = 0; k < series.size(); ++k) {
    const double fresh = normal(stream, k);
    if (k == 0) {
      values.push_back(fresh);
      continue;
    }
    const double dt = rows.time_s[series[k]] - rows.time_s[series[k - 1]];
    const double kept = maths::exp(-dt / kWanderTime_s);
    values.push_back(kept * values.back() + std::sqrt(1 - kept * kept) * fresh);
  }
  return values;
}

}  // namespace

std::string Conditions::text() const {
  std::vector<std::string> parts;
  if (groups > 0) parts.push_back(fmt::format("{} group{}", groups, groups == 1 ? "" : "s"));
  if (uneven) parts.push_back("uneven time steps");
  if (misfit > 0) parts.push_back(fmt::format("a smooth misfit of {:g}", misfit));
  if (wander > 0) parts.push_back(fmt::format("errors that wander by {:g}", wander));
  if (bursts) parts.push_back("outliers in bursts");
  return fmt::format("{}", fmt::join(parts, ", "));
}

void arrange_protocol(const Conditions& conditions, const std::filesystem::path& folder) {
  const MeasurementSet set = MeasurementSet::open(folder);
  if (conditions.of_tables() && find_kind(set.kind).observations.measured.empty())
    throw InputError(fmt::format(
        "sets of kind {} are images: of the conditions only --groups is for them", set.kind));
  if (conditions.groups > 0) keep_groups(set, conditions.groups);
  if (conditions.uneven) make_uneven(set);
}

void disturb_set(const Conditions& conditions, uint64_t seed, const std::filesystem::path& folder) {
  if (!(conditions.misfit > 0) && !(conditions.wander > 0) && !conditions.bursts) return;
  const MeasurementSet set = MeasurementSet::open(folder);
  const Rows rows = rows_of(set, {"run", "landmark", "joint", "point"});
  const RandomStream stream{.seed = seed, .stream = 77};
  const auto& names = find_kind(set.kind).observations.measured;
  std::vector<std::vector<double>> values;
  for (size_t c = 0; c < names.size(); ++c) {
    std::vector<double> column = rows.table.numbers_or_blank(names[c]);
    const double noise = set.noise_of(names[c]);
    const RandomStream own = stream.child(names[c]);
    const auto [first, last] = std::minmax_element(rows.time_s.begin(), rows.time_s.end());
    const double rate = 2 * maths::kPi * kMisfitPeriods / std::max(*last - *first, 1e-9);
    for (size_t s = 0; s < rows.series.size(); ++s) {
      const auto& series = rows.series[s];
      const auto wander = wandering(rows, series, own.child(s));
      for (size_t k = 0; k < series.size(); ++k) {
        const double wave = std::sqrt(2.0) * maths::sin(rate * (rows.time_s[series[k]] - *first) +
                                                        static_cast<double>(c));
        column[series[k]] += noise * (conditions.misfit * wave + conditions.wander * wander[k]);
      }
    }
    values.push_back(std::move(column));
  }
  if (conditions.bursts) {
    std::vector<char> distance;  // Columns in which nothing is below 0: there, errors leave it so.
    for (const std::vector<double>& column : values)
      distance.push_back(
          std::none_of(column.begin(), column.end(), [](double v) { return v < 0; }));
    for (size_t s = 0; s < rows.series.size(); ++s) {
      for (size_t k = 0; k + kBurstRows < rows.series[s].size(); ++k) {
        const uint64_t draw = 100'000 * s + k;
        if (uniform(stream.child("burst"), draw) > kBurstShare / kBurstRows) continue;
        const double side = uniform(stream.child("side"), draw) < 0.5 ? -1 : 1;
        for (int row = 0; row < kBurstRows; ++row) {
          for (size_t c = 0; c < names.size(); ++c) {
            double& value = values[c][rows.series[s][k + row]];
            value += side * kBurstNoises * set.noise_of(names[c]);
            if (distance[c]) value = std::abs(value);
          }
        }
      }
    }
  }
  write_table_with(rows.table, names, values, rows.file);
}

}  // namespace seam::measurement
