// Points seen in views that turn as a gyroscope on the camera's body says.
#include <fmt/core.h>

#include "effects/stages/timing.h"
#include "measurement/kinds/points/points_problem.h"
#include "sim_core/base/error.h"

namespace seam::measurement {
namespace {

// Whether the effect changes what a gyroscope says of a camera's turns.
bool moves_turns(const EffectDefinition& effect) {
  if (effect.stage != effects::kInertial) return false;
  const effects::Inertial by = tried_alone(effect, 0);
  return is_of_camera(by) || moves_rates(by.gyro);
}

}  // namespace

bool PointsProblem::acts(const EffectDefinition& effect) const {
  return Problem::acts(effect) || (data_.gyroscope && moves_turns(effect));
}

std::string PointsProblem::not_testable(const Model& model, const EffectDefinition& effect,
                                        size_t parameter) const {
  if (!data_.gyroscope || !moves_turns(effect))
    return Problem::not_testable(model, effect, parameter);
  const effects::Inertial by = tried_alone(effect, parameter);
  if (effects::timing_of(model).line_delay_s == 0)
    return "the model reads all rows at once, which shows no turn: add rolling_shutter first";
  if (by.camera_offset_of_exposure != 0 && data_.exposure_s.empty())
    return "points have no exposure_s";
  if (by.gyro.per_k != effects::Triad{} && data_.gyroscope->readings.temperature_c.empty())
    return "no temperature was logged";
  return "";
}

void PointsProblem::check_offset(const Model& model) const {
  const effects::Inertial inertial = effects::inertial_of(model);
  const double last_s = data_.gyroscope->readings.at_s.back();
  for (size_t row = 0; row < data_.stamp_s.size(); ++row) {
    const double exposure_s = data_.exposure_s.empty() ? 0 : data_.exposure_s[row];
    const double by_s = offset_at(inertial, exposure_s);
    const double at_s = data_.stamp_s[row] - data_.gyroscope->first_s + by_s;
    if (at_s >= 0 && at_s <= last_s) continue;
    throw InputError(fmt::format(
        "{}:{}: found a view at {:.4g} s by the clock of the gyroscope, whose readings go from 0 "
        "to {:.4g} s: expected a camera_imu_offset under which imu.csv covers all views (here "
        "{:.4g} s), or leave the view out",
        facts_.file, facts_.line_of_row[row], at_s, last_s, by_s));
  }
}

}  // namespace seam::measurement
