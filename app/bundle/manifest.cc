#include "app/bundle/manifest.h"

#include <nlohmann/json.hpp>
#include <set>

#include "app/bundle/archive.h"
#include "sim_core/base/error.h"
#include "sim_core/input/json_input.h"
#include "sim_core/input/shown_text.h"

namespace seam::app {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kFormat = "seam-bundle/1";

// Throws nlohmann's errors where a key lacks or is of another kind.
BundleManifest manifest_of(const nlohmann::json& json) {
  BundleManifest manifest{.version = json.at("seam").at("version"),
                          .program = json.at("seam").at("program"),
                          .of = json.at("of"),
                          .files = {},
                          .folders = json.at("folders"),
                          .words = json.at("words"),
                          .needs = json.at("needs")};
  for (const nlohmann::json& file : json.at("files"))
    manifest.files.push_back({.name = file.at("name"),
                              .bytes = file.at("bytes"),
                              .sha256 = file.at("sha256"),
                              .program = file.at("program")});
  return manifest;
}

// Empty where all is well.
std::string why_refused(const BundleManifest& manifest) {
  if (manifest.files.size() > kMostBundleFiles)
    return fmt::format("found {} files, expected at most {}", manifest.files.size(),
                       kMostBundleFiles);
  std::set<std::string> names = {kManifestName};
  uint64_t left = kMostBundleBytes;
  for (const BundleFile& file : manifest.files) {
    if (const std::string why = why_no_archive_name(file.name); !why.empty()) return why;
    if (!names.insert(file.name).second)
      return fmt::format("found '{}' twice, expected each file once", file.name);
    if (file.bytes > left)
      return fmt::format("its files have more than {} GB in sum, expected less",
                         kMostBundleBytes >> 30);
    left -= file.bytes;
  }
  for (const std::string& name : names)
    for (size_t at = name.find('/'); at != std::string::npos; at = name.find('/', at + 1))
      if (names.contains(name.substr(0, at)))
        return fmt::format("found '{}' as a file and as a folder", name.substr(0, at));
  if (!names.contains(manifest.of))
    return fmt::format("found of: '{}', expected one of its files", manifest.of);
  for (const auto& [folder, inside] : manifest.folders)
    if (const std::string why = why_no_archive_name(inside); !why.empty()) return why;
  return "";
}

}  // namespace

std::string BundleManifest::to_text() const {
  Json json = {{"format", kFormat},  {"seam", {{"version", version}, {"program", program}}},
               {"of", of},           {"needs", needs},
               {"folders", folders}, {"words", words}};
  json["files"] = Json::array();
  for (const BundleFile& file : files)
    json["files"].push_back({{"name", file.name},
                             {"bytes", file.bytes},
                             {"sha256", file.sha256},
                             {"program", file.program}});
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

BundleManifest BundleManifest::from_text(const std::string& text, const std::string& where) {
  const std::string name = where + ", " + kManifestName;
  const nlohmann::json json = json_from_text(text, name, std::string("a text of ") + kFormat);
  BundleManifest manifest;
  try {
    const std::string format = json.at("format");
    if (format != kFormat)
      throw InputError(
          fmt::format("{}: found format '{}', expected {}", name, shown(format), kFormat));
    manifest = manifest_of(json);
  } catch (const nlohmann::json::exception& error) {
    throw InputError(
        fmt::format("{}: expected the keys of {}: {}", name, kFormat, shown(error.what())));
  }
  if (const std::string why = why_refused(manifest); !why.empty())
    throw InputError(fmt::format("{}: {}", name, shown(why)));
  return manifest;
}

}  // namespace seam::app
