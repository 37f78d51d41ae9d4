// What a fit would be without one part of the data after another, told from the fit to all of it:
// one step of Gauss and Newton from there, for noises one of Newton. So each group of a few can be
// held out in turn for the price of one Jacobian.
#pragma once

#include <vector>

#include "measurement/problem/problem.h"

namespace seam::measurement {

// What is held out at once.
struct HeldPart {
  Groups groups;             // Predicted to score it.
  int block = -1;            // The block that is scored; -1: all of these groups.
  std::vector<char> unseen;  // By scalar: what the fit may not see, it and a gap around it.
};

// Each group in turn; of one group alone each block in turn, with a gap of the model's memory.
std::vector<HeldPart> held_parts(const Problem& problem, const Model& model);

// The longest time over which the model's state remembers, by its parameters in seconds.
double memory_s(const Model& model);

// The score of each part under what a fit without it finds; empty where the kind has no residual
// vectors.
std::vector<Score> scores_held_out(const Problem& problem, const Fit& whole,
                                   const std::vector<Unknown>& unknowns);

}  // namespace seam::measurement
