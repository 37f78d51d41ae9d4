#include "measurement/kinds/landmarks/landmark_data.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>

#include "measurement/numerics/robust.h"
#include "measurement/sets/further_columns.h"
#include "measurement/sets/rig.h"
#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

const std::vector<std::string> kColumns = {"run", "time_s", "landmark", "range_m", "bearing_rad"};

void read_walks(const MeasurementSet& set, LandmarkData& data, std::vector<std::string>& runs,
                int64_t& reference_ns) {
  const CsvTable table = set.table("poses");
  if (table.rows() < 2)
    throw InputError(
        fmt::format("{}: found {} rows, expected 2 or more", table.file(), table.rows()));
  reference_ns = table.times_ns("time_s").front();
  const bool has_run = table.has("run");
  const std::vector<int> run_of_row =
      has_run ? number_groups(table.texts("run"), runs) : std::vector<int>(table.rows(), 0);
  if (!has_run) runs = {""};
  const std::vector<double> x = table.numbers("x_m"), y = table.numbers("y_m"),
                            theta = table.numbers("theta_rad");
  const bool has_z = table.has("z_m");
  const std::vector<double> z = has_z ? table.numbers("z_m") : std::vector<double>{};
  for (size_t run = 0; run < runs.size(); ++run) {
    std::vector<size_t> rows, keep;
    for (size_t row = 0; row < table.rows(); ++row) {
      if (run_of_row[row] == static_cast<int>(run)) rows.push_back(row);
    }
    const std::vector<double> times = log_seconds(table, "time_s", reference_ns, rows, keep);
    std::vector<double> px, py, pz, heading;
    for (const size_t row : keep) {
      px.push_back(x[row]);
      py.push_back(y[row]);
      if (has_z) pz.push_back(z[row]);
      heading.push_back(heading.empty()
                            ? theta[row]
                            : heading.back() + maths::wrap_angle(theta[row] - heading.back()));
    }
    std::vector<double> steps;
    for (size_t i = 0; i + 1 < times.size(); ++i) steps.push_back(times[i + 1] - times[i]);
    const double gap = steps.empty() ? 1 : 6 * median_of(steps);
    data.walks.push_back({Spline(times, px, gap), Spline(times, py, gap),
                          Spline(times, heading, gap),
                          has_z ? std::optional(Spline(times, pz, gap)) : std::nullopt});
  }
}

// Blocks of time serve as groups where the table has no column to hold out by.
std::vector<std::string> time_blocks(const std::vector<double>& stamps) {
  constexpr int kBlocks = 20;
  const auto [first, last] = std::minmax_element(stamps.begin(), stamps.end());
  std::vector<std::string> blocks;
  for (const double t : stamps) {
    const double share = *last > *first ? (t - *first) / (*last - *first) : 0;
    blocks.push_back("block " +
                     std::to_string(std::min(kBlocks - 1, static_cast<int>(share * kBlocks))));
  }
  return blocks;
}

using Places = std::map<std::string, std::array<double, 3>>;

Places read_places(const MeasurementSet& set, bool& heights) {
  Places places;
  const CsvTable known = set.table("landmarks");
  heights = known.has("z_m");
  const std::vector<double> lx = known.numbers("x_m"), ly = known.numbers("y_m");
  const std::vector<double> lz =
      heights ? known.numbers("z_m") : std::vector<double>(known.rows(), 0);
  const std::vector<std::string> names = known.texts("landmark");
  for (size_t row = 0; row < known.rows(); ++row) {
    if (!places.emplace(names[row], std::array{lx[row], ly[row], lz[row]}).second) {
      known.fail(row, "landmark", names[row], "each landmark once");
    }
  }
  return places;
}

// Fills what stands in each row; returns a label of its frame: the same stamp of the same run.
std::vector<std::string> read_rows(const MeasurementSet& set, const CsvTable& table,
                                   const std::vector<std::string>& runs, int64_t reference_ns,
                                   const Places& landmarks, LandmarkData& data) {
  const std::vector<int64_t> ns = table.times_ns("time_s");
  const bool has_run =
      table.has("run") && runs.size() > 0 && !(runs.size() == 1 && runs[0].empty());
  std::vector<std::string> frames;
  for (size_t row = 0; row < table.rows(); ++row) {
    const std::string run(has_run ? table.cell(row, "run") : "");
    const auto walk = std::find(runs.begin(), runs.end(), run);
    if (walk == runs.end()) table.fail(row, "run", run, "a run of " + set.files.at("poses"));
    data.walk_of_row.push_back(static_cast<int>(walk - runs.begin()));
    const std::string landmark(table.cell(row, "landmark"));
    const auto found = landmarks.find(landmark);
    if (found == landmarks.end())
      table.fail(row, "landmark", landmark,
                 "a landmark with a place in " + set.files.at("landmarks"));
    data.landmark_x.push_back(found->second[0]);
    data.landmark_y.push_back(found->second[1]);
    data.landmark_z.push_back(found->second[2]);
    data.stamp_s.push_back(1e-9 * static_cast<double>(ns[row] - reference_ns));
    const std::vector<double>& times = data.walks[data.walk_of_row[row]].x.times();
    if (data.stamp_s[row] < times.front() - 1 || data.stamp_s[row] > times.back() + 1) {
      table.fail(row, "time_s", table.cell(row, "time_s"), "a time within the poses of its run");
    }
    if (data.range_m[row] <= 0)
      table.fail(row, "range_m", table.cell(row, "range_m"),
                 "a distance above 0, or a blank cell where none was measured");
    frames.push_back(run + "|" + std::to_string(ns[row]));
  }
  return frames;
}

