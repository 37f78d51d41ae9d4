// Kind `imu` beside a camera: a row is the camera's turn from one view to the next one, held
// against what the gyroscope makes of the same time. Two turns that meet in a view share the error
// of its attitude.
#pragma once

#include "measurement/kinds/imu/camera_turns.h"
#include "measurement/kinds/kinds.h"

namespace seam::measurement {

class ImuCameraProblem : public Problem {
 public:
  explicit ImuCameraProblem(const MeasurementSet& set);

  Evaluation evaluate(const Model& model, const Groups& groups,
                      const Evaluation* warm = nullptr) const override;
  std::vector<std::vector<double>> following(
      const Model& model, const Groups& groups, const Evaluation& here,
      std::vector<std::vector<double>> columns) const override;
  void check_model(const Model& model) const override;
  std::string not_testable(const Model& model, const EffectDefinition& effect,
                           size_t parameter) const override;
  std::vector<std::vector<double>> starts(const Model& model,
                                          const EffectDefinition& effect) const override;
  bool is_smooth(const Model&) const override { return true; }
  std::vector<Finding> findings(const Model& model) const override;

 private:
  static constexpr size_t kAxes = 3;

  void add_facts(const MeasurementSet& set);
  Vec3 predicted(const GyroPath& path, const effects::Inertial& inertial, const Mat3& to_camera,
                 const CameraTurn& turn) const;
  // What stands in the scalars, as errors of attitudes that are shared have it: independent and of
  // unit variance. `evaluation` says what is used, and gets the determinants where it is asked to.
  std::vector<double> whitened(const std::vector<double>& by_scalar, const Groups& groups,
                               std::vector<double>* log_det) const;
  Eigen::Matrix3d covariance(const CameraTurn& turn) const;
  bool takes_part(size_t row) const;
  std::vector<double> best_offset(const Model& model) const;
  std::vector<double> best_turn(const Model& model) const;

  CameraData data_;
};

}  // namespace seam::measurement
