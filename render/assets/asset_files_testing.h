// A folder of files for tests of what reads them.
#pragma once

#include <gtest/gtest.h>
#include <stdlib.h>

#include <cstring>
#include <filesystem>

#include "render/assets/assets.h"
#include "sim_core/base/error.h"
#include "sim_core/base/output.h"

namespace seam::render {

namespace fs = std::filesystem;

class AssetFilesTest : public ::testing::Test {
 protected:
  AssetFilesTest() {
    std::string pattern = ::testing::TempDir() + "/seam-assets-XXXXXX";
    folder_ = mkdtemp(pattern.data());
    setenv("SEAM_CACHE", "off", 1);
  }
  ~AssetFilesTest() override {
    fs::remove_all(folder_);
    setenv("SEAM_CACHE", "off", 1);
  }
  FileName put(const std::string& name, const std::string& bytes) const {
    write_file_atomically(folder_ / name, bytes);
    return {name, folder_.string(), ""};
  }
  static std::string why_not(const FileName& file) {
    try {
      read_mesh(file, 1);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  fs::path folder_;
};

// Corners that no two facets share.
inline std::string binary_stl(int facets, uint16_t attribute = 0) {
  std::string bytes(84, '\0');
  const auto count = static_cast<uint32_t>(facets);
  std::memcpy(&bytes[80], &count, 4);
  for (int i = 0; i < facets; ++i) {
    const float x = 0.01f * static_cast<float>(i % 10), y = 0.02f * static_cast<float>(i / 10);
    const float numbers[12] = {0, 0, 2, x, y, 0, x + 0.01f, y, 0, x, y + 0.02f, 0};
    bytes.append(reinterpret_cast<const char*>(numbers), sizeof numbers);
    bytes.append(reinterpret_cast<const char*>(&attribute), 2);
  }
  return bytes;
}

}  // namespace seam::render
