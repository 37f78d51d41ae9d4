#include "measurement/kinds/points/data/points_noise.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "measurement/kinds/points/data/board_field.h"
#include "measurement/kinds/points/target/rough_camera.h"
#include "measurement/noise/unlike_groups.h"
#include "measurement/numerics/linear_algebra.h"
#include "measurement/numerics/robust.h"
#include "sim_core/base/error.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

// One view's rows beside what a smooth image of the target explains of them.
struct View {
  size_t of;  // Among all.
  std::vector<int> rows;
  Eigen::MatrixXd field;        // Orthonormal columns, over the rows' own noise.
  Eigen::MatrixXd over_image;   // What is smooth in the image, of all views, less the field's part.
  Eigen::VectorXd weight;       // 1 / its spread.
  Eigen::MatrixX3d along[2];    // By channel: of the image by the point's shift, weighted.
  Eigen::VectorXd leverage[2];  // What field and shifts take of each row.
};

// Of the polynomials over the target in each view, and over the camera's image in all of them.
constexpr int kMostDegree = 8, kMostDegreeOfImage = 7;

// What is seen twice: a smooth image of the target in each view, and a displacement of each point,
// the same in all views, which a rough camera maps into each. What neither explains is noise.
class ViewsNoise {
 public:
  ViewsNoise(const PointsData& data, const std::vector<char>& gross,
             const SeenByCamera* seen = nullptr);
  PointsNoise estimate() const;

 private:
  using Observed = std::array<Eigen::VectorXd, 2>;  // Of one view, over the rows' spreads.
  void displace(const RoughCamera& camera);
  double observed(int row, int channel) const {
    if (seen_ != nullptr) return seen_->residual_px[2 * static_cast<size_t>(row) + channel];
    return (channel ? data_.v_px : data_.u_px)[row];
  }
  void look_over_image();
  void take_fields(std::vector<Observed>& all) const;
  Eigen::Matrix3Xd asked(const std::vector<Observed>& all) const;
  std::vector<Observed> image_of(const Eigen::Matrix3Xd& shift) const;
  void take_displacements(std::vector<Observed>& all) const;
  std::array<std::vector<double>, 2> left(std::vector<Observed> all) const;
  double left_of_unit() const;
  std::vector<double> unlike_views(const std::array<std::vector<double>, 2>& left,
                                   const std::array<double, 2>& sigma) const;
  std::vector<Observed> measured() const;
  std::vector<Observed> drawn(uint64_t probe) const;
  Eigen::Index point_of(const View& view, Eigen::Index i) const {
    return data_.point_of_row[view.rows[static_cast<size_t>(i)]];
  }

  const PointsData& data_;
  const SeenByCamera* seen_;
  std::vector<View> views_;
  std::vector<Eigen::Matrix3d> inverse_;  // By point; 0 where too few views show it.
  bool displaced_ = false;
};

ViewsNoise::ViewsNoise(const PointsData& data, const std::vector<char>& gross,
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
    int degree = kMostDegree;
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
    throw InputError(fmt::format(
        "measurement.yaml: noise: found none, and no view has points enough to estimate it "
        "from ({} or more), expected for example {{u_px: 0.2, v_px: 0.2}}",
        kPointsTellNoise));
  if (seen != nullptr) look_over_image();
  if (views_.size() < kViewsTellDisplacements) return;
  if (seen != nullptr) {
    displace(seen->camera);
    return;
  }
  std::vector<std::vector<int>> rows(data.rows_of_view.size());
  for (const View& view : views_) rows[view.of] = view.rows;
  if (const auto camera = camera_of_views(data, rows)) displace(*camera);
}

