#include "scheduler/listen/connection_count.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

namespace seam::scheduler {
namespace {

using ::testing::HasSubstr;

class Pair {
 public:
  Pair() { EXPECT_EQ(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends_), 0); }
  ~Pair() { hang_up(); }
  int end() const { return ends_[0]; }
  void hang_up() {
    for (int& end : ends_)
      if (end >= 0) close(std::exchange(end, -1));
  }

 private:
  int ends_[2];
};

class Counting : public ::testing::Test {
 protected:
  ConnectionCount::Clock::time_point now_{std::chrono::hours(1)};
  ConnectionCount count_{{.in_all = 5, .by_peer = 3}, [this] { return now_; }};
  Pair pairs_[8];
};

TEST_F(Counting, OnePeerLeavesRoomForOthers) {
  for (int i = 0; i < 3; ++i) EXPECT_EQ(count_.refusal("a", pairs_[i].end()), "");
  EXPECT_THAT(count_.refusal("a", pairs_[3].end()), HasSubstr("3 connections of a stand"));
  EXPECT_EQ(count_.refusal("b", pairs_[3].end()), "");
  EXPECT_EQ(count_.refusal("b", pairs_[4].end()), "");
  EXPECT_THAT(count_.refusal("c", pairs_[5].end()), HasSubstr("5 connections stand"));
  EXPECT_EQ(count_.standing(), 5u);
}

TEST_F(Counting, WhoHungUpMakesRoomAlsoWhereTheDescriptorIsUsedAgain) {
  for (int i = 0; i < 3; ++i) EXPECT_EQ(count_.refusal("a", pairs_[i].end()), "");
  EXPECT_NE(count_.refusal("a", pairs_[3].end()), "");
  const int freed = pairs_[0].end();
  pairs_[0].hang_up();
  const Pair another;  // The lowest free numbers: those of the first.
  ASSERT_EQ(another.end(), freed);
  // It was looked a moment ago; a flood of connections does not make it look each time.
  EXPECT_NE(count_.refusal("a", pairs_[3].end()), "");
  now_ += std::chrono::milliseconds(100);
  EXPECT_EQ(count_.refusal("a", pairs_[3].end()), "");
  EXPECT_EQ(count_.standing(), 3u);
}

TEST(Counted, LimitsFollowTheDescriptors) {
  rlimit before{};
  getrlimit(RLIMIT_NOFILE, &before);
  rlimit few = before;
  few.rlim_cur = 100;
  setrlimit(RLIMIT_NOFILE, &few);
  EXPECT_EQ(connection_limits().in_all, 50u);
  EXPECT_EQ(connection_limits().by_peer, 25u);
  setrlimit(RLIMIT_NOFILE, &before);
}

TEST(Counted, PeersOfUnixSocketsAreUsers) {
  const Pair pair;
  EXPECT_EQ(peer_of_socket(pair.end()), "user " + std::to_string(getuid()));
}

}  // namespace
}  // namespace seam::scheduler
