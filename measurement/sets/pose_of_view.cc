#include "measurement/sets/pose_of_view.h"

#include <algorithm>
#include <cmath>

namespace seam::measurement {
namespace {

// A view whose width is fewer sigmas of the noise turns about its line by more than a step of a fit
// can follow.
constexpr double kSigmas = 5;
// Of the length: a width below the one may be noise where none is stated; one above the other is
// none, whatever is stated.
constexpr double kNarrow = 0.01, kWide = 0.1;

}  // namespace

PointSpread spread_of(const std::vector<Vec3>& points) {
  if (points.empty()) return {};
  const auto count = static_cast<double>(points.size());
  Vec3 middle(0.0), along(0.0);
  for (const Vec3& p : points) middle += p / count;
  double sum2 = 0;
  for (const Vec3& p : points) {
    const Vec3 d = p - middle;
    sum2 += glm::dot(d, d);
    if (glm::dot(d, d) > glm::dot(along, along)) along = d;
  }
  if (!(sum2 > 0)) return {};
  // The direction of the largest spread, by the power method.
  constexpr int kRounds = 30;
  for (int round = 0; round < kRounds; ++round) {
    const Vec3 axis = glm::normalize(along);
    along = Vec3(0.0);
    for (const Vec3& p : points) along += glm::dot(p - middle, axis) * (p - middle);
  }
  const Vec3 axis = glm::normalize(along);
  double across2 = 0;
  for (const Vec3& p : points) {
    const Vec3 d = glm::cross(p - middle, axis);
    across2 += glm::dot(d, d);
  }
  return {std::sqrt(sum2 / count), std::sqrt(across2 / count)};
}

std::optional<double> stated_noise_px(const MeasurementSet& set, const CsvTable& table) {
  if (table.has("sigma_px") && table.rows() > 0) {
    std::vector<double> sigma = table.numbers("sigma_px");
    const auto middle = sigma.begin() + static_cast<std::ptrdiff_t>(sigma.size() / 2);
    std::nth_element(sigma.begin(), middle, sigma.end());
    return *middle;
  }
  const auto u = set.noise.find("u_px"), v = set.noise.find("v_px");
  if (u == set.noise.end() || v == set.noise.end()) return std::nullopt;
  return std::max(u->second, v->second);
}

std::string why_no_pose(const std::vector<Vec3>& points_m, const std::vector<Vec3>& image_px,
                        std::optional<double> noise_px) {
  if (points_m.size() < kPointsOfPose)
    return "fewer than 4 points: that is too few to tell a pose of 6 unknowns and a model by";
  const PointSpread target = spread_of(points_m), image = spread_of(image_px);
  const double least_px =
      noise_px ? std::min(kSigmas * *noise_px, kWide * image.length) : kNarrow * image.length;
  if (!(target.length > 0)) return "points at one place of the target, which fix no pose";
  if (!(image.length > noise_px.value_or(0)))
    return "points at one place of the image, which fix no pose";
  // What the width of the target would measure in the image if the view faced it.
  const double faced_px = target.width * image.length / target.length;
  if (!(faced_px > least_px))
    return "points on one line of the target: the view may turn about it, so that they fix no pose";
  if (!(image.width > least_px))
    return "points on one line of the image: the target is seen edge on, so that they fix no pose";
  return "";
}

}  // namespace seam::measurement
