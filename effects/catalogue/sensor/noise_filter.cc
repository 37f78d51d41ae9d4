#include <algorithm>
#include <cmath>

#include "effects/effect.h"
#include "effects/stages/sensor/mixing.h"
#include "effects/stages/sensor/sensor.h"

namespace seam::effects {

namespace {

constexpr double kLeastMixing = -0.15;

Parameter weight(const std::string& name, const std::string& line) {
  return {.name = name,
          .min = kLeastMixing,
          .max = kMostMixing,
          .scale = 0.02,
          .help = "Of each of the two neighbours in a " + line +
                  "; the pixel itself has 1 - 2 times that. Below 0 the filter sharpens.",
          .plausible = {-0.1, 0.19,
                        "neighbours in infrared arrays couple by 0.005 to 0.02, mild filters of "
                        "cameras by up to 0.2; beyond, a stronger filter may be meant"}};
}

// Not 0, at which there is no filter to fit.
double start_of(double correlation) {
  const double most = mixed_correlation(kMostMixing), least = mixed_correlation(kLeastMixing);
  const double start = mixing_of(std::clamp(correlation, least, most));
  return std::abs(start) > 1e-4 ? start : 1e-4;
}

}  // namespace

// A filter of weights (w, 1 - 2 w, w) leaves 1 - 4 w + 6 w^2 of the variance of independent noise
// in each direction: what takes that for photon noise finds a gain that is too small. Infrared
// arrays couple their pixels by 0.005 to 0.02 (Moore, Ninkov, Forrest, Optical Engineering 45,
// 076402, 2006); the filters of cameras go up to the binomial (1, 2, 1) / 4, which nothing undoes.
EffectDefinition noise_filter() {
  return {
      .name = "noise_filter",
      .stage = Stage::sensor,
      .kinds = kPhotometry,
      .parameters = {weight("along_rows", "row"), weight("along_columns", "column")},
      .help =
          "The camera, or its sensor, mixes each pixel with its neighbours: a filter against "
          "noise, or charge that couples. Noise is smaller, and alike in neighbours; all other "
          "effects of the sensor but rounding act before it.",
      .formula =
          "dn mixed by (w, 1 - 2 w, w), w = along_rows in rows, then w = along_columns in columns",
      .signature = "noise of single frames that is alike in neighbouring pixels",
      .example = "noise_filter: {along_rows: 0.1, along_columns: 0.1}",
      .spread_only = true,
      .family = Family::noise,
      .starts = {{kPhotometry, StartSearch::excess}},
      .advice = {{kPhotometry,
                  {},
                  "raw images, without the camera's own processing: there noise of neighbours is "
                  "independent unless the sensor couples them"}},
      .sensor =
          [](Values p, SensorChain& chain) {
            chain.mixing = {p[0], p[1]};
          },
      .start_from_excess =
          [](const SensorExcess& excess) {
            return std::vector<double>{start_of(excess.likeness_in_row),
                                       start_of(excess.likeness_in_column)};
          },
      .proof = {{.values = {0.1, 0},
                 .expected = {{"noise_kept", 0.66},
                              {"next_in_row", 0.242424242424242},
                              {"next_in_column", 0}},
                 .source = "python: 0.8**2 + 2 * 0.1**2, 2 * 0.1 * 0.8 / (0.8**2 + 2 * 0.1**2), 0",
                 .tolerance = 1e-06},
                {.values = {0.2, -0.05},
                 .expected = {{"noise_kept", 0.5346}, {"next_in_column", -0.0905349794238683}},
                 .source = "python: sum((a * b)**2 for a in (0.2, 0.6, 0.2) for b in (-0.05, 1.1, "
                           "-0.05)), 2 * -0.05 * 1.1 / (2 * 0.05**2 + 1.1**2)",
                 .tolerance = 1e-06}},
  };
}

}  // namespace seam::effects
