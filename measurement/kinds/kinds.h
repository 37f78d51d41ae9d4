// The kinds of measurement: how to open a set of each, and how to make one (`seam measure`).
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "measurement/problem/problem.h"
#include "measurement/sets/observations.h"
#include "measurement/sets/set.h"

namespace seam::measurement {

struct MeasureOptions {
  uint64_t seed = 0;
  bool noise = true;  // False: the noise-free prediction.
  std::filesystem::path out;
};

struct Kind {
  std::string name;
  ObservationTable observations;
  // Reads and checks the whole set.
  std::unique_ptr<Problem> (*open)(const MeasurementSet& set) = nullptr;
  // Writes into `options.out` the set that the model would give by this protocol: measured columns
  // are made (those present are ignored), all else is copied. Random numbers: counters named by
  // (seed, kind, row), see sim_core/base/random.h.
  void (*measure)(const Model& truth, const MeasurementSet& protocol,
                  const MeasureOptions& options) = nullptr;
  // Lines of observations of what this model places behind the camera, where that can be said
  // without a fit; null for kinds without known points.
  std::vector<int> (*behind_camera)(const Model& model, const MeasurementSet& set) = nullptr;
};

// Throws InputError for a kind that nobody supplies.
const Kind& find_kind(const std::string& name);
// Kinds that run the simulator (frames, ranges) are supplied by tools/ with this.
void register_kind(Kind kind);

std::unique_ptr<Problem> open_problem(const std::filesystem::path& set);

// Copies every file of the protocol that `measure` does not write itself.
void copy_protocol(const MeasurementSet& protocol, const std::filesystem::path& out,
                   const std::vector<std::string>& except_files);
// One more file of the protocol, by its name in the set.
void copy_into(const std::filesystem::path& out, const MeasurementSet& protocol,
               const std::string& name);
// Where a file of that name is written to: inside `out`, in folders that exist.
std::filesystem::path written_path(const std::filesystem::path& out, const std::string& name);

}  // namespace seam::measurement
