// The figures of EMVA 1288 (release 3.1, linear cameras) from the statistics of whole frames, by
// the standard's own formulas, each with the standard error that the samples leave it.
#pragma once

#include <optional>

#include "effects/stages/sensor/sensor.h"
#include "measurement/kinds/photometry/stack/photometry_data.h"

namespace seam::measurement {

// Nothing (no figures) for colour images, and without levels of light and dark frames in pairs.
// Where dark frames are cut off at 0, those alone that rest on lit ones.
FigureTable emva_figures(const PhotometryData& data);

// The largest share of zeros among the values of a level of dark frames; 0 where it is no larger
// than the standard allows.
double darks_cut_off(const PhotometryData& data);

// Of these figures those of means alone: nothing that the noise of single pixels has part in.
FigureTable without_noise(FigureTable figures);
bool has_system_gain(const FigureTable& figures);

// The system gain that the standard would find in these levels if they were as a sensor's model
// says: where the response bends it is not that of the least signals. Nothing without photon noise.
std::optional<double> emva_gain(const PhotometryData& data, const effects::SensorChain& chain);

}  // namespace seam::measurement
