#include "app/import/draft/checks.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>

#include "sim_core/base/error.h"

namespace seam::app {
namespace {

double median_step_ns(const std::vector<int64_t>& ns) {
  std::vector<double> steps;
  for (size_t i = 1; i < ns.size(); ++i) {
    if (ns[i] > ns[i - 1])
      steps.push_back(static_cast<double>(ns[i]) - static_cast<double>(ns[i - 1]));
  }
  if (steps.empty()) return 0;
  std::nth_element(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2),
                   steps.end());
  return steps[steps.size() / 2];
}

}  // namespace

int64_t time_unit_ns(const ImportRequest& request, const std::string& column) {
  if (!request.time_unit.empty()) return nanoseconds_in(request.time_unit);
  for (const char* unit : {"ms", "us", "ns"}) {
    for (const char* joint : {"_", "[", "(", " "}) {
      const size_t at = column.find(std::string(joint) + unit);
      if (at != std::string::npos && at + 3 + (joint[0] == '[' || joint[0] == '(') >= column.size())
        return nanoseconds_in(unit);
    }
  }
  return nanoseconds_in("s");
}

std::string unit_in(const std::string& column, const std::vector<std::string>& units) {
  size_t end = column.size();
  while (end > 0 && (column[end - 1] == ']' || column[end - 1] == ')')) --end;
  size_t start = end;
  while (start > 0 && std::isalpha(static_cast<unsigned char>(column[start - 1])) != 0) --start;
  if (start == 0) return "";  // The whole name.
  std::string word = column.substr(start, end - start);
  for (char& c : word) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  for (const auto& [spelt, unit] :
       {std::pair{"degree", "deg"}, {"degrees", "deg"}, {"radian", "rad"}, {"radians", "rad"}}) {
    if (word == spelt) word = unit;
  }
  return std::find(units.begin(), units.end(), word) == units.end() ? "" : word;
}

std::string angle_unit_in(const std::string& column) {
  return unit_in(column, {"deg", "rad", "mrad"});
}

std::string length_unit_in(const std::string& column) {
  return unit_in(column, {"m", "cm", "mm", "um"});
}

void check_times(const std::vector<int64_t>& ns, const RowPlace& place,
                 const ImportRequest& request, double most_step_s, SetDraft& draft) {
  for (size_t i = 1; i < ns.size(); ++i) {
    if (ns[i] < ns[i - 1])
      throw InputError(
          fmt::format("{}: found a time {} s before that of the row above it, expected times that "
                      "run forwards (several runs in one file need a column that names them)",
                      place(i), seconds_text(ns[i - 1] - ns[i])));
  }
  const double step_ns = median_step_ns(ns);
  if (step_ns == 0) return;
  if (request.time_unit.empty() && (step_ns > most_step_s * 1e9 || step_ns < 1e3)) {
    std::string meant = "another unit";
    for (const auto& [unit, below] : {std::pair{"ms", 1e3}, {"us", 1e6}, {"ns", 1e9}}) {
      if (step_ns / below <= most_step_s * 1e9 && step_ns > 1e9 * most_step_s) {
        meant = unit;
        break;
      }
    }
    throw InputError(fmt::format(
        "{}: times are {:.4g} s apart here, expected seconds: they look like {}; say it, "
        "--time-unit s, ms, us or ns",
        place(1), step_ns * 1e-9, meant));
  }
  size_t jumps = 0, first = 0;
  for (size_t i = 1; i < ns.size(); ++i) {
    if (static_cast<double>(ns[i] - ns[i - 1]) <= 20 * step_ns) continue;
    if (jumps++ == 0) first = i;
  }
  if (jumps > 0)
    draft.warn(
        fmt::format("{}: the clock jumps by {:.6g} s where {:.4g} s are usual, {} such jumps in "
                    "all",
                    place(first), static_cast<double>(ns[first] - ns[first - 1]) * 1e-9,
                    step_ns * 1e-9, jumps));
}

void to_radians(std::vector<double>& values, const std::string& quantity, const RowPlace& place,
                const ImportRequest& request, SetDraft& draft) {
  constexpr double kMost_rad = 5 * 2 * std::numbers::pi;
  size_t largest = 0;
  for (size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i]))
      throw InputError(fmt::format("{}: {}: found no number, expected a finite angle in each row",
                                   place(i), quantity));
    if (std::abs(values[i]) > std::abs(values[largest])) largest = i;
  }
  if (values.empty()) return;
  const double most = std::abs(values[largest]);
  if (request.unit.empty()) {
    if (most > kMost_rad)
      throw InputError(fmt::format(
          "{}: {}: found {}, expected radians: angles like this look like {}; say it, --unit deg, "
          "rad, turns or ticks:N",
          place(largest), quantity, values[largest],
          most > 720 ? "ticks of an encoder" : "degrees"));
    return;
  }
  const double factor = radians_in(request.unit);
  for (double& value : values) value *= factor;
  if (request.unit == "deg" && most < 3.5 && most > 0)
    draft.warn(fmt::format("{}: {} reaches {} only: are these radians, not degrees?",
                           place(largest), quantity, most));
  if (request.unit == "rad" && most > 4 * kMost_rad)
    draft.warn(fmt::format("{}: {} reaches {}: are these degrees, not radians?", place(largest),
                           quantity, values[largest]));
}

}  // namespace seam::app
