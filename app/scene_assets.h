// What draws a scenario's frames: the ray caster, or OpenGL with the meshes and textures that the
// scenario's objects name.
#pragma once

#include <memory>
#include <string>

#include "render/gl/device.h"
#include "sim_core/scenario/scenario.h"
#include "sim_core/scene/scene_file.h"

namespace seam::app {

// Reads the meshes and textures that the scenario's objects and robots name; these get what their
// files say (ObjectSpec::asset, size and fingerprint). Throws InputError for files that cannot be
// had.
render::Assets read_assets(Scenario& scenario);
// The same of a scene, in its files' order, and of a robot.
render::Assets read_assets(const SceneFiles& files);
render::Assets read_assets(RobotBody& body);

// `drawing`: "analytic", "opengl", or "auto", OpenGL where an object needs it. None where the ray
// caster makes the frames. `gl`: where OpenGL comes from, see GlDevice. Throws InputError as
// read_assets, and where the ray caster was asked for what it cannot draw.
std::unique_ptr<render::GlDevice> device_for(Scenario& scenario, const std::string& drawing,
                                             const std::string& gl);

}  // namespace seam::app
