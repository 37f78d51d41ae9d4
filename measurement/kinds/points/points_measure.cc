// Makes a set of points: what the model would show by a protocol's frames.
#include <algorithm>

#include "effects/stages/joint_track.h"
#include "effects/stages/noise.h"
#include "measurement/kinds/kinds.h"
#include "measurement/kinds/points/points_predictor.h"
#include "sim_core/base/error.h"

namespace seam::measurement {

namespace {

// The rig by which a set is made. Of a board whose poses its reader shall not know the protocol
// says them in its table `poses`.
Rig rig_to_make(const MeasurementSet& protocol) {
  Rig rig = Rig::from_set(protocol);
  if (rig.type() != Rig::Type::unknown) return rig;
  if (!protocol.has_file("poses"))
    protocol.root.at("rig").fail(
        "found an unknown pose, expected a chain or poses, or a table `poses` under `files`: a "
        "protocol must say where the camera is");
  return Rig::from_poses(protocol.file("poses"));
}

// Draws of a target: displacements of its points, the same in all frames, the bending of each frame
// and how it sways before cameras but the first, by counters of their numbers.
class TargetDraw {
 public:
  TargetDraw(const PointsData& data, const Model& truth, const RandomStream& stream, bool noise)
      : data_(data),
        shape_(effects::target_of(truth)),
        flex_(stream.child("flex")),
        sway_(stream.child("sway")),
        focus_(stream.child("focus")),
        motion_(stream.child("motion")) {
    for (size_t point = 0; point < data.target.names.size(); ++point) {
      Vec3 shift(0.0);
      for (int axis = 0; axis < 3 && noise; ++axis)
        shift[axis] = shape_.scatter_sigma_m *
                      normal(stream.child("scatter"), 3 * point + static_cast<size_t>(axis));
      displaced_m_.push_back(shift);
    }
    if (!noise) shape_.flex_sigma_m = shape_.sway_shift_sigma_m = shape_.sway_turn_sigma_rad = 0;
    if (!noise) shape_.focus_sigma = shape_.motion_sigma_rad = 0;
  }

  // By what share the focal length of the row's view is longer.
  double longer(size_t row) const {
    return shape_.focus_sigma *
           normal(focus_.child(static_cast<uint64_t>(data_.camera_of_row[row])),
                  static_cast<uint64_t>(data_.frame_of_row[row]));
  }

  bool has_motion() const { return shape_.motion_sigma_rad > 0; }
  // How far a point at this place before the rig comes while an image is read.
  Vec3 carried(size_t row, const Vec3& p_R) const {
    return swayed(motion_.child(static_cast<uint64_t>(data_.frame_of_row[row])), p_R, 0,
                  shape_.motion_sigma_rad);
  }

  Vec3 shift_W(size_t row) const {
    const auto point = static_cast<size_t>(data_.point_of_row[row]);
    const double bend_m =
        shape_.flex_sigma_m * normal(flex_, static_cast<uint64_t>(data_.frame_of_row[row]));
    const Vec3 bent(0, 0, bend_m * data_.target.bending(point, shape_));
    return data_.target.axes_W * (displaced_m_[point] + bent + swayed(row));
  }

 private:
  static Vec3 swayed(const RandomStream& stream, const Vec3& p, double shift_m, double turn_rad) {
    const auto drawn = [&](uint64_t first) {
      return Vec3(normal(stream, first), normal(stream, first + 1), normal(stream, first + 2));
    };
    return effects::swayed_by(p, shift_m * drawn(0), turn_rad * drawn(3));
  }
  Vec3 swayed(size_t row) const {
    const auto camera = static_cast<uint64_t>(data_.camera_of_row[row]);
    if (camera == 0 || !shape_.has_sway()) return Vec3(0.0);
    return swayed(sway_.child(camera).child(static_cast<uint64_t>(data_.frame_of_row[row])),
                  data_.target.in_axes(static_cast<size_t>(data_.point_of_row[row])),
                  shape_.sway_shift_sigma_m, shape_.sway_turn_sigma_rad);
  }

