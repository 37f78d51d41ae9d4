// What never changes of a measurement set: its rows, channels, groups and covariates.
//
// Vocabulary: a *row* is one line of the observation file; a *scalar* is one residual (a row of
// points has two, u and v).
#pragma once

#include <string>
#include <vector>

#include "effects/questions.h"
#include "measurement/sets/left_out.h"

namespace seam::measurement {

// One flag a group: whether it takes part.
using Groups = std::vector<char>;

struct Channel {
  std::string name;        // The residual's name with its unit: u_px.
  double noise = 1;        // One sigma of a single observation, in that unit.
  bool estimated = false;  // The set left its noise unknown.
  // And what the best model leaves may tell it better (search/models/noise_size.cc).
  bool correctable = false;
};

struct Covariate {
  enum class Type {
    smooth,    // A quantity.
    sign,      // -1, 0, 1.
    cyclic,    // An angle in radians.
    category,  // A label, numbered from 0: structure is a mean for each.
  };
  std::string name;  // As docs/reference/definitions.md, "What remains", has it.
  Type type = Type::smooth;
  std::vector<double> values;  // One a row; NaN where unknown.
  bool in_products = true;     // Whether `a*b` with the other covariates is looked at.
  // Made from the very values whose residuals are looked at: a function of it may follow their
  // errors, so that causes without a name do not depend on it.
  bool of_measured = false;
};

// A residual made of two channels of a row, such as that along the radius; its weights are of unit
// length, so that it has the noise of its parts.
struct CombinedChannel {
  std::string name;
  int channel_a = 0, channel_b = 1;
  std::vector<double> weight_a, weight_b;  // By row.
};

// A figure by which a field's standard describes what was measured, with its standard error.
struct Figure {
  std::string name, unit;
  double value = 0, sigma = 0;
};
struct FigurePoint {
  double light = 0;  // Photons, where the set counts them.
  double signal_dn = 0, snr = 0, sigma = 0, expected = 0;
};
struct FigureTable {
  std::string title;
  std::vector<Figure> figures;     // Empty: the kind or the set has none.
  std::vector<FigurePoint> curve;  // Signal over noise, measured and as the figures have it.
};

// What never changes: filled by the kind when it reads the set.
struct Facts {
  effects::SetFacts set;  // What it says of itself to the effects: its kind, what it lacks.
  std::string title;
  std::string fingerprint;
  std::string file;                 // Of the observations, for messages.
  int width_px = 0, height_px = 0;  // Of the image that points are seen in; 0: none.
  std::vector<int> line_of_row;
  std::vector<Channel> channels;
  std::vector<std::string> groups;  // Their names.
  std::vector<int> group_of_row;
  std::vector<double> time_of_row;  // Seconds since the set's reference; orders neighbours.
  // Neighbours for outliers and correlation: rows of one series (a landmark's track in a run, a
  // joint log's run), numbered; empty: the group is the series.
  std::vector<int> series_of_row;
  bool tests_neighbours = true;  // Whether the structure tests look for correlation in a series.
  // By row: 1 where it has the reading of a row beside it, rounded to steps that are coarser than
  // the noise. The two share one error, that of the rounding, and count once in structure tests.
  // Empty: every row has an error of its own.
  std::vector<char> shares_error;
  std::vector<int> row_of;      // By scalar.
  std::vector<int> channel_of;  // By scalar.
  double values_of_scalar = 1;  // Measured values of which a scalar is the mean.
  std::vector<Covariate> covariates;
  std::vector<std::string> notes;     // What of the set takes no part, and why: sentences.
  std::vector<LeftOutRows> left_out;  // By choice.
  FigureTable figures;
  std::vector<CombinedChannel> combined;  // Looked at by the structure tests beside the channels.

  std::string kind() const { return effects::kind_facts(set.kind).name; }
  size_t scalars() const { return row_of.size(); }
  size_t rows() const { return line_of_row.size(); }
  int group_of(size_t scalar) const { return group_of_row[row_of[scalar]]; }
};

}  // namespace seam::measurement
