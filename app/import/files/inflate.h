// Deflated bytes of strangers.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace seam::app {

enum class Deflate { zlib, raw };

// Throws InputError, naming `where`, for damaged bytes and for more than `limit_bytes`.
std::string inflated(std::string_view packed, Deflate form, uint64_t limit_bytes,
                     const std::string& where);

}  // namespace seam::app
