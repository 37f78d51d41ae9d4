// Keeps the loop's thread and its only client on one core while turns are short. A client of a
// cheap run answers in some microseconds, less than it takes to wake another core. On which core
// they are is left to the operating system: the loop goes where it is sent, the client follows.
#pragma once

#include <sched.h>
#include <sys/types.h>

#include <chrono>

namespace seam::scheduler {

class SharedCore {
 public:
  // A turn begins, before the client gets it; `client`: its process, if that is on this machine,
  // else 0. Its first thread is taken to be the one that answers. Called by the loop's thread.
  void begin(pid_t client);
  // It has ended after `waited`: the loop's thread may go where it could before.
  void end(std::chrono::nanoseconds waited);

 private:
  bool keep_client(int core);
  void let_client_go();

  pid_t client_ = 0;
  cpu_set_t clients_own_{};  // Where it might be before.
  int clients_core_ = -1;    // Where it is kept; -1: nowhere.
  cpu_set_t loops_own_{};    // The same of the loop's thread, while it is kept.
  bool loop_kept_ = false;
  int short_turns_ = 0;  // One after another.
};

}  // namespace seam::scheduler
