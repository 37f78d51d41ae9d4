// What a run writes, claimed before anything starts: a path that cannot be written, that another
// run writes or that is read meanwhile is told at once.
#pragma once

#include <memory>
#include <optional>

#include "app/session/frame_files.h"
#include "app/session/run_session.h"
#include "app/trust/log_signature.h"
#include "mcap/io.h"
#include "sim_core/base/output.h"

namespace seam::app {

struct SessionOutputs {
  // Throws InputError and UsageError.
  explicit SessionOutputs(const SessionOptions& options);

  std::unique_ptr<mcap::Output> log;  // None: not asked for.
  std::optional<SigningKey> key;      // Signs the log when it is whole.
  std::optional<FrameFiles> frames;
  OutputFile json;
  OutputFile tokens;  // Readable by this user alone.
};

}  // namespace seam::app
