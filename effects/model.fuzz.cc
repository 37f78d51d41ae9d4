// Whatever a model file holds, reading it ends in a model or an InputError.
#include "effects/model.h"

#include "sim_core/base/config.h"
#include "sim_core/base/error.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  try {
    const std::string text(reinterpret_cast<const char*>(data), size);
    seam::effects::Model::from_config(seam::ConfigNode::from_text(text, "fuzz.yaml"));
  } catch (const seam::InputError&) {
  }
  return 0;
}
