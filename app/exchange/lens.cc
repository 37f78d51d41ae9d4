#include "app/exchange/lens.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <optional>

#include "measurement/numerics/damped_step.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

// Rays through a grid of pixels, borders included. Where the lens maps no ray to a pixel there is
// none.
std::vector<Sight> sights_of(const effects::Projection& projection) {
  constexpr int kColumns = 41, kRows = 31;
  std::vector<Sight> sights;
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      const double u = (projection.width_px() - 1.0) * column / (kColumns - 1);
      const double v = (projection.height_px() - 1.0) * row / (kRows - 1);
      const auto ray = projection.unproject(u, v);
      if (!ray) continue;
      const effects::ImagePoint seen = projection.project(*ray);
      if (seen.visible) sights.push_back({*ray, seen.u, seen.v});
    }
  }
  if (sights.size() < kColumns * kRows / 10)
    throw InputError(fmt::format(
        "the model's lens maps rays to {} of {} pixels tried of an image of {} x {} px: expected "
        "a lens that fills it; see --size",
        sights.size(), kColumns * kRows, projection.width_px(), projection.height_px()));
  return sights;
}

Eigen::VectorXd numbers_of(const Lens& lens) {
  Eigen::VectorXd numbers(4 + static_cast<Eigen::Index>(lens.coefficients.size()));
  numbers << lens.fx_px, lens.fy_px, lens.cx_px, lens.cy_px,
      Eigen::Map<const Eigen::VectorXd>(lens.coefficients.data(),
                                        static_cast<Eigen::Index>(lens.coefficients.size()));
  return numbers;
}

Lens lens_of(LensFamily family, const Eigen::VectorXd& numbers) {
  return {.family = family,
          .fx_px = numbers[0],
          .fy_px = numbers[1],
          .cx_px = numbers[2],
          .cy_px = numbers[3],
          .coefficients = {numbers.begin() + 4, numbers.end()}};
}

Eigen::VectorXd misses(const Lens& lens, const std::vector<Sight>& sights) {
  Eigen::VectorXd miss(2 * static_cast<Eigen::Index>(sights.size()));
  Eigen::Index i = 0;
  for (const Sight& sight : sights) {
    const auto [u, v] = lens.project(sight.p_C);
    miss[i++] = u - sight.u;
    miss[i++] = v - sight.v;
  }
  return miss;
}

// Central differences: good to 1e-10, so that the fit ends at the last digits.
Eigen::MatrixXd slopes(LensFamily family, const Eigen::VectorXd& numbers,
                       const std::vector<Sight>& sights) {
  Eigen::MatrixXd slope(2 * static_cast<Eigen::Index>(sights.size()), numbers.size());
  for (Eigen::Index k = 0; k < numbers.size(); ++k) {
    const double step = 1e-6 * std::max(1.0, std::abs(numbers[k]));
    Eigen::VectorXd there = numbers, here = numbers;
    there[k] += step, here[k] -= step;
    slope.col(k) =
        (misses(lens_of(family, there), sights) - misses(lens_of(family, here), sights)) /
        (2 * step);
  }
  return slope;
}

std::array<double, 2> fisheye_point(const Lens& lens, const Vec3& p) {
  const double across = std::hypot(p.x, p.y);
  const double theta = std::atan2(across, p.z), t2 = theta * theta;
  const auto& k = lens.coefficients;
  const double bent = theta * (1 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))));
  const double scale = across > 0 ? bent / across : 1 / p.z;
  return {lens.fx_px * p.x * scale + lens.cx_px, lens.fy_px * p.y * scale + lens.cy_px};
}

}  // namespace

size_t coefficient_count(LensFamily family) {
  switch (family) {
    case LensFamily::pinhole:
      return 0;
    case LensFamily::radtan:
      return 4;
    case LensFamily::plumb_bob:
      return 5;
    case LensFamily::rational:
      return 8;
    case LensFamily::thin_prism:
      return 12;
    case LensFamily::equidistant:
      return 4;
  }
  return 0;
}

LensForm form_of(LensFamily family) {
  if (family == LensFamily::equidistant) return LensForm::fisheye;
  const bool rational = family == LensFamily::rational || family == LensFamily::thin_prism;
  return rational ? LensForm::rational : LensForm::ordinary;
}

std::string name_of(LensForm form) {
  if (form == LensForm::ordinary) return "ordinary";
  return form == LensForm::rational ? "rational" : "fisheye";
}

std::string words_of(LensFamily family) {
  const auto with = [&](const char* coefficients) {
    return fmt::format("{} ({})", name_of(form_of(family)), coefficients);
  };
  switch (family) {
    case LensFamily::pinhole:
      return with("perspective without distortion");
    case LensFamily::radtan:
      return with("k1, k2, p1, p2");
    case LensFamily::plumb_bob:
      return with("k1, k2, p1, p2, k3");
    case LensFamily::rational:
      return with("k1, k2, p1, p2, k3, k4, k5, k6");
    case LensFamily::thin_prism:
      return with("k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4");
    case LensFamily::equidistant:
      return with("k1, k2, k3, k4 of the angle from the axis, not k1, k2, p1, p2");
  }
  return "";
}

