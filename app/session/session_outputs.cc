#include "app/session/session_outputs.h"

#include <sys/stat.h>

#include "sim_core/base/error.h"

namespace seam::app {

SessionOutputs::SessionOutputs(const SessionOptions& options) {
  if (!options.sign_key.empty()) {
    if (options.log.empty()) throw UsageError("--sign: give --log too, the log to sign");
    key = SigningKey::read_private(options.sign_key);
  }
  if (options.durable && options.log.empty())
    throw UsageError("--durable: give --log too, the log to keep");
  OutputRules rules{.inputs = options.inputs};
  if (!options.log.empty()) {
    OutputRules log_rules = rules;
    log_rules.grows = true;
    log_rules.overwrite = options.force;
    log_rules.durable = options.durable;
    log_rules.mode = S_IRUSR | S_IWUSR;
    log = mcap::create_file(options.log, log_rules);
    rules.inputs.emplace_back(options.log);
  }
  json = OutputFile(options.json, rules);
  rules.mode = S_IRUSR | S_IWUSR;
  tokens = OutputFile(options.token_file, rules);
  if (!options.frames.empty()) frames.emplace(options.frames, options.force);
}

}  // namespace seam::app
