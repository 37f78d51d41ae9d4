// Corners of a calibration target, and cameras, as sets of points: what the kinds of cameras share.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "app/exchange/exchange.h"
#include "app/import/draft/request.h"
#include "app/import/draft/set_draft.h"
#include "sim_core/base/pose.h"

namespace seam::app {

struct SeenCorner {
  size_t point = 0;  // Its place on the target.
  Vec3 p_W{0.0};     // Metres.
  double u_px = 0, v_px = 0;
  double weight = 1;    // Divides the variance.
  double sigma_px = 0;  // Its own scatter where that was measured; 0: unknown.
};

struct SeenView {
  std::string name;
  std::string
      camera;  // Of a rig, whose views of one instant share their name; empty: there is one.
  int64_t time_ns = 0;
  std::vector<SeenCorner> corners;
};

// Points of a flat target, row by row, the first at the origin.
std::vector<Vec3> board_points(int columns, int rows, double spacing_x_m, double spacing_y_m);

// The request's board; throws UsageError where the user did not say all of it.
std::vector<Vec3> board_of(const ImportRequest& request, const std::string& why);

// Throws where a corner-to-corner distance cannot be metres and the user named no unit.
void check_spacing(double spacing_m, const std::string& where, const ImportRequest& request);

// Views of a target whose poses are unknown, as `points`. Faults of the corners (outside the image,
// u and v exchanged) are errors or warnings; others are reported of the whole set.
// `times_known` false: views are numbered by seconds, and the draft says so. The effects are those
// of the cameras, or where there are none a free perspective camera that starts from the views; of
// a rig one for each of its cameras, and where they stand beside the first.
void draft_views(const std::vector<SeenView>& views, bool times_known,
                 const std::vector<PlainCamera>& cameras, const std::string& file, SetDraft& draft);
// The same of one camera; null: none is known.
void draft_views(const std::vector<SeenView>& views, bool times_known, const PlainCamera* camera,
                 const std::string& file, SetDraft& draft);

// Calibrations without corners: a protocol of a board held before the camera, or before a rig of
// several, and its model.
void draft_protocol(const std::vector<PlainCamera>& cameras, const ImportRequest& request,
                    SetDraft& draft);

// The effects of a camera as YAML, of one of a rig by its name. Coefficients are plain numbers:
// they stay fixed.
std::string effects_of(const PlainCamera& camera, const std::string& of_camera = "");

// A focal length from views of a flat target, the principal point in the image's middle; 0 where
// the views do not constrain it.
double focal_length_from(const std::vector<SeenView>& views, int width_px, int height_px);

}  // namespace seam::app