  const PointsData& data_;
  effects::TargetShape shape_;
  RandomStream flex_, sway_, focus_, motion_;
  std::vector<Vec3> displaced_m_;
};

// The logged angle is the true one rounded to this step; the true one lies within half of it.
std::vector<double> rounding_errors(const PointsData& data, const PointsPredictor& predictor,
                                    const RandomStream& stream, size_t row, double step_rad) {
  std::vector<double> errors(data.rig.joint_names().size(), 0);
  if (!(step_rad > 0)) return errors;
  const auto& log = data.rig.log_times();
  const double t = predictor.instant(row, 0.5 * data.camera.height_px);
  const size_t node =
      std::min<size_t>(std::upper_bound(log.begin(), log.end(), t) - log.begin(), log.size() - 1);
  for (size_t j = 0; j < errors.size(); ++j)
    errors[j] = step_rad * (uniform(effects::rounding_stream(stream).child(j), node) - 0.5);
  return errors;
}

}  // namespace

void measure_points(const Model& truth, const MeasurementSet& protocol,
                    const MeasureOptions& options) {
  Facts facts;
  PointsData data = read_points(protocol, rig_to_make(protocol), false, facts);
  const CsvTable table = protocol.table("points");
  std::fill(data.v_px.begin(), data.v_px.end(), 0.5 * data.camera.height_px);
  const effects::Timing timing = effects::timing_of(truth);
  const RandomStream stream = RandomStream{.seed = options.seed}.child("measure").child("points");
  // Spreads of whole frames are drawn: a latency a frame, an error at each sample of the log.
  const PointsPredictor predictor(data, truth);
  const TargetDraw drawn(data, truth, stream, options.noise);
  const double step = options.noise ? predictor.motion().quantisation_step_rad : 0;
  std::vector<std::string> columns = table.columns();
  for (const char* name : {"u_px", "v_px"}) {
    if (!table.has(name)) columns.push_back(name);
  }
  const effects::Few scatter = effects::noise_of(truth).point_scatter;
  CsvWriter out(columns);
  for (size_t row = 0; row < data.p_W.size(); ++row) {
    const uint64_t frame = static_cast<uint64_t>(data.frame_of_row[row]);
    const double late = options.noise ? timing.own_latency_s(stream, frame) : 0;
    const std::vector<double> errors = rounding_errors(data, predictor, stream, row, step);
    const Vec3 p_W = predictor.places_W()[row] + drawn.shift_W(row);
    const auto seen_at = [&](const Vec3& place_W) {
      return predictor.image_at(row, place_W, late, errors.empty() ? nullptr : errors.data());
    };
    effects::ImagePoint point = seen_at(p_W);
    const int height_px = data.cameras[static_cast<size_t>(data.camera_of_row[row])].height_px;
    // The row at which it is seen says how far it has come, and that where it is seen.
    for (int round = 0; round < 4 && drawn.has_motion() && point.visible; ++round) {
      const Pose X_WR = predictor.motion().X_WC(predictor.instant(row, point.v));
      const Vec3 way_R = drawn.carried(row, X_WR.inverse() * p_W);
      point = seen_at(p_W + X_WR.R * ((point.v / height_px - 0.5) * way_R));
    }
    double u = point.u + drawn.longer(row) * (point.u - point.cx),
           v = point.v + drawn.longer(row) * (point.v - point.cy);
    if (options.noise) {
      const auto sigma = [&](const char* name) {
        return protocol.noise.contains(name) ? protocol.noise.at(name) : 0.0;
      };
      u += sigma("u_px") * normal(stream.child("noise"), 2 * row);
      v += sigma("v_px") * normal(stream.child("noise"), 2 * row + 1);
      if (uniform(stream.child("scattered"), row) < scatter.fraction) {
        u += scatter.size * normal(stream.child("scatter"), 2 * row);
        v += scatter.size * normal(stream.child("scatter"), 2 * row + 1);
      }
    }
    const CameraView& view = data.cameras[static_cast<size_t>(data.camera_of_row[row])];
    const bool inside = u > -0.5 && v > -0.5 && u < view.width_px - 0.5 && v < view.height_px - 0.5;
    if (!point.visible || !inside) continue;
    std::vector<std::string> cells;
    for (const std::string& name : columns) {
      cells.push_back(name == "u_px"   ? fmt::format("{:.6f}", u)
                      : name == "v_px" ? fmt::format("{:.6f}", v)
                                       : std::string(table.cell(row, name)));
    }
    out.row(cells);
  }
  copy_protocol(protocol, options.out, {"points"});
  out.write(written_path(options.out, protocol.files.at("points")));
}

}  // namespace seam::measurement
