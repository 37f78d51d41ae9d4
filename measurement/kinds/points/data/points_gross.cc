#include "measurement/kinds/points/data/points_gross.h"

#include <fmt/ranges.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <optional>

#include "measurement/numerics/linear_algebra.h"
#include "measurement/numerics/robust.h"
#include "sim_core/base/error.h"

namespace seam::measurement {
namespace {

// A corner so far from where its neighbours say, in distances to the next, is another corner or
// none. Between neighbours the image of a board is nearly linear, whatever the lens: even near the
// edge of a fisheye the error is a tenth. Smaller errors are outliers of a model.
constexpr double kOfSpacing = 0.35;
constexpr size_t kNeighbours = 10;
// Where the image bends (a board that goes away from a wide lens) so many say more.
constexpr size_t kNeighboursOfBend = 20;
// A view with so many of them has other labels, or none.
constexpr double kMostWrong = 0.3;
// Views that differ from so many others in the sense of the board's corners are mirrored.
constexpr double kMostMirrored = 0.25;
// Coordinates this many extents away belong to no target.
constexpr double kElsewhere = 100;

struct ViewFit {
  std::vector<int> rows;
  std::vector<char> wrong;  // By row of these.
  double sense = 0;         // Sign of the turn from the board's x to its y in the image.
};

// A map from the board to the image, linear in columns of the board's coordinates, through points
// of which a few may be wrong: least sum of distances, by reweighting.
Eigen::MatrixX2d robust_map(const Eigen::MatrixXd& board, const Eigen::MatrixXd& image) {
  Eigen::VectorXd weight = Eigen::VectorXd::Ones(board.rows());
  Eigen::MatrixX2d map;
  for (int round = 0; round < 12; ++round) {
    Eigen::MatrixXd normal = board.transpose() * weight.asDiagonal() * board;
    normal.diagonal() *= 1 + 1e-9;
    map = solve_square(normal, board.transpose() * weight.asDiagonal() * image);
    const Eigen::VectorXd off = (image - board * map).rowwise().norm();
    weight = off.cwiseMax(1e-3).cwiseInverse();
  }
  return map;
}

// The row's neighbours on the board, nearest first.
std::vector<Eigen::Index> nearest(const Eigen::MatrixXd& board, Eigen::Index to, size_t most) {
  std::vector<std::pair<double, Eigen::Index>> order;
  for (Eigen::Index k = 0; k < board.rows(); ++k) {
    if (k != to) order.emplace_back((board.row(k) - board.row(to)).squaredNorm(), k);
  }
  const size_t count = std::min(most, order.size());
  std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count), order.end());
  std::vector<Eigen::Index> near;
  for (size_t i = 0; i < count; ++i) near.push_back(order[i].second);
  return near;
}

// Where the neighbours' second-order map has a row, if there are enough of them.
std::optional<Eigen::RowVector2d> said_with_bend(const Eigen::MatrixXd& board,
                                                 const Eigen::MatrixXd& image, Eigen::Index row) {
  const std::vector<Eigen::Index> near = nearest(board, row, kNeighboursOfBend);
  if (near.size() < kNeighboursOfBend) return std::nullopt;
  const auto from_row = [&](Eigen::Index k) { return (board.row(k) - board.row(row)).tail<2>(); };
  const double reach = from_row(near.back()).norm();
  Eigen::MatrixXd terms(near.size(), 6);
  for (size_t k = 0; k < near.size(); ++k) {
    const double a = from_row(near[k])[0] / reach, b = from_row(near[k])[1] / reach;
    terms.row(static_cast<Eigen::Index>(k)) << 1, a, b, a * a, a * b, b * b;
  }
  return robust_map(terms, image(near, Eigen::all)).row(0);
}

ViewFit fit_view(const PointsData& data, const std::vector<int>& rows) {
  ViewFit fit{.rows = rows, .wrong = std::vector<char>(rows.size(), 0)};
  const auto n = static_cast<Eigen::Index>(rows.size());
  if (!data.target.flat || n < 8) return fit;
  Eigen::MatrixXd board(n, 3), image(n, 2);
  for (Eigen::Index i = 0; i < n; ++i) {
    const int row = rows[static_cast<size_t>(i)];
    const Vec3 p = (data.p_W[row] - data.target.middle_W) * data.target.axes_W;
    board.row(i) << 1, p.x / data.target.half_x_m, p.y / data.target.half_y_m;
    image.row(i) << data.u_px[row], data.v_px[row];
  }
  const auto whole = robust_map(board, image);
  const double det = whole(1, 0) * whole(2, 1) - whole(1, 1) * whole(2, 0);
  fit.sense = det > 0 ? 1 : det < 0 ? -1 : 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    const std::vector<Eigen::Index> near = nearest(board, i, kNeighbours);
    const Eigen::MatrixXd near_board = board(near, Eigen::all);
    const auto map = robust_map(near_board, image(near, Eigen::all));
    const Eigen::RowVector2d said = board.row(i) * map;
    // The distance to the next corners as the map has it.
    std::vector<double> spacing;
    for (size_t k = 0; k < std::min<size_t>(4, near.size()); ++k)
      spacing.push_back((near_board.row(static_cast<Eigen::Index>(k)) * map - said).norm());
    const double most = kOfSpacing * median_of(spacing);
    if ((image.row(i) - said).norm() <= most) continue;
    const auto bent = said_with_bend(board, image, i);
    fit.wrong[static_cast<size_t>(i)] = !bent || (image.row(i) - *bent).norm() > most;
  }
  return fit;
}

