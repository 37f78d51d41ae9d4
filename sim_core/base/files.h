// Whole files in and out. Output is written to a temporary beside the target and renamed, so that
// a reader never sees half a file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace seam {

// Throws InputError with the file's name when it cannot be read or is larger than `limit_bytes`.
// Only files with an end are read: folders, pipes, sockets and devices are refused.
std::string read_file(const std::filesystem::path& path, uint64_t limit_bytes = uint64_t{1} << 32);

void write_file_atomically(const std::filesystem::path& path, std::string_view contents);

}  // namespace seam
