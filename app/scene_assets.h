// What draws a scenario's frames: the ray caster, or OpenGL with the meshes and textures that the
// scenario's objects name.
#pragma once

#include <memory>
#include <string>

#include "render/gl/device.h"
#include "sim_core/scenario/scenario.h"

namespace seam::app {

// `drawing`: "analytic", "opengl", or "auto", OpenGL where an object needs it. None where the ray
// caster makes the frames. `gl`: where OpenGL comes from, see GlDevice. Objects get what their
// files say (ObjectSpec::asset, size and fingerprint). Throws InputError for files that cannot be
// had and where the ray caster was asked for what it cannot draw.
std::unique_ptr<render::GlDevice> device_for(Scenario& scenario, const std::string& drawing,
                                             const std::string& gl);

}  // namespace seam::app
