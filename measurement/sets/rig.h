// Where the camera is: a chain of joints with an encoder log, measured poses, or unknown.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "effects/model.h"
#include "effects/stages/joint_track.h"
#include "measurement/sets/rig_keys.h"
#include "measurement/sets/set.h"
#include "measurement/sets/spline.h"
#include "sim_core/base/pose.h"

namespace seam::measurement {

// Poses measured at times, interpolated smoothly (positions and quaternions by splines).
class PoseTrack {
 public:
  PoseTrack() = default;
  PoseTrack(const std::vector<double>& times, const std::vector<Vec3>& positions,
            const std::vector<std::array<double, 4>>& quaternions);
  Pose at(double t_s) const;

 private:
  Spline position_[3];
  Spline quaternion_[4];  // w, x, y, z with continuous signs; normalised after interpolation.
};

class Rig {
 public:
  enum class Type { chain, poses, unknown };
  // How unknown poses follow each other.
  enum class Path { still, constant_velocity, spline, beside_gyroscope };

  // Reads `rig:` and the logs it needs. Throws InputError.
  static Rig from_set(const MeasurementSet& set);

  // The camera's poses from a table of its own, to make a set whose reader will not know them.
  static Rig from_poses(const std::filesystem::path& table);

  Type type() const { return type_; }
  Path path() const { return path_; }
  double knot_s() const { return knot_s_; }  // Of a spline; 0: not stated.
  // First time of the reference log; all times below are seconds since it. Unknown poses have no
  // log: the caller sets the first stamp.
  int64_t reference_ns() const { return reference_ns_; }
  void set_reference_ns(int64_t reference) { reference_ns_ = reference; }
  double first_s() const { return first_s_; }
  double last_s() const { return last_s_; }

  const std::vector<std::string>& joint_names() const { return joint_names_; }
  // Logged angle and rate, before any effect.
  const Spline& logged(size_t joint) const { return logged_[joint]; }
  const std::vector<double>& log_times() const { return track_.time_s; }
  // Period of the head's motion (of the joint that moves most), 0 where it does not repeat.
  double cycle_s() const { return cycle_s_; }

  // The camera's motion under a model's encoder and mount effects.
  class Motion {
   public:
    // `joint_errors` are added to the true angles, one a joint; empty: none.
    Pose X_WC(double t_s, const double* joint_errors = nullptr) const;
    // A point of the world in the camera's frame: the same as X_WC(t).inverse() * p_W, but link by
    // link, which is several times faster (fits spend most of their time here).
    Vec3 to_camera(double t_s, const Vec3& p_W, const double* joint_errors = nullptr) const;
    double quantisation_step_rad = 0;

   private:
    friend class Rig;
    const Rig* rig_ = nullptr;
    std::vector<Spline> joints_;
    Pose X_LC_;
  };
  Motion motion(const effects::Model& model) const;

 private:
  struct Link {
    Pose fixed;      // Before the joint.
    int joint = -1;  // Index of the joint, -1 for a fixed link.
    Vec3 axis{0.0};
  };

  void read_chain(const RigKeys& keys, const MeasurementSet& set);
  void read_poses(const CsvTable& table);
  void find_cycle();
  effects::JointTrack finer_track() const;

  Type type_ = Type::unknown;
  Path path_ = Path::still;
  double knot_s_ = 0;
  int64_t reference_ns_ = 0;
  double first_s_ = 0, last_s_ = 0;
  std::vector<Link> links_;
  std::vector<std::string> joint_names_;
  std::vector<Spline> logged_;
  effects::JointTrack track_;       // As logged.
  effects::JointTrack fine_track_;  // The same, interpolated: for effects with memory.
  PoseTrack poses_;
  double cycle_s_ = 0;
};

// Times of a log in seconds since its first; throws where they do not increase. Rows that repeat
// the time before are dropped from `keep`.
std::vector<double> log_seconds(const CsvTable& table, const std::string& column,
                                int64_t reference_ns, const std::vector<size_t>& rows,
                                std::vector<size_t>& keep);

}  // namespace seam::measurement
