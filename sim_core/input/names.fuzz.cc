// Whatever name a file states: what is taken for a path inside a folder leads to no place outside
// it, by the operating system's own judgement, and what is shown moves no cursor.
#include <fcntl.h>
#include <linux/openat2.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>

#include "sim_core/base/error.h"
#include "sim_core/input/file_names.h"
#include "sim_core/input/shown_text.h"

using namespace seam;
namespace fs = std::filesystem;

namespace {

// A folder with all kinds of links, beside what must not be reached.
struct Folder {
  Folder() {
    std::string pattern = (fs::temp_directory_path() / "seam-names-XXXXXX").string();
    SEAM_CHECK(mkdtemp(pattern.data()) != nullptr, "{}", pattern);
    top = pattern;
    inside = top / "set";
    fs::create_directories(inside / "a" / "b");
    fs::create_directory(top / "outside");
    fs::create_directory_symlink("a", inside / "in");
    fs::create_directory_symlink("..", inside / "up");
    fs::create_directory_symlink("../../outside", inside / "a" / "out");
    fs::create_symlink("../../none", inside / "a" / "gone");
    descriptor = open(inside.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC);
  }
  ~Folder() {
    close(descriptor);
    fs::remove_all(top);
  }
  fs::path top, inside;
  int descriptor = -1;
};

// The kernel refuses whatever leads out with EXDEV. Kernels before 5.6 do not know the question.
bool leads_out(const Folder& folder, const std::string& name) {
  open_how how{};
  how.flags = O_PATH | O_CLOEXEC;
  how.resolve = RESOLVE_BENEATH | RESOLVE_NO_MAGICLINKS;
  const long opened = syscall(SYS_openat2, folder.descriptor, name.c_str(), &how, sizeof how);
  if (opened >= 0) close(static_cast<int>(opened));
  return opened < 0 && errno == EXDEV;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const Folder folder;
  const std::string name(reinterpret_cast<const char*>(data), size);
  const std::string text = shown(name);
  for (const char c : text)
    SEAM_CHECK(static_cast<unsigned char>(c) >= 0x20 && c != 0x7F, "{:02x} is sent", c);
  SEAM_CHECK(shown(text) == text);
  if (!why_not_inside(folder.inside, name).empty()) return 0;
  SEAM_CHECK(name.find('\0') == std::string::npos);
  SEAM_CHECK(!leads_out(folder, name), "'{}' leads out", name);
  SEAM_CHECK(path_inside(folder.inside, name).string().starts_with(folder.inside.string() + "/"));
  return 0;
}
