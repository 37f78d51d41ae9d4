#include "sim_core/base/error.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <numeric>

namespace seam {
namespace {

size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t{0});
  for (size_t i = 1; i <= a.size(); ++i) {
    size_t diagonal = row[0];
    row[0] = i;
    for (size_t j = 1; j <= b.size(); ++j) {
      const size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
    }
  }
  return row[b.size()];
}

}  // namespace

const std::string* near_name(std::string_view unknown, const std::vector<std::string>& known) {
  const auto nearest =
      std::min_element(known.begin(), known.end(), [&](const auto& a, const auto& b) {
        return edit_distance(unknown, a) < edit_distance(unknown, b);
      });
  if (nearest == known.end()) return nullptr;
  const size_t distance = edit_distance(unknown, *nearest);
  // Of a short word most letters must agree, or each other short word would be near.
  const bool near =
      distance <= std::max<size_t>(2, unknown.size() / 2) && 2 * distance <= nearest->size();
  return near ? &*nearest : nullptr;
}

std::string suggestion_for(std::string_view unknown, const std::vector<std::string>& known) {
  if (known.empty()) return "";
  if (const std::string* near = near_name(unknown, known))
    return fmt::format(", did you mean '{}'?", *near);
  return fmt::format(", known: {}", fmt::join(known, ", "));
}

void check_failed(const char* file, int line, const char* condition, const std::string& values) {
  std::fprintf(stderr, "%s:%d: internal check failed: %s %s\n", file, line, condition,
               values.c_str());
  std::abort();
}

}  // namespace seam
