// Where fits of an effect start that changes ranges at some places of the robot or the landmark.
#pragma once

#include <vector>

#include "effects/stages/detector.h"
#include "measurement/kinds/landmarks/landmark_data.h"
#include "measurement/problem/evaluation.h"

namespace seam::measurement {

// Of an effect whose first parameter is a size, and whose others have the values of one of these
// shapes: the shape that takes most of what an evaluation leaves, with the size that it then has;
// none where no shape moves anything. `predicted`: what the model says, by row.
std::vector<std::vector<double>> landmark_shape(const LandmarkData& data,
                                                const std::vector<effects::Detection>& predicted,
                                                const Evaluation& left,
                                                const effects::EffectDefinition& effect,
                                                const std::vector<std::vector<double>>& shapes);

// How many of the shapes move some range or bearing by most of their size: the others lie where
// nothing was seen.
double shapes_that_act(const std::vector<effects::Detection>& predicted,
                       const effects::EffectDefinition& effect,
                       const std::vector<std::vector<double>>& shapes);

}  // namespace seam::measurement
