// Where an adjustment of a target sees its points, and how that follows from all that it estimates.
#include <Eigen/Dense>
#include <algorithm>

#include "measurement/kinds/points/points_predictor.h"
#include "measurement/kinds/points/target_adjustment.h"

namespace seam::measurement {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

using Slopes3 = Eigen::Matrix<double, 2, 3>;

Eigen::Matrix3d as_eigen(const Mat3& m) {
  Eigen::Matrix3d out;
  for (int c = 0; c < 3; ++c) {
    for (int r = 0; r < 3; ++r) out(r, c) = m[c][r];
  }
  return out;
}

// How a turn about the origin, a vector along its axis, moves this place.
Matrix3d by_turn(const Vec3& p) {
  Matrix3d slopes;
  slopes << 0, p.z, -p.y, -p.z, 0, p.x, p.y, -p.x, 0;
  return slopes;
}

}  // namespace

Vec3 TargetAdjustment::place_W(const Compiled& model, const State& state, size_t row) const {
  const auto point = static_cast<size_t>(given_.data.point_of_row[row]);
  Vec3 shift = state.displaced_m[point];
  if (has_flex()) {
    const auto frame = static_cast<size_t>(given_.data.frame_of_row[row]);
    shift.z += state.extra[frame][0] * compiled_.shape.flex_sigma_m *
               given_.data.target.bending(point, model.shape);
  }
  if (sways(row)) {
    const auto& e = state.extra[static_cast<size_t>(given_.data.frame_of_row[row])];
    const Index at = sway_at(given_.data.camera_of_row[row]);
    const double shift_m = compiled_.shape.sway_shift_sigma_m,
                 turn_rad = compiled_.shape.sway_turn_sigma_rad;
    shift += effects::swayed_by(given_.data.target.in_axes(point),
                                shift_m * Vec3(e[at], e[at + 1], e[at + 2]),
                                turn_rad * Vec3(e[at + 3], e[at + 4], e[at + 5]));
  }
  return model.places_W[row] + given_.data.target.axes_W * shift;
}

PathSighting path_sighting(const PointsData& data, size_t row, const Vec3& place_W, double sigma_u,
                           double sigma_v) {
  return {.row = row,
          .frame = static_cast<size_t>(data.frame_of_row[row]),
          .p_T = place_W - data.target.middle_W,
          .u_px = data.u_px[row],
          .v_px = data.v_px[row],
          .sigma_u = sigma_u,
          .sigma_v = sigma_v,
          .stamp_s = data.stamp_s[row],
          .camera = data.camera_of_row[row],
          .columns = data.columns_of(row)};
}

PathSighting TargetAdjustment::sighting(const Compiled& model, const State& state,
                                        size_t row) const {
  return path_sighting(given_.data, row, place_W(model, state, row), given_.sigma[2 * row],
                       given_.sigma[2 * row + 1]);
}

Vec3 TargetAdjustment::carried(const State& state, size_t row, const Vec3& p_R) const {
  if (!has_motion()) return p_R;
  const auto& e = state.extra[static_cast<size_t>(given_.data.frame_of_row[row])];
  const Index at = motion_at();
  const Vec3 turn_rad = given_.data.part_read(row) * compiled_.shape.motion_sigma_rad *
                        Vec3(e[at], e[at + 1], e[at + 2]);
  return p_R + effects::swayed_by(p_R, Vec3(0.0), turn_rad);
}

effects::ImagePoint TargetAdjustment::focused(const State& state, size_t row,
                                              effects::ImagePoint image) const {
  if (!has_focus()) return image;
  const auto& extra = state.extra[static_cast<size_t>(given_.data.frame_of_row[row])];
  const double longer =
      compiled_.shape.focus_sigma * extra[focus_at(given_.data.camera_of_row[row])];
  image.u += longer * (image.u - image.cx);
  image.v += longer * (image.v - image.cy);
  return image;
}

bool TargetAdjustment::see(const Compiled& model, const State& state, size_t row,
                           Vector2d& uv) const {
  const PointsData& data = given_.data;
  if (given_.path)
    return image_on_path(*given_.path, model.camera, state.controls, sighting(model, state, row),
                         uv);
  const Vec3 p_W = place_W(model, state, row);
  const effects::ImagePoint image = focused(
      state, row,
      unknown_poses_
          ? model.camera.cameras.project(
                carried(state, row, state.X_CW[static_cast<size_t>(data.frame_of_row[row])] * p_W),
                data.stamp_s[row], data.v_px[row], data.camera_of_row[row], data.columns_of(row))
          : model.predictor->image_at(row, p_W));
  uv = {image.u, image.v};
  return image.has_place();
}

// The cause's size in a scalar of the k-th used row of its frame.
double TargetAdjustment::cause(size_t frame, size_t k, int channel, Index which) const {
  return given_.causes[frame](2 * static_cast<Index>(k) + channel, which);
}

void TargetAdjustment::slopes_of_pose(const State& state, size_t row, const Slopes3& by_C,
                                      Cell& cell) const {
  const Vec3 p_C = state.X_CW[static_cast<size_t>(given_.data.frame_of_row[row])] *
                   place_W(compiled_, state, row);
  // d p_C = turn x p_C + shift.
  cell.by_view.leftCols<3>() = by_C * by_turn(p_C);
  cell.by_view.middleCols<3>(3) = by_C;
}

