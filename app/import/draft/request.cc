#include "app/import/draft/request.h"

#include <charconv>
#include <cmath>
#include <numbers>

#include "sim_core/base/error.h"

namespace seam::app {
namespace {

using Units = std::vector<std::pair<std::string, double>>;

double factor_of(const Units& units, const std::string& unit, const char* of) {
  std::vector<std::string> known;
  for (const auto& [name, factor] : units) {
    if (name == unit) return factor;
    known.push_back(name);
  }
  throw UsageError(fmt::format("'{}' is no unit of {}{}", unit, of, suggestion_for(unit, known)));
}

}  // namespace

double radians_in(const std::string& unit) {
  constexpr double kTurn = 2 * std::numbers::pi;
  if (unit.starts_with("ticks:")) {
    double ticks = 0;
    const char* end = unit.data() + unit.size();
    const auto [stop, error] = std::from_chars(unit.data() + 6, end, ticks);
    if (error == std::errc() && stop == end && ticks >= 1 && std::isfinite(ticks))
      return kTurn / ticks;
    throw UsageError(fmt::format("'{}': expected ticks:N with N ticks a turn", unit));
  }
  return factor_of(
      {{"rad", 1}, {"mrad", 1e-3}, {"deg", kTurn / 360}, {"turns", kTurn}, {"ticks:N", kTurn}},
      unit, "angles");
}

double metres_in(const std::string& unit) {
  return factor_of({{"m", 1}, {"cm", 1e-2}, {"mm", 1e-3}, {"um", 1e-6}, {"in", 0.0254}}, unit,
                   "lengths");
}

int64_t nanoseconds_in(const std::string& unit) {
  return std::llround(factor_of({{"s", 1e9}, {"ms", 1e6}, {"us", 1e3}, {"ns", 1}}, unit, "times"));
}

}  // namespace seam::app
