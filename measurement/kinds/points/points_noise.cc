#include "measurement/kinds/points/points_noise.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "measurement/kinds/points/board_field.h"
#include "measurement/kinds/points/target/rough_camera.h"
#include "measurement/numerics/linear_algebra.h"
#include "measurement/numerics/robust.h"
#include "sim_core/base/error.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

// Residuals of the least-squares fit of y by the columns of A, scaled by 1 / sqrt(1 - leverage) so
// that each has the variance of the noise.
Eigen::VectorXd studentised(const Eigen::MatrixXd& A, const Eigen::VectorXd& y) {
  const Eigen::MatrixXd Q = column_basis(A);
  Eigen::VectorXd r = y - Q * (Q.transpose() * y);
  for (Eigen::Index i = 0; i < r.size(); ++i)
    r[i] /= std::sqrt(std::max(0.05, 1 - Q.row(i).squaredNorm()));
  return r;
}

// One view's rows beside what a smooth image of the target explains of them.
struct View {
  size_t of;  // Among all.
  std::vector<int> rows;
  Eigen::MatrixXd field;        // Orthonormal columns, over the rows' own noise.
  Eigen::VectorXd weight;       // 1 / its spread.
  Eigen::MatrixX3d along[2];    // By channel: of the image by the point's shift, weighted.
  Eigen::VectorXd leverage[2];  // What field and shifts take of each row.
};

// Displacements are told of points that so many views show.
constexpr size_t kSeveral = 4;
// Polynomials of the whole image, and of what a camera leaves of it.
constexpr int kDegreeAlone = 8, kDegreeBesideCamera = 3;

// What is seen twice: a smooth image of the target in each view, and a displacement of each point,
// the same in all views, which a rough camera maps into each. What neither explains is noise.
class ViewsNoise {
 public:
  ViewsNoise(const PointsData& data, const std::vector<char>& gross, int most_degree,
             const SeenByCamera* seen = nullptr);
  std::array<double, 2> sigma() const;

 private:
  using Observed = std::array<Eigen::VectorXd, 2>;  // Of one view, over the rows' spreads.
  void displace(const RoughCamera& camera);
  double observed(int row, int channel) const {
    if (seen_ != nullptr) return seen_->residual_px[2 * static_cast<size_t>(row) + channel];
    return (channel ? data_.v_px : data_.u_px)[row];
  }
  std::array<std::vector<double>, 2> left(std::vector<Observed> all) const;
  std::vector<Observed> measured() const;
  std::vector<Observed> drawn(uint64_t probe) const;
  size_t point_of(const View& view, Eigen::Index i) const {
    return static_cast<size_t>(data_.point_of_row[view.rows[static_cast<size_t>(i)]]);
  }

  const PointsData& data_;
  const SeenByCamera* seen_;
  std::vector<View> views_;
  std::vector<Eigen::Matrix3d> inverse_;  // By point; 0 where too few views show it.
  bool displaced_ = false;
};

ViewsNoise::ViewsNoise(const PointsData& data, const std::vector<char>& gross, int most_degree,
                       const SeenByCamera* seen)
    : data_(data), seen_(seen) {
  for (size_t v = 0; v < data.rows_of_view.size(); ++v) {
    const std::vector<int>& all = data.rows_of_view[v];
    View view{.of = v};
    if (seen != nullptr && !seen->camera.X_CW[v]) continue;
    std::copy_if(all.begin(), all.end(), std::back_inserter(view.rows),
                 [&](int row) { return gross.empty() || !gross[2 * row]; });
    if (view.rows.empty()) continue;
    const BoardField field(data, view.rows);
    if (field.along().empty()) continue;
    // As flexible as half of the frame's points allow.
    int degree = most_degree;
    while (degree > 1 && static_cast<size_t>(field.columns(degree).cols()) * 2 > view.rows.size())
      --degree;
    const Eigen::MatrixXd A = field.columns(degree);
    const auto n = static_cast<Eigen::Index>(view.rows.size());
    if (A.cols() + 4 > n) continue;
    view.weight = Eigen::VectorXd::Ones(n);
    for (Eigen::Index i = 0; i < n && !data.spread.empty(); ++i)
      view.weight[i] = 1 / data.spread[view.rows[static_cast<size_t>(i)]];
    view.field = column_basis(view.weight.asDiagonal() * A);
    for (int c = 0; c < 2; ++c) {
      view.along[c] = Eigen::MatrixX3d::Zero(n, 3);
      view.leverage[c] = view.field.rowwise().squaredNorm();
    }
    views_.push_back(std::move(view));
  }
  if (views_.empty())
    throw InputError(
        "measurement.yaml: noise: found none, and no view has points enough to estimate it from "
        "(7 or more), expected for example {u_px: 0.2, v_px: 0.2}");
  if (views_.size() < kSeveral) return;
  if (seen != nullptr) {
    displace(seen->camera);
    return;
  }
  std::vector<std::vector<int>> rows(data.rows_of_view.size());
  for (const View& view : views_) rows[view.of] = view.rows;
  if (const auto camera = camera_of_views(data, rows)) displace(*camera);
}

