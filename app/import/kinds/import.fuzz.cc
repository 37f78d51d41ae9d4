// Whatever files somebody gives to `seam import KIND`, a set comes of them or an InputError. The
// input is a line with the kind, then the files one after another, each behind a line "### NAME".
#include "app/import/import.h"

#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "app/import/pictures/bag_pictures.h"
#include "sim_core/base/error.h"

using namespace seam::app;
namespace fs = std::filesystem;

namespace {

// A folder in memory where the system has one, gone with the process.
struct Folder {
  Folder() : path("/dev/shm/seam-fuzz-import-" + std::to_string(getpid())) {}
  ~Folder() { fs::remove_all(path); }
  fs::path path;
};

bool is_plain(const std::string& name) {
  return !name.empty() && name.size() < 40 && name[0] != '.' &&
         name.find_first_of("/\\") == std::string::npos && name.find('\0') == std::string::npos;
}

void import_pictures_of_bag(const ImportRequest& request, SetDraft& draft) {
  for (const fs::path& source : request.sources) {
    const fs::path into = source.parent_path() / "pictures";
    fs::create_directories(into);
    unpack_pictures(source, "", into, draft);
  }
}

// The imports of the table that read files in this process, and the pictures of a bag.
std::map<std::string, void (*)(const ImportRequest&, SetDraft&)> fuzzed_kinds() {
  std::map<std::string, void (*)(const ImportRequest&, SetDraft&)> kinds = {
      {"pictures", import_pictures_of_bag}};
  for (const ImportKind& kind : import_kinds()) {
    if (kind.fuzzed) kinds.emplace(kind.name, kind.fill);
  }
  return kinds;
}

ImportRequest request_of(const std::string& text, const fs::path& folder) {
  ImportRequest request;
  for (size_t start = text.find("### "); start != std::string::npos;) {
    const size_t line_end = std::min(text.find('\n', start), text.size());
    const size_t next = text.find("\n### ", line_end);
    const std::string name = text.substr(start + 4, line_end - start - 4);
    const size_t end = next == std::string::npos ? text.size() : next + 1;
    if (is_plain(name) && line_end < end && request.sources.size() < 8) {
      std::ofstream(folder / name, std::ios::binary)
          << text.substr(line_end + 1, end - line_end - 1);
      request.sources.push_back(folder / name);
    }
    start = next == std::string::npos ? next : next + 1;
  }
  return request;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const Folder folder;
  fs::remove_all(folder.path);
  fs::create_directories(folder.path / "in");
  const std::string text(reinterpret_cast<const char*>(data), size);
  static const auto kinds = fuzzed_kinds();
  const auto kind = kinds.find(text.substr(0, text.find('\n')));
  if (kind == kinds.end()) return 0;
  ImportRequest request = request_of(text, folder.path / "in");
  if (request.sources.empty()) return 0;
  request.board_columns = 3, request.board_rows = 2, request.spacing_m = 0.03;
  request.width_px = 640, request.height_px = 480;
  // A bag with pictures would start their readers.
  if (kind->first == "ros") request.board_columns = 0;
  try {
    SetDraft draft(folder.path / "out");
    kind->second(request, draft);
    draft.finish("fuzz");
  } catch (const seam::InputError&) {
  } catch (const seam::UsageError&) {
  }
  return 0;
}
