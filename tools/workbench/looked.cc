#include "tools/workbench/looked.h"

#include <fstream>
#include <iterator>

#include "effects/registry.h"
#include "tools/workbench/formula.h"

namespace seam::tools {

using nlohmann::json;

json json_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) return nullptr;
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  json found = json::parse(text, nullptr, /*allow_exceptions=*/false);
  return found.is_discarded() ? json(nullptr) : found;
}

void Looked::read(const std::filesystem::path& folder) {
  compare = json_of(folder / "compare.json");
  effects = json_of(folder / "model.json");
  set = json_of(folder / "set.json");
  search = json_of(folder / "search.json");
  diagnose = json_of(folder / "diagnose.json");
}

json search_json(const Looked& looked) {
  json fields = {{"candidates", json::array()},
                 {"prospects", json::array()},
                 {"ties", json::array()},
                 {"not_testable", json::array()},
                 {"advice", ""},
                 {"ordered_by", ""}};
  for (const char* key : {"candidates", "prospects", "ties", "not_testable", "ordered_by"}) {
    if (looked.search.is_object() && looked.search.contains(key)) fields[key] = looked.search[key];
  }
  if (looked.diagnose.is_object()) {
    for (const char* key : {"candidates", "not_testable", "advice", "verdict", "headline",
                            "explanation", "unnamed_cause", "outliers"}) {
      if (looked.diagnose.contains(key)) fields[key] = looked.diagnose[key];
    }
    if (looked.diagnose.contains("suggestion"))
      fields["suggestion"] = with_formula_text(looked.diagnose["suggestion"]);
  }
  for (const char* key : {"candidates", "prospects"}) {
    for (json& one : fields[key]) {
      const auto effect = effects::find_effect(one.value("effect", ""));
      if (effect) one["help"] = effect->help;
    }
  }
  if (looked.cancelled) fields["cancelled"] = true;
  if (!looked.trouble.empty()) fields["trouble"] = looked.trouble;
  return fields;
}

}  // namespace seam::tools
