#include "sim_core/scene/board.h"

#include <fmt/format.h>

namespace seam {
namespace {

// Circles are discs so thick: nearer than the ground by more than rounding, thinner than any pixel.
constexpr double kInk_m = 1e-4;

}  // namespace

void describe(ConfigTable& table, BoardSpec& board) {
  // A schema names the keys of all shapes, and no object has all of them.
  const bool always = !table.names_alternatives();
  table.choice_of({"pattern", "What is on the board.", always}, board.pattern,
                  {"chessboard", "circles"});
  table.integer({"columns", "Squares or circles in a row.", always}, board.columns, 1, 100);
  table.integer({"rows", "Rows of squares or circles.", always}, board.rows, 1, 100);
  table.number({"pitch_m", "From the middle of a square or circle to the next one's, m.", always},
               board.pitch_m, {1e-4, 100});
  if (!always || board.pattern == BoardPattern::circles) {
    table.number({"diameter_m", "Of circles: their diameter, m.", always}, board.diameter_m,
                 {1e-4, 100});
    table.require(board.diameter_m < board.pitch_m, "diameter_m",
                  fmt::format("found {}, expected less than the pitch of {}", board.diameter_m,
                              board.pitch_m));
  }
  table.number({"border_m", "White around the pattern, m."}, board.border_m, {0, 100});
  table.numbers({"dark_rgb", "Of squares and circles, linear radiance."}, board.dark);
  table.numbers({"light_rgb", "Of the ground, linear radiance."}, board.light);
}

std::vector<Primitive> board_primitives(const BoardSpec& board, const Pose& X_WO,
                                        uint16_t object_id) {
  const double width = static_cast<double>(board.columns) * board.pitch_m;
  const double height = static_cast<double>(board.rows) * board.pitch_m;
  std::vector<Primitive> parts;
  const auto add = [&](Shape shape, const Vec3& place, const Vec3& size, const Rgb& rgb) {
    parts.push_back({.shape = shape,
                     .object_id = object_id,
                     .X_WO = X_WO * translation(place),
                     .size = size,
                     .rgb = rgb});
  };
  add(Shape::rectangle, {0, 0, 0}, {width + 2 * board.border_m, height + 2 * board.border_m, 0},
      board.light);
  for (int64_t row = 0; row < board.rows; ++row) {
    for (int64_t column = 0; column < board.columns; ++column) {
      const Vec3 middle((static_cast<double>(column) + 0.5) * board.pitch_m - 0.5 * width,
                        (static_cast<double>(row) + 0.5) * board.pitch_m - 0.5 * height, 0);
      if (board.pattern == BoardPattern::circles) {
        add(Shape::cylinder, middle, {0.5 * board.diameter_m, 0, kInk_m}, board.dark);
      } else if ((row + column) % 2 == 0) {
        add(Shape::rectangle, middle, {board.pitch_m, board.pitch_m, 0}, board.dark);
      }
    }
  }
  return parts;
}

}  // namespace seam
