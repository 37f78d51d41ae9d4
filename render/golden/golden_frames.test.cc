#include "render/golden/golden_frames.h"

#include <gtest/gtest.h>

#include "sim_core/base/error.h"
#include "sim_core/base/files.h"
#include "sim_core/base/output.h"

namespace seam::render {
namespace {

TEST(GoldenFrames, FingerprintsArePinned) {
  const std::string path = std::string(SEAM_SOURCE_DIR) + "/render/golden/golden_frames.txt";
  const std::string current = golden_frame_lines(1);
  std::string pinned;
  try {
    pinned = read_file(path);
  } catch (const InputError&) {
  }
  if (current != pinned) write_file_atomically(path + ".new", current);
  EXPECT_EQ(current, pinned) << "compare " << path << " with " << path << ".new";
}

// Counts that divide the rows of the frames evenly, and counts that do not.
TEST(GoldenFrames, ThreadsChangeNoBit) {
  const std::string one = golden_frame_lines(1);
  for (const int threads : {2, 3, 5, 8}) EXPECT_EQ(golden_frame_lines(threads), one) << threads;
}

}  // namespace
}  // namespace seam::render
