// Effects as formulas: what a person may write at each stage, and whether what was written is one.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace seam::tools {

// The stages with their variables, those first that act on this kind of measurement.
nlohmann::json formula_stages_json(const std::string& kind);

// A file for `seam add`: the lines stand below the effect's name and stage. Throws UsageError for
// a name that is none.
std::string formula_file(const std::string& stage, const std::string& name,
                         const std::string& text);

// {"ok": true, "parameters"} or {"ok": false, "error", "line"}, the line in the text.
nlohmann::json formula_checked(const std::string& stage, const std::string& name,
                               const std::string& text);

// What `diagnose` suggests, ready to be edited: also its stage, and the text that stands below it
// in its file.
nlohmann::json with_formula_text(nlohmann::json suggestion);

}  // namespace seam::tools