// Ranges and bearings, of which either may be blank, in single rows or all of them.
void read_measured(const CsvTable& table, LandmarkData& data, Facts& facts) {
  const std::vector<double> blank(table.rows(), std::numeric_limits<double>::quiet_NaN());
  const auto column = [&](const char* name) {
    return table.has(name) ? table.numbers_or_blank(name) : blank;
  };
  data.range_m = column(kLandmarkColumns[0]);
  data.bearing_rad = column(kLandmarkColumns[1]);
  const std::array<const std::vector<double>*, 2> values = {&data.range_m, &data.bearing_rad};
  int channels = 0;
  for (size_t c = 0; c < 2; ++c) {
    const bool any = std::any_of(values[c]->begin(), values[c]->end(),
                                 [](double value) { return !std::isnan(value); });
    if (any) data.channels[c] = channels++;
  }
  if (channels == 0)
    throw InputError(
        fmt::format("{}: found no value in columns {} and {}, expected ranges, "
                    "bearings or both",
                    table.file(), kLandmarkColumns[0], kLandmarkColumns[1]));
  size_t without = 0;
  for (size_t row = 0; row < table.rows(); ++row) {
    std::array<int, 2> scalars = {-1, -1};
    for (size_t c = 0; c < 2; ++c) {
      if (std::isnan((*values[c])[row])) continue;
      scalars[c] = static_cast<int>(facts.scalars());
      facts.row_of.push_back(static_cast<int>(row));
      facts.channel_of.push_back(data.channels[c]);
    }
    without += scalars[0] < 0 && scalars[1] < 0;
    data.scalars.push_back(scalars);
  }
  if (without > 0)
    facts.notes.push_back(
        fmt::format("{} of {} observations hold neither range nor bearing", without, table.rows()));
}

}  // namespace

LandmarkData read_landmarks(const MeasurementSet& set, bool measured, Facts& facts) {
  LandmarkData data;
  std::vector<std::string> runs;
  int64_t reference_ns = 0;
  read_walks(set, data, runs, reference_ns);
  const Places landmarks = read_places(set, data.heights);
  if (!data.heights && data.walks.front().z)
    facts.notes.push_back(
        "poses state heights (z_m) and landmarks do not: all is taken to lie in a plane");
  const CsvTable table = set.table("observations");
  if (table.rows() == 0) throw InputError(table.file() + ": no rows, expected observations");
  facts.set.kind = effects::kLandmarks;
  facts.title = set.title;
  facts.file = table.file();
  if (measured)
    read_measured(table, data, facts);
  else
    data.range_m.assign(table.rows(), 1);
  data.landmark_of_row = number_groups(table.texts("landmark"), data.landmarks);
  std::vector<std::string> frames = read_rows(set, table, runs, reference_ns, landmarks, data);
  for (size_t row = 0; row < table.rows(); ++row) facts.line_of_row.push_back(table.line(row));
  const std::vector<std::string> groups =
      table.has(set.group) ? table.texts(set.group) : time_blocks(data.stamp_s);
  facts.group_of_row = number_groups(groups, facts.groups);
  // A frame lies within one group.
  for (size_t row = 0; row < frames.size(); ++row) frames[row] += "|" + groups[row];
  std::vector<std::string> frame_names;
  const std::vector<int> frame_of_row = number_groups(frames, frame_names);
  data.rows_of_frame.resize(frame_names.size());
  for (size_t row = 0; row < frames.size(); ++row)
    data.rows_of_frame[frame_of_row[row]].push_back(static_cast<int>(row));
  facts.time_of_row = data.stamp_s;
  for (size_t row = 0; row < table.rows(); ++row) {
    facts.series_of_row.push_back(data.walk_of_row[row] * static_cast<int>(data.landmarks.size()) +
                                  data.landmark_of_row[row]);
  }
  data.further = further_columns(table, kColumns);
  std::ranges::move(table.incomplete_columns(kColumns), std::back_inserter(facts.notes));
  for (size_t c = 0; measured && c < data.further.names.size(); ++c)
    facts.covariates.push_back({.name = data.further.names[c], .values = data.further.values[c]});
  return data;
}

}  // namespace seam::measurement
