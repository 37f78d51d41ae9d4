// What a match shows, as a scene of a measurement set.
#pragma once

#include <string>
#include <vector>

#include "app/import/draft/set_draft.h"
#include "sim_core/scene/scene.h"

namespace seam::app {

// The scene at one instant, and the same primitives, in the same order, at later ones: what moves
// evenly gets its velocity. The draft says what was left out, and what moves as no scene holds it.
struct SceneAt {
  SimTime time;
  std::vector<Primitive> primitives;
};
std::string scene_yaml(const std::vector<SceneAt>& instants, const Rgb& background,
                       const Lighting& lighting, SetDraft& draft);

}  // namespace seam::app
