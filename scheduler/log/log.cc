#include "scheduler/log/log.h"

#include <fmt/format.h>

#include <algorithm>

#include "scheduler/log/foxglove.h"
#include "sim_core/base/error.h"

namespace seam::scheduler {
uint64_t log_time(SimTime time) {
  return static_cast<uint64_t>(std::max<int64_t>(0, time.ns()));
}

std::string picture_topic(const std::string& robot) {
  return std::string(kPictures.topic) + robot;
}

SimTime time_of(const LogRecord& record) {
  return std::visit(
      [](const auto& value) -> SimTime {
        if constexpr (requires { value.time; }) return value.time;
        return SimTime();
      },
      record);
}

Log Log::open(const std::filesystem::path& path, LogAccess access) {
  return open(mcap::open_file(path), access);
}

Log Log::open(std::unique_ptr<mcap::Input> input, LogAccess access) {
  return Log(access == LogAccess::indexed ? mcap::Reader::open(std::move(input))
                                          : mcap::Reader::scan(std::move(input)));
}

Log::Log(mcap::Reader reader) : reader_(std::make_unique<mcap::Reader>(std::move(reader))) {
  for (const auto& [id, channel] : reader_->contents().channels) {
    if (channel.message_encoding != "protobuf") continue;
    for (const Topic topic : kTopics) {
      if (channel.topic == topic_name(topic)) topics_[id] = topic;
    }
    if (channel.topic.starts_with(kPictures.topic)) {
      picture_channels_[id] = channel.topic.substr(kPictures.topic.size());
    }
  }
  try {
    LogCursor cursor(*this, {Topic::header});
    const std::optional<LogRecord> header = cursor.next();
    if (!header && reader_->contents().header.profile == kLogFormat) {
      throw InputError("no /seam/header: the run was killed before it wrote one; run it again");
    }
    if (!header) throw InputError("no /seam/header: not a SEAM log");
    header_ = std::get<RunHeader>(*header);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", name(), error.what()));
  }
}

std::optional<Topic> Log::topic_of(uint16_t channel_id) const {
  const auto found = topics_.find(channel_id);
  if (found == topics_.end()) return std::nullopt;
  return found->second;
}

std::vector<mcap::Loss> Log::losses() const {
  std::vector<mcap::Loss> losses;
  for (const mcap::Loss& loss : reader_->contents().losses) {
    if (!loss.index_only) losses.push_back(loss);
  }
  if (const auto& behind = reader_->contents().behind_end) {
    losses.push_back(*behind);
    losses.back().what = "behind the end of the file stands " + behind->what;
  }
  return losses;
}

bool Log::chunk_has(const mcap::ChunkPlace& chunk, Topic topic) const {
  if (chunk.channels.empty()) return true;  // The index does not say.
  return std::any_of(chunk.channels.begin(), chunk.channels.end(),
                     [&](uint16_t channel) { return topic_of(channel) == topic; });
}

std::optional<LogRecord> Log::last_before(Topic topic, SimTime time) const {
  const auto& chunks = reader_->contents().chunks;
  for (auto chunk = chunks.rbegin(); chunk != chunks.rend(); ++chunk) {
    if (chunk->start_time_ns > log_time(time) || !chunk_has(*chunk, topic)) continue;
    std::string last;
    bool found = false;
    reader_->for_each_message(*chunk, [&](const mcap::Message& message) {
      if (topic_of(message.channel_id) != topic || message.log_time_ns > log_time(time)) return;
      last = message.data;
      found = true;
    });
    if (found) return decode(topic, last, header_.robots);
  }
  return std::nullopt;
}

std::optional<EndRecord> Log::end() const {
  const auto& chunks = reader_->contents().chunks;
  if (chunks.empty() || !chunk_has(chunks.back(), Topic::end)) return std::nullopt;
  std::optional<EndRecord> end;
  reader_->for_each_message(chunks.back(), [&](const mcap::Message& message) {
    if (topic_of(message.channel_id) != Topic::end) return;
    end = std::get<EndRecord>(decode(Topic::end, message.data, header_.robots));
  });
  return end;
}

SimTime Log::end_time() const {
  uint64_t last_ns = 0;
  for (const mcap::ChunkPlace& chunk : reader_->contents().chunks) {
    last_ns = std::max(last_ns, chunk.end_time_ns);
  }
  return SimTime::from_ns(static_cast<int64_t>(std::min<uint64_t>(last_ns, INT64_MAX)));
}

std::optional<SnapshotRecord> Log::snapshot_before(SimTime time) const {
  std::optional<LogRecord> record = last_before(Topic::snapshot, time);
  if (!record) return std::nullopt;
  return std::get<SnapshotRecord>(std::move(*record));
}

std::optional<StepRecord> Log::step_before(SimTime time) const {
  std::optional<LogRecord> record = last_before(Topic::step, time);
  if (!record) return std::nullopt;
  return std::get<StepRecord>(std::move(*record));
}

bool Log::has_pictures() const {
  return !picture_channels_.empty();
}

std::optional<std::string> Log::picture(const FrameRecord& frame) const {
  const std::string& robot = header_.robots[static_cast<size_t>(frame.robot)];
  const auto channel = std::find_if(picture_channels_.begin(), picture_channels_.end(),
                                    [&](const auto& entry) { return entry.second == robot; });
  if (channel == picture_channels_.end()) return std::nullopt;
  const uint64_t time_ns = log_time(frame.time);
  std::optional<std::string> png;
  for (const mcap::ChunkPlace& chunk : reader_->contents().chunks) {
    if (chunk.start_time_ns > time_ns || chunk.end_time_ns < time_ns) continue;
    reader_->for_each_message(chunk, [&](const mcap::Message& message) {
      if (message.channel_id == channel->first && message.log_time_ns == time_ns) {
        png = picture_of(message.data);
      }
    });
    if (png) break;
  }
  return png;
}

MessageCursor::MessageCursor(const Log& log, SimTime from) : log_(log), from_ns_(log_time(from)) {}

std::optional<mcap::Message> MessageCursor::next() {
  const auto& chunks = log_.file().contents().chunks;
  while (true) {
    while (offset_ < records_.size()) {
      mcap::ByteSource source(std::string_view(records_).substr(offset_));
      try {
        const mcap::Opcode opcode{source.number<uint8_t>()};
        const std::string_view content = source.raw(source.number<uint64_t>());
        offset_ = records_.size() - source.left();
        if (opcode == mcap::Opcode::message) return mcap::decode_message(content);
      } catch (const mcap::Malformed& error) {
        throw InputError(fmt::format("{}: {}", log_.name(), error.what()));
      }
    }
    while (next_chunk_ < chunks.size() && chunks[next_chunk_].end_time_ns < from_ns_) {
      ++next_chunk_;
    }
    if (next_chunk_ >= chunks.size()) return std::nullopt;
    records_ = log_.file().read_chunk(chunks[next_chunk_++]);
    offset_ = 0;
  }
}

LogCursor::LogCursor(const Log& log, TopicSet topics, SimTime from)
    : log_(log), messages_(log, from), topics_(std::move(topics)), from_ns_(log_time(from)) {}

std::optional<LogRecord> LogCursor::next() {
  while (const std::optional<mcap::Message> message = messages_.next()) {
    const std::optional<Topic> topic = log_.topic_of(message->channel_id);
    if (!topic || message->log_time_ns < from_ns_ || !topics_.contains(*topic)) continue;
    last_bytes_ = message->data;
    last_topic_ = *topic;
    return decode(*topic, message->data, log_.header().robots);
  }
  return std::nullopt;
}

}  // namespace seam::scheduler
