// Supplies render/'s renderer to measurement sets of kind `frames`.
#pragma once

namespace seam::app {

void supply_renderer_to_measurements();

}  // namespace seam::app
