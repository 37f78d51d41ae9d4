#include "scheduler/clients/shared_core.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

namespace seam::scheduler {
namespace {

using std::chrono_literals::operator""us;

cpu_set_t allowed(pid_t thread) {
  cpu_set_t set;
  CPU_ZERO(&set);
  EXPECT_EQ(sched_getaffinity(thread, sizeof set, &set), 0);
  return set;
}

bool same(const cpu_set_t& a, const cpu_set_t& b) {
  return CPU_EQUAL(&a, &b);
}

// A process that waits to be ended.
class Sleeper {
 public:
  Sleeper() : process_(fork()) {
    while (process_ == 0) pause();
  }
  ~Sleeper() {
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
  }
  pid_t process() const { return process_; }

 private:
  pid_t process_;
};

TEST(SharedCore, TheClientFollowsTheLoopWhileTurnsAreShort) {
  const Sleeper client;
  const cpu_set_t before = allowed(0);
  SharedCore core;
  for (int turn = 0; turn < 10; ++turn) {
    EXPECT_TRUE(same(allowed(0), before)) << "the loop is free between turns";
    core.begin(client.process());
    core.end(10us);
  }
  core.begin(client.process());
  const cpu_set_t one = allowed(client.process());
  EXPECT_EQ(CPU_COUNT(&one), 1);
  EXPECT_TRUE(same(allowed(0), one));
  core.end(2000us);
  EXPECT_TRUE(same(allowed(client.process()), before)) << "a client that computes is free";
  EXPECT_TRUE(same(allowed(0), before));
}

TEST(SharedCore, LeavesAloneWhoMayNotBeWhereTheLoopIs) {
  const cpu_set_t before = allowed(0);
  if (CPU_COUNT(&before) < 2) GTEST_SKIP() << "one core";
  const Sleeper client;
  int first = 0;
  while (!CPU_ISSET(first, &before)) ++first;
  cpu_set_t one, others = before;
  CPU_ZERO(&one);
  CPU_SET(first, &one);
  CPU_CLR(first, &others);
  ASSERT_EQ(sched_setaffinity(client.process(), sizeof others, &others), 0);
  ASSERT_EQ(sched_setaffinity(0, sizeof one, &one), 0);
  SharedCore core;
  for (int turn = 0; turn < 20; ++turn) {
    core.begin(client.process());
    core.end(10us);
  }
  EXPECT_TRUE(same(allowed(client.process()), others));
  EXPECT_TRUE(same(allowed(0), one));
  ASSERT_EQ(sched_setaffinity(0, sizeof before, &before), 0);
}

TEST(SharedCore, AClientElsewhereIsNobodyHere) {
  const cpu_set_t before = allowed(0);
  SharedCore core;
  for (int turn = 0; turn < 20; ++turn) {
    core.begin(0);
    EXPECT_TRUE(same(allowed(0), before));
    core.end(10us);
  }
}

}  // namespace
}  // namespace seam::scheduler