// A camera of another family leaves the same in each view, wherever the target is. Places are those
// that the camera predicts: measured ones hold the very noise that is looked for.
void ViewsNoise::look_over_image() {
  std::vector<std::vector<double>> places(2);
  for (const View& view : views_) {
    for (const int row : view.rows) {
      places[0].push_back(data_.u_px[row] - observed(row, 0));
      places[1].push_back(data_.v_px[row] - observed(row, 1));
    }
  }
  Eigen::MatrixXd all = image_columns(std::move(places), kMostDegreeOfImage);
  Eigen::Index at = 0;
  for (const View& view : views_) {
    auto rows = all.middleRows(at, view.weight.size());
    rows = (view.weight.asDiagonal() * rows).eval();
    rows -= view.field * (view.field.transpose() * rows);
    at += rows.rows();
  }
  // What the views' own polynomials have but for so little is theirs.
  constexpr double kTheirs = 1e-3;
  const Eigen::MatrixXd basis = column_basis(all, kTheirs);
  at = 0;
  for (View& view : views_) {
    view.over_image = basis.middleRows(at, view.weight.size());
    at += view.over_image.rows();
  }
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
      const auto point = static_cast<size_t>(point_of(view, i));
      ++counts[point];
      for (int c = 0; c < 2; ++c) {
        view.along[c].row(i) = view.weight[i] * slopes->row(c);
        normal[point] += view.along[c].row(i).transpose() * view.along[c].row(i);
      }
    }
  }
  for (size_t point = 0; point < counts.size(); ++point) {
    const bool told = counts[point] >= kViewsTellDisplacements;
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
        view.leverage[c][i] +=
            along * inverse_[static_cast<size_t>(point_of(view, i))] * along.transpose();
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

// Takes out of the views what is smooth in each of them, and in all.
void ViewsNoise::take_fields(std::vector<Observed>& all) const {
  Eigen::MatrixX2d shared = Eigen::MatrixX2d::Zero(views_.front().over_image.cols(), 2);
  for (size_t v = 0; v < views_.size(); ++v) {
    const Eigen::MatrixXd& field = views_[v].field;
    for (size_t c = 0; c < 2; ++c) {
      Eigen::VectorXd& y = all[v][c];
      y -= field * (field.transpose() * y);
      if (shared.rows() > 0)
        shared.col(static_cast<Eigen::Index>(c)) += views_[v].over_image.transpose() * y;
    }
  }
  for (size_t v = 0; v < views_.size() && shared.rows() > 0; ++v) {
    for (size_t c = 0; c < 2; ++c)
      all[v][c] -= views_[v].over_image * shared.col(static_cast<Eigen::Index>(c));
  }
}

// By point: what moves its image in all views as these observations ask for.
Eigen::Matrix3Xd ViewsNoise::asked(const std::vector<Observed>& all) const {
  Eigen::Matrix3Xd shift = Eigen::Matrix3Xd::Zero(3, static_cast<Eigen::Index>(inverse_.size()));
  for (size_t v = 0; v < views_.size(); ++v) {
    for (size_t c = 0; c < 2; ++c) {
      for (Eigen::Index i = 0; i < all[v][c].size(); ++i)
        shift.col(point_of(views_[v], i)) += views_[v].along[c].row(i).transpose() * all[v][c][i];
    }
  }
  return shift;
}

// The image of displacements, less what fields explain of it.
std::vector<ViewsNoise::Observed> ViewsNoise::image_of(const Eigen::Matrix3Xd& shift) const {
  std::vector<Observed> all(views_.size());
  for (size_t v = 0; v < views_.size(); ++v) {
    for (size_t c = 0; c < 2; ++c) {
      all[v][c].resize(views_[v].weight.size());
      for (Eigen::Index i = 0; i < all[v][c].size(); ++i)
        all[v][c][i] = views_[v].along[c].row(i) * shift.col(point_of(views_[v], i));
    }
  }
  take_fields(all);
  return all;
}

// Takes out fields and displacements together, by conjugate gradients over the displacements: a
// bend of the target is smooth, too, and of what both explain taking them in turn leaves a part for
// long.
void ViewsNoise::take_displacements(std::vector<Observed>& all) const {
  constexpr int kMost = 100;
  constexpr double kEnough = 1e-4;  // Of what is left, by its square.
  const auto alone = [&](const Eigen::Matrix3Xd& shift) {
    Eigen::Matrix3Xd out = shift;
    for (Eigen::Index p = 0; p < out.cols(); ++p)
      out.col(p) = inverse_[static_cast<size_t>(p)] * shift.col(p);
    return out;
  };
  Eigen::Matrix3Xd slope = asked(all), along = alone(slope);
  double size = slope.cwiseProduct(along).sum();
  for (int round = 0; round < kMost && size > 0; ++round) {
    const std::vector<Observed> image = image_of(along);
    const Eigen::Matrix3Xd bend = asked(image);
    const double step = size / along.cwiseProduct(bend).sum();
    if (!std::isfinite(step)) return;
    double left = 0;
    for (size_t v = 0; v < views_.size(); ++v) {
      for (size_t c = 0; c < 2; ++c)
        all[v][c] -= step * image[v][c], left += all[v][c].squaredNorm();
    }
    if (step * size < kEnough * left) return;
    slope -= step * bend;
    const Eigen::Matrix3Xd next = alone(slope);
    const double before = size;
    size = slope.cwiseProduct(next).sum();
    along = next + size / before * along;
  }
}

// What is left of each channel, each over the square root of its own share that is left.
std::array<std::vector<double>, 2> ViewsNoise::left(std::vector<Observed> all) const {
  take_fields(all);
  if (displaced_) take_displacements(all);
  std::array<std::vector<double>, 2> left;
  for (size_t v = 0; v < views_.size(); ++v) {
    for (size_t c = 0; c < 2; ++c) {
      for (Eigen::Index i = 0; i < views_[v].weight.size(); ++i)
        left[c].push_back(all[v][c][i] / std::sqrt(std::max(0.05, 1 - views_[v].leverage[c][i])));
    }
  }
  return left;
}

// What noise of unit size leaves, since fields, what all views share and displacements take some of
// the same. Told as the noise is: what few views leave of displaced points differs from row to row,
// and the far ones of such a mixture count in none of both.
double ViewsNoise::left_of_unit() const {
  constexpr size_t kEnough = 30000;
  std::vector<double> all;
  for (uint64_t probe = 0; all.size() < kEnough; ++probe) {
    for (const std::vector<double>& channel : left(drawn(probe)))
      all.insert(all.end(), channel.begin(), channel.end());
  }
  return clipped_sigma(all);
}

// By view: how much more or less it scatters than others, u and v together, however it counted.
std::vector<double> ViewsNoise::unlike_views(const std::array<std::vector<double>, 2>& left,
                                             const std::array<double, 2>& sigma) const {
  std::vector<ResidualGroup> groups(data_.rows_of_view.size());
  size_t at = 0;
  for (const View& view : views_) {
    ResidualGroup& group = groups[view.of];
    const double counted = data_.spread_of_view.empty() ? 1 : data_.spread_of_view[view.of];
    for (Eigen::Index i = 0; i < view.weight.size(); ++i, ++at) {
      for (size_t c = 0; c < 2; ++c) {
        group.values.push_back(counted * left[c][at] / sigma[c]);
        group.freedom += std::max(0.0, 1 - view.leverage[c][i]);
      }
    }
  }
  return spreads_of_groups(groups);
}

PointsNoise ViewsNoise::estimate() const {
  const auto here = left(measured());
  PointsNoise noise{.sigma = {clipped_sigma(here[0]), clipped_sigma(here[1])}};
  noise.of_view = unlike_views(here, noise.sigma);
  if (!displaced_ && seen_ == nullptr) return noise;
  const double unit = left_of_unit();
  for (double& value : noise.sigma) value /= unit;
  return noise;
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

PointsNoise estimate_views_noise(const PointsData& data, const std::vector<char>& gross,
                                 const SeenByCamera* seen) {
  return ViewsNoise(data, gross, seen).estimate();
}

}  // namespace seam::measurement
