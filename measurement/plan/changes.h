// What may be changed of a measurement that was not made yet: more of it, faster, wider.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "measurement/sets/set.h"

namespace seam::measurement {

struct ProtocolChange {
  std::string what;    // "twice as many frames".
  double cost = 1;     // How long it takes, as a multiple of the protocol.
  double repeats = 1;  // As many sets like the protocol.
  double faster = 1;   // The motion takes this part of its time less.
  double wider = 1;    // Commands differ by so much more from their mean.
};

// Whether its own measurements alone say where the camera was (a board's views with unknown poses):
// such a set stands for itself, since no other one can be made by its protocol.
bool needs_its_measurements(const MeasurementSet& protocol);

// Those that make sense for the protocol's kind and rig.
std::vector<ProtocolChange> changes_of(const MeasurementSet& protocol);

// Writes the changed protocol into an empty folder.
void write_changed(const MeasurementSet& protocol, const ProtocolChange& change,
                   const std::filesystem::path& folder);

}  // namespace seam::measurement
