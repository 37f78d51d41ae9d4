// A replay log as its readers see it: the header, and records of chosen kinds from any time on.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "mcap/reader.h"
#include "scheduler/log/log_records.h"

namespace seam::scheduler {

using TopicSet = std::set<Topic>;
inline const TopicSet kAllTopics(std::begin(kTopics), std::end(kTopics));

// How far a reader trusts the file's index.
enum class LogAccess : uint8_t {
  indexed,  // The index where it is whole; damaged chunks are errors when they are reached.
  scanned,  // Every chunk is checked first; damaged ones are left out and reported as losses.
};

class Log {
 public:
  // Throws InputError where the file is no SEAM log, or none of this major version.
  static Log open(const std::filesystem::path& path, LogAccess access = LogAccess::indexed);
  static Log open(std::unique_ptr<mcap::Input> input, LogAccess access = LogAccess::indexed);
  Log(Log&&) noexcept = default;
  Log& operator=(Log&&) noexcept = default;

  const RunHeader& header() const { return header_; }
  const std::string& name() const { return reader_->name(); }
  const mcap::Reader& file() const { return *reader_; }
  // What could not be read, indexes aside.
  std::vector<mcap::Loss> losses() const;

  // The run's end as its writer saw it; nothing where the writer was killed.
  std::optional<EndRecord> end() const;
  // Of the last record.
  SimTime end_time() const;
  // The last snapshot at or before this time.
  std::optional<SnapshotRecord> snapshot_before(SimTime time) const;
  // The last step at or before this time.
  std::optional<StepRecord> step_before(SimTime time) const;
  // The picture of a frame, where the log holds it: PNG.
  std::optional<std::string> picture(const FrameRecord& frame) const;
  bool has_pictures() const;

  std::optional<Topic> topic_of(uint16_t channel_id) const;

 private:
  explicit Log(mcap::Reader reader);
  std::optional<LogRecord> last_before(Topic topic, SimTime time) const;
  bool chunk_has(const mcap::ChunkPlace& chunk, Topic topic) const;

  std::unique_ptr<mcap::Reader> reader_;
  RunHeader header_;
  std::map<uint16_t, Topic> topics_;                  // By channel.
  std::map<uint16_t, std::string> picture_channels_;  // Robot by channel.
};

// Walks over all messages in the order of writing, which is the order of time.
class MessageCursor {
 public:
  // From the first chunk that reaches to `from`. `log` must outlive the cursor.
  explicit MessageCursor(const Log& log, SimTime from = SimTime());

  // Nothing at the end; throws InputError at damage. The message points into the cursor, until the
  // next call.
  std::optional<mcap::Message> next();

 private:
  const Log& log_;
  uint64_t from_ns_;
  size_t next_chunk_ = 0;
  std::string records_;  // Of the current chunk.
  size_t offset_ = 0;
};

// Walks over the records of chosen kinds in the order of writing, which is the order of time.
class LogCursor {
 public:
  // From the first record whose time is at or after `from`. `log` must outlive the cursor.
  LogCursor(const Log& log, TopicSet topics, SimTime from = SimTime());

  // Nothing at the end; throws InputError at damage.
  std::optional<LogRecord> next();
  // The file's bytes of the record that `next` gave last.
  const std::string& last_bytes() const { return last_bytes_; }
  Topic last_topic() const { return last_topic_; }

 private:
  const Log& log_;
  MessageCursor messages_;
  TopicSet topics_;
  uint64_t from_ns_;
  std::string last_bytes_;
  Topic last_topic_ = Topic::header;
};

// MCAP times are unsigned: times before the start count as 0.
uint64_t log_time(SimTime time);
// Of whatever record.
SimTime time_of(const LogRecord& record);
// "/camera/red1".
std::string picture_topic(const std::string& robot);

}  // namespace seam::scheduler
