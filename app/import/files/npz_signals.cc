// Arrays of numpy as signals: MuJoCo's time, qpos and ctrl as users save them, and episodes.
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "app/import/files/npz.h"
#include "app/import/files/signals.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

constexpr size_t kMostColumns = 1000;

// As many as the times are; where no array is called so, as most arrays have.
size_t rows_of(const std::map<std::string, NpyArray>& arrays) {
  for (const char* name : {"timestamp", "time_s", "time", "t", "times", "timestamps"}) {
    const auto found = arrays.find(name);
    if (found != arrays.end() && found->second.texts.empty() && !found->second.shape.empty())
      return found->second.shape[0];
  }
  std::map<size_t, size_t> arrays_by_rows;
  for (const auto& [name, array] : arrays)
    if (!array.shape.empty() && array.texts.empty()) ++arrays_by_rows[array.shape[0]];
  size_t rows = 0, most = 0;
  for (const auto& [of_rows, count] : arrays_by_rows)
    if (count >= most && of_rows > 1) rows = of_rows, most = count;
  return rows;
}

void add_signals(SignalLog& log, const std::string& name, const NpyArray& array, size_t rows) {
  const size_t columns = array.shape.size() == 2 ? array.shape[1] : 1;
  if (columns > kMostColumns || log.names.size() + columns > kMostColumns)
    throw InputError(fmt::format("{}: more than {} signals", log.file, kMostColumns));
  for (size_t c = 0; c < columns; ++c) {
    std::vector<double> values(rows);
    for (size_t row = 0; row < rows; ++row) values[row] = array.values[row * columns + c];
    const std::string one = columns == 1 ? name : fmt::format("{}[{}]", name, c);
    log.names.push_back(one);
    log.full_names.push_back(one);
    log.values.push_back(std::move(values));
  }
}

}  // namespace

void read_npz_signals(SignalLog& log, const std::string& bytes) {
  const auto arrays = read_npz(bytes, log.file, 2);  // Pictures are left out.
  const size_t rows = rows_of(arrays);
  for (const auto& [name, array] : arrays) {
    if (!array.texts.empty())
      log.lists[name] = array.texts;
    else if (array.values.size() == 1 && rows != 1)
      log.constants[name] = array.values[0];
    else if (rows > 0 && !array.shape.empty() && array.shape[0] == rows && !array.values.empty())
      add_signals(log, name, array, rows);
  }
  if (log.names.empty()) {
    std::vector<std::string> names;
    for (const auto& [name, array] : arrays) names.push_back(name);
    throw InputError(fmt::format(
        "{}: found {}, expected arrays with a row an instant: time, commands "
        "and measured angles",
        log.file,
        names.empty() ? "no arrays of numbers" : fmt::format("{}", fmt::join(names, ", "))));
  }
  for (size_t row = 0; row < rows; ++row)
    log.places.push_back(fmt::format("{}: row {}", log.file, row));
}

}  // namespace seam::app
