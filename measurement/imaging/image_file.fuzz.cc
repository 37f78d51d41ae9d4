// Whatever bytes stand in a picture (PNG, TIFF), reading it ends in an image or an InputError.
#include "measurement/imaging/image_file.h"

#include "sim_core/base/error.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  try {
    seam::measurement::decode_image(std::string(reinterpret_cast<const char*>(data), size),
                                    "input");
  } catch (const seam::InputError&) {
  }
  return 0;
}
