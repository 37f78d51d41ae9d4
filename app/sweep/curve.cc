#include "app/sweep/curve.h"

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <charconv>
#include <cmath>
#include <map>

#include "app/sweep/table.h"
#include "measurement/numerics/moments.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

constexpr double kTail = 0.025;  // On either side.

using measurement::deviation_of;
using measurement::mean_of;

Estimate mean_estimate(const std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  Estimate estimate{.value = mean_of(values)};
  if (n < 2) return estimate;
  const boost::math::students_t t(n - 1);
  const double half = boost::math::quantile(t, 1 - kTail) * deviation_of(values) / std::sqrt(n);
  estimate.low = estimate.value - half;
  estimate.high = estimate.value + half;
  return estimate;
}

Estimate deviation_estimate(const std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  if (n < 2) return {.value = std::nan("")};
  const boost::math::chi_squared chi(n - 1);
  const double s = deviation_of(values);
  return {s, s * std::sqrt((n - 1) / boost::math::quantile(chi, 1 - kTail)),
          s * std::sqrt((n - 1) / boost::math::quantile(chi, kTail))};
}

// Between the k-th smallest and the k-th greatest value, k as great as the 95 % allow.
Estimate median_estimate(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const size_t n = values.size(), middle = n / 2;
  Estimate estimate{.value =
                        n % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle])};
  const boost::math::binomial coins(static_cast<double>(n), 0.5);
  size_t outside = 0;  // Values on either side that the interval leaves out.
  while (outside < n / 2 && boost::math::cdf(coins, static_cast<double>(outside)) <= kTail)
    ++outside;
  if (outside == 0) return estimate;  // Not even the whole range holds it with 95 %.
  estimate.low = values[outside - 1];
  estimate.high = values[n - outside];
  return estimate;
}

Estimate rate_estimate(const std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  const auto hits = static_cast<double>(
      std::count_if(values.begin(), values.end(), [](double value) { return value != 0; }));
  const double z = boost::math::quantile(boost::math::normal(), 1 - kTail);
  const double p = hits / n, scale = 1 + z * z / n;
  const double centre = (p + z * z / (2 * n)) / scale;
  const double half = z / scale * std::sqrt(p * (1 - p) / n + z * z / (4 * n * n));
  return {p, std::max(0.0, centre - half), std::min(1.0, centre + half)};
}

size_t column_of(const std::vector<std::string>& columns, const std::string& name,
                 const char* option) {
  const auto found = std::find(columns.begin(), columns.end(), name);
  if (found == columns.end())
    throw UsageError(
        fmt::format("{} {}: no such column{}", option, name, suggestion_for(name, columns)));
  return static_cast<size_t>(found - columns.begin());
}

double number_in(const std::string& cell, const std::string& column, uint64_t run) {
  double number = 0;
  const auto [rest, error] = std::from_chars(cell.data(), cell.data() + cell.size(), number);
  if (error != std::errc() || rest != cell.data() + cell.size())
    throw InputError(fmt::format("run {}: {}: found '{}', expected a number", run, column, cell));
  return number;
}

}  // namespace

Estimate estimate_of(CurveStatistic statistic, std::vector<double> values) {
  if (values.empty()) return {.value = std::nan("")};
  switch (statistic) {
    case CurveStatistic::mean:
      return mean_estimate(values);
    case CurveStatistic::deviation:
      return deviation_estimate(values);
    case CurveStatistic::median:
      return median_estimate(std::move(values));
    case CurveStatistic::rate:
      return rate_estimate(values);
  }
  return {};
}

std::vector<CurvePoint> curve_of(const ResultsFile& results, CurveStatistic statistic,
                                 const std::string& value, const std::string& over,
                                 const std::string& by) {
  const std::vector<std::string> columns = table_columns(results.plan());
  const size_t value_column = column_of(columns, value, "--value");
  const size_t x_column = column_of(columns, over, "--over");
  const size_t by_column = by.empty() ? 0 : column_of(columns, by, "--by");
  std::vector<CurvePoint> points;
  std::vector<std::vector<double>> values;
  std::map<std::pair<std::string, std::string>, size_t> places;
  results.each([&](const RunRecord& record) {
    if (record.failed()) return;
    const std::vector<std::string> cells = table_cells(results.plan(), record);
    if (cells[value_column].empty()) return;
    const std::string series = by.empty() ? "" : cells[by_column];
    const auto [place, fresh] = places.try_emplace({cells[x_column], series}, points.size());
    if (fresh) {
      points.push_back({cells[x_column], series, 0, {}});
      values.emplace_back();
    }
    values[place->second].push_back(number_in(cells[value_column], value, record.run));
  });
  for (size_t i = 0; i < points.size(); ++i) {
    points[i].count = values[i].size();
    points[i].estimate = estimate_of(statistic, std::move(values[i]));
  }
  return points;
}

}  // namespace seam::app