std::array<double, 2> Lens::project(const Vec3& p_C) const {
  if (family == LensFamily::equidistant) return fisheye_point(*this, p_C);
  const auto c = [&](size_t i) { return i < coefficients.size() ? coefficients[i] : 0; };
  const double x = p_C.x / p_C.z, y = p_C.y / p_C.z, r2 = x * x + y * y;
  const double radial =
      (1 + r2 * (c(0) + r2 * (c(1) + r2 * c(4)))) / (1 + r2 * (c(5) + r2 * (c(6) + r2 * c(7))));
  const double xd =
      x * radial + 2 * c(2) * x * y + c(3) * (r2 + 2 * x * x) + r2 * (c(8) + r2 * c(9));
  const double yd =
      y * radial + c(2) * (r2 + 2 * y * y) + 2 * c(3) * x * y + r2 * (c(10) + r2 * c(11));
  return {fx_px * xd + cx_px, fy_px * yd + cy_px};
}

LensFit fit_lens(const effects::Projection& projection, LensFamily family) {
  return fit_lens(sights_of(projection), family, projection.width_px(), projection.height_px());
}

LensFit fit_lens(const std::vector<Sight>& sights, LensFamily family, double width_px,
                 double height_px) {
  // A perspective lens sees nothing at right angles to its axis or behind it.
  const bool wide = std::any_of(sights.begin(), sights.end(), [](const Sight& sight) {
    return sight.p_C.z < 0.02 * glm::length(sight.p_C);
  });
  if (wide && family != LensFamily::equidistant)
    return {.lens = {.family = family}, .rms_px = HUGE_VAL, .most_px = HUGE_VAL};
  // From the ideal lens, whose focal lengths and centre come out of a few of the same rays.
  Lens lens{.family = family,
            .fx_px = width_px,
            .fy_px = width_px,
            .cx_px = 0.5 * (width_px - 1),
            .cy_px = 0.5 * (height_px - 1),
            .coefficients = std::vector<double>(coefficient_count(family), 0)};
  Eigen::VectorXd numbers = numbers_of(lens);
  Eigen::VectorXd miss = misses(lens, sights);
  measurement::descend(
      {.look = [&] { return measurement::parabola_of(slopes(family, numbers, sights), miss); },
       .move =
           [&](const Eigen::VectorXd& by) {
             const Eigen::VectorXd there = numbers + by;
             Eigen::VectorXd missed = misses(lens_of(family, there), sights);
             if (!(missed.squaredNorm() < miss.squaredNorm())) return false;
             numbers = there, miss = std::move(missed);
             return true;
           },
       .height = [&] { return 0.5 * miss.squaredNorm(); },
       .worth = [] { return measurement::Worth{.promise = 1e-24, .gain = 1e-24}; }},
      {.start = 1e-4}, 200);
  LensFit fit{.lens = lens_of(family, numbers)};
  fit.rms_px = std::sqrt(miss.squaredNorm() / static_cast<double>(sights.size()));
  for (Eigen::Index i = 0; i < miss.size(); i += 2)
    fit.most_px = std::max(fit.most_px, std::hypot(miss[i], miss[i + 1]));
  return fit;
}

LensFit best_lens(const effects::Projection& projection, const std::vector<LensFamily>& families) {
  return best_lens(sights_of(projection), families, projection.width_px(), projection.height_px());
}

LensFit best_lens(const std::vector<Sight>& sights, const std::vector<LensFamily>& families,
                  double width_px, double height_px) {
  constexpr double kUnseen_px = 0.01;  // Corner detectors scatter by 0.05 px at best.
  constexpr double kVisible_px = 0.5;  // What calibrations leave at the corners.
  std::optional<LensFit> unseen, nearest, fisheye;
  for (const LensFamily family : families) {
    LensFit fit = fit_lens(sights, family, width_px, height_px);
    const bool fisheye_form = form_of(family) == LensForm::fisheye;
    if (fit.exact() && (!fisheye_form || family == families.front())) return fit;
    if (fisheye_form) {
      fisheye = std::move(fit);
      continue;
    }
    if (!unseen && fit.most_px < kUnseen_px) unseen = fit;
    if (!nearest || fit.rms_px < nearest->rms_px) nearest = std::move(fit);
  }
  if (unseen) return *unseen;
  if (!nearest) return *fisheye;
  const bool needs_fisheye =
      fisheye && nearest->most_px > kVisible_px && fisheye->most_px < 0.5 * nearest->most_px;
  return needs_fisheye ? *fisheye : *nearest;
}

}  // namespace seam::app
