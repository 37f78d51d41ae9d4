#include "measurement/kinds/landmarks/landmark_findings.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>

namespace seam::measurement {
namespace {

// A landmark that lies clearly off its place in the map.
std::optional<Finding> misplaced(const std::string& name, const Displacement& found) {
  constexpr double kClear2 = 20;  // Chi-square of two: 5e-5 of all landmarks by chance.
  const double x = found.mean_m[0], y = found.mean_m[1], size = std::hypot(x, y);
  const auto [xx, yy, xy] = found.covariance_m2;
  const double chi2 = (yy * x * x - 2 * xy * x * y + xx * y * y) / (xx * yy - xy * xy);
  if (!(chi2 > kClear2)) return std::nullopt;
  const double along = std::sqrt(xx * x * x + 2 * xy * x * y + yy * y * y) / size;
  return Finding{
      .what = "landmark",
      .name = name,
      .values = {{"distance_m", size},
                 {"sigma_m", along},
                 {"dx_m", x},
                 {"dy_m", y},
                 {"dx_sigma_m", std::sqrt(xx)},
                 {"dy_sigma_m", std::sqrt(yy)}},
      .text = fmt::format("landmark {} lies {:.3g} +- {:.2g} cm from where the map says (x "
                          "{:+.3g} cm, y {:+.3g} cm)",
                          name, 100 * size, 100 * along, 100 * x, 100 * y)};
}

// A landmark whose ranges are clearly too long or too short.
std::optional<Finding> delayed(const std::string& name, const Displacement& found) {
  constexpr double kClear = 4;  // Sigmas: 6e-5 of all landmarks by chance.
  const double sigma_m = std::sqrt(found.delay_variance_m2);
  if (!(std::abs(found.delay_m) > kClear * sigma_m)) return std::nullopt;
  return Finding{.what = "landmark",
                 .name = name,
                 .values = {{"delay_m", found.delay_m}, {"delay_sigma_m", sigma_m}},
                 .text = fmt::format("ranges of landmark {} are too {} by {:.3g} +- {:.2g} cm",
                                     name, found.delay_m > 0 ? "long" : "short",
                                     100 * std::abs(found.delay_m), 100 * sigma_m)};
}

}  // namespace

std::vector<Finding> found_of(const std::vector<std::string>& landmarks,
                              const effects::Noise& noise,
                              const std::vector<Displacement>& displacements) {
  std::vector<Finding> findings;
  for (size_t k = 0; k < displacements.size(); ++k) {
    for (const auto& found :
         {noise.place_variance > 0 ? misplaced(landmarks[k], displacements[k]) : std::nullopt,
          noise.delay_variance > 0 ? delayed(landmarks[k], displacements[k]) : std::nullopt}) {
      if (found) findings.push_back(*found);
    }
  }
  return findings;
}

FieldPlace over_time_by_landmark(const LandmarkData& data, const Facts& facts,
                                 const Evaluation& here) {
  const std::vector<double> none(facts.scalars(), 0);
  const size_t channels = facts.channels.size(), landmarks = data.landmarks.size();
  FieldPlace place{.slopes = {channels, none},
                   .covariates = {facts.covariates[0]},
                   .part_of_row = data.landmark_of_row,
                   .part = "landmark",
                   .named = {channels * landmarks, none}};
  for (size_t i = 0; i < facts.scalars(); ++i) {
    const auto channel = static_cast<size_t>(facts.channel_of[i]);
    const auto landmark = static_cast<size_t>(data.landmark_of_row[facts.row_of[i]]);
    place.slopes[channel][i] = facts.channels[channel].noise / here.sigma[i];
    place.named[channel * landmarks + landmark][i] = place.slopes[channel][i];
  }
  return place;
}

}  // namespace seam::measurement
