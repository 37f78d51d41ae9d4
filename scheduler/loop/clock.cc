#include "scheduler/loop/clock.h"

#include <algorithm>
#include <cmath>

#include "sim_core/base/error.h"

namespace seam::scheduler {

namespace {
__extension__ using Wide = __int128;
}

Clock::Clock(const ClockSettings& settings, RandomStream jitter)
    : settings_(settings), jitter_(jitter) {
  SEAM_CHECK(settings.period.ns() > 0, "period {} ns", settings.period.ns());
  SEAM_CHECK(settings.divisor > 0, "divisor {}", settings.divisor);
  SEAM_CHECK(std::abs(settings.drift) < 0.1, "drift {}", settings.drift);
}

SimTime Clock::tick(int64_t index) const {
  // Exact for any run that fits 292 years: the product needs more than 64 bits only on the way.
  const auto nominal_ns =
      static_cast<int64_t>(static_cast<Wide>(index) * settings_.period.ns() / settings_.divisor);
  int64_t ns = settings_.offset.ns() + nominal_ns +
               std::llround(static_cast<double>(nominal_ns) * settings_.drift);
  if (settings_.jitter_sigma_s > 0) {
    const double limit_ns =
        0.45 * static_cast<double>(settings_.period.ns()) / static_cast<double>(settings_.divisor);
    const double jitter_ns =
        settings_.jitter_sigma_s * 1e9 * normal(jitter_, static_cast<uint64_t>(index));
    ns += std::llround(std::clamp(jitter_ns, -limit_ns, limit_ns));
  }
  // A jitter cannot move a tick before the start of the run.
  return SimTime::from_ns(std::max<int64_t>(ns, 0));
}

int64_t Clock::first_at_or_after(SimTime time) const {
  const double period_ns = static_cast<double>(settings_.period.ns()) /
                           static_cast<double>(settings_.divisor) * (1 + settings_.drift);
  const double since_ns = static_cast<double>(time.ns() - settings_.offset.ns());
  int64_t index = std::max<int64_t>(0, static_cast<int64_t>(since_ns / period_ns) - 2);
  while (tick(index) < time) ++index;
  return index;
}

ClockSettings clock_settings(const ClockSpec& spec) {
  return {.offset = spec.phase,
          .period = spec.period,
          .drift = spec.drift_ppm * 1e-6,
          .jitter_sigma_s = spec.jitter_sigma.s()};
}

ClockSettings clock_settings(const CameraSpec& camera) {
  if (!camera.locked) return clock_settings(camera.clock);
  return {.offset = camera.lock_start, .period = camera.lock_cycle, .divisor = camera.lock_frames};
}

}  // namespace seam::scheduler
