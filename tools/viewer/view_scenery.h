// Who plays on what: a match's robots, and what stands still there, for the viewer
// (docs/reference/viewer_api.md).
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "render/assets/assets.h"
#include "sim_core/world/world.h"

namespace seam::tools {

// The primitives of the world at its start that do not move, from the ground up. `assets`: of the
// renderer that draws them, null where it has no meshes.
nlohmann::json scenery_of(const World& world, const render::Assets* assets);
// The scenario's robots, in its order.
nlohmann::json robots_of(const Scenario& scenario);

}  // namespace seam::tools
