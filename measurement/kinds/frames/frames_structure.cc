// Structure in the residuals of whole images: smooth functions of place, light and time, and of the
// image's gradients, by which displacement and blur show.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>

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
// a fifth of the noise (docs/reference/definitions.md).
constexpr double kOwnError = 0.1;

struct Block {
  std::string covariate;
  Eigen::Index first, count;
};
// The first of them are also tested for spread.
constexpr size_t kSpreadBlocks = 4;
constexpr Eigen::Index kSpreadFeatures = 24;

std::vector<Block> blocks_of(size_t frames) {
  return {{"column", 0, 6},      {"row", 6, 6},
          {"radius", 12, 6},     {"illumination", 18, 6},
          {"gradient_u", 24, 3}, {"gradient_v", 27, 3},
          {"channel", 30, 3},    {"time", 33, static_cast<Eigen::Index>(frames)}};
}

// Polynomials of degree 1 to `count`.
void add_legendre(double x, Eigen::Index count, double scale, VectorXd& out, Eigen::Index first) {
  for (Eigen::Index k = 0; k < count; ++k)
    out[first + k] = scale * legendre(static_cast<int>(k) + 1, x);
}

std::vector<Unknown> unknowns_of_means(const Model& model) {
  std::vector<Unknown> unknowns;
  for (const auto& effect : model.effects()) {
    for (size_t i = 0; i < effect.parameters.size(); ++i) {
      const auto& parameter = effect.definition->parameters[i];
      if (effect.parameters[i].refitted() && !parameter.integer && !effect.definition->spread_only)
        unknowns.push_back({effect.definition->name, i});
    }
  }
  return unknowns;
}

// Residuals projected on all features and on the derivatives by the model's unknowns, which have
// their part of each test taken out.
class FrameProjections {
 public:
  FrameProjections(const Evaluation& here, const std::vector<std::vector<double>>& columns,
                   size_t frames)
      : here_(here),
        columns_(columns),
        blocks_(blocks_of(frames)),
        features_(blocks_.back().first + blocks_.back().count),
        fitted_(static_cast<Eigen::Index>(columns.size())) {}

  // The f-th frame, whose samples start at `first`.
  void add_frame(size_t f, size_t first, const std::vector<uint16_t>& image, int width,
                 int height) {
    const auto predicted = [&](int u, int v, int c) {
      const size_t i = (static_cast<size_t>(std::clamp(v, 0, height - 1)) * width +
                        std::clamp(u, 0, width - 1)) *
                           3 +
                       c;
      return image[i] - here_.residual[first + i];
    };
    VectorXd b(features_ + fitted_);
    for (int v = 0; v < height; ++v) {
      for (int u = 0; u < width; ++u) {
        const double x = 2.0 * u / std::max(1, width - 1) - 1,
                     y = 2.0 * v / std::max(1, height - 1) - 1;
        const double radius = 2 * effects::rho(u, v, width, height) - 1;
        for (int c = 0; c < 3; ++c) {
          const size_t at = first + (static_cast<size_t>(v) * width + u) * 3 + c;
          if (!here_.used[at]) continue;
          const double w = 1 / here_.sigma[at];
          b.setZero();
          add_legendre(x, 6, w, b, 0), add_legendre(y, 6, w, b, 6),
              add_legendre(radius, 6, w, b, 12);
          add_legendre(predicted(u, v, c) / 127.5 - 1, 6, w, b, 18);
          const double gu = 0.5 * (predicted(u + 1, v, c) - predicted(u - 1, v, c)) * w;
          const double gv = 0.5 * (predicted(u, v + 1, c) - predicted(u, v - 1, c)) * w;
          b.segment(24, 6) << gu, gu * x, gu * y, gv, gv * x, gv * y;
          b[30 + c] = w;
          b[33 + static_cast<Eigen::Index>(f)] = w;
          for (Eigen::Index k = 0; k < fitted_; ++k) b[features_ + k] = columns_[k][at];
          add_sample(at, w, b);
        }
      }
    }
  }

