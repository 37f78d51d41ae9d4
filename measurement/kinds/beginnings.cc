#include "measurement/kinds/beginnings.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "sim_core/base/error.h"

namespace seam::measurement {
namespace {

// Two thirds of the groups show 4,000 rows, as many as tell of a tenth of the noise
// (fitting/few_groups.h).
constexpr size_t kRowsAtFirst = 6600;
constexpr size_t kManyRows = 15'000;
// Of groups as long on average six are more rows than the beginnings of all.
constexpr size_t kLongGroup = 1250;
constexpr size_t kLeastOfAGroup = 250;

// Root mean square of how much a column changes from row to row of a group; 0 for what is no
// number.
double liveliness(const CsvTable& table, const std::string& group, const std::string& column) {
  std::vector<double> values;
  try {
    values = table.numbers_or_blank(column);
  } catch (const InputError&) {
    return 0;
  }
  std::map<std::string_view, double> last;
  double sum = 0, count = 0;
  for (size_t row = 0; row < values.size(); ++row) {
    if (std::isnan(values[row])) continue;
    const auto [before, first] = last.try_emplace(table.cell(row, group), values[row]);
    if (first) continue;
    const double change = values[row] - std::exchange(before->second, values[row]);
    sum += change * change, ++count;
  }
  return count > 0 ? std::sqrt(sum / count) : 0;
}

// Of each column; that of the group and the time say nothing.
std::vector<double> livelinesses(const CsvTable& table, const std::string& group) {
  std::vector<double> all;
  for (const std::string& name : table.columns())
    all.push_back(name == group || name == "time_s" ? 0 : liveliness(table, group, name));
  return all;
}

// Whether as much goes on in the beginnings as in all rows: who rests at first tells nothing.
bool stand_for(const std::vector<double>& whole, const std::vector<double>& first) {
  constexpr double kAsLively = 0.5;
  return std::equal(first.begin(), first.end(), whole.begin(), whole.end(),
                    [](double at_first, double of_all) { return at_first >= kAsLively * of_all; });
}

// The whole set's scalar of each scalar of its beginnings, which stand in the same lines; nothing
// where the two say different things of themselves.
std::optional<std::vector<size_t>> places_in(const Facts& whole, const Facts& first) {
  const auto same_name = [](const Channel& a, const Channel& b) { return a.name == b.name; };
  if (!std::equal(whole.channels.begin(), whole.channels.end(), first.channels.begin(),
                  first.channels.end(), same_name) ||
      whole.groups != first.groups)
    return std::nullopt;
  std::map<std::pair<int, int>, size_t> places;  // By line and channel.
  const int last_line = *std::max_element(first.line_of_row.begin(), first.line_of_row.end());
  for (size_t i = 0; i < whole.scalars(); ++i) {
    const int line = whole.line_of_row[whole.row_of[i]];
    if (line <= last_line) places[{line, whole.channel_of[i]}] = i;
  }
  std::vector<size_t> scalar;
  for (size_t i = 0; i < first.scalars(); ++i) {
    const auto place = places.find({first.line_of_row[first.row_of[i]], first.channel_of[i]});
    if (place == places.end()) return std::nullopt;
    scalar.push_back(place->second);
  }
  return scalar;
}

}  // namespace

void add_beginnings(const Kind& kind, MeasurementSet set, const Instruments& instruments,
                    Problem& problem) {
  const Facts& facts = problem.facts();
  const size_t groups = facts.groups.size();
  if (!kind.rows_follow_time || facts.rows() < kManyRows || facts.rows() < groups * kLongGroup)
    return;
  const std::string& table = kind.observations.file;
  const CsvTable all = set.table(table);
  const std::vector<double> whole = livelinesses(all, set.group);
  for (size_t each = std::max(kLeastOfAGroup, kRowsAtFirst / groups);; each *= 2) {
    if (2 * each * groups > all.rows()) return;
    set.beginning = {table, each};
    if (stand_for(whole, livelinesses(set.table(table), set.group))) break;
  }
  for (const Channel& channel : facts.channels) set.noise[channel.name] = channel.noise;
  try {
    Problem::Beginnings beginnings{.problem = kind.open(set, instruments)};
    auto scalar = places_in(facts, beginnings.problem->facts());
    if (!scalar) return;
    beginnings.scalar = std::move(*scalar);
    problem.have_beginnings(std::move(beginnings));
  } catch (const InputError&) {
    // What cannot be read of beginnings alone is read of all rows.
  }
}

}  // namespace seam::measurement
