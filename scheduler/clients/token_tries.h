// Who tries tokens that are wrong is slowed down: after some tries a peer waits before the next one
// is looked at, twice as long each time. What is right is not looked at either while a peer waits,
// else guesses in parallel would be free.
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <mutex>
#include <string>

namespace seam::scheduler {

class TokenTries {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr int kFreeTries = 100;
  static constexpr double kFirstDelay_s = 0.1;
  static constexpr double kLongestDelay_s = 60;
  // A peer that tried nothing for so long starts anew.
  static constexpr double kForgotten_s = 600;
  static constexpr size_t kMostPeers = 4096;

  explicit TokenTries(std::function<Clock::time_point()> now = Clock::now) : now_(std::move(now)) {}

  // For how long (seconds) this peer's tries at this name ("supervisor", "robot red1") are not
  // looked at; 0: the next one is.
  double wait_s(const std::string& peer, const std::string& name) const;
  void note_wrong(const std::string& peer, const std::string& name);

 private:
  struct Tries {
    int wrong = 0;
    Clock::time_point last;
    Clock::time_point next;  // Before it none is looked at.
  };
  using Key = std::pair<std::string, std::string>;

  void forget_old(Clock::time_point now);

  std::function<Clock::time_point()> now_;
  mutable std::mutex mutex_;
  std::map<Key, Tries> tries_;
};

// Whose tries count together: gRPC's name of a peer ("ipv4:10.0.0.7:51312") without the port, and
// all users of Unix sockets, who choose their end's name themselves.
std::string peer_of(const std::string& grpc_peer);

// "token: too many wrong ones from this peer, look again in 1.6 s".
std::string wait_text(double wait_s);

}  // namespace seam::scheduler
