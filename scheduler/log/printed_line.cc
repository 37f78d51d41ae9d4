#include "scheduler/log/printed_line.h"

#include <fmt/format.h>

#include <algorithm>

#include "foxglove/log.pb.h"
#include "sim_core/base/error.h"

namespace seam::scheduler {

std::string encode(const PrintedLine& line) {
  constexpr int64_t kSecond_ns = 1'000'000'000;
  foxglove::Log log;
  // Printed lines have times from 0 on.
  log.mutable_timestamp()->set_seconds(line.time.ns() / kSecond_ns);
  log.mutable_timestamp()->set_nanos(static_cast<int32_t>(line.time.ns() % kSecond_ns));
  log.set_level(foxglove::Log::INFO);
  log.set_message(line.text);
  log.set_name(line.robot);
  return log.SerializeAsString();
}

PrintedCursor::PrintedCursor(const Log& log) : messages_(log) {
  for (const auto& [id, channel] : log.file().contents().channels)
    if (channel.topic == kPrinted.topic) channels_.insert(id);
}

std::optional<PrintedLine> PrintedCursor::next() {
  if (channels_.empty()) return std::nullopt;
  while (const std::optional<mcap::Message> message = messages_.next()) {
    if (!channels_.contains(message->channel_id)) continue;
    foxglove::Log log;
    if (!log.ParseFromArray(message->data.data(), static_cast<int>(message->data.size())))
      throw InputError(fmt::format("{}: {} bytes that are no {}", kPrinted.topic,
                                   message->data.size(), kPrinted.schema));
    const uint64_t time_ns = std::min<uint64_t>(message->log_time_ns, INT64_MAX);
    return PrintedLine{SimTime::from_ns(static_cast<int64_t>(time_ns)), log.name(), log.message()};
  }
  return std::nullopt;
}

}  // namespace seam::scheduler
