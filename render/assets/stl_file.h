// Plain binary STL, the format of most robots' meshes: read without the library that knows all
// formats, which takes far more time and memory for it (docs/reference/rendering.md).
#pragma once

#include <string_view>

#include "render/assets/mesh_bytes.h"

namespace seam::render {

// Whether the bytes are such a file without colours, which Assimp reads.
bool is_plain_stl(std::string_view bytes);

// Its triangles, with the vertices that Assimp makes of it. Throws InputError for places that are
// no numbers.
ReadMesh read_plain_stl(std::string_view bytes);

}  // namespace seam::render
