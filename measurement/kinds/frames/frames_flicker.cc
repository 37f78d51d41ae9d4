// The residual light of whole images' rows, in which the frequency of lamps is sought.
#include "effects/stages/sensor/sensor.h"
#include "effects/stages/timing.h"
#include "measurement/imaging/flicker_search.h"
#include "measurement/kinds/frames/frames.h"

namespace seam::measurement {
std::vector<double> FramesProblem::flicker_start(const Model& model) const {
  const Groups training = training_groups();
  const Evaluation here = evaluate(model, training);
  const std::vector<size_t> frames = frames_of(training);
  const double black_dn = effects::sensor_of(model).black_dn;
  const auto rows = static_cast<size_t>(protocol_.height_px());
  const size_t row_samples = samples_ / rows;
  RowLight light{.row_delay_s = row_delays(model, protocol_.height_px())};
  for (const size_t frame : frames) {
    std::vector<double> relative(rows, 0);
    double weight = 0;
    for (size_t v = 0; v < rows; ++v) {
      double seen = 0, size = 0;
      for (size_t i = frame * samples_ + v * row_samples, end = i + row_samples; i < end; ++i) {
        const double signal = images_[frame][i - frame * samples_] - here.residual[i] - black_dn;
        const double w = signal / (here.sigma[i] * here.sigma[i]);
        seen += w * here.residual[i], size += w * signal;
      }
      if (size > 0) relative[v] = seen / size;
      weight += size / static_cast<double>(rows);
    }
    light.frame_time_s.push_back((protocol_.stamp(frame) - protocol_.reference()).s() +
                                 0.5 * effects::timing_of(model).exposure_s);
    light.relative.push_back(std::move(relative));
    light.weight.push_back(weight);
  }
  return strongest_flicker(light, 0);
}

double FramesProblem::looks(const Model& model, const EffectDefinition& effect) const {
  if (effects::start_rule(effect, facts_.set.kind).search != effects::StartSearch::frequency)
    return Problem::looks(model, effect);
  const size_t frames = protocol_.frames();
  const double span_s = (protocol_.stamp(frames - 1) - protocol_.stamp(0)).s();
  return flicker_looks(row_delays(model, protocol_.height_px()),
                       {.count = frames, .span_s = std::abs(span_s)}, frames);
}

}  // namespace seam::measurement
