#include "app/session/session_outputs.h"

#include <sys/stat.h>

namespace seam::app {

SessionOutputs::SessionOutputs(const SessionOptions& options) {
  OutputRules rules{.inputs = options.inputs};
  if (!options.log.empty()) {
    OutputRules log_rules = rules;
    log_rules.grows = true;
    log_rules.overwrite = options.force;
    log = mcap::create_file(options.log, log_rules);
    rules.inputs.emplace_back(options.log);
  }
  json = OutputFile(options.json, rules);
  rules.mode = S_IRUSR | S_IWUSR;
  tokens = OutputFile(options.token_file, rules);
  if (!options.frames.empty()) frames.emplace(options.frames, options.force);
}

}  // namespace seam::app
