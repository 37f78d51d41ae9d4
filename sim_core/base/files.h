// Whole files in; sim_core/base/output.h is for what goes out.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace seam {

// Throws InputError with the file's name when it cannot be read or is larger than `limit_bytes`.
// Only files with an end are read: folders, pipes, sockets and devices are refused.
std::string read_file(const std::filesystem::path& path, uint64_t limit_bytes = uint64_t{1} << 32);

}  // namespace seam
