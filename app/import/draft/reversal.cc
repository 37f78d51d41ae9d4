#include "app/import/draft/reversal.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim_core/base/error.h"

namespace seam::app {

void Reversal::apply(const std::string& joint, const std::vector<double>& command_rad,
                     std::vector<double>& measured_rad) {
  const auto& names = request_.reversed;
  if (measured_rad.empty() || std::find(names.begin(), names.end(), joint) == names.end()) return;
  std::vector<double> differences;
  for (size_t i = 0; i < measured_rad.size(); ++i) {
    measured_rad[i] = -measured_rad[i];
    differences.push_back(command_rad[i] - measured_rad[i]);
  }
  const auto middle = differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2);
  std::nth_element(differences.begin(), middle, differences.end());
  const double turns = std::round(*middle / (2 * std::numbers::pi));
  if (turns == 0) return;
  turned_ = true;
  for (double& angle : measured_rad) angle += turns * 2 * std::numbers::pi;
}

void Reversal::finish(const std::set<std::string>& joints, SetDraft& draft) const {
  for (const std::string& name : request_.reversed) {
    if (!joints.contains(name))
      throw InputError(fmt::format("--reverse {}: joint '{}' is missing{}; joints here: {}", name,
                                   name, suggestion_for(name, {joints.begin(), joints.end()}),
                                   fmt::join(joints, ", ")));
  }
  if (!request_.reversed.empty())
    draft.did(fmt::format("measured angles of {} with the other sign{}",
                          fmt::join(request_.reversed, ", "),
                          turned_ ? ", and whole turns added" : ""));
}

}  // namespace seam::app
