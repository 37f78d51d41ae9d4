// Likelihood of a photometry set's sums under a model.
//
// Values are Gaussian around the prediction with this covariance S: independent noise of each
// value; row noise, shared by a row of a frame; and fixed patterns as random effects that persist
// over all frames: a gain and an offset for each sample, an offset for each column. S is never
// built: the parts are nested (samples in columns) or orthogonal (changes in time, means over
// time), and Woodbury's identity gives r' S^-1 r and log det S from sums over samples. Where
// variances differ along a row the split is an approximation whose error is of the order of that
// difference over the number of columns.
#pragma once

#include <vector>

#include "measurement/kinds/photometry/likelihood/photometry_model.h"
#include "measurement/kinds/photometry/likelihood/photometry_rows.h"

namespace seam::measurement {

// Values that are certain (a field clipped whole) say nothing of the error where they fit, which
// `fits` asks of the square of a residual.
class CertainValues {
 public:
  CertainValues(const PhotometryData& data, const effects::SensorChain& chain);
  bool is_certain(double mean, double variance) const;
  bool fits(double mean, double square) const;

 private:
  const effects::SensorChain& chain_;
  int file_bits_;
  double least_at_top_dn2_, least_at_bottom_dn2_;
};

struct PhotometryScore {
  double chi2 = 0;
  double log_likelihood = 0;
  int64_t values = 0;
  int nuisances = 0;
  double square = 0;             // Sum of squared plain residuals.
  std::vector<double> by_frame;  // Log-likelihood; what frames share is divided equally.
};

// Gives a score its chi-square and its log-likelihood. False where there is none: a response that
// `falls` within the light of the set, and what comes out beyond zero where variances differ wildly
// along rows, as at clipping, so that rows and columns are no longer told apart exactly.
bool set_likelihood(const Quadratic& total, bool falls, const PhotometrySums& sums,
                    PhotometryScore& score);

// `channels_share`: row noise and column offsets are the same in all channels.
PhotometryScore score_photometry(const PhotometryData& data, const PhotometrySums& sums,
                                 const PhotometryPrediction& prediction, bool channels_share);

}  // namespace seam::measurement
