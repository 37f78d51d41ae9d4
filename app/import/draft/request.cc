#include "app/import/draft/request.h"

#include <fmt/ranges.h>

#include <algorithm>
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

bool holds(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

std::string ImportRequest::name_of(const std::string& quantity) const {
  // A name that is missing in the kind's list would be refused when users map it.
  SEAM_CHECK(quantities.empty() || holds(quantities, quantity), "{}", quantity);
  const auto found = names.find(quantity);
  return found == names.end() ? "" : found->second;
}

const std::string& ImportRequest::unit_of(const std::string& quantity,
                                          const std::string& general) const {
  const auto own = own_units.find(quantity);
  return own == own_units.end() ? general : own->second;
}

void check_names(const ImportRequest& request, const std::string& kind) {
  const auto check = [&](const char* option, const auto& pairs) {
    for (const auto& [ours, theirs] : pairs) {
      if (holds(request.quantities, ours)) continue;
      throw UsageError(
          fmt::format("{} {}={}: unknown name '{}', expected one of the names of import {}: {}",
                      option, ours, theirs, ours, kind, fmt::join(request.quantities, ", ")));
    }
  };
  check("--map", request.names);
  check("a unit,", request.own_units);
}

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
