// Which import reads a file: by a cheap look at its name, its first bytes and its columns.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/import/import.h"

namespace seam::app {

// The import that people mean by a word that is no kind's name, as a sentence with its command;
// empty: none.
std::string kind_meant_by(const std::string& word);

// Throws UsageError for a word that is none's name, with what may be meant.
const ImportKind& import_kind_named(const std::string& name);

// For the first of the sources that `kind` does not read and another import does, a sentence that
// names that import's command; empty: there is none.
std::string other_import_for(const std::vector<std::filesystem::path>& sources,
                             const std::string& kind);

// The first import that reads any of these files, or files right below these folders; null: none.
const ImportKind* import_that_reads(const std::vector<std::filesystem::path>& sources);

// Throws InputError where a file of another program is given instead of one of ours, naming the
// import that reads it.
void refuse_foreign_file(const std::filesystem::path& path);

}  // namespace seam::app
