#include "sim_core/world/radio.h"

#include <algorithm>
#include <tuple>

#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"

namespace seam {
namespace {

// A sender whose channel is busy for longer than this drops what it is given.
constexpr SimDuration kLongestQueue = SimDuration::from_ns(1'000'000'000);

}  // namespace

Radio::Radio(const RadioSpec& spec, std::vector<std::string> ids, std::vector<Team> teams,
             RandomStream stream)
    : spec_(&spec),
      ids_(std::move(ids)),
      teams_(std::move(teams)),
      stream_(stream),
      senders_(ids_.size()) {}

std::vector<std::pair<size_t, RadioFate>> Radio::send(size_t from, const std::string& payload,
                                                      SimTime time,
                                                      const std::vector<Pose2>& places) {
  Sender& sender = senders_.at(from);
  const int64_t sequence = sender.sequence++;
  const SimTime begin = std::max(time, sender.free_at);
  const bool full = begin - time > kLongestQueue;
  if (!full)
    sender.free_at =
        begin + SimDuration::from_s(static_cast<double>(payload.size()) / spec_->bytes_per_s);
  std::vector<std::pair<size_t, RadioFate>> fates;
  for (size_t to = 0; to < ids_.size(); ++to) {
    if (to == from || teams_[to] != teams_[from]) continue;
    const double distance =
        maths::length(places[to].x_m - places[from].x_m, places[to].y_m - places[from].y_m);
    const RandomStream link =
        stream_.child(static_cast<uint64_t>(from)).child(static_cast<uint64_t>(to));
    RadioFate fate = RadioFate::on_its_way;
    if (full) {
      fate = RadioFate::queue_full;
    } else if (distance > spec_->range_m) {
      fate = RadioFate::out_of_range;
    } else if (uniform(link, static_cast<uint64_t>(sequence)) < spec_->loss) {
      fate = RadioFate::lost;
    }
    fates.emplace_back(to, fate);
    if (fate != RadioFate::on_its_way) continue;
    const InFlight message{sender.free_at + spec_->latency,
                           static_cast<int64_t>(from),
                           static_cast<int64_t>(to),
                           sequence,
                           time,
                           payload};
    const auto before = [](const InFlight& a, const InFlight& b) {
      return std::tie(a.arrives, a.from, a.sequence, a.to) <
             std::tie(b.arrives, b.from, b.sequence, b.to);
    };
    messages_.insert(std::upper_bound(messages_.begin(), messages_.end(), message, before),
                     message);
  }
  return fates;
}

std::vector<RadioMessage> Radio::received(size_t to, SimTime time, SimTime since) const {
  std::vector<RadioMessage> messages;
  for (const InFlight& m : messages_) {
    if (m.to != static_cast<int64_t>(to) || m.arrives > time || m.arrives <= since) continue;
    messages.push_back({ids_[static_cast<size_t>(m.from)], m.sent, m.arrives, m.payload});
  }
  return messages;
}

void Radio::forget_before(SimTime time) {
  std::erase_if(messages_, [&](const InFlight& m) { return m.arrives < time; });
}

void Radio::InFlight::visit(StateVisitor& visitor) {
  visitor.field("arrives", arrives);
  visitor.field("from", from);
  visitor.field("to", to);
  visitor.field("sequence", sequence);
  visitor.field("sent", sent);
  visitor.text("payload", payload);
}

void Radio::Sender::visit(StateVisitor& visitor) {
  visitor.field("free_at", free_at);
  visitor.field("sequence", sequence);
}

void Radio::visit(StateVisitor& visitor) {
  for (Sender& sender : senders_) sender.visit(visitor);
  visitor.list("messages", messages_);
  for (const InFlight& m : messages_) {
    const auto known = [&](int64_t robot) {
      return robot >= 0 && robot < static_cast<int64_t>(ids_.size());
    };
    if (!known(m.from) || !known(m.to))
      throw InputError("snapshot: a radio message of an unknown robot");
  }
}

}  // namespace seam
