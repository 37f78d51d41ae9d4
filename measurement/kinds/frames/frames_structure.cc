// Structure in the residuals of whole images: smooth functions of place, light and time, and of the
// image's gradients, by which displacement and blur show.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "effects/stages/geometry.h"
#include "measurement/kinds/frames/frames.h"
#include "measurement/numerics/legendre.h"
#include "measurement/numerics/linear_algebra.h"
#include "measurement/numerics/regression.h"

namespace seam::measurement {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Share of the noise below which a structure may be the renderer's own error, which must stay below
// a fifth of the noise (docs/definitions.md).
constexpr double kOwnError = 0.1;

struct Block {
  std::string covariate;
  Eigen::Index first, count;
};

// Polynomials of degree 1 to `count`.
void add_legendre(double x, Eigen::Index count, double scale, VectorXd& out, Eigen::Index first) {
  for (Eigen::Index k = 0; k < count; ++k)
    out[first + k] = scale * legendre(static_cast<int>(k) + 1, x);
}

}  // namespace

std::vector<Structure> FramesProblem::structure(const Model& model, const Groups& groups,
                                                int) const {
  const Evaluation here = evaluate(model, groups);
  if (!here.valid) return {};
  std::vector<Unknown> unknowns;
  for (const auto& effect : model.effects()) {
    for (size_t i = 0; i < effect.parameters.size(); ++i) {
      const auto& parameter = effect.definition->parameters[i];
      if (effect.parameters[i].refitted() && !parameter.integer && !effect.definition->spread_only)
        unknowns.push_back({effect.definition->name, i});
    }
  }
  const auto columns = jacobian(model, unknowns, groups, here);
  const std::vector<size_t> frames = frames_of(groups);
  const std::vector<Block> blocks = {
      {"column", 0, 6},      {"row", 6, 6},
      {"radius", 12, 6},     {"illumination", 18, 6},
      {"gradient_u", 24, 3}, {"gradient_v", 27, 3},
      {"channel", 30, 3},    {"time", 33, static_cast<Eigen::Index>(frames.size())}};
  const Eigen::Index features = blocks.back().first + blocks.back().count,
                     fitted = static_cast<Eigen::Index>(columns.size());
  MatrixXd gram = MatrixXd::Zero(features + fitted, features + fitted),
           spread_gram = MatrixXd::Zero(24, 24);
  VectorXd t = VectorXd::Zero(features + fitted), spread_t = VectorXd::Zero(24),
           b(features + fitted);
  const int width = protocol_.width_px(), height = protocol_.height_px();
  double count = 0, square = 0;
  for (size_t f = 0; f < frames.size(); ++f) {
    const size_t first = frames[f] * samples_;
    const auto predicted = [&](int u, int v, int c) {
      const size_t i = (static_cast<size_t>(std::clamp(v, 0, height - 1)) * width +
                        std::clamp(u, 0, width - 1)) *
                           3 +
                       c;
      return images_[frames[f]][i] - here.residual[first + i];
    };
    for (int v = 0; v < height; ++v) {
      for (int u = 0; u < width; ++u) {
        const double x = 2.0 * u / std::max(1, width - 1) - 1,
                     y = 2.0 * v / std::max(1, height - 1) - 1;
        const double radius = 2 * effects::rho(u, v, width, height) - 1;
        for (int c = 0; c < 3; ++c) {
          const size_t at = first + (static_cast<size_t>(v) * width + u) * 3 + c;
          if (!here.used[at]) continue;
          const double w = 1 / here.sigma[at];
          b.setZero();
          add_legendre(x, 6, w, b, 0), add_legendre(y, 6, w, b, 6),
              add_legendre(radius, 6, w, b, 12);
          add_legendre(predicted(u, v, c) / 127.5 - 1, 6, w, b, 18);
          const double gu = 0.5 * (predicted(u + 1, v, c) - predicted(u - 1, v, c)) * w;
          const double gv = 0.5 * (predicted(u, v + 1, c) - predicted(u, v - 1, c)) * w;
          b.segment(24, 6) << gu, gu * x, gu * y, gv, gv * x, gv * y;
          b[30 + c] = w;
          b[33 + static_cast<Eigen::Index>(f)] = w;
          for (Eigen::Index k = 0; k < fitted; ++k) b[features + k] = columns[k][at];
          gram.selfadjointView<Eigen::Lower>().rankUpdate(b);
          t += here.whitened[at] * b;
          const VectorXd s = b.head(24) / w;
          const double z2 = here.whitened[at] * here.whitened[at] - 1;
          spread_gram.selfadjointView<Eigen::Lower>().rankUpdate(s);
          spread_t += z2 * s;
          count += 1, square += z2 * z2;
        }
      }
    }
  }
  const MatrixXd full = gram.selfadjointView<Eigen::Lower>();
  const MatrixXd spread = spread_gram.selfadjointView<Eigen::Lower>();
  double sigma = 0;
  for (size_t i = 0; i < here.used.size(); ++i) sigma += here.used[i] ? here.sigma[i] / count : 0;
  std::vector<Structure> found;
  const double looks = static_cast<double>(blocks.size()) + 4;
  const auto judge = [&](const Block& block, const char* moment, double chi2, double freedom) {
    const double p = corrected(chi2_tail(chi2, freedom), looks);
    const double strength = std::sqrt(std::max(0.0, chi2 - freedom) / count);
    if (p < 0.01 && strength > kOwnError) {
      found.push_back({.residual = "dn",
                       .moment = moment,
                       .covariate = block.covariate,
                       .strength = strength * sigma,
                       .p_value = p});
    }
  };
  for (const Block& block : blocks) {
    MatrixXd own = full.block(block.first, block.first, block.count, block.count);
    VectorXd right = t.segment(block.first, block.count);
    if (fitted > 0) {
      const MatrixXd across = full.block(block.first, features, block.count, fitted);
      const MatrixXd solved =
          solve_any_rank(full.bottomRightCorner(fitted, fitted), across.transpose());
      own -= across * solved;
      right -= solved.transpose() * t.tail(fitted);
    }
    Eigen::Index rank = 0;
    const VectorXd solved = solve_any_rank(own, right, &rank);
    judge(block, "mean", right.dot(solved), static_cast<double>(rank));
  }
  const double scatter = std::max(square / count, 1e-9);
  for (size_t k = 0; k < 4; ++k) {
    Eigen::Index rank = 0;
    const VectorXd right = spread_t.segment(blocks[k].first, 6);
    const VectorXd solved =
        solve_any_rank(spread.block(blocks[k].first, blocks[k].first, 6, 6), right, &rank);
    judge(blocks[k], "spread", right.dot(solved) / scatter, static_cast<double>(rank));
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Structure& a, const Structure& c) { return a.strength > c.strength; });
  return found;
}

}  // namespace seam::measurement
