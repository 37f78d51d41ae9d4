// What a person takes away from the page: models in the files of other programs.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "effects/model.h"

namespace seam::tools {

// `[{name, what}]`: the formats of `seam export` that hold a model of this kind of measurement.
nlohmann::json export_formats_json(const std::string& kind);

struct Exporting {
  effects::Model model;  // As the page shows it: what is free has its fitted values.
  std::string version;
  std::filesystem::path set;
  std::filesystem::path scratch;  // A folder for what the command writes.
  std::string format;
  bool drop = false;  // What the format cannot hold is left out, and its cost is said.
};

// By `seam export` in a process of its own: `{name, text, notes}`. Throws Refusal with its words.
nlohmann::json exported_json(const Exporting& wanted);

}  // namespace seam::tools
