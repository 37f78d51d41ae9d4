// Tests of the residual means of a photometry set against smooth functions of place and light.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "measurement/kinds/photometry/likelihood/stack_view.h"
#include "measurement/kinds/photometry/structure/photometry_chi2.h"

namespace seam::measurement {

// A place in the reduced data: a sample of a level.
struct SamplePlace {
  size_t level;
  int u, v, channel;
  double x, y, radius;  // -1 to 1, -1 to 1, 0 to 1.
};
SamplePlace place_of(const PhotometryData& data, size_t level, int u, int v, int channel);

// Writes functions of a place, and of the light there, to `out`, which comes as zeros.
using PlaceBasis = std::function<void(const SamplePlace&, double gain, Eigen::VectorXd& out)>;

// Samples that stand out, with a hot offset or a weak gain: they are no part of the mean's
// structure. Empty where the model has neither.
std::vector<char> outstanding_samples(const PhotometryView& view,
                                      const PhotometryPrediction& prediction);

// A step over which the prediction's derivative by a parameter is taken.
double small_step(const effects::Parameter& parameter, double value);

// Directions that the model's refitted parameters explain are taken out of each test.
class MeanTests {
 public:
  MeanTests(const PhotometryView& view, const Model& model);

  const PhotometryPrediction& prediction() const { return prediction_; }
  // `count`: of the basis' functions.
  StructureTest run(const std::string& covariate, int count, const PlaceBasis& basis) const;

 private:
  double residual(size_t l, size_t i) const {
    return view_.sums.levels[l].mean[i] - prediction_.levels[l].mean[i];
  }

  void add_direction(const Model& model, const std::string& effect, size_t index, double value,
                     const effects::Parameter& parameter);
  StructureTest reduce(const std::string& covariate, int count, const Eigen::VectorXd& statistic,
                       const Eigen::MatrixXd& covariance, const Eigen::MatrixXd& gram,
                       double weights) const;

  const PhotometryView& view_;
  const PhotometryData& data_;
  PhotometryPrediction prediction_;
  std::vector<std::vector<std::vector<double>>> directions_;  // By parameter, level, sample.
  std::vector<char> outstanding_;
};

}  // namespace seam::measurement
