// Whatever a scenario file holds, reading it ends in a scenario or an InputError.
#include "sim_core/scenario/scenario.h"

#include "sim_core/base/error.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  try {
    const std::string text(reinterpret_cast<const char*>(data), size);
    seam::Scenario::from_text(text, "fuzz.yaml").to_yaml();
  } catch (const seam::InputError&) {
  }
  return 0;
}
