// Kind `imu`: gyroscope and accelerometer at rest, or turned at known rates.
//
// Rows are of two sorts. A mean is what a stretch reads on an axis: the true rate or force as the
// sensors' means have it. A power is that of a band of lines (noise_lines.h): its cube root is
// nearly normal (Wilson and Hilferty 1931), with an error that does not depend on the model. So
// effects of noise move the mean of powers, and all effects are fitted and compared alike.
#pragma once

#include <map>

#include "effects/stages/inertial/inertial.h"
#include "measurement/kinds/imu/noise_lines.h"
#include "measurement/kinds/imu/run_means.h"
#include "measurement/kinds/kinds.h"
#include "measurement/problem/curves.h"

namespace seam::measurement {

// Powers closer than this are not separated, however many lines they are the mean of: 1 % of the
// amplitude. Filters and resonances of real sensors make ripples of this size.
inline constexpr double kPowerAccuracy = 0.02;

class ImuProblem : public Problem, public HasCurves {
 public:
  explicit ImuProblem(const MeasurementSet& set);

  Evaluation evaluate(const Model& model, const Groups& groups,
                      const Evaluation* warm = nullptr) const override;
  // All errors are independent, and no nuisance follows.
  std::vector<std::vector<double>> following(
      const Model&, const Groups&, const Evaluation&,
      std::vector<std::vector<double>> columns) const override {
    return columns;
  }
  void check_model(const Model& model) const override;
  std::string not_testable(const Model& model, const EffectDefinition& effect,
                           size_t parameter) const override;
  std::vector<std::vector<double>> starts(const Model& model,
                                          const EffectDefinition& effect) const override;
  std::vector<std::vector<double>> starts_on(const Groups& groups, const Model& model,
                                             const EffectDefinition& effect,
                                             const EffectList& companions) const override;
  double looks(const Model& model, const EffectDefinition& effect) const override;
  std::vector<Structure> structure(const Model& model, const Groups& groups,
                                   int fitted) const override;
  bool is_smooth(const Model&) const override { return true; }
  std::vector<char> find_outliers(const Model&) const override {
    return std::vector<char>(facts_.scalars(), 0);
  }
  std::string no_outliers_because() const override {
    return "noise is seen in powers of many samples, in which a single one does not show";
  }
  std::vector<Curve> curves(const Model& model) const override;

 private:
  struct Row {
    enum class What { mean, per_k, gravity, power, clock, jitter } what = What::mean;
    size_t stretch = 0, axis = 0, part = 0;
    double observed = 0, sigma = 0;
    double freedom = 0;          // Of a power and of a variance of stamps,
    double scale = 1;            // what that is held against,
    size_t first = 0, last = 0;  // and its lines.
  };
  void add_rows(const MeasurementSet& set);
  void add_means(size_t stretch, size_t part, const std::string& group);
  void add_stamps(size_t stretch, const std::vector<std::string>& groups);
  void add_power(const NoiseBand& band, size_t axis, const std::string& group);
  void add_row(Row row, const std::string& channel, const std::string& group);
  void add_covariates();
  bool many_runs() const { return facts_.groups.size() >= kFewGroups; }
  // run_means.cc
  struct ChannelOfRuns {
    size_t axis = 0;
    double rows = 0, squares = 0;
    std::map<std::string, RunMean> runs;
  };
  bool compares_runs(const Row& row) const;
  std::map<int, ChannelOfRuns> means_of_runs(const Evaluation& here) const;
  std::vector<Structure> runs_that_differ(const Model& model, const Evaluation& here) const;
  void compare_forces(const Groups& groups, Evaluation& evaluation) const;
  bool sees_attitudes() const;
  bool turns() const;
  bool warmth_changes() const;
  bool stamps_scatter() const;
  std::string lacking(const effects::Inertial& by) const;
  size_t longest_stretch() const;
  std::vector<double> without_warmth(size_t axis, const effects::Inertial& inertial) const;
  size_t axis_of_line(const EffectDefinition& effect) const;
  std::vector<std::vector<double>> line_starts(const Model& model, const EffectDefinition& effect,
                                               const Groups& groups) const;
  double predicted(const Row& row, const effects::Inertial& inertial) const;
  double power_ratio(const Row& row, const effects::Inertial& inertial) const;
  double reading_of(const Row& row, const effects::Inertial& inertial, double warmer_k) const;
  double force_size(const Row& row, const effects::Inertial& inertial) const;
  const effects::InertialSensor& sensor(const effects::Inertial& inertial, size_t axis) const {
    return axis < 3 ? inertial.gyro : inertial.accel;
  }

  ImuData data_;
  std::array<AxisNoise, kImuAxes> noise_;
  std::array<double, kImuAxes> stated_{};  // White noise of a sample beside the model's.
  bool attitudes_ = false;
  std::vector<Row> rows_;
};

void measure_imu(const Model& truth, const MeasurementSet& protocol, const MeasureOptions& options);

}  // namespace seam::measurement
