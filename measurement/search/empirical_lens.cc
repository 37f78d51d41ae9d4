#include "measurement/search/empirical_lens.h"

#include <algorithm>
#include <cmath>

#include "effects/questions.h"

namespace seam::measurement {
namespace {

// Whether a cause may be the lens: some function of it depends on the place in the image alone.
bool of_image(const UnnamedCause& cause) {
  const auto is_place = [](const std::string& name) {
    return name == "row" || name == "column" || name == "radius";
  };
  return std::any_of(cause.depends_on.begin(), cause.depends_on.end(), [&](const auto& names) {
    return std::all_of(names.begin(), names.end(), is_place);
  });
}

// Pixels, over both directions.
double rms_of(const Assessment& assessment) {
  double sum2 = 0;
  for (const double rms : assessment.held.native) sum2 += rms * rms;
  return std::sqrt(sum2 / static_cast<double>(assessment.held.native.size()));
}

double noise_px(const Problem& problem) {
  double sum2 = 0;
  for (const Channel& channel : problem.facts().channels) sum2 += channel.noise * channel.noise;
  return std::sqrt(sum2 / static_cast<double>(problem.facts().channels.size()));
}

}  // namespace

void hold_against_splines(const Problem& problem, const Progress& progress, const Grown& searched,
                          SearchResult& result) {
  if (!result.unnamed || !of_image(*result.unnamed)) return;
  const auto splines = effects::any_lens();
  if (!splines || !problem.acts(*splines)) return;
  progress("holding lenses against splines");
  const auto with_splines = [&](const Grown& base) {
    std::vector<NotTestable> reasons;
    return try_effect(problem, base, splines, reasons);
  };
  std::optional<Candidate> best = with_splines(result.best);
  if (searched.added.size() > result.best.added.size() &&
      (!best || best->grown.assessment.error > kMisfit)) {
    auto other = with_splines(searched);
    if (other && (!best || merit_of(other->grown) > merit_of(best->grown) + kUnnamedWidth))
      best = std::move(other);
  }
  if (!best || !best->grown.assessment.valid) return;
  const Assessment& with = best->grown.assessment;
  const Assessment& named = searched.assessment;
  // Where something is left that is no noise, evidence is too sure.
  const double misfit = std::max(1.0, with.error * with.error);
  const double lead = (merit_of(best->grown) - merit_of(searched)) / misfit;
  const double more_px2 = std::pow(rms_of(named), 2) - std::pow(rms_of(with), 2);
  if (!(lead > kUnnamedWidth) || !(with.held_ll() > named.held_ll()) ||
      !(more_px2 > std::pow(result.material * noise_px(problem), 2)))
    return;
  result.splines = EmpiricalLens{.effect = splines->name,
                                 .lead = lead,
                                 .error = with.error,
                                 .named_error = named.error,
                                 .rms_px = rms_of(with),
                                 .named_rms_px = rms_of(named)};
  EmpiricalLens& lens = *result.splines;
  for (const std::string& name : best->grown.added) {
    if (name != splines->name) lens.beside.push_back(name);
  }
  for (const effects::ModelEffect& effect : named.model.effects()) {
    if (effects::replaces(*splines, effect.definition->term))
      lens.named.push_back(effect.definition->name);
  }
  lens.assessment = with;
}

}  // namespace seam::measurement
