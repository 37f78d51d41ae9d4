#include "measurement/kinds/imu/imu_data.h"

#include <algorithm>
#include <cmath>

#include "measurement/kinds/imu/spectra/cosine_transform.h"
#include "measurement/numerics/moments.h"
#include "measurement/numerics/robust.h"
#include "measurement/sets/temperatures.h"
#include "sim_core/base/error.h"

namespace seam::measurement {
namespace {

// A step of time beyond so many of the usual ones is a gap; half of one and less are jitter.
constexpr double kGap = 1.5;

struct Columns {
  std::vector<int64_t> time_ns;
  std::vector<std::string> run;  // Empty: the set names none.
  std::array<std::vector<double>, kImuAxes> samples, truth;
  std::vector<double> temperature_c;
};

std::array<std::vector<double>, kImuAxes> columns_of(
    const CsvTable& table, const std::array<const char*, kImuAxes>& names) {
  std::array<std::vector<double>, kImuAxes> columns;
  for (size_t axis = 0; axis < kImuAxes; ++axis)
    if (table.has(names[axis])) columns[axis] = table.numbers_or_blank(names[axis]);
  return columns;
}

// Three axes of a sensor or none.
void expect_whole(const CsvTable& table, const std::array<const char*, kImuAxes>& names,
                  size_t first) {
  size_t count = 0;
  for (size_t axis = first; axis < first + 3; ++axis) count += table.has(names[axis]) ? 1 : 0;
  if (count == 0 || count == 3) return;
  throw InputError(fmt::format("{}: found {} of the columns {}, {}, {}, expected all three or none",
                               table.file(), count, names[first], names[first + 1],
                               names[first + 2]));
}

// Whether a row goes on with what the one before it began.
bool goes_on(const Columns& columns, size_t before, size_t row, double usual_s) {
  const double step_s = 1e-9 * static_cast<double>(columns.time_ns[row] - columns.time_ns[before]);
  if (step_s > kGap * usual_s) return false;
  for (const auto& truth : columns.truth) {
    if (!truth.empty() && truth[row] != truth[before]) return false;
  }
  return columns.run.empty() || columns.run[row] == columns.run[before];
}

bool is_whole(const Columns& columns, size_t row) {
  for (const auto* part : {&columns.samples, &columns.truth}) {
    for (const auto& values : *part)
      if (!values.empty() && std::isnan(values[row])) return false;
  }
  return true;
}

// The usual step of time, from those that go forward within a run.
double usual_step_s(const CsvTable& table, const Columns& columns) {
  std::vector<double> steps;
  for (size_t row = 1; row < table.rows(); ++row) {
    if (!columns.run.empty() && columns.run[row] != columns.run[row - 1]) continue;
    expect_later(table, columns.time_ns, row);
    steps.push_back(1e-9 * static_cast<double>(columns.time_ns[row] - columns.time_ns[row - 1]));
  }
  if (steps.empty())
    throw InputError(fmt::format(
        "{}: found no two rows of one run ({} of all), expected samples that follow each other",
        table.file(), table.rows()));
  return median_of(steps);
}

void take(const Columns& columns, std::vector<size_t> rows, ImuData& data) {
  // All but the last few, of a length whose spectrum is quick to find.
  const size_t n = quick_length(rows.size());
  data.left += rows.size() - n;
  rows.resize(n);
  ImuStretch stretch;
  const size_t first = rows.front(), last = rows.back();
  stretch.dt_s = 1e-9 * static_cast<double>(columns.time_ns[last] - columns.time_ns[first]) /
                 static_cast<double>(n - 1);
  stretch.start_s = 1e-9 * static_cast<double>(columns.time_ns[first] - columns.time_ns[0]);
  stretch.group = columns.run.empty() ? std::to_string(data.stretches.size()) : columns.run[first];
  for (const size_t row : rows)
    stretch.stamp_s.push_back(1e-9 *
                              static_cast<double>(columns.time_ns[row] - columns.time_ns[first]));
  for (size_t axis = 0; axis < kImuAxes; ++axis) {
    if (!columns.truth[axis].empty()) stretch.truth[axis] = columns.truth[axis][first];
    if (columns.samples[axis].empty()) continue;
    for (const size_t row : rows) stretch.samples[axis].push_back(columns.samples[axis][row]);
    stretch.mean[axis] = mean_of(stretch.samples[axis]);
  }
  if (!columns.temperature_c.empty()) {
    for (const size_t row : rows) stretch.temperature_c.push_back(columns.temperature_c[row]);
    stretch.warmth_c = mean_of(stretch.temperature_c);
  }
  stretch.rows = std::move(rows);
  data.stretches.push_back(std::move(stretch));
}

// An axis that reads the same in all rows has no noise that could be seen.
void expect_scatter(const CsvTable& table, const ImuData& data) {
  constexpr double kLeast = 1e-12;  // As of a stated noise.
  for (size_t axis = 0; axis < kImuAxes; ++axis) {
    if (!data.has[axis]) continue;
    const double first = data.stretches.front().samples[axis].front();
    const bool scatters =
        std::any_of(data.stretches.begin(), data.stretches.end(), [&](const ImuStretch& stretch) {
          return std::any_of(stretch.samples[axis].begin(), stretch.samples[axis].end(),
                             [&](double sample) { return std::abs(sample - first) >= kLeast; });
        });
    if (!scatters)
      throw InputError(fmt::format(
          "{}: column {} is {:g} in all rows, expected readings that scatter: leave out the three "
          "columns of a sensor that was not logged",
          table.file(), kImuColumns[axis], first));
  }
}

// A sensor's temperature in degrees Celsius, blank or not.
void expect_warmth(const CsvTable& table, const std::vector<double>& warmth_c) {
  constexpr double kLeast_c = -273.15, kMost_c = 1000;
  for (size_t row = 0; row < warmth_c.size(); ++row) {
    if (warmth_c[row] < kLeast_c || warmth_c[row] > kMost_c)
      table.fail(row, kTemperature, table.cell(row, kTemperature),
                 fmt::format("degrees Celsius, {:g} to {:g}", kLeast_c, kMost_c));
  }
}

// A temperature that is logged more slowly than the rest stays until the next one.
void hold_last(std::vector<double>& values) {
  const auto known =
      std::find_if(values.begin(), values.end(), [](double v) { return !std::isnan(v); });
  if (known == values.end()) values.clear();
  double last = values.empty() ? 0 : *known;
  for (double& value : values) last = value = std::isnan(value) ? last : value;
}

}  // namespace

Vec3 force_read(const ImuStretch& stretch) {
  return {stretch.mean[3], stretch.mean[4], stretch.mean[5]};
}

double size_of(const Vec3& v) {
  return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

ImuData read_imu(const MeasurementSet& set, bool measured) {
  const CsvTable table = set.table("imu");
  for (const size_t sensor : {0, 3}) {
    expect_whole(table, kImuTruth, sensor);
    if (measured) expect_whole(table, kImuColumns, sensor);
  }
  Columns columns{.time_ns = table.times_ns("time_s"), .truth = columns_of(table, kImuTruth)};
  if (table.has(set.group) || set.root.has("group")) columns.run = table.texts(set.group);
  if (measured) columns.samples = columns_of(table, kImuColumns);
  if (table.has(kTemperature)) columns.temperature_c = table.numbers_or_blank(kTemperature);
  expect_warmth(table, columns.temperature_c);
  hold_last(columns.temperature_c);
  ImuData data;
  data.gravity_mps2 =
      set.root.number_or("gravity_mps2", data.gravity_mps2, {.min = 0.1, .max = 100});
  data.rate_hz = set.root.number_or("rate_hz", 0, {.min = 1e-3, .max = 1e6});
  for (size_t axis = 0; axis < kImuAxes; ++axis) data.has[axis] = !columns.samples[axis].empty();
  data.knows_rates = !columns.truth[0].empty();
  data.knows_forces = !columns.truth[3].empty();
  const double usual_s = usual_step_s(table, columns);
  std::vector<size_t> rows;
  const auto end = [&] {
    if (rows.size() >= kLeastSamples)
      take(columns, std::move(rows), data);
    else
      data.left += rows.size();
    rows.clear();
  };
  for (size_t row = 0; row < table.rows(); ++row) {
    const bool whole = is_whole(columns, row);
    if (!rows.empty() && (!whole || !goes_on(columns, rows.back(), row, usual_s))) end();
    if (whole) rows.push_back(row);
    data.left += whole ? 0 : 1;
  }
  end();
  if (data.stretches.empty())
    throw InputError(fmt::format(
        "{}: found no stretch of {} samples with even times and one reference, expected a rest or "
        "a turn at one rate that lasts so long",
        table.file(), kLeastSamples));
  if (measured) expect_scatter(table, data);
  return data;
}

}  // namespace seam::measurement
