// What the effects of errors that wander have in common: their two parameters, and where a search
// for them begins.
#pragma once

#include <string>
#include <vector>

#include "effects/stages/noise.h"

namespace seam::effects {

inline std::vector<Parameter> wander_parameters(const std::string& sigma, const std::string& unit,
                                                double most, double usual) {
  return {{.name = sigma,
           .min = 0,
           .max = most,
           .scale = usual,
           .help = "Standard deviation of the error that wanders, " + unit + "."},
          {.name = "tau_s",
           .min = 0,
           .max = 10000,
           .scale = 1,
           .help = "Its memory, seconds: after so long a third is left of it."}};
}

// Sizes around the usual one with short, middling and long memories.
inline std::vector<StartRule> wander_starts(Kind kind, double usual) {
  std::vector<std::vector<double>> places;
  for (const double sigma : {usual / 10, usual, usual * 10})
    for (const double tau_s : {0.3, 2.0, 15.0}) places.push_back({sigma, tau_s});
  return {{kind, StartSearch::best_listed, std::move(places)}};
}

}  // namespace seam::effects
