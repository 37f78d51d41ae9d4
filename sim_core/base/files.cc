#include "sim_core/base/files.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>

#include "sim_core/base/error.h"

namespace seam {

std::string read_file(const std::filesystem::path& path, uint64_t limit_bytes) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) {
    throw InputError(fmt::format("{}: is a folder, expected a file", path.string()));
  }
  std::ifstream in(path, std::ios::binary);
  if (!in) {
    throw InputError(fmt::format("{}: cannot be read: {}", path.string(), std::strerror(errno)));
  }
  const uint64_t size = std::filesystem::file_size(path, error);
  if (!error && size > limit_bytes) {
    throw InputError(
        fmt::format("{}: is {} bytes long, expected at most {}", path.string(), size, limit_bytes));
  }
  std::ostringstream contents;
  contents << in.rdbuf();
  return std::move(contents).str();
}

void write_file_atomically(const std::filesystem::path& path, std::string_view contents) {
  std::filesystem::path temporary = path;
  temporary += fmt::format(".{}.part", ::getpid());
  {
    std::ofstream out(temporary, std::ios::binary);
    out.write(contents.data(), static_cast<std::streamsize>(contents.size()));
    out.flush();
    if (!out) {
      const std::string why = std::strerror(errno);
      std::error_code ignored;
      std::filesystem::remove(temporary, ignored);
      throw InputError(fmt::format("{}: cannot be written: {}", path.string(), why));
    }
  }
  std::filesystem::rename(temporary, path);
}

}  // namespace seam
