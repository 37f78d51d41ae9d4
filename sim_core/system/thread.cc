#include "sim_core/system/thread.h"

#include <pthread.h>
#include <signal.h>

#include <system_error>

#include "sim_core/base/error.h"

namespace seam {

std::jthread start_thread(std::function<void()> work) {
  sigset_t all, before;
  sigfillset(&all);
  // A new thread takes over the mask of the one that starts it.
  pthread_sigmask(SIG_SETMASK, &all, &before);
  std::jthread thread;
  std::string refused;
  try {
    thread = std::jthread(std::move(work));
  } catch (const std::system_error& error) {
    refused = error.code().message();
  }
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  if (!refused.empty()) throw InputError(fmt::format("cannot start a thread: {}", refused));
  return thread;
}

}  // namespace seam
