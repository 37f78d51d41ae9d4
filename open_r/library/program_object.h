// An object that was built as a shared library. Several that have classes of one name do not meet:
// each finds its own first.
#pragma once

#include <filesystem>
#include <string>

#include "open_r/library/system.h"

namespace seam::open_r {

// Loads the object; its constructors run. Throws Fault where the file is none.
OID load_object(System& system, const std::string& name, const std::filesystem::path& file);

}  // namespace seam::open_r
