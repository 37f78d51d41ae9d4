#include "app/import/servo/feature_names.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "app/import/files/source_file.h"
#include "sim_core/base/error.h"
#include "sim_core/input/json_input.h"

namespace seam::app {
namespace {

using nlohmann::json;

// A list of names, or lists by what they are: {"motors": [...]}.
std::vector<std::string> names_in(const json& value) {
  std::vector<std::string> names;
  if (value.is_array()) {
    for (const json& name : value) {
      if (!name.is_string()) return {};
      names.push_back(name.get<std::string>());
    }
  } else if (value.is_object()) {
    for (const auto& [key, list] : value.items()) {
      const auto more = names_in(list);
      names.insert(names.end(), more.begin(), more.end());
    }
  }
  return names;
}

size_t columns_of(const SignalLog& log, const std::string& feature) {
  size_t count = 0;
  while (log.find({fmt::format("{}[{}]", feature, count)}) >= 0) ++count;
  return count;
}

void name_feature(SignalLog& log, const std::string& feature,
                  const std::vector<std::string>& names) {
  const size_t count = columns_of(log, feature);
  if (count == 0 || names.empty()) return;
  if (count != names.size())
    throw InputError(fmt::format("{}: {} has {} numbers, expected as many as there are names: {}",
                                 log.file, feature, count, names.size()));
  std::vector<size_t> places;
  for (size_t i = 0; i < count; ++i)
    places.push_back(static_cast<size_t>(log.find({fmt::format("{}[{}]", feature, i)})));
  for (size_t i = 0; i < count; ++i)
    log.names[places[i]] = log.full_names[places[i]] = feature + "." + names[i];
}

}  // namespace

bool is_feature_file(const std::filesystem::path& path) {
  return path.filename() == "info.json" || path.filename() == "schema.json";
}

FeatureNames read_feature_names(const std::filesystem::path& path) {
  const json root = json_from_text(read_source(path), path.string(), "a data set's features");
  if (!root.is_object() || !root.contains("features") || !root["features"].is_object())
    throw InputError(fmt::format(
        "{}: features: missing, expected the names of a data set's numbers", path.string()));
  FeatureNames found;
  for (const auto& [feature, facts] : root["features"].items())
    if (facts.is_object() && facts.contains("names")) found[feature] = names_in(facts["names"]);
  return found;
}

void name_features(SignalLog& log, const FeatureNames& names) {
  for (const auto& [feature, list] : names) name_feature(log, feature, list);
  constexpr std::string_view kNames = ".names";
  for (const auto& [key, list] : log.lists)
    if (key.ends_with(kNames)) name_feature(log, key.substr(0, key.size() - kNames.size()), list);
}

}  // namespace seam::app
