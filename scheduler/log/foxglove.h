// A match in Foxglove's well-known schemas (log_manifest.h), so that other MCAP tools show it.
// Frames of reference: "world" (W), "ROBOT" (B, the body), "ROBOT/camera" (C: x right, y down, z
// forward; before the model's mount effects).
#pragma once

#include <string>
#include <string_view>

#include "sim_core/world/world.h"

namespace seam::scheduler {

// Each returns the bytes of one message.
std::string compressed_image(SimTime time, const std::string& frame_id, std::string png);
std::string frame_transforms(const World& world, SimTime time);
// Ball and robots; with `all`, also what stands still.
std::string scene_update(const World& world, SimTime time, bool all);

// The PNG in a foxglove.CompressedImage; throws InputError where the bytes are none.
std::string picture_of(std::string_view compressed_image);

}  // namespace seam::scheduler
