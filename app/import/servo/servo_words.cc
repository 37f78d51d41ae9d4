#include "app/import/servo/servo_words.h"

#include <algorithm>
#include <cmath>

#include "sim_core/base/error.h"

namespace seam::app {
namespace {

using Names = std::vector<std::string>;

void refuse_word(const SignalLog& log, const std::string& name) {
  const auto odd = log.odd.find(name);
  if (odd == log.odd.end()) return;
  throw InputError(fmt::format("{}: {}: found '{}', expected a number or nothing",
                               odd->second.place, name, odd->second.text));
}

std::string without_numbers(const SignalLog& log, const std::string& name) {
  const auto odd = log.odd.find(name);
  const std::string found =
      odd == log.odd.end() ? "" : fmt::format(" ('{}' in {})", odd->second.text, odd->second.place);
  return fmt::format("{}: column {} holds no number{}", log.file, name, found);
}

}  // namespace

void look_for_words(const ImportRequest& request, const SignalLog& log, const std::string& quantity,
                    const Names& usual, SetDraft& draft) {
  const Names names = names_of(request, quantity, usual);
  if (const int at = log.find(names); at >= 0)
    return refuse_word(log, log.names[static_cast<size_t>(at)]);
  const std::string words = log.find_words(names);
  if (words.empty()) return;
  if (!request.name_of(quantity).empty())
    throw InputError(without_numbers(log, words) + fmt::format(" (--map {}=...)", quantity));
  draft.warn(without_numbers(log, words) + ": left out");
}

void look_at_efforts(const ImportRequest& request, const SignalLog& log,
                     std::vector<JointColumns>& joints, SetDraft& draft) {
  bool found = false;
  for (JointColumns& joint : joints) {
    if (!joint.effort) continue;
    found = true;
    const std::string& name = log.names[*joint.effort];
    const std::vector<double>& values = log.values[*joint.effort];
    const auto blank = std::count_if(values.begin(), values.end(),
                                     [](double value) { return !std::isfinite(value); });
    if (static_cast<size_t>(blank) == values.size()) {
      draft.warn(without_numbers(log, name) + ": left out");
      joint.effort.reset();
      continue;
    }
    refuse_word(log, name);
    if (blank > 0)
      draft.did(fmt::format("{}: {} of {} rows have no number in column {}: blank there", log.file,
                            blank, values.size(), name));
  }
  if (found) return;
  Names usual = servo_names().efforts;
  for (const std::string& name : usual) {
    if (log.find({name + "[0]"}) >= 0)
      draft.warn(fmt::format("{}: column {} has not one number for each of {} joints: left out",
                             log.file, name, joints.size()));
  }
  for (const JointColumns& joint : joints) {
    for (const std::string& end : effort_ends()) usual.push_back(joint.joint + end);
  }
  for (const std::string& name : Names(usual)) usual.push_back(name + "[0]");
  look_for_words(request, log, "effort", usual, draft);
}

}  // namespace seam::app
