// Whitening of a series of residuals whose errors are a small state, such as an angle and a rate:
// it moves on from row to row by a matrix of its own each time, and between two rows a draw of one
// sigma drives it. What a joint makes of commands that act too early or too late is such an error.
#pragma once

#include <vector>

#include "effects/stages/noise.h"
#include "measurement/problem/problem.h"

namespace seam::measurement {

// From one row to the next: what is left of the state, and what a unit of the draw and of its
// square add.
struct DrivenStep {
  double q_of_q = 1, q_of_w = 0, w_of_q = 0, w_of_w = 1;
  double q_of_draw = 0, w_of_draw = 0;
  double q_of_square = 0, w_of_square = 0;
};

// The first angle of a state that is not known to begin at 0.
struct DrivenStart {
  double q = 0, variance = 0;
};

// Takes residuals with sigmas of their own (whitened by these already, as whiten_diagonal leaves
// them) in order of time, with a step less than rows. Errors that wander may add to the same
// residuals. Whitens those that are used, adds what is missing to their group's log det, and to the
// sigmas of all, which have nothing of the start. The rate begins at 0.
void whiten_driven(const Facts& facts, const std::vector<size_t>& scalars,
                   const std::vector<double>& time_s, const std::vector<DrivenStep>& steps,
                   const DrivenStart& start, double draw_sigma,
                   const std::vector<effects::Wander>& wanders, Evaluation& evaluation);

}  // namespace seam::measurement
