// Where fits of photometry candidates start: estimates from the residual means and variances.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "measurement/kinds/photometry/likelihood/stack_view.h"
#include "measurement/kinds/photometry/structure/photometry_neighbour_tests.h"

namespace seam::measurement {

double log_likelihood(const PhotometryView& view, const Model& model);
// Whether that needs a look at few cells of light only, in place of all samples.
bool cells_stand_for(const PhotometryView& view, const Model& model);

// Values of the effect's parameters from which fits start, the likeliest first. `whole`: where few
// odd samples are looked for; `noise`: of the images as they are.
std::vector<std::vector<double>> photometry_starts(const PhotometryView& view,
                                                   const PhotometryView& whole, const Model& model,
                                                   const EffectDefinition& effect,
                                                   const NoiseLikeness& noise);
// Gain and black of the straight line through the levels' means (Theil and Sen), whatever unit the
// light is in; nothing where fewer than two levels of light tell it.
std::optional<std::pair<double, double>> straight_response(const PhotometryView& view);

// The strongest wave over the image that stays: amplitude_dn, period_px, angle_rad, phase_rad
// (photometry_wave.cc).
std::vector<double> strongest_wave(const PhotometryView& view,
                                   const PhotometryPrediction& prediction);
// How many waves it can tell apart.
double wave_looks(const PhotometryData& data);

// How many frequencies `flicker_starts` can tell apart.
double flicker_looks(const PhotometryData& data, const Model& model);
// The strongest periodic wave of the residual light: frequencies to start from
// (photometry_flicker.cc).
std::vector<std::vector<double>> flicker_starts(const PhotometryView& view, const Model& model,
                                                const PhotometryPrediction& prediction);

}  // namespace seam::measurement
