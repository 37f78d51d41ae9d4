#include "effects/not_a_number.h"

#include <cmath>

#include "sim_core/base/error.h"

namespace seam::effects {

std::string number_shown(double value) {
  return std::isnan(value) ? "nan" : fmt::format("{:g}", value);
}

void fail_with(const std::string& effect, const std::string& output, double value,
               const std::string& where) {
  throw InputError(
      fmt::format("{}: effect '{}' gives {} = {}, expected a number that can be used (`seam "
                  "check MODEL` tries a formula over its ranges)",
                  where, effect, output, number_shown(value)));
}

std::string robot_at(const std::string& robot, double t_s) {
  return fmt::format("robot '{}' at {:.9g} s", robot, t_s);
}

}  // namespace seam::effects
