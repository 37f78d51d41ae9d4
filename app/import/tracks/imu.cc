// `seam import imu`: tables or bags of ROS with a gyroscope, an accelerometer or both, a file a
// run.
#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "app/import/draft/checks.h"
#include "app/import/files/text_table.h"
#include "app/import/kinds/kinds.h"
#include "app/import/tracks/imu_bag.h"
#include "app/import/tracks/track.h"
#include "measurement/numerics/robust.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

constexpr size_t kAxes = 6;
constexpr double kGravity_mps2 = 9.80665;

// Our names of the quantities, those in the set, and what people call them; axis by axis, the
// gyroscope first.
constexpr std::array<const char*, kAxes> kQuantities = {"gx", "gy", "gz", "ax", "ay", "az"};
constexpr std::array<const char*, kAxes> kColumns = {"wx_radps", "wy_radps", "wz_radps",
                                                     "ax_mps2",  "ay_mps2",  "az_mps2"};

std::vector<std::string> usual_names(size_t axis) {
  const std::string letter(1, "xyz"[axis % 3]);
  std::vector<std::string> names = {kColumns[axis], kQuantities[axis]};
  const std::vector<std::string> of_gyro = {"w",
                                            "gyro",
                                            "gyro_",
                                            "gyr_",
                                            "w_",
                                            "w_RS_S_",
                                            "omega_",
                                            "gyroscope_",
                                            "angular_velocity_",
                                            "angular_velocity.",
                                            "field.angular_velocity.",
                                            "rate_",
                                            "ang_vel_"};
  const std::vector<std::string> of_accel = {"a",
                                             "accel",
                                             "accel_",
                                             "acc_",
                                             "acc",
                                             "a_RS_S_",
                                             "a_",
                                             "accelerometer_",
                                             "linear_acceleration_",
                                             "linear_acceleration.",
                                             "field.linear_acceleration.",
                                             "lin_acc_"};
  for (const std::string& name : axis < 3 ? of_gyro : of_accel) names.push_back(name + letter);
  return names;
}

struct Run {
  std::string name;
  std::vector<int64_t> ns;
  std::vector<int> lines;
  std::array<std::vector<double>, kAxes> values;
  std::vector<double> temperature_c;
};

class ImuImport {
 public:
  ImuImport(const ImportRequest& request, SetDraft& draft) : request_(request), draft_(draft) {}
  void run();

 private:
  void read(const TextTable& table, const std::string& name);
  void read_bag(const std::filesystem::path& bag, const std::string& name);
  void add(Run run, const std::string& file, const RowPlace& place);
  double unit_of(size_t axis, const std::string& column) const;
  void find_gravity();
  std::string white_noise(size_t first, const char* effect, const char* parameter) const;

  const ImportRequest& request_;
  SetDraft& draft_;
  std::vector<Run> runs_;
  std::set<std::string> left_out_;  // Columns.
};

double ImuImport::unit_of(size_t axis, const std::string& column) const {
  if (axis < 3) return radians_of(request_, kQuantities[axis], column);
  const std::string unit = unit_in(column, {"mps2", "m/s^2", "m s^-2", "g", "mg"});
  return unit == "g" ? kGravity_mps2 : unit == "mg" ? 1e-3 * kGravity_mps2 : 1;
}

