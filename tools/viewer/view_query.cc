#include "tools/viewer/view_query.h"

#include <charconv>
#include <cmath>

#include "sim_core/base/error.h"

namespace seam::tools {

double number_of(const Query& query, const std::string& name, double fallback) {
  const auto found = query.find(name);
  if (found == query.end()) return fallback;
  const std::string& text = found->second;
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value) ||
      std::abs(value) > 9e9) {
    throw UsageError(fmt::format("{}: found '{}', expected a number", name, text.substr(0, 40)));
  }
  return value;
}

int64_t integer_of(const Query& query, const std::string& name, int64_t fallback) {
  const double value = number_of(query, name, static_cast<double>(fallback));
  if (value != std::floor(value) || value < 0) {
    throw UsageError(name + ": expected a whole number from 0 on");
  }
  return static_cast<int64_t>(value);
}

std::string text_of(const Query& query, const std::string& name, const std::string& fallback) {
  const auto found = query.find(name);
  return found == query.end() ? fallback : found->second;
}

}  // namespace seam::tools
