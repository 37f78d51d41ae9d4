// Images as scientific cameras' programs write them: PNG and TIFF, told apart by their first bytes.
#pragma once

#include <filesystem>
#include <string>

#include "sim_core/base/image.h"

namespace seam::measurement {

// Grey or RGB, 8 or 16 bits a sample; throws InputError for anything else, damaged files, files of
// several images, or more than 64 million pixels.
Image read_image(const std::filesystem::path& path);
// The same of a file's bytes; `name` is what errors call it.
Image decode_image(std::string bytes, const std::string& name);

}  // namespace seam::measurement
