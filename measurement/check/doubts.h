// Doubts about a set when a model fails far beyond what effects explain: units, axes, columns
// exchanged, each with what speaks for it. Analysis commands print them before their results.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "effects/model.h"
#include "measurement/kinds/kinds.h"
#include "measurement/sets/set.h"

namespace seam::measurement {

// What a doubt begins with that asks what the columns mean.
inline constexpr std::string_view kQuestion = "question: ";

// What to say of observations whose points stand behind the camera, by their lines.
std::string behind_the_camera(const MeasurementSet& set, const Kind& kind,
                              const std::vector<int>& lines);

// `error` is the model's on held-out groups, in noise units; not finite where it could not be had.
// Lines for people, empty where nothing is odd.
std::vector<std::string> doubts(const MeasurementSet& set, const effects::Model& model,
                                double error);

}  // namespace seam::measurement
