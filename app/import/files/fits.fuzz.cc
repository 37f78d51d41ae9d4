// Whatever FITS and EXIF headers hold, reading them ends in pixels, an exposure, nothing or an
// InputError.
#include "app/import/files/fits.h"

#include "sim_core/base/error.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  seam::app::exif_exposure_s(bytes);
  try {
    seam::app::read_fits(bytes, "input");
  } catch (const seam::InputError&) {
  }
  return 0;
}