void ImuImport::read(const TextTable& table, const std::string& name) {
  const int time = column_of(table, request_, "time",
                             {"time_s", "time", "t", "timestamp", "#timestamp", "stamp", "t_ns",
                              "time_ns", "timestamp_ns", "%time", "field.header.stamp"});
  if (time < 0)
    throw InputError(fmt::format("{}:1: expected a column time; say its name with --map time=NAME",
                                 table.file()));
  const auto at = [](int column) { return static_cast<size_t>(column); };
  std::array<int, kAxes> columns{};
  for (size_t axis = 0; axis < kAxes; ++axis)
    columns[axis] = column_of(table, request_, kQuantities[axis], usual_names(axis));
  for (const size_t sensor : {0, 3}) {
    const auto count = std::count_if(&columns[sensor], &columns[sensor] + 3,
                                     [](int column) { return column >= 0; });
    if (count != 0 && count != 3)
      throw InputError(fmt::format(
          "{}:1: found {} of the three axes {}, {}, {}, expected all or none; say their names with "
          "--map",
          table.file(), count, kQuantities[sensor], kQuantities[sensor + 1],
          kQuantities[sensor + 2]));
  }
  if (columns[0] < 0 && columns[3] < 0)
    throw InputError(fmt::format(
        "{}:1: expected columns of a gyroscope (gx, gy, gz) or an accelerometer (ax, ay, az); say "
        "their names with --map gx=NAME,...",
        table.file()));
  const int warmth =
      column_of(table, request_, "temperature", {"temperature_c", "temperature", "temp", "temp_c"});
  std::set<int> taken(columns.begin(), columns.end());
  taken.insert({time, warmth});
  name_beside(table, taken, left_out_);
  Run run{.name = name};
  const int64_t unit = time_unit_of(request_, "time", table.full_name(at(time)));
  for (size_t row = 0; row < table.rows(); ++row) {
    const int64_t ns = time_in(table, row, time, unit);
    if (!run.ns.empty() && ns == run.ns.back()) continue;
    run.ns.push_back(ns), run.lines.push_back(table.line(row));
    for (size_t axis = 0; axis < kAxes; ++axis) {
      if (columns[axis] < 0) continue;
      run.values[axis].push_back(unit_of(axis, table.full_name(at(columns[axis]))) *
                                 table.number_or_blank(row, at(columns[axis])));
    }
    if (warmth >= 0) run.temperature_c.push_back(table.number_or_blank(row, at(warmth)));
  }
  const std::vector<int> lines = run.lines;
  add(std::move(run), table.file() + ":1",
      [&](size_t i) { return fmt::format("{}:{}", table.file(), lines[i]); });
}

void ImuImport::read_bag(const std::filesystem::path& bag, const std::string& name) {
  ImuBag read = read_imu_bag(bag, request_, draft_);
  Run run{.name = name, .ns = std::move(read.ns), .values = std::move(read.values)};
  const std::vector<int64_t> ns = run.ns;
  add(std::move(run), bag.string(), [&](size_t i) {
    return fmt::format("{}: {} at {} s", bag.string(), read.topic, seconds_text(ns[i]));
  });
}

void ImuImport::add(Run run, const std::string& file, const RowPlace& place) {
  check_times(run.ns, place, request_, 1, draft_);
  if (!runs_.empty()) {
    const Run& first = runs_.front();
    for (size_t axis = 0; axis < kAxes; ++axis) {
      if (first.values[axis].empty() != run.values[axis].empty())
        throw InputError(fmt::format("{}: expected the sensors of the first file", file));
    }
    if (first.temperature_c.empty() != run.temperature_c.empty())
      throw InputError(fmt::format("{}: expected a temperature in all files or in none", file));
  }
  runs_.push_back(std::move(run));
}

// An accelerometer at rest that reads about 1 or 1000 reads it in g or mg.
void ImuImport::find_gravity() {
  std::vector<double> sizes;
  for (const Run& run : runs_) {
    for (size_t i = 0; i < run.values[3].size(); ++i) {
      const double size = std::hypot(run.values[3][i], run.values[4][i], run.values[5][i]);
      if (std::isfinite(size)) sizes.push_back(size);
    }
  }
  if (sizes.empty()) return;
  const double usual = measurement::median_of(sizes);
  for (const auto& [unit, size] : {std::pair("g", 1.0), std::pair("mg", 1000.0)}) {
    constexpr double kNear = 0.2;
    if (std::abs(usual - size) > kNear * size) continue;
    for (Run& run : runs_) {
      for (size_t axis = 3; axis < kAxes; ++axis)
        for (double& value : run.values[axis]) value *= kGravity_mps2 / size;
    }
    draft_.did(fmt::format("accelerations from {} to m/s^2: at rest they have the size {:.4g}",
                           unit, usual));
    return;
  }
  constexpr double kFar = 0.2;
  if (std::abs(usual - kGravity_mps2) > kFar * kGravity_mps2)
    draft_.warn(fmt::format(
        "the usual size of the acceleration is {:.4g} m/s^2: a sensor at rest reads 9.8", usual));
}

