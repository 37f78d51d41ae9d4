// Loops over independent parts on several cores.
#pragma once

#include <cstddef>
#include <functional>

namespace seam::measurement {

// Runs job(0) ... job(count - 1) on the machine's cores that no other loop uses, which may be one
// that this one runs in; results must go to places of their own, so that they do not depend on how
// many threads there are. Rethrows the first exception. In the caller's thread alone where jobs are
// not worth others: to start one takes some 30 us.
void parallel_for(size_t count, const std::function<void(size_t)>& job, bool worth_threads = true);

// The most threads that parallel_for uses in this process, before any of it; 0: one for each core.
// For processes that share the machine's cores.
void use_threads(size_t most);

}  // namespace seam::measurement
