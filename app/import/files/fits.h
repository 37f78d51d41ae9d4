// FITS images and EXIF exposures, in memory and bounded: the little of both that flat fields need.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "sim_core/base/image.h"

namespace seam::app {

struct FitsImage {
  Image image;                                // Of 8 or 16 bits.
  std::map<std::string, std::string> header;  // By keyword; text without its quotes.
};

bool is_fits(std::string_view bytes);
// The primary image. Throws InputError for anything but integers that 16 bits hold, and for more
// than 64 million pixels.
FitsImage read_fits(std::string_view bytes, const std::string& name);

// ExposureTime of a TIFF file, or of the eXIf chunk of a PNG; nothing where it has none.
std::optional<double> exif_exposure_s(std::string_view bytes);

}  // namespace seam::app
