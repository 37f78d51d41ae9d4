#include "scheduler/clients/token_tries.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace seam::scheduler {
namespace {

TokenTries::Clock::duration seconds(double s) {
  return std::chrono::duration_cast<TokenTries::Clock::duration>(std::chrono::duration<double>(s));
}

}  // namespace

double TokenTries::wait_s(const std::string& peer, const std::string& name) const {
  const std::lock_guard lock(mutex_);
  const auto found = tries_.find({peer, name});
  if (found == tries_.end()) return 0;
  return std::max(0.0, std::chrono::duration<double>(found->second.next - now_()).count());
}

void TokenTries::note_wrong(const std::string& peer, const std::string& name) {
  const std::lock_guard lock(mutex_);
  const Clock::time_point now = now_();
  forget_old(now);
  Tries& tries = tries_[{peer, name}];
  ++tries.wrong;
  tries.last = tries.next = now;
  if (tries.wrong <= kFreeTries) return;
  const int doublings = std::min(tries.wrong - kFreeTries - 1, 30);
  tries.next += seconds(std::min(std::ldexp(kFirstDelay_s, doublings), kLongestDelay_s));
}

void TokenTries::forget_old(Clock::time_point now) {
  std::erase_if(tries_,
                [&](const auto& entry) { return now - entry.second.last > seconds(kForgotten_s); });
  if (tries_.size() < kMostPeers) return;
  tries_.erase(std::min_element(tries_.begin(), tries_.end(), [](const auto& a, const auto& b) {
    return a.second.last < b.second.last;
  }));
}

std::string peer_of(const std::string& grpc_peer) {
  if (grpc_peer.starts_with("unix")) return "unix";
  return grpc_peer.substr(0, grpc_peer.rfind(':'));
}

std::string wait_text(double wait_s) {
  return fmt::format("token: too many wrong ones from this peer, try again in {:.1f} s", wait_s);
}

}  // namespace seam::scheduler
