// Calibration boards, made of the shapes that every renderer has, so that what a detector finds has
// coordinates known to the last digit.
#pragma once

#include <vector>

#include "sim_core/input/config_table.h"
#include "sim_core/scene/scene.h"

namespace seam {

enum class BoardPattern : uint8_t { chessboard, circles, aprilgrid };

// In the board's frame x runs along its rows to the right, y along its columns upwards, z out of
// its face; the origin is the middle of the pattern.
struct BoardSpec {
  BoardPattern pattern = BoardPattern::chessboard;
  int64_t columns = 9;  // Squares, circles or tags in a row.
  int64_t rows = 6;
  double pitch_m = 0.03;     // From one square's or circle's middle to the next.
  double diameter_m = 0.02;  // Of circles.
  double tag_m = 0.06;       // The side of a tag's black square.
  double gap_m = 0.018;      // Between tags, and the side of the small squares at their corners.
  double border_m = 0.03;    // White around the pattern.
  Rgb dark{0.02, 0.02, 0.02};
  Rgb light{0.85, 0.85, 0.85};
};

void describe(ConfigTable& table, BoardSpec& board);

// The board's parts at the pose: the white ground first. The square of the lower left corner is
// dark; tags are those of the family 36h11, number 0 at the lower left, counted along the rows, as
// Kalibr prints them.
std::vector<Primitive> board_primitives(const BoardSpec& board, const Pose& X_WO,
                                        uint16_t object_id);

}  // namespace seam
