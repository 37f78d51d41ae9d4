#include "sim_core/base/files.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "sim_core/base/error.h"
#include "sim_core/base/output.h"

namespace seam {
namespace fs = std::filesystem;
namespace {

std::string message_of(const fs::path& path, uint64_t limit_bytes = 100) {
  try {
    read_file(path, limit_bytes);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(ReadFile, OnlyFilesWithAnEnd) {
  const fs::path folder = fs::path(testing::TempDir()) / "read_file";
  fs::remove_all(folder);
  fs::create_directories(folder);
  EXPECT_EQ(message_of(folder), folder.string() + ": is a folder, expected a file");
  EXPECT_EQ(message_of("/dev/zero"), "/dev/zero: is a device, expected a file");
  const fs::path pipe = folder / "pipe";  // Nobody writes to it: reading would never begin.
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(message_of(pipe), pipe.string() + ": is a pipe, expected a file");
  EXPECT_NE(message_of(folder / "none").find("cannot be read: No such file"), std::string::npos);
  fs::remove_all(folder);
}

TEST(ReadFile, SizeIsBounded) {
  const fs::path path = fs::path(testing::TempDir()) / "read_file.txt";
  write_file_atomically(path, std::string(100, 'x'));
  EXPECT_EQ(read_file(path, 100), std::string(100, 'x'));
  EXPECT_EQ(message_of(path, 99), path.string() + ": is 100 bytes long, expected at most 99");
  // A file that the kernel makes up states no size.
  EXPECT_FALSE(read_file("/proc/self/status", 1 << 20).empty());
  EXPECT_EQ(message_of("/proc/self/status", 10), "/proc/self/status: is longer than 10 bytes");
  fs::remove(path);
}

}  // namespace
}  // namespace seam
