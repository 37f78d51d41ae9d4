// Whatever a MAT-file holds, reading it ends in arrays or an InputError.
#include "app/import/files/mat_file.h"

#include "sim_core/base/error.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  try {
    seam::app::MatFile::from_bytes({reinterpret_cast<const char*>(data), size}, "input");
  } catch (const seam::InputError&) {
  }
  return 0;
}
