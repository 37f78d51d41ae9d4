// What was computed of one version, as it is in its folder of the session's cache.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace seam::tools {

struct Looked {
  nlohmann::json compare, effects, set, search, diagnose;  // Null until they are there.
  std::string trouble;                                     // Why it came to no end.
  bool cancelled = false;

  // Reads what is there anew.
  void read(const std::filesystem::path& folder);
  bool ended() const { return search.is_object() && search.value("ended", false); }
};

// What the page shows of the search: of the diagnosis, where it has ended, else of the look.
nlohmann::json search_json(const Looked& looked);

// A JSON file of ours; null where it is not there or not whole.
nlohmann::json json_of(const std::filesystem::path& file);

}  // namespace seam::tools
