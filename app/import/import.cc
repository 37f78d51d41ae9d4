#include "app/import/import.h"

#include <fmt/ranges.h>

#include "app/import/kinds/kinds.h"
#include "sim_core/base/error.h"

namespace seam::app {

const std::vector<ImportKind>& import_kinds() {
  static const std::vector<ImportKind> kinds = {
      {.name = "servo",
       .help = "logs of commanded and measured angles: CSV or JSON, a file a run",
       .options = {"map", "unit", "time-unit"},
       .fill = import_servo},
  };
  return kinds;
}

std::string import_set(const ImportKind& kind, const ImportRequest& request,
                       const std::string& title, const std::filesystem::path& out) {
  std::vector<std::string> names;
  for (const auto& source : request.sources) names.push_back(source.filename().string());
  std::string from = fmt::format(
      "{}", fmt::join(names.begin(), names.begin() + std::min<size_t>(names.size(), 4), ", "));
  if (names.size() > 4) from += fmt::format(" and {} more", names.size() - 4);
  SetDraft draft(out);
  kind.fill(request, draft);
  draft.title = title.empty() ? fmt::format("Imported from {} ({})", from, kind.name) : title;
  draft.finish(from);
  return draft.text();
}

}  // namespace seam::app
