// What a robot measured of beacons at known places on a known path, as a set of landmarks.
#pragma once

#include <limits>
#include <map>
#include <string>
#include <vector>

#include "app/import/draft/set_draft.h"
#include "app/import/tracks/track.h"

namespace seam::app {

struct Beacon {
  std::string name;
  double x_m = 0, y_m = 0, z_m = 0;
};

struct Sighting {
  int64_t ns = 0;
  std::string beacon;
  // Where measured, else not a number.
  double range_m = std::numeric_limits<double>::quiet_NaN();
  double bearing_rad = std::numeric_limits<double>::quiet_NaN();
  std::string place;                     // "file:line".
  std::map<std::string, double> beside;  // Further columns, by their names in the set.
};

struct BeaconLog {
  std::vector<Beacon> beacons;
  bool has_heights = false;  // Of beacons.
  Track path;
  std::vector<Sighting> seen;  // In order of time.

  bool any(double Sighting::*measured) const;
};

void draft_beacons(const BeaconLog& log, SetDraft& draft);

}  // namespace seam::app
