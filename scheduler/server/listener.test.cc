// A listener that lives, whoever connects.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scheduler/server/live_testing.h"
#include "scheduler/server/silent_connections.h"

namespace seam::scheduler {
namespace {

using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using namespace seam::scheduler::testing;  // NOLINT: helpers of this folder's tests.

// Leaves this process so many descriptors that it may open.
class FewDescriptors {
 public:
  explicit FewDescriptors(int count) {
    getrlimit(RLIMIT_NOFILE, &before_);
    rlimit few = before_;
    const int next = dup(0);  // The lowest that is free.
    close(next);
    few.rlim_cur = static_cast<rlim_t>(next + count);
    setrlimit(RLIMIT_NOFILE, &few);
  }
  ~FewDescriptors() { setrlimit(RLIMIT_NOFILE, &before_); }

 private:
  rlimit before_{};
};

// As if somebody had ended them; how many there were.
int shut_down_listeners_of(const std::string& address) {
  const int port = std::stoi(address.substr(address.rfind(':') + 1));
  int count = 0;
  for (int fd = 3; fd < 4096; ++fd) {
    int listens = 0;
    socklen_t size = sizeof listens;
    sockaddr_in name{};
    socklen_t name_size = sizeof name;
    if (getsockopt(fd, SOL_SOCKET, SO_ACCEPTCONN, &listens, &size) != 0 || listens == 0) continue;
    getsockname(fd, reinterpret_cast<sockaddr*>(&name), &name_size);
    if (name.sin_family == AF_INET && ntohs(name.sin_port) == port)
      count += shutdown(fd, SHUT_RDWR) == 0;
  }
  return count;
}

class Listening : public ::testing::Test {
 protected:
  void serve(const std::string& address, std::optional<ConnectionLimits> limits = {}) {
    server_.emplace(
        ServerOptions{.addresses = {address}, .supervisor_token = "boss", .limits = limits},
        scenario_, world_, hub_, control_);
  }
  const std::string& address() const { return server_->addresses()[0]; }
  // Why a robot is not welcome; empty where it is.
  std::string robot_comes() const {
    RawClient client(address());
    client.hello("r0", "token-r0");
    v1::ServerMessage message;
    if (client.read(message)) return message.has_welcome() ? "" : "no welcome";
    return client.finish().error_message() + " ";
  }
  std::string robot_comes_in_time() const {
    std::string why;
    for (int tries = 0; tries < 50 && !(why = robot_comes()).empty(); ++tries)
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    return why;
  }
  // What the log holds of connections, within a second.
  std::string logged() {
    std::string text;
    for (int tries = 0; tries < 20; ++tries) {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      for (const SimulationEvent& fault : hub_.take_faults())
        if (fault.name == "connections") text += fault.detail + "\n";
    }
    return text;
  }

  Scenario scenario_ = Scenario::from_text(scenario_text(SEAM_SOURCE_DIR, 1, 0.3), "test.yaml");
  World world_{scenario_};
  RunControl control_;
  ClientHub hub_{LiveRun::hub_robots(scenario_), control_};
  std::optional<Server> server_;
};

// More than the descriptors that a program usually has, on a plain loopback address: a robot still
// gets in, and who says nothing is hung up on.
TEST_F(Listening, SilentConnectionsDoNotEndIt) {
  const UsualDescriptorLimit limit;
  if (!limit.can_be_raised_to(4096)) GTEST_SKIP() << "the system allows no more descriptors";
  serve("127.0.0.1:0");
  const SilentConnections silent(address(), 1100);
  ASSERT_EQ(silent.count(), 1100u);
  EXPECT_EQ(robot_comes(), "");
  EXPECT_TRUE(silent.hung_up_within(20));
}

TEST_F(Listening, OnePeerDoesNotTakeTheConnectionsOfAll) {
  serve("127.0.0.1:0", ConnectionLimits{.in_all = 20, .by_peer = 8});
  const SilentConnections silent(address(), 30, "127.0.0.2");
  EXPECT_THAT(silent.last_words(5), HasSubstr("8 connections of 127.0.0.2 stand"));
  EXPECT_EQ(robot_comes(), "");
  const SilentConnections more(address(), 8, "127.0.0.3"), most(address(), 8, "127.0.0.4");
  EXPECT_THAT(most.last_words(5), HasSubstr("20 connections stand"));
  EXPECT_THAT(robot_comes(), HasSubstr("GOAWAY"));
  EXPECT_THAT(logged(), ContainsRegex("refused [0-9]+ connections: 20 connections stand"));
}

TEST_F(Listening, WithoutDescriptorsItRefusesAndGoesOn) {
  serve("127.0.0.1:0");
  SilentConnections silent(60);
  {
    const FewDescriptors few(4);
    silent.open_all(address());
    EXPECT_THAT(silent.last_words(5), HasSubstr("no descriptors left"));
  }
  EXPECT_EQ(robot_comes(), "");
}

TEST_F(Listening, ADeadListenerIsOpenedAgain) {
  serve("127.0.0.1:0");
  EXPECT_EQ(robot_comes(), "");
  ASSERT_EQ(shut_down_listeners_of(address()), 1);
  EXPECT_EQ(robot_comes_in_time(), "");
  EXPECT_THAT(logged(), HasSubstr("the listener was dead, another was opened"));
}

TEST_F(Listening, AUnixSocketWhoseNameWasTakenAwayIsOpenedAgain) {
  const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) / "listening";
  std::filesystem::create_directories(folder);
  const std::filesystem::path name = folder / "socket";
  serve("unix:" + name.string());
  std::filesystem::remove(name);
  EXPECT_EQ(robot_comes_in_time(), "");
  server_.reset();
  EXPECT_FALSE(std::filesystem::exists(name));
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace seam::scheduler
