// Pictures in bags of ROS, as files that the reader of pictures takes.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "app/import/pictures/camera_info.h"

namespace seam::app {

struct BagPictures {
  std::string topic;
  std::vector<std::filesystem::path> files;
  std::map<std::string, int64_t> stamps_ns;  // By the file's name.
  std::optional<PlainCamera> camera;         // By the CameraInfo beside the topic.
};

// Writes the pictures of one topic of images (Image or CompressedImage) into a folder, one at a
// time: the first whose name holds `camera`. Empty where the bag has none.
BagPictures unpack_pictures(const std::filesystem::path& bag, const std::string& camera,
                            const std::filesystem::path& into, SetDraft& draft);

}  // namespace seam::app
