#include "effects/stages/row_schedule.h"

#include <algorithm>
#include <cmath>

#include "sim_core/base/error.h"

namespace seam::effects {
namespace {

// Places on the grid first_ns + k * step_ns that lie inside a row's window.
struct GridRange {
  int64_t first = 0;
  int64_t last = 0;
};

int64_t floor_divide(int64_t a, int64_t b) {
  return a / b - ((a % b != 0) && ((a < 0) != (b < 0)));
}

std::vector<RowWindow> row_windows(const Timing& timing, SimTime stamp, int height_px,
                                   const RowScheduleOptions& options) {
  const SimDuration exposure = SimDuration::from_s(timing.exposure_s);
  const double since_reference_s = (stamp - options.reference).s();
  std::vector<RowWindow> rows(height_px);
  for (int row = 0; row < height_px; ++row) {
    const double offset_s = timing.row_start_after_stamp_s(row, since_reference_s);
    const SimTime start = stamp + SimDuration::from_s(offset_s) + options.jitter;
    rows[row] = {start, start + exposure};
  }
  return rows;
}

// Few instants: each weighs the part of the window nearest to it, then a tilt moves the mean time
// to the middle.
std::vector<double> weights_of_few(const std::vector<double>& t, double length) {
  const size_t count = t.size();
  std::vector<double> weights(count);
  double mean_t = 0, weighted_t = 0, spread = 0;
  for (size_t k = 0; k < count; ++k) {
    const double begin = k == 0 ? 0 : 0.5 * (t[k - 1] + t[k]);
    const double end = k + 1 == count ? length : 0.5 * (t[k] + t[k + 1]);
    weights[k] = (end - begin) / length;
    weighted_t += weights[k] * t[k];
    mean_t += t[k] / static_cast<double>(count);
  }
  for (size_t k = 0; k < count; ++k) spread += (t[k] - mean_t) * (t[k] - mean_t);
  if (count < 2) return weights;
  const double tilt = (0.5 * length - weighted_t) / spread;
  for (size_t k = 0; k < count; ++k) weights[k] += tilt * (t[k] - mean_t);
  return weights;
}

// See the header; phi and psi are the distances of the outermost instants from the window's ends
// in steps, `length` the window in steps.
std::vector<double> euler_maclaurin_weights(int64_t count, double phi, double psi, double length) {
  if (count < 4) {
    std::vector<double> t(count);
    for (int64_t k = 0; k < count; ++k) t[k] = phi + static_cast<double>(k);
    return weights_of_few(t, length);
  }
  std::vector<double> weights(count, 1.0);
  const auto correct = [](double offset, double& outermost, double& next) {
    const double inner = 1.0 / 12 - 0.5 * offset * offset;
    next += inner;
    outermost += (offset - 0.5) - inner;
  };
  correct(phi, weights[0], weights[1]);
  correct(psi, weights[count - 1], weights[count - 2]);
  for (double& weight : weights) weight /= length;
  return weights;
}

RowSchedule one_instant_a_row(std::vector<RowWindow> rows) {
  RowSchedule schedule;
  const auto middle = [](const RowWindow& row) { return row.start + (row.end - row.start) / 2; };
  for (const RowWindow& row : rows) schedule.instants.push_back(middle(row));
  std::sort(schedule.instants.begin(), schedule.instants.end());
  schedule.instants.erase(std::unique(schedule.instants.begin(), schedule.instants.end()),
                          schedule.instants.end());
  for (const RowWindow& row : rows) {
    const auto place =
        std::lower_bound(schedule.instants.begin(), schedule.instants.end(), middle(row));
    schedule.first_instant.push_back(static_cast<int>(place - schedule.instants.begin()));
    schedule.weights.push_back({1.0});
  }
  schedule.rows = std::move(rows);
  return schedule;
}

}  // namespace

SimTime stamp_in_lock(const Timing& timing, SimTime stamp, const HeadCycle& cycle) {
  if (timing.sync_period_frames <= 0) return stamp;
  const double locked_ns = timing.in_lock(static_cast<double>((stamp - cycle.start).ns()),
                                          static_cast<double>(cycle.length.ns()));
  return cycle.start + SimDuration::from_ns(std::llround(locked_ns));
}

RowSchedule make_row_schedule(const Timing& timing, SimTime stamp, int height_px,
                              const RowScheduleOptions& options) {
  return schedule_of_windows(row_windows(timing, stamp, height_px, options),
                             options.instants_per_row);
}

RowSchedule schedule_of_windows(std::vector<RowWindow> rows, int instants_per_row) {
  SEAM_CHECK(!rows.empty() && instants_per_row >= 1 && instants_per_row <= kMaxInstantsPerRow,
             "height {}, instants {}", rows.size(), instants_per_row);
  const int height_px = static_cast<int>(rows.size());
  const int64_t exposure_ns = (rows[0].end - rows[0].start).ns();
  if (instants_per_row == 1 || exposure_ns < instants_per_row)
    return one_instant_a_row(std::move(rows));
  const int64_t step_ns = exposure_ns / instants_per_row;
  std::vector<int> in_time_order(height_px);
  for (int row = 0; row < height_px; ++row) in_time_order[row] = row;
  std::stable_sort(in_time_order.begin(), in_time_order.end(),
                   [&](int a, int b) { return rows[a].start < rows[b].start; });
  const int64_t grid_ns = rows[in_time_order[0]].start.ns() + step_ns / 2;

  RowSchedule schedule;
  schedule.first_instant.resize(height_px);
  schedule.weights.resize(height_px);
  int64_t next_place = 0;  // The first place of the grid that is not yet an instant.
  for (const int row : in_time_order) {
    const int64_t start_ns = rows[row].start.ns() - grid_ns;
    const int64_t end_ns = rows[row].end.ns() - grid_ns;
    const GridRange range{-floor_divide(-start_ns, step_ns), floor_divide(end_ns, step_ns)};
    // Rows that are far apart in time leave gaps in the grid, where nobody samples.
    next_place = std::max(next_place, range.first);
    for (; next_place <= range.last; ++next_place) {
      schedule.instants.push_back(SimTime::from_ns(grid_ns + next_place * step_ns));
    }
    const int64_t count = range.last - range.first + 1;
    schedule.first_instant[row] = static_cast<int>(static_cast<int64_t>(schedule.instants.size()) -
                                                   (next_place - range.first));
    const double step = static_cast<double>(step_ns);
    schedule.weights[row] =
        euler_maclaurin_weights(count, static_cast<double>(range.first * step_ns - start_ns) / step,
                                static_cast<double>(end_ns - range.last * step_ns) / step,
                                static_cast<double>(exposure_ns) / step);
  }
  schedule.rows = std::move(rows);
  return schedule;
}

}  // namespace seam::effects
