// Which runs this user made on this machine: `seam replay resume` starts the programs of such a
// run's log without asking. A digest of each run that started programs stands in a file of the
// user's own (docs/replay.md), and of each sweep, whose results `seam sweep rerun` takes; logs hold
// nothing of it, so that they stay the same bytes everywhere and nobody can claim in a log where it
// was made.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/simulator.h"

namespace seam::app {

class RunsMadeHere {
 public:
  // $XDG_STATE_HOME/seam/runs, or ~/.local/state/seam/runs; nothing is known where there is no
  // home.
  RunsMadeHere();
  explicit RunsMadeHere(std::filesystem::path file) : file_(std::move(file)) {}

  // Whether a run of the same scenario, seed included, started the same programs from the same
  // working folder. What cannot be read is not known.
  bool holds(const Simulator& simulator) const;
  // Does nothing for a run without programs, or where it cannot be noted: its log will be asked
  // about.
  void note(const Simulator& simulator) const;

  // The same of anything that is known by these texts in this order, in the present working folder;
  // none: nothing that could be held.
  bool holds(const std::vector<std::string>& texts) const;
  void note(const std::vector<std::string>& texts) const;

 private:
  std::filesystem::path file_;  // Empty: none.
};

}  // namespace seam::app
