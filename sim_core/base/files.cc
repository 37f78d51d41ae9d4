#include "sim_core/base/files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "sim_core/base/error.h"

namespace seam {

namespace {

const char* kind_of(mode_t mode) {
  if (S_ISDIR(mode)) return "a folder";
  if (S_ISFIFO(mode)) return "a pipe";
  if (S_ISSOCK(mode)) return "a socket";
  return "a device";
}

// An open file, closed at the end of its scope.
class InputFile {
 public:
  // A pipe that nobody writes to would block the opening for good, hence O_NONBLOCK; on regular
  // files it changes nothing.
  explicit InputFile(const std::filesystem::path& path)
      : descriptor_(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY)) {}
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;
  ~InputFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  int descriptor() const { return descriptor_; }

 private:
  int descriptor_;
};

}  // namespace

std::string read_file(const std::filesystem::path& path, uint64_t limit_bytes) {
  const auto refuse = [&](const std::string& why) {
    throw InputError(fmt::format("{}: {}", path.string(), why));
  };
  const InputFile file(path);
  struct stat facts {};
  if (file.descriptor() < 0 || ::fstat(file.descriptor(), &facts) != 0)
    refuse(fmt::format("cannot be read: {}", std::strerror(errno)));
  if (!S_ISREG(facts.st_mode))
    refuse(fmt::format("is {}, expected a file", kind_of(facts.st_mode)));
  const auto size = static_cast<uint64_t>(facts.st_size);
  if (size > limit_bytes)
    refuse(fmt::format("is {} bytes long, expected at most {}", size, limit_bytes));
  // What the kernel makes up as it is read states no size, and a file may grow meanwhile.
  std::string contents(size, '\0');
  size_t length = 0;
  while (true) {
    if (length == contents.size()) contents.resize(std::min(2 * length + 4096, limit_bytes + 1));
    const ssize_t count =
        ::read(file.descriptor(), contents.data() + length, contents.size() - length);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) refuse(fmt::format("cannot be read: {}", std::strerror(errno)));
    if (count == 0) break;
    length += static_cast<size_t>(count);
    if (length > limit_bytes) refuse(fmt::format("is longer than {} bytes", limit_bytes));
  }
  contents.resize(length);
  return contents;
}

}  // namespace seam
