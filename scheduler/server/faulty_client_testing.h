// Clients in tests that fail in each of the ways that faults.test.cc tries.
#pragma once

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <limits>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "scheduler/server/live_testing.h"
#include "sim_core/base/random.h"

namespace seam::scheduler::testing {

// The ways to fail. Each is one client's behaviour until the run is over.
enum class Fault {
  killed,
  silent,
  slow,
  reconnecting,
  garbage,
  duplicates,
  stale,
  nan,
  huge,
  half_open,
  shuffled,
  stalled
};
inline constexpr int kFaults = 12;

// Clients that are stalled one by one, each as its turn comes while the others wait already, and
// then released together, in random order.
class Stall {
 public:
  Stall(int clients, uint64_t seed) : clients_(clients), stream_{seed, 99} {}

  // When the client of this place among the stalled ones is to call `hold`.
  static uint64_t sequence_of(int place) { return 20 + 5 * static_cast<uint64_t>(place); }

  // Returns when all are here (or after 2 s: the run ended for one of them) and it is this one's
  // turn.
  void hold() {
    std::unique_lock lock(mutex_);
    const auto ticket = random_bits(stream_, static_cast<uint64_t>(held_++))[0];
    tickets_.insert(ticket);
    changed_.notify_all();
    const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds(2);
    changed_.wait_until(lock, limit,
                        [&] { return held_ >= clients_ && *tickets_.begin() == ticket; });
    std::this_thread::sleep_for(std::chrono::microseconds(ticket % 5000));
    tickets_.erase(ticket);
    ++released_;
    changed_.notify_all();
  }
  int released() const { return released_; }

 private:
  const int clients_;
  const RandomStream stream_;
  std::mutex mutex_;
  std::condition_variable changed_;
  int held_ = 0;
  std::set<uint64_t> tickets_;  // Of those that are held; the lowest goes first.
  std::atomic<int> released_ = 0;
};

class FaultyClient {
 public:
  // `place` is its place among the clients that `stall` holds.
  FaultyClient(const LiveRun& run, int robot, Fault fault, uint64_t seed, Stall& stall,
               int place = 0)
      : address_(run.address),
        id_(run.scenario.robots[static_cast<size_t>(robot)].id),
        robot_(robot),
        fault_(fault),
        stream_{seed, static_cast<uint64_t>(robot)},
        stall_(stall),
        place_(place) {}

  void operator()() {
    const uint64_t strikes_at =
        fault_ == Fault::stalled ? Stall::sequence_of(place_) : 3 + draw() % 200;
    while (!over_) {
      RawClient client(address_);
      if (!client.hello(id_, "token-" + id_)) return;
      v1::ServerMessage message;
      bool again = false;
      while (!again && client.read(message)) {
        if (message.has_goodbye()) over_ = true;
        if (message.has_observation()) again = !answer(client, message.observation(), strikes_at);
      }
      // Only who leaves by itself cancels: the status that the server gave would be lost.
      if (again) client.cancel();
      if (client.finish().error_code() == grpc::StatusCode::FAILED_PRECONDITION) return;  // Over.
      if (fault_ == Fault::killed && struck_) return;
    }
  }

 private:
  uint64_t draw() { return random_bits(stream_, draws_++)[0]; }
  void sleep_ms(uint64_t ms) { std::this_thread::sleep_for(std::chrono::milliseconds(ms)); }

  // False: leave this connection.
  bool answer(RawClient& client, const v1::Observation& seen, uint64_t strikes_at) {
    v1::Decision decision = busy(robot_, seen);
    const bool once = fault_ == Fault::silent || fault_ == Fault::stalled;
    // A client that was frozen meanwhile may not get the very number.
    const bool strike =
        once ? !struck_ && seen.sequence() >= strikes_at
             : seen.sequence() == strikes_at || (seen.sequence() > strikes_at && draw() % 40 == 0);
    if (strike) {
      struck_ = true;
      switch (fault_) {
        case Fault::killed:
          return false;
        case Fault::silent:
          sleep_ms(400);
          break;  // Longer than the limit: frozen, then back.
        case Fault::slow:
          sleep_ms(draw() % 30);
          break;
        case Fault::reconnecting:
          return false;
        case Fault::garbage:
          send_garbage();
          break;
        case Fault::duplicates:
          client.decide(decision);
          break;
        case Fault::stale:
          client.decide(seen.sequence() - draw() % 3);
          break;
        case Fault::nan:
          decision.mutable_walk()->set_vx_m_s(std::numeric_limits<double>::quiet_NaN());
          break;
        case Fault::huge:
          decision.add_messages(std::string(WireLimits::kMaxReceivedBytes, 'x'));
          break;
        case Fault::half_open:
          open_and_forget();
          break;
        case Fault::shuffled:
          std::this_thread::sleep_for(std::chrono::microseconds(draw() % 2000));
          break;
        case Fault::stalled:
          stall_.hold();
          break;
      }
    }
    return client.decide(decision);
  }

  int open_socket() const {
    const int fd = socket(AF_UNIX, SOCK_STREAM, 0);
    sockaddr_un address{.sun_family = AF_UNIX};
    address_.substr(5).copy(address.sun_path, sizeof address.sun_path - 1);
    EXPECT_EQ(connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    return fd;
  }
  void send_garbage() {
    const int fd = open_socket();
    std::string bytes;
    if (draw() % 2 == 0) bytes = "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n";  // Good so far.
    for (int i = 0; i < 300; ++i) bytes += static_cast<char>(draw());
    send(fd, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    close(fd);
  }
  void open_and_forget() { sockets_.push_back(open_socket()); }

  std::string address_, id_;
  int robot_;
  Fault fault_;
  RandomStream stream_;
  Stall& stall_;
  int place_;
  uint64_t draws_ = 0;
  bool struck_ = false;
  bool over_ = false;
  struct Sockets : std::vector<int> {
    ~Sockets() {
      for (const int fd : *this) close(fd);
    }
  } sockets_;
};

}  // namespace seam::scheduler::testing