class Gross {
 public:
  Gross(const PointsData& data, Facts& facts)
      : data_(data), facts_(facts), bad_(data.p_W.size(), 0) {}

  std::vector<char> find() {
    without_weight();
    far_from_the_target();
    if (data_.rig.type() == Rig::Type::unknown) by_view();
    if (std::find(bad_.begin(), bad_.end(), 1) == bad_.end()) return {};
    if (std::find(bad_.begin(), bad_.end(), 0) == bad_.end())
      throw InputError(fmt::format(
          "{}: no row takes part, expected views that show the target, each corner under its own "
          "name. {}",
          facts_.file, fmt::join(facts_.notes, ". ")));
    std::vector<char> scalars;
    for (const char bad : bad_) scalars.insert(scalars.end(), 2, bad);
    return scalars;
  }

 private:
  void note(const std::vector<int>& rows, const std::string& why) {
    if (rows.empty()) return;
    constexpr size_t kTold = 12;
    std::vector<int> lines;
    for (const int row : rows) {
      bad_[row] = 1;
      if (lines.size() < kTold) lines.push_back(facts_.line_of_row[row]);
    }
    facts_.notes.push_back(fmt::format("{} {} left out ({} {}{}): {}", rows.size(),
                                       rows.size() == 1 ? "row" : "rows",
                                       rows.size() == 1 ? "line" : "lines", fmt::join(lines, ", "),
                                       rows.size() > kTold ? " and more" : "", why));
  }

  void without_weight() {
    std::vector<int> rows;
    for (size_t row = 0; row < data_.spread.size(); ++row) {
      if (data_.spread[row] == 0) rows.push_back(static_cast<int>(row));
    }
    note(rows, "they have weight 0");
  }

  void far_from_the_target() {
    std::vector<int> far;
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<double> sorted;
      for (const Vec3& p : data_.p_W) sorted.push_back(p[axis]);
      std::sort(sorted.begin(), sorted.end());
      const double low = sorted[sorted.size() / 4], high = sorted[3 * sorted.size() / 4];
      const double extent =
          std::max({high - low, std::abs(low), std::abs(high),
                    data_.target.half_x_m > 1e6 ? 1e-3 : 1e-3 * data_.target.half_x_m});
      for (size_t row = 0; row < data_.p_W.size(); ++row) {
        const double value = data_.p_W[row][axis];
        const double away = std::max(low - value, value - high);
        if (away > kElsewhere * extent) far.push_back(static_cast<int>(row));
      }
    }
    std::sort(far.begin(), far.end());
    far.erase(std::unique(far.begin(), far.end()), far.end());
    if (20 * far.size() > data_.p_W.size()) return;
    note(far, "their points lie far from all others");
  }

  void by_view();
  void mirrored(const std::vector<ViewFit>& fits);

  const PointsData& data_;
  Facts& facts_;
  std::vector<char> bad_;
};

void Gross::mirrored(const std::vector<ViewFit>& fits) {
  int right = 0, left = 0;
  for (const ViewFit& fit : fits) right += fit.sense > 0, left += fit.sense < 0;
  const int fewer = std::min(right, left);
  if (fewer == 0 || fewer > kMostMirrored * (right + left)) return;
  const double sense = right < left ? 1 : -1;
  for (const ViewFit& fit : fits) {
    if (fit.sense != sense) continue;
    note(fit.rows, fmt::format("frame {} shows the board from behind, as no other does: its labels "
                               "are mirrored",
                               data_.frames[data_.frame_of_row[fit.rows.front()]]));
  }
}

void Gross::by_view() {
  std::vector<ViewFit> fits;
  for (const std::vector<int>& all : data_.rows_of_view) {
    std::vector<int> rows;
    std::copy_if(all.begin(), all.end(), std::back_inserter(rows),
                 [&](int row) { return !bad_[row]; });
    if (!rows.empty()) fits.push_back(fit_view(data_, rows));
  }
  mirrored(fits);
  std::vector<int> wrong;
  for (const ViewFit& fit : fits) {
    if (bad_[fit.rows.front()]) continue;
    const auto count = std::count(fit.wrong.begin(), fit.wrong.end(), 1);
    if (static_cast<double>(count) > kMostWrong * static_cast<double>(fit.rows.size())) {
      note(fit.rows, fmt::format("frame {} is no smooth image of the target: its labels or its "
                                 "corners are wrong",
                                 data_.frames[data_.frame_of_row[fit.rows.front()]]));
      continue;
    }
    for (size_t i = 0; i < fit.rows.size(); ++i) {
      if (fit.wrong[i]) wrong.push_back(fit.rows[i]);
    }
  }
  note(wrong, "they are far from where their neighbours in the view say");
}

}  // namespace

std::vector<char> gross_errors(const PointsData& data, Facts& facts) {
  return Gross(data, facts).find();
}

}  // namespace seam::measurement
