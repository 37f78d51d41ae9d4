// The bytes are those of the format's fields; numpy and Python's zipfile read them in
// tests/episodes_test.py and tests/workbench_test.py.
#include "app/bundle/zip_writer.h"

#include <gtest/gtest.h>

namespace seam::app {
namespace {

std::string packed() {
  std::string bytes;
  ZipWriter zip([&](std::string_view piece) { bytes += piece; }, "too long");
  zip.add("a.txt", "123456", "789");
  zip.add("folder/b", "");
  zip.finish();
  return bytes;
}

TEST(ZipWriter, StoresWhatItIsGiven) {
  const std::string bytes = packed();
  EXPECT_EQ(bytes.substr(0, 4), "PK\x03\x04");
  // The check value of CRC-32 in the catalogue of its parameters is that of these nine digits.
  EXPECT_EQ(bytes.substr(14, 4), "\x26\x39\xF4\xCB");
  EXPECT_EQ(bytes.substr(30, 14), "a.txt123456789");
  const std::string end = bytes.substr(bytes.size() - 22);
  EXPECT_EQ(end.substr(0, 4), "PK\x05\x06");
  EXPECT_EQ(end[10], 2);  // Files.
  EXPECT_EQ(packed(), bytes);
}

}  // namespace
}  // namespace seam::app
