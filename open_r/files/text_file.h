// A file of settings, whole.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

namespace seam::open_r {

// Of settings, Makefiles and stubs: people write them.
constexpr size_t kMostTextBytes = size_t{4} << 20;

// Throws Fault with the file's name where it cannot be read or is longer. Only files with an end
// are read: folders, pipes, sockets and devices are refused.
std::string read_text(const std::filesystem::path& file);

}  // namespace seam::open_r
