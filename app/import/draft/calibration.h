// Cameras as the files of calibrations write them down.
#pragma once

#include <string>
#include <vector>

#include "app/exchange/exchange.h"
#include "app/import/draft/set_draft.h"

namespace seam::app {

// OpenCV's coefficients in its order, 0 to 14 of them, or four of its fisheye. Gives the draft what
// no effect holds (a tilted sensor). Throws InputError, naming `where`, for another count.
void take_coefficients(const std::vector<double>& k, bool fisheye, const std::string& where,
                       Lens& lens, SetDraft& draft);

// Throws InputError where the matrix, or focal lengths and centre, are all 0.
void check_calibrated(const std::vector<double>& matrix, const std::string& where);

// Warns of a lens that is not one-to-one over its image, and of a principal point outside it.
void doubt_lens(const PlainCamera& camera, const std::string& where, SetDraft& draft);

// Throws InputError where the numbers are no camera's.
void check_camera(const PlainCamera& camera, const std::string& where);

}  // namespace seam::app
