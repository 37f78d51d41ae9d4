// Other people's files as bytes.
#pragma once

#include <filesystem>
#include <string>

namespace seam::app {

// Throws InputError where the file cannot be read, is empty, or is the pointer that Git LFS leaves
// in place of a large file that was not fetched.
std::string read_source(const std::filesystem::path& path,
                        uint64_t limit_bytes = uint64_t{1} << 30);

}  // namespace seam::app
