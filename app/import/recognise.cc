#include "app/import/recognise.h"

#include <algorithm>
#include <fstream>

#include "app/import/file_look.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

namespace fs = std::filesystem;

FileLook look_at(const fs::path& path) {
  constexpr size_t kStart = 4096;
  FileLook look{.name = path.filename().string(), .extension = path.extension().string()};
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return look;
  std::ifstream file(path, std::ios::binary);
  look.start.resize(kStart);
  file.read(look.start.data(), static_cast<std::streamsize>(kStart));
  look.start.resize(static_cast<size_t>(file.gcount()));
  // A row that is cut off is none.
  const size_t whole = look.start.size() < kStart ? look.start.size() : look.start.rfind('\n');
  try {
    if (whole != std::string::npos)
      look.table = TextTable::from_text(look.start.substr(0, whole), look.name);
  } catch (const InputError&) {
    // No table.
  }
  return look;
}

std::string sentence(const ImportKind& kind) {
  return fmt::format("{}: `seam import {}`", kind.what, kind.name);
}

}  // namespace

std::string kind_meant_by(const std::string& word) {
  for (const ImportKind& kind : import_kinds()) {
    if (std::find(kind.also.begin(), kind.also.end(), word) != kind.also.end())
      return "For " + sentence(kind);
  }
  return "";
}

const ImportKind& import_kind_named(const std::string& name) {
  std::vector<std::string> names;
  for (const ImportKind& kind : import_kinds()) {
    if (kind.name == name) return kind;
    names.push_back(kind.name);
  }
  const std::string meant = kind_meant_by(name);
  if (!meant.empty()) throw UsageError(fmt::format("unknown kind '{}'. {}", name, meant));
  throw UsageError(fmt::format("unknown kind '{}'{}", name, suggestion_for(name, names)));
}

std::string other_import_for(const std::vector<fs::path>& sources, const std::string& kind) {
  for (const fs::path& source : sources) {
    const FileLook look = look_at(source);
    // These read where a robot was beside what it measured.
    const bool reads_poses = kind == "wheels" || kind == "ranges";
    const ImportKind* other = nullptr;
    bool own = false;
    for (const ImportKind& row : import_kinds()) {
      if (row.looks == nullptr || !row.looks(look)) continue;
      own = own || row.name == kind || (reads_poses && (row.name == "tum" || row.name == "euroc"));
      if (other == nullptr) other = &row;
    }
    if (!own && other != nullptr)
      return fmt::format("{} looks like {}", source.string(), sentence(*other));
  }
  return "";
}

const ImportKind* import_that_reads(const std::vector<fs::path>& sources) {
  std::vector<fs::path> files;
  for (const fs::path& source : sources) {
    if (!fs::is_directory(source)) {
      files.push_back(source);
      continue;
    }
    for (const auto& entry : fs::directory_iterator(source)) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) {
    const FileLook look = look_at(file);
    for (const ImportKind& kind : import_kinds()) {
      if (kind.looks != nullptr && kind.looks(look)) return &kind;
    }
  }
  return nullptr;
}

void refuse_foreign_file(const fs::path& path) {
  const std::string extension = path.extension().string();
  if (extension == ".yaml" || extension == ".yml" || extension == ".mcap") return;
  const std::string other = other_import_for({path}, "");
  if (!other.empty())
    throw InputError(
        fmt::format("{}: found a file of another program, expected a measurement set "
                    "or another file of SEAM. {}",
                    path.string(), other));
}

}  // namespace seam::app
