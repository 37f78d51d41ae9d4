// The kinds of measurement: how to open a set of each, and how to make one (`seam measure`). What
// else is asked of a kind by its name stands in effects/kind.h.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "measurement/imaging/instruments.h"
#include "measurement/problem/problem.h"
#include "measurement/sets/observations.h"
#include "measurement/sets/set.h"

namespace seam::measurement {

struct MeasureOptions {
  uint64_t seed = 0;
  bool noise = true;  // False: the noise-free prediction.
  std::filesystem::path out;
  std::vector<std::string>* warnings = nullptr;  // Of what the set does not show.
};

struct Kind {
  effects::Kind bit{};
  ObservationTable observations;
  // The rows of a group follow each other in time (column time_s), and no row's prediction needs
  // those after it.
  bool rows_follow_time = false;
  // Reads and checks the whole set.
  std::unique_ptr<Problem> (*open)(const MeasurementSet& set,
                                   const Instruments& instruments) = nullptr;
  // Writes into `options.out` the set that the model would give by this protocol: measured columns
  // are made (those present are ignored), all else is copied. Random numbers: counters named by
  // (seed, kind, row), see sim_core/base/random.h.
  void (*measure)(const Model& truth, const MeasurementSet& protocol, const MeasureOptions& options,
                  const Instruments& instruments) = nullptr;
  // Lines of observations of what this model places behind the camera, where that can be said
  // without a fit; null for kinds without known points.
  std::vector<int> (*behind_camera)(const Model& model, const MeasurementSet& set) = nullptr;
};

// Throws InputError for a name that is none.
const Kind& find_kind(const std::string& name);

// Kinds that run the simulator need the instruments; others do without.
// `target`: a file of where the points of the target are (MeasurementSet::target), empty: none.
std::unique_ptr<Problem> open_problem(const std::filesystem::path& set,
                                      const Instruments& instruments = {},
                                      const std::filesystem::path& target = {});
std::unique_ptr<Problem> open_problem(MeasurementSet set, const Instruments& instruments = {});

// The set in a folder with the rows left out that a file names (measurement/sets/left_out.h); an
// empty name leaves none out.
MeasurementSet open_set(const std::filesystem::path& folder, const std::filesystem::path& left_out);

// Writes the set that the model would give by this protocol, whatever its kind.
void measure_set(const Model& truth, const MeasurementSet& protocol, const MeasureOptions& options,
                 const Instruments& instruments = {});

// By row: whether a protocol leaves this cell of a measured column blank on purpose, since nothing
// was measured there. A table that has all the columns and no value in any is wholly to be made.
std::vector<char> left_blank(const CsvTable& table, const std::string& column,
                             const std::vector<std::string>& measured);

// Copies every file of the protocol that `measure` does not write itself.
void copy_protocol(const MeasurementSet& protocol, const std::filesystem::path& out,
                   const std::vector<std::string>& except_files);
// One more file of the protocol, by its name in the set.
void copy_into(const std::filesystem::path& out, const MeasurementSet& protocol,
               const std::string& name);
// Where a file of that name is written to: inside `out`, in folders that exist.
std::filesystem::path written_path(const std::filesystem::path& out, const std::string& name);

}  // namespace seam::measurement
