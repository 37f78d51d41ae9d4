#include "sim_core/input/json_input.h"

#include <nlohmann/json.hpp>

#include "sim_core/base/error.h"
#include "sim_core/base/files.h"

namespace seam {
namespace {

constexpr uint64_t kMaxBytes = uint64_t{256} << 20;
constexpr int kMaxDepth = 64;

}  // namespace

nlohmann::json json_from_text(const std::string& text, const std::string& name,
                              const std::string& expected) {
  const auto refuse_depth = [&](int depth, nlohmann::json::parse_event_t, nlohmann::json&) {
    if (depth > kMaxDepth)
      throw InputError(fmt::format("{}: nested deeper than {} levels", name, kMaxDepth));
    return true;
  };
  try {
    return nlohmann::json::parse(text, refuse_depth);
  } catch (const nlohmann::json::parse_error& error) {
    throw InputError(
        fmt::format("{}: byte {}: found no JSON, expected {}", name, error.byte, expected));
  } catch (const nlohmann::json::out_of_range&) {
    throw InputError(
        fmt::format("{}: holds a number that no double can, expected {}", name, expected));
  }
}

nlohmann::json read_json(const std::filesystem::path& path, const std::string& expected) {
  return json_from_text(read_file(path, kMaxBytes), path.string(), expected);
}

}  // namespace seam
