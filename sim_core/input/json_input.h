// JSON of other people, bounded in size and depth.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace seam {

// Throws InputError where the file cannot be read, is longer than 256 MiB, is no JSON or nests
// deeper than 64 levels (whoever walks a JSON value goes down by recursion). `expected` completes
// the message.
nlohmann::json read_json(const std::filesystem::path& path, const std::string& expected);
nlohmann::json json_from_text(const std::string& text, const std::string& name,
                              const std::string& expected);

}  // namespace seam
