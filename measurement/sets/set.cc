#include "measurement/sets/set.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "effects/kind.h"
#include "measurement/sets/noise_bounds.h"
#include "measurement/sets/rig_keys.h"
#include "sim_core/base/error.h"
#include "sim_core/base/files.h"
#include "sim_core/base/hash.h"
#include "sim_core/input/config_table.h"
#include "sim_core/input/file_names.h"

namespace seam::measurement {
namespace {

constexpr double kLargest = 1e300;

void describe_camera(ConfigTable& table, CameraFacts& camera) {
  table.allow_notes();
  int64_t width = camera.width_px, height = camera.height_px, bits = camera.bits;
  table.integer({"width_px", "Of its images.", true}, width, 1, 100000);
  table.integer({"height_px", "Of its images.", true}, height, 1, 100000);
  table.number({"frame_period_s", "From frame to frame, s."}, camera.frame_period_s, {0, 1e6});
  table.text({"channels", "grey or rgb."}, camera.channels);
  table.integer({"bits", "Of a sample."}, bits, 1, 16);
  camera.width_px = static_cast<int>(width), camera.height_px = static_cast<int>(height);
  camera.bits = static_cast<int>(bits);
}

// Of outcomes; their reader reads them (kinds/outcomes).
void describe_runs(ConfigTable& table) {
  std::map<std::string, std::string> scenarios;
  std::vector<std::string> robots;
  int64_t most_runs = kUsualMostRuns;
  table.texts_by_name(
      {"scenarios", "Of outcomes: plans of runs (seam-sweep/1) in the folder by name."}, scenarios);
  table.texts({"robots", "Of outcomes: the robots whose model it is; left out: all."}, robots);
  table.integer({"most_runs", "Of outcomes: runs that one command may make."}, most_runs, 1,
                kMostRuns);
  table.elsewhere({"candidates",
                   "Of outcomes: effects that are tried, each blank or with parameters' bounds "
                   "[low, high]; left out: all."},
                  [](ConfigTable& names) { names.allow_notes(); });
}

// Of inertial sensors; their reader reads it (kinds/imu).
void describe_imu(ConfigTable& table) {
  double gravity_mps2 = 9.80665;
  table.number(
      {"gravity_mps2", "Of imu: the size of the force that the accelerometer feels at rest."},
      gravity_mps2, {0.1, 100});
  double rate_hz = 0;
  table.number({"rate_hz",
                "Of imu: samples a second by the sensor's own clock, as its data sheet "
                "has it: the set's time stamps then tell of that clock."},
               rate_hz, {1e-3, 1e6});
}

void describe_set(ConfigTable& table, MeasurementSet& set) {
  table.allow_notes();
  table.format("seam-measurement/1");
  size_t kind = 0;
  table.choice({"kind", "What was measured.", true}, kind, effects::kind_names());
  set.kind = effects::kinds()[kind].name;
  table.text({"title", "A line for people; the folder's name where not given."}, set.title);
  table.object({"camera", "Of sets with images or places in them."},
               [&](ConfigTable& camera) { describe_camera(camera, set.camera); });
  table.numbers_by_name(
      {"noise", "One sigma of a single observation by column; left out: it is estimated."},
      set.noise, {0, kLargest});
  set.group = effects::kinds()[kind].group;
  table.text({"group", "The column whose groups are held out whole."}, set.group);
  table.texts_by_name({"files", "The set's tables by name, in the folder.", true}, set.files);
  const ConfigKey rig = {"rig",
                         "Of points and frames: where the camera is; imu is short for "
                         "{pose: unknown, motion: imu}."};
  // A schema says that a word may stand for the map.
  if (table.names_alternatives())
    table.file_or_object(rig, describe_rig_keys);
  else
    table.elsewhere(rig, describe_rig_keys);
  std::string joint, scene, detector, colour_table;
  table.text({"joint", "Of joints: the one whose rows are read; left out: all."}, joint);
  table.text({"scene", "Of frames and ranges: a seam-scene/1 file in the folder."}, scene);
  table.text({"detector", "Of ranges: the behaviour that measures."}, detector);
  table.text({"colour_table", "Of ranges: a seam-colour-table/1 file in the folder."},
             colour_table);
  describe_runs(table);
  describe_imu(table);
}

// Further tables may have any name, but hardly one that is nearly a name that is read.
void refuse_misspelt(const ConfigNode& files, const std::string& name) {
  static const std::vector<std::string> kTables = {
      "points", "poses",  "joints",   "odometry", "landmarks", "observations",
      "frames", "ranges", "outcomes", "imu",      "attitudes"};
  if (std::find(kTables.begin(), kTables.end(), name) != kTables.end()) return;
  const std::string suggestion = suggestion_for(name, kTables);
  if (suggestion.starts_with(", did you mean"))
    files.fail(fmt::format("unknown table '{}'{}", name, suggestion));
}

}  // namespace

MeasurementSet MeasurementSet::open(const std::filesystem::path& path) {
  const bool is_folder = std::filesystem::is_directory(path);
  const std::filesystem::path yaml = is_folder ? path / "measurement.yaml" : path;
  MeasurementSet set{.folder = yaml.parent_path(), .root = ConfigNode::from_file(yaml)};
  const ConfigNode& root = set.root;
  if (!root.is_map()) root.fail("expected a map");
  root.at("format");
  set.title = set.folder.filename().string();
  read_config(root, [&](ConfigTable& table) { describe_set(table, set); });
  std::erase_if(set.noise, [](const auto& entry) { return !(entry.second > 0); });
  for (const auto& [column, sigma] : set.noise) {
    if (sigma < kLeastNoise || sigma > kMostNoise)
      root.at("noise").fail(fmt::format(
          "{}: found {:g}, expected {:g} to {:g} in the column's unit (left out: it is estimated)",
          column, sigma, kLeastNoise, kMostNoise));
  }
  const ConfigNode files = root.at("files");
  for (const std::string& name : files.keys()) {
    refuse_misspelt(files, name);
    set.inside(files.at(name));
  }
  return set;
}

std::string MeasurementSet::schema() {
  MeasurementSet set{.root = ConfigNode::from_text("{}", "schema")};
  return config_schema("SEAM measurement set",
                       [&](ConfigTable& table) { describe_set(table, set); });
}

std::filesystem::path MeasurementSet::file(const std::string& name) const {
  const auto found = files.find(name);
  if (found == files.end())
    root.at("files").fail(fmt::format("'{}' is missing: a set of kind {} needs it", name, kind));
  return folder / found->second;
}

namespace {

// By row: whether it is one of the first so many of its group.
std::vector<char> first_of_each(const CsvTable& table, const std::string& group, size_t most) {
  std::vector<std::string> names;
  const std::vector<int> group_of = number_groups(table.texts(group), names);
  const std::vector<double> time_s = table.numbers("time_s");
  std::vector<std::vector<double>> times(names.size());
  for (size_t row = 0; row < table.rows(); ++row) times[group_of[row]].push_back(time_s[row]);
  for (std::vector<double>& of_group : times) {
    const auto last =
        of_group.begin() + static_cast<ptrdiff_t>(std::min(most, of_group.size())) - 1;
    std::nth_element(of_group.begin(), last, of_group.end());
    of_group = {*last};
  }
  std::vector<char> kept(table.rows());
  for (size_t row = 0; row < table.rows(); ++row)
    kept[row] = time_s[row] <= times[group_of[row]][0];
  return kept;
}

// Leaves out the rows of all joints but one.
void keep_joint(const ConfigNode& joint, CsvTable& table) {
  const std::string name = joint.text();
  const std::vector<std::string> joints = table.texts("joint");
  std::vector<char> kept;
  for (const std::string& one : joints) kept.push_back(one == name);
  if (std::find(joints.begin(), joints.end(), name) == joints.end())
    joint.fail(fmt::format("{} has no rows of joint '{}'{}", table.file(), name,
                           suggestion_for(name, joints)));
  table.keep_rows(kept);
}

}  // namespace

CsvTable MeasurementSet::table(const std::string& name) const {
  CsvTable table = CsvTable::read(file(name));
  if (kind == "joints" && name == "joints" && root.has("joint"))
    keep_joint(root.at("joint"), table);
  left_out.take_from(name, table);
  table.exchange(exchanged.first, exchanged.second);
  if (beginning.rows > 0 && name == beginning.table)
    table.keep_rows(first_of_each(table, group, beginning.rows));
  return table;
}

std::filesystem::path MeasurementSet::inside(const ConfigNode& name) const {
  const std::string why = why_not_inside(folder, name.text());
  if (!why.empty()) name.fail(why);
  return folder / name.text();
}

std::filesystem::path MeasurementSet::inside(const CsvTable& table, size_t row,
                                             std::string_view column) const {
  const std::string name(table.cell(row, column));
  const std::string why = why_not_inside(folder, name);
  if (!why.empty())
    throw InputError(
        fmt::format("{}:{}: column {}: {}", table.file(), table.line(row), column, why));
  return folder / name;
}

double MeasurementSet::noise_of(const std::string& column) const {
  const auto given = noise.find(column);
  return given == noise.end() ? 0 : given->second;
}

std::string MeasurementSet::fingerprint() const {
  Hasher hasher;
  hasher.add(read_file(root.file()));
  for (const auto& [name, relative] : files) {
    hasher.add(name);
    hasher.add(read_file(folder / relative));
  }
  for (const auto& [name, lines] : left_out.lines) {
    hasher.add(name);
    for (const int line : lines) hasher.add(int64_t{line});
  }
  return to_hex(hasher.digest());
}

std::vector<char> held_out_groups(const std::vector<std::string>& group_ids) {
  constexpr uint64_t kSeed = 0x5EA3;
  std::vector<std::pair<uint64_t, size_t>> order;
  for (size_t i = 0; i < group_ids.size(); ++i) {
    Hasher hasher;
    hasher.add(kSeed);
    hasher.add(group_ids[i]);
    order.emplace_back(hasher.digest(), i);
  }
  std::sort(order.begin(), order.end());
  std::vector<char> held_out(group_ids.size(), 0);
  const size_t count =
      static_cast<size_t>(std::ceil(0.3 * static_cast<double>(group_ids.size()) - 1e-9));
  for (size_t i = 0; i < count; ++i) held_out[order[i].second] = 1;
  return held_out;
}

std::vector<int> number_groups(const std::vector<std::string>& values,
                               std::vector<std::string>& names) {
  std::unordered_map<std::string, int> number;  // Only looked up, never iterated.
  std::vector<int> groups(values.size());
  for (size_t i = 0; i < values.size(); ++i) {
    const auto [found, is_new] = number.try_emplace(values[i], static_cast<int>(names.size()));
    if (is_new) names.push_back(values[i]);
    groups[i] = found->second;
  }
  return groups;
}

}  // namespace seam::measurement
