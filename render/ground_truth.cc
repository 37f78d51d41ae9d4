#include "render/ground_truth.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "render/cast/scene_motion.h"
#include "render/gl/device.h"
#include "sim_core/base/error.h"

namespace seam::render {
namespace {

// The scene as a function of time, from the frame's instants.
class SceneInTime {
 public:
  explicit SceneInTime(const FrameJob& job) : job_(job) {}

  SceneInstant at(SimTime time) const {
    if (job_.instants.size() < 2) return job_.instants.front();
    const auto [a, b] = around(time);
    return interpolate(*a, *b, time);
  }

  // Where the camera and one primitive stand.
  void poses_at(SimTime time, size_t primitive, Pose& X_WC, Pose& X_WO) const {
    if (job_.instants.size() < 2) {
      X_WC = job_.instants[0].X_WC, X_WO = job_.instants[0].primitives[primitive].X_WO;
      return;
    }
    const auto [a, b] = around(time);
    const auto only = [&](const SceneInstant& scene) {
      SceneInstant one{.time = scene.time, .X_WC = scene.X_WC, .primitives = {}};
      one.primitives.push_back(scene.primitives[std::min(primitive, scene.primitives.size() - 1)]);
      return one;
    };
    const SceneInstant scene = interpolate(only(*a), only(*b), time);
    X_WC = scene.X_WC, X_WO = scene.primitives[0].X_WO;
  }

 private:
  using Place = std::vector<SceneInstant>::const_iterator;
  std::pair<Place, Place> around(SimTime time) const {
    const auto after =
        std::lower_bound(job_.instants.begin(), job_.instants.end(), time,
                         [](const SceneInstant& a, SimTime t) { return a.time < t; });
    const Place b = std::clamp(after, job_.instants.begin() + 1, job_.instants.end() - 1);
    return {b - 1, b};
  }
  const FrameJob& job_;
};

struct ImagePosition {
  double u, v;
  bool visible;
};

// Where a point fixed to a primitive is seen when the row that shows it is at `fraction` of its
// window: the row depends on the image point and the image point on the row's time.
ImagePosition follow(const FrameJob& job, const SceneInTime& scenes,
                     const effects::Projection& projection, size_t primitive, const Vec3& p_O,
                     double fraction, double row) {
  ImagePosition seen{0, row, false};
  const auto last_row = static_cast<double>(job.schedule.rows.size() - 1);
  for (int step = 0; step < 4; ++step) {
    const double clamped = std::clamp(seen.v, 0.0, last_row);
    const auto below = static_cast<size_t>(clamped);
    const auto above = std::min(below + 1, job.schedule.rows.size() - 1);
    const auto time_in = [&](const RowWindow& window) {
      return static_cast<double>((window.start - job.stamp).ns()) +
             fraction * static_cast<double>((window.end - window.start).ns());
    };
    const double between = clamped - static_cast<double>(below);
    const double after_ns = (1 - between) * time_in(job.schedule.rows[below]) +
                            between * time_in(job.schedule.rows[above]);
    Pose X_WC, X_WO;
    scenes.poses_at(job.stamp + SimDuration::from_ns(std::llround(after_ns)), primitive, X_WC,
                    X_WO);
    const effects::ImagePoint point = projection.project(X_WC.inverse() * (X_WO * p_O), 0, clamped);
    seen = {point.u, point.v, point.visible};
    if (!point.visible) return seen;
  }
  return seen;
}

// What the rays through the centres of each row's pixels meet in the middle of its window.
class Centres {
 public:
  Centres(const FrameJob& job, const CameraRays& rays, const GlDevice* opengl)
      : job_(job),
        rays_(rays),
        scenes_(job),
        pattern_(rays.columns()),
        caster_(rays, pattern_, false, 1) {
    if (opengl) drawn_ = opengl->see_centres(middle_of_rows(), rays);
  }

