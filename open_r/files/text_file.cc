#include "open_r/files/text_file.h"

#include <fstream>

#include "open_r/files/fault.h"

namespace seam::open_r {
namespace {

namespace fs = std::filesystem;

const char* kind_of(fs::file_type type) {
  switch (type) {
    case fs::file_type::not_found:
      return "is not there";
    case fs::file_type::directory:
      return "is a folder";
    case fs::file_type::fifo:
      return "is a pipe";
    case fs::file_type::socket:
      return "is a socket";
    default:
      return "is a device";
  }
}

}  // namespace

std::string read_text(const fs::path& file) {
  std::error_code error;
  // Before it is opened: a pipe that nobody writes to would block the opening for good.
  const fs::file_status status = fs::status(file, error);
  if (status.type() == fs::file_type::none)
    throw Fault(file.string() + ": cannot be read: " + error.message());
  if (!fs::is_regular_file(status))
    throw Fault(file.string() + ": " + kind_of(status.type()) + ", expected a file");
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw Fault(file.string() + ": cannot be read");
  std::string text(kMostTextBytes + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<size_t>(stream.gcount()));
  if (text.size() > kMostTextBytes)
    throw Fault(file.string() + ": expected at most " + std::to_string(kMostTextBytes) + " bytes");
  return text;
}

}  // namespace seam::open_r
