#include "measurement/kinds/points/points_scatter.h"

#include <cmath>

#include "effects/stages/noise.h"
#include "measurement/noise/hidden_errors.h"

namespace seam::measurement {

std::optional<FewErrors> scatter_of(const Model& model) {
  const effects::Few few = effects::noise_of(model).point_scatter;
  if (few.none()) return std::nullopt;
  return FewErrors(FewErrors::Sort::normal, few.fraction, few.size);
}

void whiten_scattered(const FewErrors& scatter, const std::vector<size_t>& scalars,
                      const Eigen::MatrixXd& causes, const Facts& facts, Evaluation& evaluation) {
  HiddenErrors errors;
  for (Eigen::Index cause = 0; cause < causes.cols(); ++cause) errors.add(1, kLasting);
  std::vector<HiddenErrors::Share> shares;
  for (size_t k = 0; k < scalars.size(); ++k) {
    shares.clear();
    for (Eigen::Index cause = 0; cause < causes.cols(); ++cause) {
      const double slope = causes(static_cast<Eigen::Index>(k), cause);
      if (slope != 0) shares.push_back({static_cast<int>(cause), slope});
    }
    const bool same_point = k > 0 && facts.row_of[scalars[k]] == facts.row_of[scalars[k - 1]];
    errors.observe(scalars[k], 0, shares, &scatter, same_point);
  }
  errors.whiten(facts, evaluation);
}

Failure failure_of(const FewErrors& scatter, double u, double v, double sigma_u, double sigma_v) {
  const double u2 = sigma_u * sigma_u, v2 = sigma_v * sigma_v;
  const double size2 = scatter.size() * scatter.size();
  // Precisions of a point that failed over those of one that did not.
  const double less_u = u2 / (u2 + size2), less_v = v2 / (v2 + size2);
  const double sound = (1 - scatter.fraction()) *
                       std::exp(-0.5 * (u * u / u2 * (1 - less_u) + v * v / v2 * (1 - less_v)));
  const double failing = scatter.fraction() * std::sqrt(less_u * less_v);
  const double failed = failing / (failing + sound);
  return {failed, sigma_u / std::sqrt(1 - failed + failed * less_u),
          sigma_v / std::sqrt(1 - failed + failed * less_v)};
}

bool refine_scattered_pose(const FewErrors& scatter, const Cameras& cameras,
                           std::vector<Sighting> seen, bool near, Pose& X_CW) {
  // From where an earlier one ended, weights hardly change.
  const int rounds = near ? 2 : 8;
  // Weights that change by less move a pose by less than matters.
  constexpr double kSame = 1e-3;
  const std::vector<Sighting> stated = seen;
  for (int round = 0; round < rounds; ++round) {
    double changed = 0;
    const auto weigh = [&](double& sigma, double by) {
      changed = std::max(changed, std::abs(by / sigma - 1));
      sigma = by;
    };
    for (size_t i = 0; i < seen.size(); ++i) {
      const Sighting& s = stated[i];
      const effects::ImagePoint point =
          cameras.project(X_CW * s.p_W, s.t_s, s.v_px, s.camera, s.columns);
      if (!point.visible) return false;
      const Failure failure =
          failure_of(scatter, s.u_px - point.u, s.v_px - point.v, s.sigma_u, s.sigma_v);
      weigh(seen[i].sigma_u, failure.sigma_u);
      weigh(seen[i].sigma_v, failure.sigma_v);
    }
    if (changed < kSame && round > 0) break;
    if (!refine_pose(cameras, seen, X_CW)) return false;
  }
  return true;
}

}  // namespace seam::measurement
