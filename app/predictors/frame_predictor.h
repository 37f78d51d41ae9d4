// The renderers as measurement sets of whole images need them: the ray caster, or OpenGL for scenes
// with meshes or textures.
#pragma once

#include "measurement/imaging/instruments.h"

namespace seam::app {

measurement::OpenFrameRenderer rendered_frames();

}  // namespace seam::app
