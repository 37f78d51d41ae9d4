// Robots from URDF files: links, joints with their limits, what is to be seen. Inertias and
// collision shapes are left aside but for the mass: the simulator's robots move as their servos do.
#pragma once

#include <map>
#include <string>

#include "sim_core/body/robot_body.h"

namespace seam {

// The body that a file says: its tree (not connected yet), parts, name and mass. `packages` are
// folders, relative to the file's folder as it was named, by the names in package:// addresses. All
// meshes are inside `file.folder`. Colours are taken as sRGB. Throws InputError naming file and
// line.
RobotBody body_from_urdf(const std::string& text, const FileName& file,
                         const std::map<std::string, std::string>& packages);
// The same of the file's own text.
RobotBody body_from_urdf(const FileName& file, const std::map<std::string, std::string>& packages);

}  // namespace seam
