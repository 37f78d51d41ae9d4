#include "measurement/sets/rig.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numeric>

#include "effects/stages/geometry.h"
#include "sim_core/base/error.h"

namespace seam::measurement {

PoseTrack::PoseTrack(const std::vector<double>& times, const std::vector<Vec3>& positions,
                     const std::vector<std::array<double, 4>>& quaternions) {
  std::vector<double> signal(times.size());
  for (int axis = 0; axis < 3; ++axis) {
    for (size_t i = 0; i < times.size(); ++i) signal[i] = positions[i][axis];
    position_[axis] = Spline(times, signal);
  }
  // q and -q are the same rotation: keep the sign that is nearest to the one before.
  std::vector<double> sign(times.size(), 1);
  for (size_t i = 1; i < times.size(); ++i) {
    double dot = 0;
    for (int c = 0; c < 4; ++c) dot += quaternions[i][c] * quaternions[i - 1][c];
    sign[i] = dot < 0 ? -sign[i - 1] : sign[i - 1];
  }
  for (int c = 0; c < 4; ++c) {
    for (size_t i = 0; i < times.size(); ++i) signal[i] = sign[i] * quaternions[i][c];
    quaternion_[c] = Spline(times, signal);
  }
}

Pose PoseTrack::at(double t_s) const {
  return {rotation_from_quaternion(quaternion_[0].value(t_s), quaternion_[1].value(t_s),
                                   quaternion_[2].value(t_s), quaternion_[3].value(t_s)),
          {position_[0].value(t_s), position_[1].value(t_s), position_[2].value(t_s)}};
}

std::vector<double> log_seconds(const CsvTable& table, const std::string& column,
                                int64_t reference_ns, const std::vector<size_t>& rows,
                                std::vector<size_t>& keep) {
  const std::vector<int64_t> ns = table.times_ns(column);
  std::vector<double> seconds;
  for (const size_t row : rows) {
    if (!keep.empty() && ns[row] < ns[keep.back()]) {
      table.fail(row, column, table.cell(row, column), "a time not before that of the row before");
    }
    if (!keep.empty() && ns[row] == ns[keep.back()]) continue;
    keep.push_back(row);
    seconds.push_back(1e-9 * static_cast<double>(ns[row] - reference_ns));
  }
  return seconds;
}

Rig Rig::from_set(const MeasurementSet& set) {
  Rig rig;
  const ConfigNode node = set.root.at("rig");
  const RigKeys keys = rig_keys_of(node);
  rig.path_ = static_cast<Path>(keys.motion);
  rig.knot_s_ = keys.knot_s;
  if (keys.has_chain) {
    rig.read_chain(keys, set);
  } else if (!keys.poses.empty()) {
    rig.type_ = Type::poses;
    rig.read_poses(set.has_file(keys.poses) ? set.table(keys.poses)
                                            : CsvTable::read(set.inside(node.at("poses"))));
  }
  return rig;
}

Rig Rig::from_poses(const std::filesystem::path& table) {
  Rig rig;
  rig.type_ = Type::poses;
  rig.read_poses(CsvTable::read(table));
  return rig;
}

void Rig::read_chain(const RigKeys& keys, const MeasurementSet& set) {
  type_ = Type::chain;
  Pose fixed;
  for (const RigLink& link : keys.chain) {
    if (!link.joint.empty()) {
      const auto found = std::find(joint_names_.begin(), joint_names_.end(), link.joint);
      const int index = static_cast<int>(found - joint_names_.begin());
      if (found == joint_names_.end()) joint_names_.push_back(link.joint);
      links_.push_back(
          {.fixed = fixed, .joint = index, .axis = link.axis / glm::length(link.axis)});
      fixed = Pose{};
    } else if (!std::isnan(link.translate_m.x)) {
      fixed = fixed * translation(link.translate_m);
    } else {
      fixed =
          fixed * rotation(rotation_zyx(link.rotate_rad.x, link.rotate_rad.y, link.rotate_rad.z));
    }
  }
  links_.push_back({.fixed = fixed});
  if (joint_names_.empty()) {  // A fixed camera: any time will do.
    first_s_ = -1e300, last_s_ = 1e300;
    return;
  }
  const CsvTable table = set.table("joints");
  if (table.rows() < 2)
    throw InputError(
        fmt::format("{}: found {} rows, expected 2 or more", table.file(), table.rows()));
  reference_ns_ = table.times_ns("time_s").front();
  std::vector<size_t> rows(table.rows()), keep;
  std::iota(rows.begin(), rows.end(), 0);
  track_.time_s = log_seconds(table, "time_s", reference_ns_, rows, keep);
  for (const std::string& name : joint_names_) {
    const std::vector<double> all = table.numbers(name + "_rad");
    effects::JointSeries series{.name = name, .role = effects::joint_role(name)};
    for (const size_t row : keep) series.q_rad.push_back(all[row]);
    logged_.emplace_back(track_.time_s, series.q_rad);
    track_.joints.push_back(std::move(series));
  }
  first_s_ = track_.time_s.front(), last_s_ = track_.time_s.back();
  fine_track_ = finer_track();
  find_cycle();
}

void Rig::read_poses(const CsvTable& table) {
  if (table.rows() < 2)
    throw InputError(
        fmt::format("{}: found {} rows, expected 2 or more", table.file(), table.rows()));
  reference_ns_ = table.times_ns("time_s").front();
  std::vector<size_t> rows(table.rows()), keep;
  std::iota(rows.begin(), rows.end(), 0);
  const std::vector<double> times = log_seconds(table, "time_s", reference_ns_, rows, keep);
  const std::vector<double> x = table.numbers("x_m"), y = table.numbers("y_m"),
                            z = table.numbers("z_m");
  const std::vector<double> q[4] = {table.numbers("qw"), table.numbers("qx"), table.numbers("qy"),
                                    table.numbers("qz")};
  std::vector<Vec3> positions;
  std::vector<std::array<double, 4>> quaternions;
  for (const size_t row : keep) {
    const double norm = std::sqrt(q[0][row] * q[0][row] + q[1][row] * q[1][row] +
                                  q[2][row] * q[2][row] + q[3][row] * q[3][row]);
    if (std::abs(norm - 1) > 0.01)
      table.fail(row, "qw", fmt::format("a quaternion of norm {}", norm), "norm 1");
    positions.emplace_back(x[row], y[row], z[row]);
    quaternions.push_back({q[0][row] / norm, q[1][row] / norm, q[2][row] / norm, q[3][row] / norm});
  }
  poses_ = PoseTrack(times, positions, quaternions);
  first_s_ = times.front(), last_s_ = times.back();
}

effects::JointTrack Rig::finer_track() const {
  constexpr size_t kFiner = 8;
  effects::JointTrack fine;
  const std::vector<double>& times = track_.time_s;
  for (size_t i = 0; i + 1 < times.size(); ++i) {
    for (size_t k = 0; k < kFiner; ++k)
      fine.time_s.push_back(times[i] + (times[i + 1] - times[i]) * static_cast<double>(k) / kFiner);
  }
  fine.time_s.push_back(times.back());
  for (size_t j = 0; j < track_.joints.size(); ++j) {
    effects::JointSeries series{.name = track_.joints[j].name, .role = track_.joints[j].role};
    for (const double t : fine.time_s) series.q_rad.push_back(logged_[j].value(t));
    fine.joints.push_back(std::move(series));
  }
  return fine;
}

// The shortest shift after which the log repeats itself, refined by a parabola.
void Rig::find_cycle() {
  size_t busiest = 0;
  double largest = 0;
  for (size_t j = 0; j < logged_.size(); ++j) {
    const auto [low, high] =
        std::minmax_element(track_.joints[j].q_rad.begin(), track_.joints[j].q_rad.end());
    if (*high - *low > largest) largest = *high - *low, busiest = j;
  }
  if (largest <= 1e-6) return;
  const Spline& angle = logged_[busiest];
  const double span = last_s_ - first_s_;
  constexpr int kSamples = 400;
  const auto mismatch = [&](double shift) {
    double sum = 0;
    for (int i = 0; i < kSamples; ++i) {
      const double t = first_s_ + (span - shift) * i / (kSamples - 1);
      const double difference = angle.value(t + shift) - angle.value(t);
      sum += difference * difference;
    }
    return std::sqrt(sum / kSamples) / largest;
  };
  const double step = span / 2000;
  bool left_start = false;
  for (double shift = step; shift < 0.6 * span; shift += step) {
    const double here = mismatch(shift);
    left_start = left_start || here > 0.15;
    if (!left_start || here > 0.1 || here > mismatch(shift - step) || here > mismatch(shift + step))
      continue;
    double low = shift - step, high = shift + step;  // Golden section.
    for (int i = 0; i < 40; ++i) {
      const double a = high - 0.618034 * (high - low), b = low + 0.618034 * (high - low);
      (mismatch(a) < mismatch(b) ? high : low) = mismatch(a) < mismatch(b) ? b : a;
    }
    if (mismatch(0.5 * (low + high)) < 0.01) {
      cycle_s_ = 0.5 * (low + high);
      return;
    }
  }
}

Rig::Motion Rig::motion(const effects::Model& model) const {
  Motion motion;
  motion.rig_ = this;
  motion.X_LC_ = effects::mount_of(model);
  if (type_ == Type::poses) {
    // The pose is the camera's own: mount effects act in the link's axes before it.
    motion.X_LC_ = rotation(glm::transpose(link_to_camera_axes())) * motion.X_LC_;
    return motion;
  }
  if (type_ == Type::unknown) return motion;
  bool any = false, memory = false;
  for (const effects::ModelEffect& effect : model.effects()) {
    any = any || effect.definition->encoder || effect.definition->joint_map;
    memory = memory || effect.definition->remembers;
  }
  if (!any) {
    motion.joints_ = logged_;
    return motion;
  }
  effects::JointTrack track = memory ? fine_track_ : track_;
  effects::apply_encoder_effects(model, track);
  for (const effects::ModelEffect& effect : model.effects()) {
    if (!effect.definition->joint_map) continue;
    for (size_t j = 0; j < track.joints.size(); ++j) {
      if (track.joints[j].role != effects::JointRole::pan) continue;
      for (size_t i = 0; i < track.time_s.size(); ++i) {
        const effects::JointSample sample{.q_rad = track.joints[j].q_rad[i],
                                          .rate_rad_per_s = logged_[j].rate(track.time_s[i]),
                                          .command_rad = track.joints[j].q_rad[i],
                                          .t_s = track.time_s[i],
                                          .role = track.joints[j].role};
        track.joints[j].q_rad[i] = effect.definition->joint_map(effect.values(), sample);
      }
    }
  }
  for (const effects::JointSeries& joint : track.joints)
    motion.joints_.emplace_back(track.time_s, joint.q_rad);
  motion.quantisation_step_rad = track.quantisation_step_rad;
  return motion;
}

Vec3 Rig::Motion::to_camera(double t_s, const Vec3& p_W, const double* joint_errors) const {
  if (rig_->type_ != Type::chain) return X_WC(t_s).inverse() * p_W;
  Vec3 p = p_W;
  for (const Link& link : rig_->links_) {
    p = (p - link.fixed.p) * link.fixed.R;  // v * R is R' v.
    if (link.joint < 0) continue;
    const double angle =
        joints_[link.joint].value(t_s) + (joint_errors ? joint_errors[link.joint] : 0);
    const double s = std::sin(angle), c = std::cos(angle);
    // Rodrigues' formula for the rotation by -angle.
    p = c * p - s * glm::cross(link.axis, p) + (1 - c) * glm::dot(link.axis, p) * link.axis;
  }
  return (p - X_LC_.p) * X_LC_.R;
}

Pose Rig::Motion::X_WC(double t_s, const double* joint_errors) const {
  if (rig_->type_ == Type::poses) return rig_->poses_.at(t_s) * X_LC_;
  if (rig_->type_ == Type::unknown) return X_LC_;
  Pose X_WL;
  for (const Link& link : rig_->links_) {
    X_WL = X_WL * link.fixed;
    if (link.joint < 0) continue;
    const double angle =
        joints_[link.joint].value(t_s) + (joint_errors ? joint_errors[link.joint] : 0);
    X_WL = X_WL * rotation(rotation_about(link.axis, angle));
  }
  return X_WL * X_LC_;
}

}  // namespace seam::measurement
