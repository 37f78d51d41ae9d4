// Deflated bytes of strangers.
#pragma once

#include <string>
#include <string_view>

#include "app/import/files/budget.h"

namespace seam::app {

enum class Deflate { zlib, raw };

// Throws InputError, naming `where`, for damaged bytes and for more than the budget has.
std::string inflated(std::string_view packed, Deflate form, UnpackBudget& budget,
                     const std::string& where);

}  // namespace seam::app
