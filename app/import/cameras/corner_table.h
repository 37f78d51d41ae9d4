// Corners of a target in a table: a row a corner, with its frame or time, its place on the target
// (its number, or its row and column), and the camera that saw it where there are several.
#pragma once

#include <string>
#include <vector>

#include "app/import/draft/points_draft.h"
#include "app/import/draft/request.h"
#include "app/import/draft/target.h"
#include "app/import/files/text_table.h"
#include "app/import/pictures/rig_views.h"

namespace seam::app {

class CornerTable {
 public:
  // Throws InputError where columns are missing.
  CornerTable(const TextTable& table, const ImportRequest& request);

  bool has_times() const { return time_ >= 0; }
  bool has_cameras() const { return camera_ >= 0; }
  // The cameras that the table names, as they first appear.
  std::vector<std::string> cameras() const;

  // What these cameras saw, one after another under one name a frame; an empty name is a table
  // without cameras. Throws InputError for a corner that stands twice, for a camera that is not
  // there and for one that shares no frame with another.
  std::vector<SeenView> views(const TargetSpec& target, const std::vector<std::string>& cameras,
                              SetDraft& draft) const;

 private:
  static size_t at(int column) { return static_cast<size_t>(column); }
  std::string text(size_t row, int column) const {
    return std::string(table_.cell(row, at(column)));
  }
  std::vector<SeenView> views_of(const TargetSpec& target, const std::string& camera) const;
  size_t count_in(size_t row, int column) const;
  size_t point_in(size_t row, const TargetSpec& target) const;
  size_t point_on_grid(size_t row, const TargetSpec& target) const;
  // How the table names a row's corner: by its number or by its row and column on the board.
  std::string corner_text(size_t row) const;
  void refuse_smaller_board(const std::vector<SeenView>& views, size_t points) const;
  [[noreturn]] void fail_twice(size_t row, size_t before) const;
  std::string column_of_cameras() const;
  std::string key_of(size_t row) const;

  const TextTable& table_;
  int time_ = -1, frame_ = -1, camera_ = -1, tag_ = -1, point_ = -1, u_ = -1, v_ = -1;
  int board_row_ = -1, board_column_ = -1;  // In place of point_.
  int64_t unit_ns_ = 1;
};

}  // namespace seam::app
