// `seam import`: from the files that people have to a measurement set with a nominal model.
#pragma once

#include <string>
#include <vector>

#include "app/import/draft/request.h"
#include "app/import/draft/set_draft.h"

namespace seam::app {

struct FileLook;

// A row of the table of imports (app/import/table.cc).
struct ImportKind {
  std::string name;
  std::string help;                  // What it reads, for the list of kinds.
  std::vector<std::string> options;  // Those of the command that mean something to it.
  // Our names in `--map`: all quantities that its reader asks the request for.
  std::vector<std::string> quantities;
  bool own_units = false;  // Whether it reads a unit of each quantity.
  void (*fill)(const ImportRequest& request, SetDraft& draft) = nullptr;
  // Of files that another import was given: what these are, what people call them, how they look.
  std::string what;
  std::vector<std::string> also;
  bool (*looks)(const FileLook& look) = nullptr;
  // Whether app/import/kinds/import.fuzz.cc tries it; not one that starts a program, or whose
  // reader has a fuzzer of its own.
  bool fuzzed = true;
};

const std::vector<ImportKind>& import_kinds();

// Writes the set; returns what was done, for people. `instruments` are those by which it is checked
// as the analyses do. Throws InputError with nothing written, or
// UsageError where the request does not fit the kind.
std::string import_set(const ImportKind& kind, const ImportRequest& request,
                       const std::string& title, const std::filesystem::path& out,
                       const measurement::Instruments& instruments);

}  // namespace seam::app
