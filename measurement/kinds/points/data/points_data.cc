#include "measurement/kinds/points/data/points_data.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>

#include "effects/stages/geometry.h"
#include "measurement/numerics/robust.h"
#include "measurement/sets/further_columns.h"
#include "measurement/sets/noise_bounds.h"
#include "measurement/sets/pose_of_view.h"
#include "measurement/sets/temperatures.h"
#include "sim_core/base/error.h"

namespace seam::measurement {
namespace {

const std::vector<std::string> kColumns = {"frame", "time_s", "point", "x_m",   "y_m",
                                           "z_m",   "u_px",   "v_px",  "camera"};

Covariate named(const std::string& name, std::vector<double> values,
                Covariate::Type type = Covariate::Type::smooth) {
  return {.name = name, .type = type, .values = std::move(values)};
}

// What one camera shows in one frame, of a set whose poses are not known.
struct ViewShown {
  std::string name;
  int frame = 0;
  std::vector<Vec3> points_m, image_px;
  std::string lack;  // Why its points fix no pose; empty: they do.
};

std::vector<ViewShown> views_shown(const MeasurementSet& set, const CsvTable& table,
                                   std::vector<int>& view_of_row) {
  std::vector<std::string> names;
  std::vector<std::string> of_row = table.texts("frame");
  std::vector<std::string> frames;
  const std::vector<int> frame_of_row = number_groups(of_row, frames);
  for (size_t row = 0; row < table.rows() && table.has("camera"); ++row)
    of_row[row] += fmt::format(" of camera {}", table.cell(row, "camera"));
  view_of_row = number_groups(of_row, names);
  const std::vector<double> x = table.numbers("x_m"), y = table.numbers("y_m"),
                            z = table.numbers("z_m"), u = table.numbers("u_px"),
                            v = table.numbers("v_px");
  const bool weighted = table.has("weight");
  std::vector<ViewShown> views(names.size());
  for (size_t row = 0; row < table.rows(); ++row) {
    ViewShown& view = views[static_cast<size_t>(view_of_row[row])];
    view.frame = frame_of_row[row];
    if (weighted && table.cell(row, "weight") == "0") continue;  // Takes no part.
    view.points_m.emplace_back(x[row], y[row], z[row]);
    view.image_px.emplace_back(u[row], v[row], 0);
  }
  const std::optional<double> noise_px = stated_noise_px(set, table);
  for (size_t i = 0; i < views.size(); ++i) {
    views[i].name = names[i];
    views[i].lack = why_no_pose(views[i].points_m, views[i].image_px, noise_px);
  }
  return views;
}

// A view whose pose is not known, and whose points do not fix one, constrains nothing: its rows
// take no part, and the facts say so. Few points do where another camera sees the same frame.
void leave_out_poor_views(const MeasurementSet& set, CsvTable& table, Facts& facts) {
  std::vector<int> view_of_row;
  std::vector<ViewShown> views = views_shown(set, table, view_of_row);
  std::set<int> posed;
  for (const ViewShown& view : views) {
    if (view.lack.empty()) posed.insert(view.frame);
  }
  std::map<std::string, std::vector<std::string>> poor;  // Names of views by what they lack.
  for (ViewShown& view : views) {
    if (view.points_m.size() < kPointsOfPose && posed.contains(view.frame)) view.lack.clear();
    if (!view.lack.empty()) poor[view.lack].push_back(view.name);
  }
  for (const auto& [lack, names] : poor) {
    if (names.size() == views.size())
      throw InputError(fmt::format("{}: every view (frame) shows {}", table.file(), lack));
    const size_t told = std::min<size_t>(names.size(), 8);
    facts.notes.push_back(fmt::format(
        "frame {}{} left out, {} of {} views: they show {}",
        fmt::join(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(told), ", "),
        told < names.size() ? fmt::format(" and {} more", names.size() - told) : "", names.size(),
        views.size(), lack));
  }
  if (posed.empty())
    throw InputError(fmt::format("{}: no view (frame) fixes a pose. {}", table.file(),
                                 fmt::join(facts.notes, ". ")));
  std::vector<char> kept;
  for (const int view : view_of_row) kept.push_back(views[static_cast<size_t>(view)].lack.empty());
  table.keep_rows(kept);
}

// Places of the target's points from an earlier fit, by name; points that it lacks stay as the set
// has them.
void take_places(const std::filesystem::path& path, const std::vector<std::string>& names,
                 PointsData& data, Facts& facts) {
  const CsvTable table = CsvTable::read(path);
  const std::vector<std::string> known = table.texts("point");
  const std::vector<double> x = table.numbers("x_m"), y = table.numbers("y_m"),
                            z = table.numbers("z_m");
  std::map<std::string, Vec3> place_of;
  for (size_t i = 0; i < known.size(); ++i) {
    if (!place_of.emplace(known[i], Vec3(x[i], y[i], z[i])).second)
      table.fail(i, "point", known[i], "each point once");
  }
  size_t missing = 0;
  for (const std::string& name : names) missing += !place_of.contains(name);
  if (missing == names.size())
    throw InputError(fmt::format("{}: holds none of the points of {}, expected the same names",
                                 table.file(), facts.file));
  if (missing > 0)
    facts.notes.push_back(fmt::format("{} of {} points are not in {} and stay as the set has them",
                                      missing, names.size(), table.file()));
  for (size_t row = 0; row < data.p_W.size(); ++row) {
    const auto found = place_of.find(names[static_cast<size_t>(data.point_of_row[row])]);
    if (found != place_of.end()) data.p_W[row] = found->second;
  }
}

// Places of an earlier fit that lie on a line are none of a target.
void refuse_places_without_pose(const MeasurementSet& set, const CsvTable& table,
                                const PointsData& data) {
  const std::optional<double> noise_px = stated_noise_px(set, table);
  std::string lack;
  for (const std::vector<int>& rows : data.rows_of_view) {
    std::vector<Vec3> points_m, image_px;
    for (const int row : rows) {
      points_m.push_back(data.p_W[row]);
      image_px.emplace_back(data.u_px[row], data.v_px[row], 0);
    }
    lack = why_no_pose(points_m, image_px, noise_px);
    if (lack.empty()) return;
  }
  throw InputError(fmt::format(
      "{}: with these places every view of {} shows {}; expected where the points of the target "
      "were found (--target-out)",
      set.target.string(), table.file(), lack));
}

// Noise that rows state for themselves: sigma_px, or a weight that divides the channel's variance.
void check_spread(const CsvTable& table) {
  const bool stated = table.has("sigma_px"), weighted = table.has("weight");
  if (!stated && !weighted) return;
  if (stated && weighted)
    throw InputError(table.file() +
                     ": found columns sigma_px and weight, expected one of them: both say how "
                     "noisy a row is");
  const std::string column = stated ? "sigma_px" : "weight";
  const std::vector<double> values = table.numbers(column);
  for (size_t row = 0; row < table.rows(); ++row) {
    if (values[row] >= kLeastNoise && values[row] <= kMostNoise) continue;
    if (stated || values[row] != 0)
      table.fail(row, column, table.cell(row, column),
                 fmt::format("{} from {:g} to {:g}",
                             stated ? "a standard deviation" : "a weight, 0 (takes no part) or",
                             kLeastNoise, kMostNoise));
  }
}

void read_spread(const CsvTable& table, PointsData& data) {
  if (table.has("sigma_px")) {
    data.spread = table.numbers("sigma_px");
    data.sigma_px = median_of(data.spread);
    for (double& sigma : data.spread) sigma /= data.sigma_px;
  } else if (table.has("weight")) {
    data.spread = table.numbers("weight");
    for (double& weight : data.spread) weight = weight > 0 ? 1 / std::sqrt(weight) : 0;
  }
}

void read_exposures(const CsvTable& table, PointsData& data) {
  if (!table.has("exposure_s")) return;
  constexpr double kLongest_s = 3600;
  data.exposure_s = table.numbers("exposure_s");
  for (size_t row = 0; row < table.rows(); ++row) {
    if (!(data.exposure_s[row] >= 0 && data.exposure_s[row] <= kLongest_s))
      table.fail(row, "exposure_s", table.cell(row, "exposure_s"),
                 "how long the frame was exposed, seconds");
  }
}

// The gyroscope has to read while any row of a view may be read.
void read_gyroscope_beside(const MeasurementSet& set, const CsvTable& table, PointsData& data) {
  if (!set.has_file("imu"))
    set.root.at("files").fail(
        "found no table imu, expected one with the gyroscope's readings beside rig: imu (motion: "
        "imu): files: {points: points.csv, imu: imu.csv}");
  auto beside = std::make_shared<GyroscopeBeside>();
  int64_t first_ns = 0;
  beside->readings = read_gyroscope(set, first_ns);
  beside->first_s = 1e-9 * static_cast<double>(first_ns - data.rig.reference_ns());
  const double usual_s = usual_step_s(beside->readings);
  for (size_t row = 0; row < table.rows(); ++row) {
    const double from_s = data.stamp_s[row] - beside->first_s;
    if (reads_all(beside->readings, usual_s, from_s, from_s + data.camera.frame_period_s)) continue;
    table.fail(
        row, "time_s", table.cell(row, "time_s"),
        fmt::format("a view during which {} reads without a gap, {:.3f} s to {:.3f} s: leave "
                    "out the views that it does not cover",
                    set.file("imu").filename().string(), 1e-9 * static_cast<double>(first_ns),
                    1e-9 * static_cast<double>(first_ns) + beside->readings.at_s.back()));
  }
  data.gyroscope = std::move(beside);
}

// Cameras on one rig, in the order in which the table names them.
void read_cameras(const CsvTable& table, PointsData& data) {
  std::vector<std::string> names = {""};
  data.camera_of_row.assign(table.rows(), 0);
  if (table.has("camera"))
    names.clear(), data.camera_of_row = number_groups(table.texts("camera"), names);
  for (const std::string& name : names)
    data.cameras.push_back({name, data.camera.width_px, data.camera.height_px});
  std::map<std::pair<int, int>, int> views;
  for (size_t row = 0; row < table.rows(); ++row) {
    const auto view = views.emplace(std::pair(data.frame_of_row[row], data.camera_of_row[row]),
                                    static_cast<int>(views.size()));
    if (view.second) data.rows_of_view.emplace_back();
    data.view_of_row.push_back(view.first->second);
    data.rows_of_view[static_cast<size_t>(view.first->second)].push_back(static_cast<int>(row));
  }
}

}  // namespace

PointsData read_points(const MeasurementSet& set, bool measured, Facts& facts) {
  return read_points(set, Rig::from_set(set), measured, facts);
}

PointsData read_points(const MeasurementSet& set, Rig rig, bool measured, Facts& facts) {
  PointsData data{.rig = std::move(rig), .camera = set.camera};
  if (data.camera.width_px == 0) set.root.at("camera").fail("missing");
  CsvTable table = set.table("points");
  if (table.rows() == 0) throw InputError(table.file() + ": no rows, expected observations");
  if (measured) check_spread(table);
  if (measured && data.rig.type() == Rig::Type::unknown) leave_out_poor_views(set, table, facts);
  facts.set.kind = effects::kPoints;
  facts.title = set.title;
  facts.width_px = data.camera.width_px, facts.height_px = data.camera.height_px;
  facts.file = table.file();
  const std::vector<int64_t> ns = table.times_ns("time_s");
  if (data.rig.type() == Rig::Type::unknown)
    data.rig.set_reference_ns(*std::min_element(ns.begin(), ns.end()));
  const std::vector<double> x = table.numbers("x_m"), y = table.numbers("y_m"),
                            z = table.numbers("z_m");
  data.u_px = measured ? table.numbers("u_px") : std::vector<double>(table.rows(), 0);
  data.v_px = measured ? table.numbers("v_px") : std::vector<double>(table.rows(), 0);
  if (measured) read_spread(table, data);
  data.frame_of_row = number_groups(table.texts("frame"), data.frames);
  data.rows_of_frame.resize(data.frames.size());
  read_cameras(table, data);
  read_exposures(table, data);
  facts.group_of_row = number_groups(table.texts(set.group), facts.groups);
  std::vector<int> group_of_frame(data.frames.size(), -1);
  for (size_t row = 0; row < table.rows(); ++row) {
    data.p_W.emplace_back(x[row], y[row], z[row]);
    data.stamp_s.push_back(1e-9 * static_cast<double>(ns[row] - data.rig.reference_ns()));
    if (data.rig.type() != Rig::Type::unknown &&
        (data.stamp_s[row] < data.rig.first_s() - 1 || data.stamp_s[row] > data.rig.last_s() + 1)) {
      table.fail(row, "time_s", table.cell(row, "time_s"), "a time within the log of the rig");
    }
    int& group = group_of_frame[data.frame_of_row[row]];
    if (group >= 0 && group != facts.group_of_row[row]) {
      table.fail(row, set.group, table.cell(row, set.group), "one group for all rows of a frame");
    }
    group = facts.group_of_row[row];
    data.rows_of_frame[data.frame_of_row[row]].push_back(static_cast<int>(row));
    facts.line_of_row.push_back(table.line(row));
    for (int channel = 0; channel < 2; ++channel) {
      facts.row_of.push_back(static_cast<int>(row));
      facts.channel_of.push_back(channel);
    }
  }
  if (data.rig.type() == Rig::Type::unknown && data.rig.path() == Rig::Path::beside_gyroscope)
    read_gyroscope_beside(set, table, data);
  std::vector<std::string> names;
  data.point_of_row = number_groups(table.texts("point"), names);
  if (!set.target.empty()) {
    take_places(set.target, names, data, facts);
    if (measured && data.rig.type() == Rig::Type::unknown)
      refuse_places_without_pose(set, table, data);
  }
  data.target = target_of_rows(names, data.point_of_row, data.p_W, data.frame_of_row);
  facts.time_of_row = data.stamp_s;
  facts.series_of_row = data.view_of_row;
  facts.tests_neighbours = false;
  data.further = further_columns(table, kColumns);
  std::ranges::move(table.incomplete_columns(kColumns), std::back_inserter(facts.notes));
  for (size_t c = 0; c < data.further.names.size(); ++c) {
    if (data.further.names[c] == kTemperature) check_temperatures(table, data.further.values[c]);
  }
  for (size_t j = 0; j < data.rig.joint_names().size(); ++j) {
    data.further.names.push_back(data.rig.joint_names()[j]);
    std::vector<double>& angle = data.further.values.emplace_back();
    for (const double t : data.stamp_s) angle.push_back(data.rig.logged(j).value(t));
  }
  if (measured) add_points_covariates(data, facts);
  return data;
}

void place_covariates(const PointsData& data, const std::vector<double>& residual, Facts& facts) {
  const size_t n = data.u_px.size();
  std::vector<double> row(n), column(n), radius(n);
  // Along the radius and across it: lenses push points along it.
  CombinedChannel along{.name = "radial_px"}, across{.name = "tangential_px"};
  for (size_t i = 0; i < n; ++i) {
    column[i] = data.u_px[i] - residual[2 * i];
    row[i] = data.v_px[i] - residual[2 * i + 1];
    radius[i] = effects::rho(column[i], row[i], data.camera.width_px, data.camera.height_px);
    const double du = column[i] - 0.5 * (data.camera.width_px - 1),
                 dv = row[i] - 0.5 * (data.camera.height_px - 1);
    const double length = std::sqrt(du * du + dv * dv);
    along.weight_a.push_back(length > 0 ? du / length : 1);
    along.weight_b.push_back(length > 0 ? dv / length : 0);
    across.weight_a.push_back(-along.weight_b.back());
    across.weight_b.push_back(along.weight_a.back());
  }
  facts.combined = {std::move(along), std::move(across)};
  facts.covariates[0].values = std::move(row);
  facts.covariates[1].values = std::move(column);
  facts.covariates[2].values = std::move(radius);
}

void add_points_covariates(const PointsData& data, Facts& facts) {
  auto& all = facts.covariates;
  for (const char* name : {"row", "column", "radius"}) all.push_back(named(name, {}));
  place_covariates(data, std::vector<double>(2 * data.u_px.size(), 0), facts);
  const auto [first, last] = std::minmax_element(data.stamp_s.begin(), data.stamp_s.end());
  if (*last > *first) all.push_back(named("time", data.stamp_s));
  const size_t of_table = data.further.names.size() - data.rig.joint_names().size();
  for (size_t j = 0; j < data.rig.joint_names().size(); ++j) {
    std::vector<double> rate, sign;
    for (const double t : data.stamp_s) {
      rate.push_back(data.rig.logged(j).rate(t));
      sign.push_back(rate.back() > 0 ? 1 : rate.back() < 0 ? -1 : 0);
    }
    const std::string& name = data.rig.joint_names()[j];
    all.push_back(named(name, data.further.values[of_table + j]));
    all.push_back(named(name + "_rate", std::move(rate)));
    all.push_back(named("sign(" + name + "_rate)", std::move(sign), Covariate::Type::sign));
  }
  if (data.rig.type() != Rig::Type::unknown) {
    const Model none =
        Model::from_config(ConfigNode::from_text("format: seam-model/1\neffects: {}\n", "none"));
    const Rig::Motion motion = data.rig.motion(none);
    std::vector<double> range;
    for (size_t i = 0; i < data.p_W.size(); ++i)
      range.push_back(glm::length(data.p_W[i] - motion.X_WC(data.stamp_s[i]).p));
    all.push_back(named("range", std::move(range)));
  }
  const std::vector<int>& points = data.point_of_row;
  if (data.target.names.size() > 1 && data.target.names.size() * 4 < points.size()) {
    all.push_back(named("point", {points.begin(), points.end()}, Covariate::Type::category));
  }
  if (data.rows_of_frame.size() > 1) {
    all.push_back(named("frame", {data.frame_of_row.begin(), data.frame_of_row.end()},
                        Covariate::Type::category));
  }
  if (data.cameras.size() > 1) {
    all.push_back(named("camera", {data.camera_of_row.begin(), data.camera_of_row.end()},
                        Covariate::Type::category));
  }
  for (size_t c = 0; c < of_table; ++c)
    all.push_back(named(data.further.names[c], data.further.values[c]));
}

}  // namespace seam::measurement
