#include "measurement/sets/set.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "effects/kind.h"
#include "sim_core/base/error.h"
#include "sim_core/base/files.h"
#include "sim_core/base/hash.h"
#include "sim_core/input/file_names.h"

namespace seam::measurement {
namespace {

const std::vector<std::string> kKeys = {"format", "kind",     "title",       "camera",
                                        "noise",  "group",    "files",       "rig",
                                        "scene",  "detector", "colour_table"};

CameraFacts read_camera(const ConfigNode& node) {
  CameraFacts camera;
  camera.width_px = static_cast<int>(node.at("width_px").integer(1, 100000));
  camera.height_px = static_cast<int>(node.at("height_px").integer(1, 100000));
  camera.frame_period_s = node.number_or("frame_period_s", 0, {0, 1e6});
  camera.channels = node.text_or("channels", "grey");
  camera.bits = static_cast<int>(node.integer_or("bits", 8, 1, 16));
  return camera;
}

// Unknown keys that look like a slip are errors; others are notes that people add to their data.
void refuse_misspelt(const ConfigNode& node, const std::vector<std::string>& known) {
  for (const std::string& key : node.keys()) {
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    const std::string hint = suggestion_for(key, known);
    if (hint.find("did you mean") != std::string::npos) node.at(key).fail("unknown key" + hint);
  }
}

}  // namespace

MeasurementSet MeasurementSet::open(const std::filesystem::path& path) {
  const bool is_folder = std::filesystem::is_directory(path);
  const std::filesystem::path yaml = is_folder ? path / "measurement.yaml" : path;
  MeasurementSet set{.folder = yaml.parent_path(), .root = ConfigNode::from_file(yaml)};
  const ConfigNode& root = set.root;
  if (!root.is_map()) root.fail("expected a map");
  root.at("format").choice({"seam-measurement/1"});
  const effects::KindFacts& kind = effects::kinds()[root.at("kind").choice(effects::kind_names())];
  set.kind = kind.name;
  set.title = root.text_or("title", set.folder.filename().string());
  if (const auto camera = root.find("camera")) set.camera = read_camera(*camera);
  if (const auto noise = root.find("noise"); noise && noise->is_map()) {
    for (const std::string& column : noise->keys()) {
      const ConfigNode value = noise->at(column);
      if (value.is_null()) continue;
      const double sigma = value.number({0, 1e300});
      if (sigma > 0) set.noise[column] = sigma;
    }
  }
  set.group = root.text_or("group", kind.group);
  const ConfigNode files = root.at("files");
  for (const std::string& name : files.keys()) {
    set.inside(files.at(name));
    set.files[name] = files.at(name).text();
  }
  refuse_misspelt(root, kKeys);
  return set;
}

std::filesystem::path MeasurementSet::file(const std::string& name) const {
  const auto found = files.find(name);
  if (found == files.end())
    root.at("files").fail(fmt::format("'{}' is missing: a set of kind {} needs it", name, kind));
  return folder / found->second;
}

CsvTable MeasurementSet::table(const std::string& name) const {
  CsvTable table = CsvTable::read(file(name));
  table.exchange(exchanged.first, exchanged.second);
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
