// Errors of means of flat fields over cells of the image, frame by frame, and what makes them
// independent: noise of the values, what rows and whole frames have in common, and patterns that
// stay over the frames.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "measurement/kinds/photometry/likelihood/photometry_model.h"
#include "measurement/kinds/photometry/means/image_cells.h"

namespace seam::measurement {

// What a model predicts of the means of one level's frames, by mean.
struct LevelMeans {
  Eigen::VectorXd mean, offset_slope, gain_slope;  // Averages over the cell; DN.
  Eigen::VectorXd values;                          // How many values a mean of one frame has.
  Eigen::VectorXd sigma;                           // Of their noise alone; 0: the mean is left out.
  double dark_s = 0;                               // For which dark currents count.
};

// (1 + loads loads')^-1/2, which leaves each residual in its place.
class RootInverse {
 public:
  RootInverse() = default;
  explicit RootInverse(const Eigen::MatrixXd& loads);
  // The same of blocks of rows, of which each stands so many times.
  RootInverse(std::vector<Eigen::MatrixXd> loads, const std::vector<double>& times);

  // Of the residuals in one block, of which there are many with the same loads: along the loads,
  // and what is to be subtracted, from the sum along all of them.
  Eigen::MatrixXd along(size_t block, const Eigen::MatrixXd& x) const {
    return along_[block].transpose() * x;
  }
  Eigen::MatrixXd taken(size_t block, const Eigen::MatrixXd& along) const {
    return along_[block] * (less_.asDiagonal() * along);
  }
  bool is_identity() const { return less_.size() == 0; }
  Eigen::Index size() const { return less_.size(); }

 private:
  std::vector<Eigen::MatrixXd> along_;
  Eigen::VectorXd less_;
};

class MeanErrors {
 public:
  // `share`: row noise and column offsets are the same in all channels. `blank`: by level, whether
  // its light is fitted.
  MeanErrors(const ImageCells& cells, const effects::SensorChain& chain,
             std::vector<LevelMeans> levels, const std::vector<int>& level_of_frame, bool share,
             const std::vector<char>& blank);

  const std::vector<LevelMeans>& levels() const { return levels_; }
  double sigma(size_t frame, Eigen::Index mean) const {
    return levels_[static_cast<size_t>(level_of_frame_[frame])].sigma[mean];
  }
  // Columns by frame and mean, in DN: their errors have unit variance and are independent.
  Eigen::MatrixXd whitened(const Eigen::MatrixXd& columns) const;

 private:
  Eigen::MatrixXd loads_of_frame(const ImageCells& cells, const LevelMeans& level) const;
  Eigen::MatrixXd loads_of_patterns(const ImageCells& cells, size_t level,
                                    const std::vector<char>& blank) const;

  const effects::SensorChain chain_;
  const bool share_;
  std::vector<LevelMeans> levels_;
  std::vector<int> level_of_frame_;
  std::vector<Eigen::VectorXd> inverse_sigma_;  // By level.
  std::vector<RootInverse> frame_;              // By level.
  RootInverse patterns_;
};

}  // namespace seam::measurement