// By the rig's turn, over its spread. `by_R` is by the place before it.
void TargetAdjustment::slopes_of_motion(const State& state, size_t row, const Slopes3& by_R,
                                        const Vec3& p_R, Cell& cell) const {
  Matrix3d moved;  // Of the place by the place before.
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 unit(0.0);
    unit[axis] = 1;
    const Vec3 there = carried(state, row, unit) - carried(state, row, Vec3(0.0));
    moved.col(axis) << there.x, there.y, there.z;
  }
  const double unit_rad = given_.data.part_read(row) * compiled_.shape.motion_sigma_rad;
  cell.by_view.middleCols<3>(pose_unknowns() + motion_at()) =
      unit_rad * by_R * moved.inverse() * by_turn(p_R);
}

bool TargetAdjustment::look_on_path(const State& state, size_t row, Cell& cell) const {
  const size_t frame = static_cast<size_t>(given_.data.frame_of_row[row]);
  PathLook look;
  if (!measurement::look_on_path(*given_.path, compiled_.camera, state.controls,
                                 sighting(compiled_, state, row), look))
    return false;
  cell.uv = look.uv, cell.z = look.z;
  cell.from = kControlUnknowns *
              static_cast<Index>(look.weights.first - given_.path->of_frame(frame).first);
  cell.by_view = look.by_controls.leftCols(kControlUnknowns * look.weights.count);
  cell.by_point = look.by_place * as_eigen(given_.data.target.axes_W);
  return true;
}

bool TargetAdjustment::look(const State& state, size_t row, size_t k, Cell& cell) const {
  if (given_.path) return look_on_path(state, row, cell);
  const PointsData& data = given_.data;
  const auto frame = static_cast<size_t>(data.frame_of_row[row]);
  const Vec3 p_W = place_W(compiled_, state, row);
  const Pose& X_CW = state.X_CW[frame];
  const Vec3 p = unknown_poses_ ? X_CW * p_W : p_W;
  const auto image_of = [&](const Vec3& at) {
    return focused(state, row,
                   unknown_poses_ ? compiled_.camera.cameras.project(
                                        carried(state, row, at), data.stamp_s[row], data.v_px[row],
                                        data.camera_of_row[row], data.columns_of(row))
                                  : compiled_.predictor->image_at(row, at));
  };
  const effects::ImagePoint here = image_of(p);
  if (!here.has_place()) return false;
  // Of the image by the place, in the camera's axes or, where the motion is known, the world's.
  Slopes3 by_place;
  const double h = 1e-6 * std::max(glm::length(p), 1e-3);
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 there = p;
    there[axis] += h;
    const effects::ImagePoint image = image_of(there);
    if (!image.has_place()) return false;
    by_place(0, axis) = (image.u - here.u) / h;
    by_place(1, axis) = (image.v - here.v) / h;
  }
  const Vector2d weight(1 / given_.sigma[2 * row], 1 / given_.sigma[2 * row + 1]);
  cell.by_view.resize(2, unknowns(frame));
  cell.uv = Vector2d(here.u, here.v);
  cell.z = Vector2d(data.u_px[row] - here.u, data.v_px[row] - here.v);
  if (unknown_poses_) slopes_of_pose(state, row, by_place, cell);
  cell.by_point =
      by_place * as_eigen(unknown_poses_ ? X_CW.R * data.target.axes_W : data.target.axes_W);
  slopes_of_extras(row, k, cell);
  if (has_focus()) {
    const Index at = focus_at(data.camera_of_row[row]);
    const double sigma = compiled_.shape.focus_sigma;
    cell.by_view.col(pose_unknowns() + at) =
        sigma / (1 + sigma * state.extra[frame][at]) * Vector2d(here.u - here.cx, here.v - here.cy);
  }
  if (has_motion()) slopes_of_motion(state, row, by_place, p, cell);
  const Index causes = unknowns(frame) - pose_unknowns() - causes_at();
  cell.z -= cell.by_view.rightCols(causes) * state.extra[frame].tail(causes);
  cell.z = weight.cwiseProduct(cell.z);
  cell.by_view = -(weight.asDiagonal() * cell.by_view).eval();
  cell.by_point = -(weight.asDiagonal() * cell.by_point).eval();
  return true;
}

// Of the image by the draws of its frame, over their spreads, and by its causes; by the point's own
// place it is known.
void TargetAdjustment::slopes_of_extras(size_t row, size_t k, Cell& cell) const {
  const Target& target = given_.data.target;
  const auto point = static_cast<size_t>(given_.data.point_of_row[row]);
  const auto frame = static_cast<size_t>(given_.data.frame_of_row[row]);
  auto extras = cell.by_view.rightCols(cell.by_view.cols() - pose_unknowns());
  if (has_flex())
    extras.col(0) = cell.by_point.col(2) * compiled_.shape.flex_sigma_m *
                    target.bending(point, compiled_.shape);
  extras.middleCols(focus_at(0), causes_at() - focus_at(0)).setZero();
  for (int axis = 0; axis < 3 && sways(row); ++axis) {
    const Index at = sway_at(given_.data.camera_of_row[row]) + axis;
    Vec3 unit(0.0);
    unit[axis] = 1;
    const Vec3 turned = effects::swayed_by(target.in_axes(point), Vec3(0.0), unit);
    extras.col(at) = compiled_.shape.sway_shift_sigma_m * cell.by_point.col(axis);
    extras.col(at + 3) = compiled_.shape.sway_turn_sigma_rad *
                         (cell.by_point * Vector3d(turned.x, turned.y, turned.z));
  }
  for (Index at = causes_at(); at < extras.cols(); ++at) {
    for (int c = 0; c < 2; ++c) extras(c, at) = cause(frame, k, c, at - causes_at());
  }
}

}  // namespace seam::measurement
