#include "tools/workbench/session/session_archive.h"

#include <algorithm>
#include <vector>

#include "app/bundle/zip_writer.h"
#include "sim_core/base/files.h"

namespace seam::tools {
namespace {

namespace fs = std::filesystem;

// In the order of their names; none where there is no such folder.
std::vector<fs::path> entries_of(const fs::path& folder) {
  std::vector<fs::path> found;
  std::error_code missing;
  for (const auto& entry : fs::directory_iterator(folder, missing)) found.push_back(entry.path());
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace

std::string session_archive(const fs::path& folder, const std::string& script) {
  std::string archive;
  app::ZipWriter zip([&](std::string_view bytes) { archive.append(bytes); },
                     folder.string() + ": a session of more than 4 GiB cannot be packed");
  const std::string top = "session/";
  const auto add = [&](const std::string& name, const fs::path& file) {
    if (fs::is_regular_file(fs::symlink_status(file))) zip.add(top + name, read_file(file));
  };
  zip.add(top + "session.sh", script);
  for (const char* name : {"session.json", "left-out.csv"}) add(name, folder / name);
  for (const char* part : {"versions", "effects"}) {
    for (const fs::path& file : entries_of(folder / part)) {
      if (file.extension() == ".yaml")
        add(std::string(part) + "/" + file.filename().string(), file);
    }
  }
  for (const fs::path& looked : entries_of(folder / "cache"))
    add("reports/" + looked.filename().string() + ".html", looked / "report.html");
  zip.finish();
  return archive;
}

}  // namespace seam::tools
