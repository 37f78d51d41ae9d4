#include "scheduler/replay/verification.h"

#include <fmt/format.h>

#include "scheduler/loop/simulation.h"
#include "scheduler/replay/log_audit.h"
#include "scheduler/replay/player.h"
#include "scheduler/replay/verifier.h"

namespace seam::scheduler {

Verification verify(const Log& log, ReRun match) {
  RunControl control;
  LogSource decisions(log);
  Verifier verifier(log, match.world, control);
  if (match.renderer == nullptr) verifier.ignore_frames();
  Simulation simulation({match.scenario,
                         match.world,
                         decisions,
                         control,
                         match.renderer,
                         {&verifier},
                         std::move(match.header)});
  simulation.run();
  Verification result{.divergence = verifier.divergence(),
                      .steps = verifier.steps(),
                      .frames = verifier.frames(),
                      .until = verifier.verified_until(),
                      .has_end = verifier.has_end(),
                      .not_compared = {}};
  if (result.divergence) return result;
  LogAudit audited = audit(log);
  result.divergence = std::move(audited.finding);
  result.not_compared = std::move(audited.unproved);
  if (match.renderer == nullptr) {
    result.not_compared.emplace_back("frames, pictures and the fingerprint of the whole run");
  }
  for (const std::string& name : verifier.absent()) {
    result.not_compared.push_back(fmt::format("{}: the log has none", name));
  }
  return result;
}

}  // namespace seam::scheduler
