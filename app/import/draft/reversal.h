// Joints whose measured angles count the other way than their commands (--reverse).
#pragma once

#include <set>
#include <string>
#include <vector>

#include "app/import/draft/request.h"
#include "app/import/draft/set_draft.h"

namespace seam::app {

class Reversal {
 public:
  explicit Reversal(const ImportRequest& request) : request_(request) {}

  // Gives a run's measured angles the other sign if the joint is named. An encoder that counts down
  // from a whole turn is then a turn away: whole turns are added, so that angles lie about
  // commands.
  void apply(const std::string& joint, const std::vector<double>& command_rad,
             std::vector<double>& measured_rad);
  // Says what was done; throws InputError for a name that no joint has.
  void finish(const std::set<std::string>& joints, SetDraft& draft) const;

 private:
  const ImportRequest& request_;
  bool turned_ = false;
};

}  // namespace seam::app