// Displacements are told from noise where most points are seen in several views.
void ViewsNoise::displace(const RoughCamera& camera) {
  std::vector<size_t> counts(data_.target.names.size(), 0);
  std::vector<Eigen::Matrix3d> normal(counts.size(), Eigen::Matrix3d::Zero());
  for (size_t v = 0; v < views_.size(); ++v) {
    View& view = views_[v];
    for (Eigen::Index i = 0; i < view.weight.size(); ++i) {
      const auto slopes =
          camera.slopes(view.of, data_.p_W[view.rows[static_cast<size_t>(i)]], data_.target.axes_W);
      if (!slopes) continue;
      ++counts[point_of(view, i)];
      for (int c = 0; c < 2; ++c) {
        view.along[c].row(i) = view.weight[i] * slopes->row(c);
        normal[point_of(view, i)] += view.along[c].row(i).transpose() * view.along[c].row(i);
      }
    }
  }
  for (size_t point = 0; point < counts.size(); ++point) {
    const bool told = counts[point] >= kSeveral;
    displaced_ = displaced_ || told;
    // Views that are all alike leave a direction open: it takes nothing then.
    const Eigen::Matrix3d ridge = 1e-6 * normal[point].trace() * Eigen::Matrix3d::Identity();
    inverse_.push_back(told ? Eigen::Matrix3d((normal[point] + ridge).inverse())
                            : Eigen::Matrix3d::Zero());
  }
  for (View& view : views_) {
    for (Eigen::Index i = 0; i < view.weight.size(); ++i) {
      for (int c = 0; c < 2; ++c) {
        const Eigen::RowVector3d along = view.along[c].row(i);
        view.leverage[c][i] += along * inverse_[point_of(view, i)] * along.transpose();
      }
    }
  }
}

std::vector<ViewsNoise::Observed> ViewsNoise::measured() const {
  std::vector<Observed> all;
  for (const View& view : views_) {
    Observed& y = all.emplace_back();
    for (int c = 0; c < 2; ++c) {
      y[c].resize(view.weight.size());
      for (Eigen::Index i = 0; i < y[c].size(); ++i)
        y[c][i] = view.weight[i] * observed(view.rows[static_cast<size_t>(i)], c);
    }
  }
  return all;
}

std::vector<ViewsNoise::Observed> ViewsNoise::drawn(uint64_t probe) const {
  const RandomStream stream = RandomStream{.seed = 1}.child("points noise").child(probe);
  std::vector<Observed> all;
  uint64_t count = 0;
  for (const View& view : views_) {
    Observed& y = all.emplace_back();
    for (int c = 0; c < 2; ++c) {
      y[c].resize(view.weight.size());
      for (double& value : y[c]) value = normal(stream, count++);
    }
  }
  return all;
}

// What is left of each channel, each over the square root of its own share that is left.
std::array<std::vector<double>, 2> ViewsNoise::left(std::vector<Observed> all) const {
  // Fields and displacements in turn: what is rough in the displacements hardly changes the fields.
  constexpr int kRounds = 4;
  std::vector<Eigen::Vector3d> shift(displaced_ ? inverse_.size() : 0);
  for (int round = 0; round <= (displaced_ ? kRounds : 0); ++round) {
    std::fill(shift.begin(), shift.end(), Eigen::Vector3d::Zero());
    for (size_t v = 0; v < views_.size(); ++v) {
      const View& view = views_[v];
      for (int c = 0; c < 2; ++c) {
        Eigen::VectorXd& y = all[v][c];
        y -= view.field * (view.field.transpose() * y);
        for (Eigen::Index i = 0; i < y.size() && displaced_; ++i)
          shift[point_of(view, i)] += view.along[c].row(i).transpose() * y[i];
      }
    }
    if (round == kRounds || !displaced_) break;
    for (size_t v = 0; v < views_.size(); ++v) {
      const View& view = views_[v];
      for (int c = 0; c < 2; ++c) {
        for (Eigen::Index i = 0; i < view.weight.size(); ++i)
          all[v][c][i] -=
              view.along[c].row(i) * (inverse_[point_of(view, i)] * shift[point_of(view, i)]);
      }
    }
  }
  std::array<std::vector<double>, 2> left;
  for (size_t v = 0; v < views_.size(); ++v) {
    for (size_t c = 0; c < 2; ++c) {
      for (Eigen::Index i = 0; i < views_[v].weight.size(); ++i)
        left[c].push_back(all[v][c][i] / std::sqrt(std::max(0.05, 1 - views_[v].leverage[c][i])));
    }
  }
  return left;
}

std::array<double, 2> ViewsNoise::sigma() const {
  const auto here = left(measured());
  std::array<double, 2> sigma{clipped_sigma(here[0]), clipped_sigma(here[1])};
  if (!displaced_) return sigma;
  // Fields and displacements share some of what they take; noise of unit size says how much.
  constexpr double kEnough = 3e4;
  double count = 0, sum2 = 0;
  for (uint64_t probe = 0; count < kEnough; ++probe) {
    for (const std::vector<double>& channel : left(drawn(probe))) {
      for (const double x : channel) ++count, sum2 += x * x;
    }
  }
  for (double& value : sigma) value /= std::sqrt(sum2 / count);
  return sigma;
}

