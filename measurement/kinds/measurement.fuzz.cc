// Whatever a measurement set holds, opening it ends in a problem or an InputError. The input is the
// files one after another, each behind a line "### NAME"; the first is measurement.yaml.
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "measurement/kinds/kinds.h"
#include "sim_core/base/error.h"

namespace {

// A folder in memory where the system has one, gone with the process.
struct Folder {
  Folder() : path("/dev/shm/seam-fuzz-" + std::to_string(getpid())) {}
  ~Folder() { std::filesystem::remove_all(path); }
  std::filesystem::path path;
};

bool plain(const std::string& name) {
  return !name.empty() && name.size() < 40 && name[0] != '.' &&
         name.find_first_of("/\\") == std::string::npos && name.find('\0') == std::string::npos;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const Folder folder;
  std::filesystem::remove_all(folder.path);
  std::filesystem::create_directories(folder.path);
  const std::string text(reinterpret_cast<const char*>(data), size);
  for (size_t start = text.find("### "); start != std::string::npos;) {
    const size_t line_end = std::min(text.find('\n', start), text.size());
    const size_t next = text.find("\n### ", line_end);
    const std::string name = text.substr(start + 4, line_end - start - 4);
    const size_t end = next == std::string::npos ? text.size() : next + 1;
    if (plain(name) && line_end < end) {
      std::ofstream(folder.path / name, std::ios::binary)
          << text.substr(line_end + 1, end - line_end - 1);
    }
    start = next == std::string::npos ? next : next + 1;
  }
  try {
    seam::measurement::open_problem(folder.path);
  } catch (const seam::InputError&) {
  }
  return 0;
}