// From the differences of samples, which all slower noise leaves nearly as they are.
std::string ImuImport::white_noise(size_t first, const char* effect, const char* parameter) const {
  if (runs_.front().values[first].empty()) return "";
  std::string text = effect;
  for (size_t axis = first; axis < first + 3; ++axis) {
    std::vector<double> steps, times;
    for (const Run& run : runs_) {
      for (size_t i = 1; i < run.ns.size(); ++i) {
        const double step = run.values[axis][i] - run.values[axis][i - 1];
        if (std::isfinite(step)) steps.push_back(step);
        times.push_back(1e-9 * static_cast<double>(run.ns[i] - run.ns[i - 1]));
      }
    }
    double squares = 0;
    for (const double step : steps) squares += step * step / static_cast<double>(steps.size());
    const double density = std::sqrt(0.5 * squares * measurement::median_of(times));
    text += fmt::format("    {}_{}: {{value: {:.4g}, free: true}}\n", "xyz"[axis % 3], parameter,
                        std::clamp(density, 1e-9, 1.0));
  }
  return text;
}

void ImuImport::run() {
  std::vector<TextTable> tables;
  for (const auto& source : request_.sources)
    if (!is_ros_bag(source)) tables.push_back(TextTable::read(source));
  if (!tables.empty()) check_columns_met(request_, tables);
  size_t table = 0, number = 0;
  for (const auto& source : request_.sources) {
    ++number;
    const std::string name = request_.sources.size() == 1
                                 ? "1"
                                 : fmt::format("{} {}", number, csv_word(source.stem().string()));
    if (is_ros_bag(source))
      read_bag(source, name);
    else
      read(tables[table++], name);
  }
  find_gravity();
  std::vector<std::string> names = {"run", "time_s"};
  const Run& first = runs_.front();
  for (size_t axis = 0; axis < kAxes; ++axis)
    if (!first.values[axis].empty()) names.emplace_back(kColumns[axis]);
  if (!first.temperature_c.empty()) names.emplace_back("temperature_c");
  measurement::CsvWriter out(names);
  size_t samples = 0;
  for (const Run& run : runs_) {
    samples += run.ns.size();
    for (size_t i = 0; i < run.ns.size(); ++i) {
      std::vector<std::string> cells = {run.name, seconds_text(run.ns[i])};
      const auto add = [&](const std::vector<double>& values) {
        if (!values.empty()) cells.push_back(std::isnan(values[i]) ? "" : exact(values[i]));
      };
      for (const auto& values : run.values) add(values);
      add(run.temperature_c);
      out.row(cells);
    }
  }
  draft_.kind = "imu";
  draft_.group = "run";
  draft_.effects = white_noise(0, "  gyro_white_noise:\n", "radps_rthz") +
                   white_noise(3, "  accel_white_noise:\n", "mps2_rthz");
  draft_.add_table("imu", out);
  draft_.did(
      fmt::format("{} samples in {} run{}", samples, runs_.size(), runs_.size() == 1 ? "" : "s"));
  say_left_out(left_out_, "readings are compared with time and temperature_c alone", draft_);
  draft_.could_not_know(
      "whether the sensor was at rest: stretches in which it moved must go (blank cells), or get "
      "columns of what it truly did (wx_true_radps, ..., ax_true_mps2, ...)");
}

}  // namespace

void import_imu(const ImportRequest& request, SetDraft& draft) {
  ImuImport(request, draft).run();
}

}  // namespace seam::app