// Degrees of the polynomials: of the direction alone, of the state alone, and of both in their
// products.
struct Degrees {
  int field, state, field_of_products, state_of_products;
};
constexpr Degrees kDegrees[] = {{7, 3, 3, 2}, {7, 3, 3, 1}, {5, 2, 2, 1}, {4, 1, 1, 1},
                                {3, 1, 0, 0}, {2, 0, 0, 0}, {1, 0, 0, 0}};

// What is smooth in where a point is seen and how the head moves then.
Eigen::MatrixXd smooth_columns(const std::vector<std::vector<double>>& direction,
                               const std::vector<std::vector<double>>& state,
                               const Degrees& degrees) {
  const auto but_constant = [](const Eigen::MatrixXd& all) {
    return Eigen::MatrixXd(all.rightCols(all.cols() - 1));
  };
  const Eigen::MatrixXd field = monomials(direction, degrees.field);
  if (state.empty()) return field;
  const Eigen::MatrixXd alone = but_constant(monomials(state, degrees.state));
  const Eigen::MatrixXd a = but_constant(monomials(direction, degrees.field_of_products));
  const Eigen::MatrixXd b = but_constant(monomials(state, degrees.state_of_products));
  Eigen::MatrixXd all(field.rows(), field.cols() + alone.cols() + a.cols() * b.cols());
  all << field, alone, Eigen::MatrixXd(field.rows(), a.cols() * b.cols());
  Eigen::Index at = field.cols() + alone.cols();
  for (Eigen::Index m = 0; m < b.cols(); ++m) {
    for (Eigen::Index k = 0; k < a.cols(); ++k) all.col(at++) = b.col(m).cwiseProduct(a.col(k));
  }
  return all;
}

// Directions of the points in the frame of a camera that hangs on the logged joints, and whatever
// else may move the image: the joints' angles and rates, and time. As flexible as half of the
// points allow.
std::array<double, 2> noise_by_directions(const PointsData& data) {
  const Model none =
      Model::from_config(ConfigNode::from_text("format: seam-model/1\neffects: {}\n", "none"));
  const Rig::Motion motion = data.rig.motion(none);
  std::vector<std::vector<double>> direction(2);
  std::vector<std::vector<double>> state;
  for (size_t i = 0; i < data.p_W.size(); ++i) {
    const Vec3 p_C = motion.X_WC(data.stamp_s[i]).inverse() * data.p_W[i];
    const double depth = std::max(p_C.z, 0.05 * glm::length(p_C));
    direction[0].push_back(p_C.x / depth);
    direction[1].push_back(p_C.y / depth);
  }
  for (size_t j = 0; j < data.rig.joint_names().size(); ++j) {
    const auto& log = data.rig.logged(j);
    std::vector<double> angle, rate;
    for (const double t : data.stamp_s) angle.push_back(log.value(t)), rate.push_back(log.rate(t));
    state.insert(state.end(), {angle, rate});
  }
  state.push_back(data.stamp_s);
  std::erase_if(state, is_constant);
  for (auto* variables : {&direction, &state}) {
    for (auto& x : *variables) x = standardised(x);
  }
  Eigen::MatrixXd A;
  for (const Degrees& degrees : kDegrees) {
    A = smooth_columns(direction, state, degrees);
    if (2 * A.cols() <= A.rows()) break;
  }
  std::array<double, 2> sigma{1, 1};
  for (int c = 0; c < 2; ++c) {
    const Eigen::VectorXd y =
        Eigen::Map<const Eigen::VectorXd>((c ? data.v_px : data.u_px).data(), A.rows());
    const Eigen::VectorXd r = studentised(A, y);
    sigma[c] = robust_sigma({r.begin(), r.end()});
  }
  return sigma;
}

}  // namespace

std::optional<RoughCamera> camera_of_views(const PointsData& data,
                                           const std::vector<std::vector<int>>& rows_of_view) {
  std::vector<std::vector<Sighting>> seen;
  for (const std::vector<int>& rows : rows_of_view) {
    seen.emplace_back();
    for (const int row : rows)
      seen.back().push_back({.p_W = data.p_W[row], .u_px = data.u_px[row], .v_px = data.v_px[row]});
  }
  return rough_camera(seen, data.camera.width_px, data.camera.height_px);
}

std::array<double, 2> estimate_points_noise(const PointsData& data,
                                            const std::vector<char>& gross) {
  return data.rig.type() == Rig::Type::unknown ? ViewsNoise(data, gross, kDegreeAlone).sigma()
                                               : noise_by_directions(data);
}

std::array<double, 2> estimate_views_noise(const PointsData& data, const std::vector<char>& gross,
                                           const SeenByCamera& seen) {
  return ViewsNoise(data, gross, kDegreeBesideCamera, &seen).sigma();
}

}  // namespace seam::measurement
