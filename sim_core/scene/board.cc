#include "sim_core/scene/board.h"

#include <fmt/format.h>

#include "sim_core/scene/april_tags.h"

namespace seam {
namespace {

// Circles are discs so thick: nearer than the ground by more than rounding, thinner than any pixel.
constexpr double kInk_m = 1e-4;

void describe_tags(ConfigTable& table, BoardSpec& board) {
  const bool always = !table.names_alternatives();
  table.number({"tag_m", "Of tags: their black square's side, m.", always}, board.tag_m,
               {1e-4, 100});
  table.number({"gap_m", "Of tags: from one's black square to the next one's, m.", always},
               board.gap_m, {0, 100});
  table.require(board.columns * board.rows <= kMostTags, "columns",
                fmt::format("found {} tags, expected at most {}: tag36h11 has no more",
                            board.columns * board.rows, kMostTags));
}

// What stands on the board, its middle in the middle of the board's frame.
class Printer {
 public:
  Printer(const BoardSpec& board, const Pose& X_WO, uint16_t object_id)
      : board_(board), X_WO_(X_WO), object_id_(object_id) {}

  std::vector<Primitive> print() {
    const bool tags = board_.pattern == BoardPattern::aprilgrid;
    const double pitch = tags ? board_.tag_m + board_.gap_m : board_.pitch_m;
    // Small squares stand at all corners of tags, outside too.
    const double beyond = tags ? board_.gap_m : 0;
    const double width = static_cast<double>(board_.columns) * pitch + beyond;
    const double height = static_cast<double>(board_.rows) * pitch + beyond;
    add(Shape::rectangle, {0, 0, 0}, {width + 2 * board_.border_m, height + 2 * board_.border_m, 0},
        board_.light);
    for (int64_t row = 0; row < board_.rows; ++row) {
      for (int64_t column = 0; column < board_.columns; ++column) {
        const Vec3 middle((static_cast<double>(column) + 0.5) * pitch - 0.5 * (width - beyond),
                          (static_cast<double>(row) + 0.5) * pitch - 0.5 * (height - beyond), 0);
        if (tags)
          add_tag(static_cast<int>(row * board_.columns + column), middle);
        else if (board_.pattern == BoardPattern::circles)
          add(Shape::cylinder, middle, {0.5 * board_.diameter_m, 0, kInk_m}, board_.dark);
        else if ((row + column) % 2 == 0)
          add_square(middle, pitch);
      }
    }
    if (tags && board_.gap_m > 0) add_gap_squares(width, height, pitch);
    return std::move(parts_);
  }

 private:
  void add(Shape shape, const Vec3& place, const Vec3& size, const Rgb& rgb) {
    parts_.push_back({.shape = shape,
                      .object_id = object_id_,
                      .X_WO = X_WO_ * translation(place),
                      .size = size,
                      .rgb = rgb});
  }
  void add_square(const Vec3& middle, double side) {
    add(Shape::rectangle, middle, {side, side, 0}, board_.dark);
  }
  void add_tag(int id, const Vec3& middle) {
    add_square(middle, board_.tag_m);
    const double cell = board_.tag_m / kTagCells;
    for (const LightCells& cells : light_cells_of_tag(id)) {
      const double x = (cells.first + 0.5 * cells.count) * cell - 0.5 * board_.tag_m;
      const double y = 0.5 * board_.tag_m - (cells.row + 0.5) * cell;
      add(Shape::rectangle, middle + Vec3(x, y, 0), {cells.count * cell, cell, 0}, board_.light);
    }
  }
  void add_gap_squares(double width, double height, double pitch) {
    for (int64_t row = 0; row <= board_.rows; ++row) {
      for (int64_t column = 0; column <= board_.columns; ++column)
        add_square({static_cast<double>(column) * pitch - 0.5 * (width - board_.gap_m),
                    static_cast<double>(row) * pitch - 0.5 * (height - board_.gap_m), 0},
                   board_.gap_m);
    }
  }

  const BoardSpec& board_;
  const Pose& X_WO_;
  const uint16_t object_id_;
  std::vector<Primitive> parts_;
};

}  // namespace

void describe(ConfigTable& table, BoardSpec& board) {
  // A schema names the keys of all shapes, and no object has all of them.
  const bool always = !table.names_alternatives();
  table.choice_of({"pattern", "What is on the board.", always}, board.pattern,
                  {"chessboard", "circles", "aprilgrid"});
  table.integer({"columns", "Squares, circles or tags in a row.", always}, board.columns, 1, 100);
  table.integer({"rows", "Rows of squares, circles or tags.", always}, board.rows, 1, 100);
  if (!always || board.pattern == BoardPattern::aprilgrid) describe_tags(table, board);
  if (!always || board.pattern != BoardPattern::aprilgrid) {
    table.number({"pitch_m", "From the middle of a square or circle to the next one's, m.", always},
                 board.pitch_m, {1e-4, 100});
  }
  if (!always || board.pattern == BoardPattern::circles) {
    table.number({"diameter_m", "Of circles: their diameter, m.", always}, board.diameter_m,
                 {1e-4, 100});
    table.require(board.diameter_m < board.pitch_m, "diameter_m",
                  fmt::format("found {}, expected less than the pitch of {}", board.diameter_m,
                              board.pitch_m));
  }
  table.number({"border_m", "White around the pattern, m."}, board.border_m, {0, 100});
  table.numbers({"dark_rgb", "Of squares, circles and tags, linear radiance."}, board.dark);
  table.numbers({"light_rgb", "Of the ground, linear radiance."}, board.light);
}

std::vector<Primitive> board_primitives(const BoardSpec& board, const Pose& X_WO,
                                        uint16_t object_id) {
  return Printer(board, X_WO, object_id).print();
}

}  // namespace seam
