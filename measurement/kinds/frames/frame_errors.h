// Errors of whole images beyond the noise of single samples: what rows and columns share, and what
// two right renderers differ by.
#pragma once

#include <vector>

#include "effects/stages/sensor/sensor.h"

namespace seam::measurement {

// Renderers place an edge to about a hundredth of a pixel: 5 x 5 rays a pixel and some tens of
// instants. Each sample, each frame and the whole set may be displaced by so much.
inline constexpr double kRendererShiftPx = 0.01;

// Derivatives of an image by its displacement in pixels, right and down, in the image's unit.
struct ImageSlope {
  std::vector<float> right, down;
};
// From the values at the pixels' borders, as cell averages give them: a sharp edge inside a pixel
// moves that pixel alone, by its whole contrast, and a ramp moves by its slope.
ImageSlope image_slope(const std::vector<float>& image, int width_px, int height_px);

// By sample: the largest squared slope among its neighbours and itself.
std::vector<float> steepest_nearby(const ImageSlope& slope, int width_px, int height_px);

// Whitens the samples of some frames, which stand one after another. A sample that is left out has
// value 0 and stays so in effect.
class FrameErrors {
 public:
  // `slopes` by frame, in DN; `used` and `sigma` by sample.
  FrameErrors(int width_px, int height_px, const effects::SensorChain& chain,
              std::vector<ImageSlope> slopes, std::vector<char> used,
              const std::vector<double>& sigma);

  // `values` by sample, already over their own sigma.
  void whiten(std::vector<double>& values) const;
  // Logarithm of the determinant that the k-th frame adds.
  double log_det(size_t k) const { return log_det_[k]; }

 private:
  struct Displacement {
    std::vector<float> direction;  // Over sigma.
    double size2 = 0;
    double stretch = 1;
  };
  void share(std::vector<double>& values, size_t frame, double ratio, bool rows) const;
  double ratio_of(double sigma_dn, size_t k) const { return sigma_dn * sigma_dn / sigma2_[k]; }

  size_t width_, height_, samples_;
  double row_sigma_dn_, column_sigma_dn_;
  std::vector<char> used_;
  std::vector<double> sigma2_;                  // Mean variance of a sample, by frame.
  std::vector<Displacement> displacements_[2];  // By axis and frame, orthogonal in each frame.
  double common_size2_[2] = {0, 0};
  std::vector<double> log_det_;
};

}  // namespace seam::measurement
