// What a glTF file unpacks to, counted before any library unpacks it: nodes may be shared, and
// accessors may have more values than there are bytes.
#pragma once

#include <string>

namespace seam::render {

// `bytes`: of a .gltf or .glb file. Throws InputError where its scenes hold more than
// kMostTriangles or their children go in a circle. Says nothing of files that are broken otherwise:
// whoever reads them does.
void check_gltf(const std::string& bytes);

}  // namespace seam::render
