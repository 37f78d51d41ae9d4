#include "measurement/problem/channel_misfit.h"

#include <algorithm>
#include <boost/math/special_functions/gamma.hpp>
#include <cmath>

namespace seam::measurement {

double ChannelMisfit::p_value() const {
  return boost::math::gamma_q(0.5 * count, 0.5 * std::min(chi2, 1200.0));
}

double ChannelMisfit::strength() const {
  return std::sqrt(std::max(0.0, residual2 - sigma2) / count);
}

ChannelMisfit misfit_of_channel(const Facts& facts, const Evaluation& evaluation, size_t channel) {
  ChannelMisfit misfit;
  for (size_t i = 0; i < facts.scalars(); ++i) {
    if (!evaluation.used[i] || facts.channel_of[i] != static_cast<int>(channel)) continue;
    const double residual = evaluation.residual[i], sigma = evaluation.sigma[i];
    const double ratio = residual / sigma;
    ++misfit.count, misfit.sigma2 += sigma * sigma;
    misfit.residual2 += residual * residual, misfit.chi2 += ratio * ratio;
  }
  return misfit;
}

}  // namespace seam::measurement
