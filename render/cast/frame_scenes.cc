#include "render/cast/frame_scenes.h"

#include <algorithm>

#include "render/cast/scene_motion.h"

namespace seam::render {
namespace {

constexpr size_t kNoInstant = static_cast<size_t>(-1);

const FigureAt* find(const std::vector<FigureAt>& figures, const Figure* figure) {
  const auto found = std::find_if(figures.begin(), figures.end(),
                                  [&](const FigureAt& at) { return at.figure == figure; });
  return found == figures.end() ? nullptr : &*found;
}

void move_between(const std::vector<Primitive>& a, const std::vector<Primitive>& b, double fraction,
                  std::vector<Primitive>& out) {
  for (size_t i = 0; i < out.size(); ++i) out[i].X_WO = between(a[i].X_WO, b[i].X_WO, fraction);
}

}  // namespace

FrameScenes::FrameScenes(const FrameJob& job, const CameraRays& rays) : job_(job), rays_(rays) {
  for (const Primitive& primitive : job.scenery) {
    scenery_centres_W_.push_back(primitive.X_WO * bounding_centre(primitive));
    scenery_radii_m_.push_back(bounding_radius(primitive));
  }
}

const std::vector<Primitive>& FrameScenes::parts_at(size_t k, const FigureAt& at) {
  auto placed = std::find_if(placed_.begin(), placed_.end(),
                             [&](const Placed& p) { return p.figure == at.figure; });
  if (placed == placed_.end())
    placed = placed_.insert(placed_.end(), {at.figure, {kNoInstant, kNoInstant}, {}});
  std::vector<Primitive>& parts = placed->parts[k % 2];
  if (placed->instant[k % 2] != k) {
    placed->instant[k % 2] = k;
    parts.clear();
    at.figure->add_parts(at.posture, parts);
  }
  return parts;
}

int FrameScenes::show_first(const Pose& X_CW, RowRange rows,
                            const std::vector<Primitive>& primitives) {
  shown_.clear();
  for (size_t i = 0; i < job_.scenery.size(); ++i) {
    if (may_be_seen(X_CW * scenery_centres_W_[i], scenery_radii_m_[i], rays_, rows))
      shown_.push_back({&job_.scenery[i], static_cast<int>(i)});
  }
  show(primitives, static_cast<int>(job_.scenery.size()));
  return static_cast<int>(job_.scenery.size() + primitives.size());
}

void FrameScenes::show(const std::vector<Primitive>& primitives, int first_place) {
  for (const Primitive& primitive : primitives) shown_.push_back({&primitive, first_place++});
}

void FrameScenes::prepare_at(size_t k, RowRange rows, PreparedInstant& out) {
  const SceneInstant& instant = job_.instants[k];
  const Pose X_CW = instant.X_WC.inverse();
  int place = show_first(X_CW, rows, instant.primitives);
  for (const FigureAt& at : instant.figures) {
    if (may_be_seen(X_CW * at.posture.p_WB, at.figure->radius_m(), rays_, rows))
      show(parts_at(k, at), place);
    place += static_cast<int>(at.figure->part_count());
  }
  prepare(instant.X_WC, shown_, job_, rays_, rows, out);
}

void FrameScenes::prepare_at(SimTime time, RowRange rows, PreparedInstant& out) {
  const auto after = std::lower_bound(job_.instants.begin(), job_.instants.end(), time,
                                      [](const SceneInstant& a, SimTime t) { return a.time < t; });
  const auto second = std::clamp(after, job_.instants.begin() + 1, job_.instants.end() - 1);
  const SceneInstant &a = *(second - 1), &b = *second;
  const SceneInstant own =
      interpolate({a.time, a.X_WC, a.primitives, {}}, {b.time, b.X_WC, b.primitives, {}}, time);
  const auto k = static_cast<size_t>(second - job_.instants.begin()) - 1;
  const double fraction = fraction_between(a, b, time);
  const Pose X_CW = own.X_WC.inverse();
  int place = show_first(X_CW, rows, own.primitives);
  // As the nearer instant has them.
  const std::vector<FigureAt>& figures = (fraction < 0.5 ? a : b).figures;
  between_.resize(figures.size());
  for (size_t i = 0; i < figures.size(); ++i) {
    const Figure* const figure = figures[i].figure;
    const FigureAt *from = find(a.figures, figure), *to = find(b.figures, figure);
    // What the other instant lacks stays as it is.
    const bool moves = from && to;
    if (!moves) from = to = &figures[i];
    const Vec3 p_WB = from->posture.p_WB + fraction * (to->posture.p_WB - from->posture.p_WB);
    if (may_be_seen(X_CW * p_WB, figure->radius_m(), rays_, rows)) {
      between_[i] = parts_at(fraction < 0.5 ? k : k + 1, figures[i]);
      if (moves) move_between(parts_at(k, *from), parts_at(k + 1, *to), fraction, between_[i]);
      show(between_[i], place);
    }
    place += static_cast<int>(figure->part_count());
  }
  prepare(own.X_WC, shown_, job_, rays_, rows, out);
}

double FrameScenes::motion_px(size_t k, double enough_px) {
  const SceneInstant &a = job_.instants[k], &b = job_.instants[k + 1];
  const Pose X_CW_a = a.X_WC.inverse(), X_CW_b = b.X_WC.inverse();
  const auto in_sight = [&](const Pose& X_CW, const Vec3& p_W, double radius_m) {
    return may_be_seen(X_CW * p_W, radius_m, rays_, {0, rays_.rows() - 1});
  };
  const auto sees_figure = [&](const Pose& X_CW, const FigureAt& at) {
    return in_sight(X_CW, at.posture.p_WB, at.figure->radius_m());
  };
  const auto sees_part = [&](const Pose& X_CW, const Primitive& part) {
    return in_sight(X_CW, part.X_WO * bounding_centre(part), bounding_radius(part));
  };
  // What is out of sight may move as it likes.
  ImageMotion motion(a.X_WC, b.X_WC, [&](const Primitive& from, const Primitive& to) {
    return sees_part(X_CW_a, from) || sees_part(X_CW_b, to);
  });
  motion.add_all(a.primitives, b.primitives);
  for (const FigureAt& from : a.figures) {
    const FigureAt* const to = find(b.figures, from.figure);
    if (!to || (!sees_figure(X_CW_a, from) && !sees_figure(X_CW_b, *to))) continue;
    const double moved_m = from.figure->motion_bound_m(from.posture, to->posture);
    const double most = motion.most_with(from.posture.p_WB, from.figure->radius_m(), moved_m);
    if (rays_.focal_px * most > enough_px) motion.add_all(parts_at(k, from), parts_at(k + 1, *to));
  }
  return rays_.focal_px * motion.most();
}

}  // namespace seam::render
