#include "render/golden/golden_frames.h"

#include <gtest/gtest.h>

#include "sim_core/base/error.h"
#include "sim_core/base/files.h"

namespace seam::render {
namespace {

TEST(GoldenFrames, FingerprintsArePinned) {
  const std::string path = std::string(SEAM_SOURCE_DIR) + "/render/golden_frames.txt";
  const std::string current = golden_frame_lines(1);
  std::string pinned;
  try {
    pinned = read_file(path);
  } catch (const InputError&) {
  }
  if (current != pinned) write_file_atomically(path + ".new", current);
  EXPECT_EQ(current, pinned) << "compare " << path << " with " << path << ".new";
}

TEST(GoldenFrames, ThreadsChangeNoBit) {
  EXPECT_EQ(golden_frame_lines(2), golden_frame_lines(1));
}

}  // namespace
}  // namespace seam::render
