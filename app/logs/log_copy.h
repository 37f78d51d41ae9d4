// A copy of a log in which turns are changed: what was learnt of a run after the fact.
#pragma once

#include <functional>

#include "mcap/io.h"
#include "scheduler/log/log.h"

namespace seam::app {

// Every message, chunk and attachment as it was, but for the turns that `change` says it changed,
// and the end's hash over the inputs, which is made anew. Throws InputError at damage.
void copy_log(const scheduler::Log& log, mcap::Output& output,
              const std::function<bool(scheduler::TurnRecord&)>& change);

}  // namespace seam::app
