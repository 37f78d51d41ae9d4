// The kinds of measurement: one table, from which readers of sets, the catalogue's pages and
// proposed formulas take what they ask of a kind.
#pragma once

#include <array>
#include <string>
#include <vector>

namespace seam::effects {

enum class Stage {
  timing,
  joint,
  mount,
  geometry,
  radiometry,
  light,
  sensor,
  detector,
  locomotion,
  target,
  corner_detector,  // Where a detector reports the points of an image: measured points alone.
  scenario          // Keys of a scenario: of whole runs alone.
};
std::string to_string(Stage stage);

// Kinds of measurement (docs/reference/measurements.md), a bit each: an effect names its kinds.
enum Kind : unsigned {
  kPoints = 1,
  kPhotometry = 2,
  kJoints = 4,
  kOdometry = 8,
  kLandmarks = 16,
  kRanges = 32,
  kFrames = 64,
  kOutcomes = 128,  // Of whole runs: every effect that the simulator runs acts on them.
};

struct KindFacts {
  Kind bit;
  const char* name;   // As `kind:` of a measurement set.
  const char* group;  // The column whose groups are held out whole, unless a set names another.
  // Stages of the formulas that are proposed where residuals of this kind remain unexplained.
  std::vector<Stage> formula_stages;
};

// Every kind, in the order of its bits.
const std::vector<KindFacts>& kinds();
const KindFacts& kind_facts(Kind bit);
std::vector<std::string> kind_names();

}  // namespace seam::effects
