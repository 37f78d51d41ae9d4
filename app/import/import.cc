#include "app/import/import.h"

#include <fmt/ranges.h>

#include "app/import/recognise.h"
#include "sim_core/base/error.h"
#include "sim_core/system/work_tally.h"

namespace seam::app {
std::string import_set(const ImportKind& kind, const ImportRequest& request,
                       const std::string& title, const std::filesystem::path& out,
                       const measurement::Instruments& instruments) {
  ImportRequest asked = request;
  asked.quantities = kind.quantities;
  check_names(asked, kind.name);
  if (!kind.own_units && !request.own_units.empty())
    throw UsageError(fmt::format(
        "{}={}: import {} takes one unit for all, expected --unit, --time-unit or --length-unit "
        "with a unit alone",
        request.own_units.begin()->first, request.own_units.begin()->second, kind.name));
  std::vector<std::string> names;
  // A folder may be given with a slash at its end.
  for (const auto& source : request.sources)
    names.push_back((source.has_filename() ? source : source.parent_path()).filename().string());
  std::string from = fmt::format(
      "{}", fmt::join(names.begin(), names.begin() + std::min<size_t>(names.size(), 4), ", "));
  if (names.size() > 4) from += fmt::format(" and {} more", names.size() - 4);
  SetDraft draft(out);
  draft.instruments = instruments;
  // Of a file that is another import's the reader says what it lacks, and we where it belongs.
  const auto with_other = [&](const std::exception& error) {
    const std::string other = other_import_for(request.sources, kind.name);
    return other.empty() ? error.what() : fmt::format("{}\n{}", error.what(), other);
  };
  say_work("reading " + from);
  try {
    kind.fill(asked, draft);
  } catch (const InputError& error) {
    throw InputError(with_other(error));
  } catch (const UsageError& error) {
    throw UsageError(with_other(error));
  }
  draft.title = title.empty() ? fmt::format("Imported from {} ({})", from, kind.name) : title;
  say_work("checking the set");
  draft.finish(from);
  return draft.text();
}

}  // namespace seam::app
