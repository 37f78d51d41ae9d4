// Flat fields as a table of means: a row is a cell of the image in one frame. It has what a flat
// field's likelihood lacks, a residual of each row with a place, a time and a light, in which
// causes without a name are looked for (measurement/infer/unnamed.h).
#pragma once

#include <memory>
#include <vector>

#include "measurement/kinds/photometry/means/image_cells.h"
#include "measurement/kinds/photometry/means/mean_errors.h"
#include "measurement/problem/problem.h"

namespace seam::measurement {

// Images of all frames and their sums.
struct MeanSource {
  const PhotometryData& data;
  std::shared_ptr<const PhotometrySums> sums;
};

class PhotometryMeans : public Problem {
 public:
  // `quick` are the same frames with fewer samples, on which derivatives are found. `of_values`
  // are the facts of the problem whose likelihood counts every value.
  PhotometryMeans(MeanSource whole, MeanSource quick, const Facts& of_values, double set_noise_dn,
                  bool channels_share);

  Evaluation evaluate(const Model& model, const Groups& groups,
                      const Evaluation* warm = nullptr) const override;
  std::vector<std::vector<double>> jacobian(const Model& model,
                                            const std::vector<Unknown>& unknowns,
                                            const Groups& groups,
                                            const Evaluation& here) const override;
  std::vector<std::vector<double>> following(
      const Model& model, const Groups& groups, const Evaluation& here,
      std::vector<std::vector<double>> columns) const override;
  // The scene's light, and what grows with time and with the exposure.
  std::vector<FieldPlace> field_places(const Model& model, const Evaluation& here) const override;
  void check_model(const Model&) const override {}

 private:
  size_t scalar_of(size_t frame, Eigen::Index mean) const {
    return frame * static_cast<size_t>(cells_.count()) + static_cast<size_t>(mean);
  }
  void fill_facts(const Facts& of_values);
  std::vector<double> whitened(const MeanErrors& errors, const std::vector<double>& column) const;

  MeanSource whole_, quick_;
  double set_noise_dn_;
  bool share_;
  ImageCells cells_, quick_cells_;
  std::vector<int> level_of_frame_;
  std::vector<char> blank_;  // By level: its light is fitted.
};

}  // namespace seam::measurement
