// Errors of single landmarks: which are clear, in words, and where one without a name may act.
#pragma once

#include <string>
#include <vector>

#include "measurement/kinds/landmarks/landmark_noise.h"

namespace seam::measurement {

// Of displacements and delays, as far as the model's noise has them.
std::vector<Finding> found_of(const std::vector<std::string>& landmarks,
                              const effects::Noise& noise,
                              const std::vector<Displacement>& displacements);

// A clock or a transmitter of each landmark's own: functions of time in each channel.
FieldPlace over_time_by_landmark(const LandmarkData& data, const Facts& facts,
                                 const Evaluation& here);

}  // namespace seam::measurement