  // Calls see(column, source, depth) where something is met.
  template <typename See>
  void row(int v, const SceneInstant& scene, const See& see) {
    if (drawn_) {
      for (int u = 0; u < rays_.width_px; ++u) {
        const size_t i = static_cast<size_t>(v) * rays_.width_px + u;
        if (drawn_->source[i] >= 0)
          see(u, static_cast<size_t>(drawn_->source[i]), drawn_->depth[i]);
      }
      return;
    }
    const int table_row = v + rays_.border_px;
    prepare(scene, job_, rays_, {table_row, table_row}, prepared_);
    const RowCaster::Seen seen = caster_.see_centres(table_row, prepared_);
    for (int u = 0; u < rays_.width_px; ++u) {
      const int column = u + rays_.border_px;
      if (seen.id[column] >= 0)
        see(u, static_cast<size_t>(prepared_.sources[seen.id[column]]), seen.depth[column]);
    }
  }

 private:
  // A job whose rows have one instant each.
  FrameJob middle_of_rows() const {
    FrameJob job = job_;
    job.instants.clear();
    job.schedule = {};
    job.schedule.rows = job_.schedule.rows;
    for (const RowWindow& row : job.schedule.rows) {
      const SimTime middle = row.start + (row.end - row.start) / 2;
      job.schedule.first_instant.push_back(static_cast<int>(job.instants.size()));
      job.schedule.weights.push_back({1.0});
      job.schedule.instants.push_back(middle);
      job.instants.push_back(scenes_.at(middle));
    }
    return job;
  }

  const FrameJob& job_;
  const CameraRays& rays_;
  SceneInTime scenes_;
  SamplePattern pattern_;
  RowCaster caster_;
  PreparedInstant prepared_;
  std::optional<GlDevice::Centres> drawn_;
};

}  // namespace

GroundTruth make_ground_truth(const FrameJob& given, const CameraRays& rays,
                              const effects::Projection& projection, const GlDevice* opengl) {
  const FrameJob job = with_all_primitives(given);
  GroundTruth truth{.width_px = rays.width_px, .height_px = rays.height_px};
  const size_t pixels = static_cast<size_t>(rays.width_px) * rays.height_px;
  truth.label.assign(pixels, static_cast<uint8_t>(Label::background));
  truth.object_id.assign(pixels, 0);
  truth.depth_m.assign(pixels, std::numeric_limits<float>::infinity());
  truth.flow_u_px.assign(pixels, 0);
  truth.flow_v_px.assign(pixels, 0);
  const SceneInTime scenes(job);
  const RayTable& green = rays.table(1);
  Centres centres(job, rays, opengl);
  for (int v = 0; v < rays.height_px; ++v) {
    const RowWindow& window = job.schedule.rows[v];
    const SceneInstant scene = scenes.at(window.start + (window.end - window.start) / 2);
    centres.row(v, scene, [&](int u, size_t source, float depth) {
      const size_t i = static_cast<size_t>(v) * rays.width_px + u;
      const Primitive& primitive = scene.primitives[source];
      const size_t ray = rays.at(v + rays.border_px) + u + rays.border_px;
      const Vec3 p_C = static_cast<double>(depth) *
                       Vec3(green.base[0][ray], green.base[1][ray], green.base[2][ray]);
      truth.label[i] = static_cast<uint8_t>(primitive.label);
      truth.object_id[i] = primitive.object_id;
      truth.depth_m[i] = static_cast<float>(p_C.z);
      if (window.start == window.end) return;
      const Vec3 p_O = primitive.X_WO.inverse() * (scene.X_WC * p_C);
      const ImagePosition first = follow(job, scenes, projection, source, p_O, 0, v);
      const ImagePosition last = follow(job, scenes, projection, source, p_O, 1, v);
      if (!first.visible || !last.visible) return;
      truth.flow_u_px[i] = static_cast<float>(last.u - first.u);
      truth.flow_v_px[i] = static_cast<float>(last.v - first.v);
    });
  }
  return truth;
}

}  // namespace seam::render
