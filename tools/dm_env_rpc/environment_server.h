// `seam serve --dm-env-rpc`: learning programs drive a scenario's robots by dm_env_rpc.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "scheduler/listen/tls_texts.h"
#include "tools/dm_env_rpc/worlds.h"

namespace seam::tools::dm {

struct ServeOptions {
  std::vector<std::string> addresses;
  std::optional<scheduler::TlsTexts> tls;
  bool until_eof = false;  // Ends when standard input ends.
};

// Serves until Ctrl-C. Throws InputError and UsageError.
void serve_environment(WorldKind kind, const ServeOptions& options);

}  // namespace seam::tools::dm
