#include "scheduler/clients/shared_core.h"

#include <utility>

namespace seam::scheduler {
namespace {

// A client that takes longer computes rather than waits, and may do so in threads of its own, which
// inherit where it may run: it is not kept.
constexpr std::chrono::milliseconds kShort{1};
constexpr int kShortTurns = 4;

constexpr pid_t kSelf = 0;

bool set_core(pid_t thread, int core) {
  cpu_set_t one;
  CPU_ZERO(&one);
  CPU_SET(core, &one);
  return sched_setaffinity(thread, sizeof one, &one) == 0;
}

}  // namespace

bool SharedCore::keep_client(int core) {
  if (clients_core_ == core) return true;
  if (clients_core_ < 0 && sched_getaffinity(client_, sizeof clients_own_, &clients_own_) != 0)
    return false;
  if (!CPU_ISSET(core, &clients_own_) || !set_core(client_, core)) return false;
  clients_core_ = core;
  return true;
}

void SharedCore::let_client_go() {
  if (std::exchange(clients_core_, -1) >= 0)
    sched_setaffinity(client_, sizeof clients_own_, &clients_own_);
  short_turns_ = 0;
}

void SharedCore::begin(pid_t client) {
  if (client != client_) let_client_go();
  client_ = client;
  if (client_ <= 0 || short_turns_ < kShortTurns) return;
  const int core = sched_getcpu();
  if (core < 0 || sched_getaffinity(kSelf, sizeof loops_own_, &loops_own_) != 0) return;
  loop_kept_ = keep_client(core) && set_core(kSelf, core);
}

void SharedCore::end(std::chrono::nanoseconds waited) {
  if (std::exchange(loop_kept_, false)) sched_setaffinity(kSelf, sizeof loops_own_, &loops_own_);
  if (waited < kShort)
    ++short_turns_;
  else
    let_client_go();
}

}  // namespace seam::scheduler