  // Those of the mean, then those of the spread.
  std::vector<Structure> structures() const {
    double sigma = 0;
    for (size_t i = 0; i < here_.used.size(); ++i)
      sigma += here_.used[i] ? here_.sigma[i] / count_ : 0;
    std::vector<Structure> found;
    const double looks = static_cast<double>(blocks_.size() + kSpreadBlocks);
    const auto judge = [&](const Block& block, const char* moment, double chi2, double freedom) {
      const double p = corrected(chi2_tail(chi2, freedom), looks);
      const double strength = std::sqrt(std::max(0.0, chi2 - freedom) / count_);
      if (p < 0.01 && strength > kOwnError) {
        found.push_back({.residual = "dn",
                         .moment = moment,
                         .covariate = block.covariate,
                         .strength = strength * sigma,
                         .p_value = p});
      }
    };
    const MatrixXd full = gram_.selfadjointView<Eigen::Lower>();
    for (const Block& block : blocks_) {
      const auto [chi2, rank] = mean_chi2(full, block);
      judge(block, "mean", chi2, static_cast<double>(rank));
    }
    const MatrixXd spread = spread_gram_.selfadjointView<Eigen::Lower>();
    const double scatter = std::max(square_ / count_, 1e-9);
    for (size_t k = 0; k < kSpreadBlocks; ++k) {
      const Block& block = blocks_[k];
      Eigen::Index rank = 0;
      const VectorXd right = spread_t_.segment(block.first, 6);
      const VectorXd solved =
          solve_any_rank(spread.block(block.first, block.first, 6, 6), right, &rank);
      judge(block, "spread", right.dot(solved) / scatter, static_cast<double>(rank));
    }
    return found;
  }

 private:
  // Of weight w and features b.
  void add_sample(size_t at, double w, const VectorXd& b) {
    gram_.selfadjointView<Eigen::Lower>().rankUpdate(b);
    t_ += here_.whitened[at] * b;
    const VectorXd s = b.head(kSpreadFeatures) / w;
    const double z2 = here_.whitened[at] * here_.whitened[at] - 1;
    spread_gram_.selfadjointView<Eigen::Lower>().rankUpdate(s);
    spread_t_ += z2 * s;
    count_ += 1, square_ += z2 * z2;
  }

  // And its degrees of freedom. `full`: the whole Gram matrix.
  std::pair<double, Eigen::Index> mean_chi2(const MatrixXd& full, const Block& block) const {
    MatrixXd own = full.block(block.first, block.first, block.count, block.count);
    VectorXd right = t_.segment(block.first, block.count);
    if (fitted_ > 0) {
      const MatrixXd across = full.block(block.first, features_, block.count, fitted_);
      const MatrixXd solved =
          solve_any_rank(full.bottomRightCorner(fitted_, fitted_), across.transpose());
      own -= across * solved;
      right -= solved.transpose() * t_.tail(fitted_);
    }
    Eigen::Index rank = 0;
    const VectorXd solved = solve_any_rank(own, right, &rank);
    return {right.dot(solved), rank};
  }

  const Evaluation& here_;
  const std::vector<std::vector<double>>& columns_;
  std::vector<Block> blocks_;
  Eigen::Index features_, fitted_;
  MatrixXd gram_ = MatrixXd::Zero(features_ + fitted_, features_ + fitted_),
           spread_gram_ = MatrixXd::Zero(kSpreadFeatures, kSpreadFeatures);
  VectorXd t_ = VectorXd::Zero(features_ + fitted_), spread_t_ = VectorXd::Zero(kSpreadFeatures);
  double count_ = 0, square_ = 0;
};

}  // namespace

std::vector<Structure> FramesProblem::structure(const Model& model, const Groups& groups,
                                                int) const {
  const Evaluation here = evaluate(model, groups);
  if (!here.valid) return {};
  const auto columns = jacobian(model, unknowns_of_means(model), groups, here);
  const std::vector<size_t> frames = frames_of(groups);
  FrameProjections projections(here, columns, frames.size());
  for (size_t f = 0; f < frames.size(); ++f) {
    projections.add_frame(f, frames[f] * samples_, images_[frames[f]], protocol_.width_px(),
                          protocol_.height_px());
  }
  std::vector<Structure> found = projections.structures();
  std::stable_sort(found.begin(), found.end(),
                   [](const Structure& a, const Structure& c) { return a.strength > c.strength; });
  return found;
}

}  // namespace seam::measurement
