#include "measurement/check/doubts.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "measurement/check/faults.h"
#include "measurement/fitting/assess.h"
#include "measurement/kinds/kinds.h"
#include "sim_core/base/error.h"

namespace seam::measurement {
namespace {

// Effects of cameras and robots leave errors of some tens of noise units; above this the data's
// units and columns are looked at, too.
constexpr double kSuspiciousError = 20;
// Above this no effect of the catalogue explains it.
constexpr double kAbsurdError = 1000;
// Columns exchanged must do so much better.
constexpr double kExchangedGain = 3;
constexpr double kManyBehind = 0.01;  // Of all points.

struct Unit {
  const char* suffix;
  double largest;  // What a robot's surroundings hold.
  const char* instead;
};
constexpr Unit kUnits[] = {{"_rad", 20, "degrees"}, {"_m", 1000, "millimetres"}};

void doubt_units(const MeasurementSet& set, std::vector<std::string>& lines) {
  for (const auto& [name, file] : set.files) {
    if (!file.ends_with(".csv")) continue;
    const CsvTable table = set.table(name);
    for (const std::string& column : table.extra_numeric_columns({})) {
      for (const Unit& unit : kUnits) {
        if (!column.ends_with(unit.suffix)) continue;
        const std::vector<double> values = table.numbers(column);
        const auto largest = std::max_element(values.begin(), values.end(), [](double a, double b) {
          return std::abs(a) < std::abs(b);
        });
        if (std::abs(*largest) <= unit.largest) continue;
        const auto row = static_cast<size_t>(largest - values.begin());
        lines.push_back(fmt::format("{}:{}: column {} reaches {:g}: {}?", table.file(),
                                    table.line(row), column, *largest, unit.instead));
      }
    }
  }
}

void doubt_columns(const MeasurementSet& set, const Kind& kind, const Model& model, double error,
                   std::vector<std::string>& lines) {
  if (!kind.observations.in_image) return;
  const std::string &u = kind.observations.measured[0], &v = kind.observations.measured[1];
  MeasurementSet exchanged = set;
  exchanged.exchanged = {u, v};
  double other = std::numeric_limits<double>::infinity();
  try {
    const auto problem = kind.open(exchanged, {});
    problem->check_model(model);
    problem->prepare(model);
    const Assessment assessment = assess(*problem, model, refitted_unknowns(model));
    if (assessment.valid) other = assessment.error;
  } catch (const InputError&) {
    return;  // What cannot be read in that way was not meant so.
  }
  if (!(kExchangedGain * other < error) && std::isfinite(error)) return;
  if (!std::isfinite(other)) return;
  const std::string instead = std::isfinite(error) ? fmt::format(" instead of {:.4g}", error) : "";
  lines.push_back(
      fmt::format("{} and {} exchanged? With {} read as {} the error is {:.4g}{} noise units", u, v,
                  v, u, other, instead));
}

void doubt_axes(const MeasurementSet& set, const Kind& kind, const Model& model,
                std::vector<std::string>& lines) {
  if (!kind.behind_camera) return;
  const std::vector<int> behind = kind.behind_camera(model, set);
  const CsvTable table = set.table(kind.observations.file);
  if (static_cast<double>(behind.size()) > kManyBehind * static_cast<double>(table.rows()))
    lines.push_back(behind_the_camera(set, kind, behind));
}

}  // namespace

std::string behind_the_camera(const MeasurementSet& set, const Kind& kind,
                              const std::vector<int>& lines) {
  const CsvTable table = set.table(kind.observations.file);
  return fmt::format(
      "{}:{}: the point stands behind the camera, one of {} among {} rows: axes of the points or "
      "of the rig?",
      table.file(), lines.front(), lines.size(), table.rows());
}

std::vector<std::string> doubts(const MeasurementSet& set, const Model& model, double error) {
  const Kind& kind = find_kind(set.kind);
  std::vector<std::string> lines;
  for (const std::string& warning : concerns_of(set, kind.observations).warnings)
    lines.push_back("warning: " + warning);
  for (const auto& faults : {faults_of_values(set), faults_of_clocks(set)}) {
    for (const std::string& fault : faults) {
      const bool asks = fault.find('?') != std::string::npos;
      lines.push_back((asks ? std::string(kQuestion) : "warning: ") + fault);
    }
  }
  std::vector<std::string> evidence;
  doubt_axes(set, kind, model, evidence);  // Where nothing can be predicted, no error is told.
  if (!std::isfinite(error) || error > kSuspiciousError) {
    doubt_columns(set, kind, model, error, evidence);
    doubt_units(set, evidence);
  }
  const bool is_absurd = !std::isfinite(error) || error > kAbsurdError;
  if (is_absurd || !evidence.empty())
    lines.push_back(!std::isfinite(error)
                        ? "units? axes? The model predicts no number for some rows"
                        : fmt::format("units? axes? The error is {:.4g} noise units{}", error,
                                      evidence.empty() ? ", more than effects explain" : ""));
  for (const std::string& line : evidence) lines.push_back("  " + line);
  return lines;
}

}  // namespace seam::measurement
