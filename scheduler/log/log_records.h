// What a log holds, as plain values. The bytes of a record are the Protocol Buffers messages of
// proto/seam/v1/log.proto; only log_codec.cc knows them.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "scheduler/log/log_manifest.h"
#include "scheduler/loop/observer.h"

namespace seam::scheduler {

inline constexpr std::string_view kLogFormat = "seam-log/1";
// Counts up whenever the world's behaviour or its fields change, so that no log is re-run by a
// program for which it means something else. Stands in RunHeader::versions as "state".
inline constexpr std::string_view kStateVersion = "1";

struct TurnRecord {
  SimTime time;
  Turn turn;
};

struct StepRecord {
  SimTime time;
  uint64_t step = 0;
  uint64_t fingerprint = 0;              // Over the sections' 64-bit hashes, in order.
  std::vector<uint32_t> section_hashes;  // The lower half of each.
  std::string field_checks;              // Two bits a field, on some steps; see field_checks.h.
  std::vector<float> poses;              // Of each robot kPoseFields, then the ball's x, y, z.
  std::vector<uint32_t> field_sums;      // See field_sums.h.
};
// In the order of StepRecord::poses.
inline constexpr std::string_view kPoseFields[] = {"x_m",      "y_m",     "heading_rad",
                                                   "tilt_rad", "pan_rad", "roll_rad"};

struct SnapshotRecord {
  SimTime time;
  uint64_t step = 0;
  std::string state;
};

struct FrameRecord {
  SimTime time;  // At which its last row ended.
  int robot = 0;
  uint64_t index = 0;
  SimTime stamp;
  uint64_t fingerprint = 0;
};

struct EndRecord {
  SimTime time;
  EndReason reason = EndReason::finished;
  uint64_t fingerprint = 0;
  uint64_t steps = 0;
  uint64_t frames = 0;
  uint64_t inputs_hash = 0;  // See inputs_hash.h; 0: the log has none.
};

// The kinds of records, each with a topic of its own (log_manifest.h).
#define SEAM_TOPIC(name, Record, Message) name,
enum class Topic : uint8_t { SEAM_LOG_MESSAGES(SEAM_TOPIC) };
#undef SEAM_TOPIC

#define SEAM_TOPIC(name, Record, Message) Topic::name,
inline constexpr Topic kTopics[] = {SEAM_LOG_MESSAGES(SEAM_TOPIC)};
#undef SEAM_TOPIC

// A record of any kind, its alternatives in the order of the topics.
template <typename, typename... Records>
using AnyOf = std::variant<Records...>;
#define SEAM_RECORD(name, Record, Message) , Record
using LogRecord = AnyOf<void SEAM_LOG_MESSAGES(SEAM_RECORD)>;
#undef SEAM_RECORD

// "/seam/turn".
std::string_view topic_name(Topic topic);
// "seam.v1.LogStep".
std::string_view schema_name(Topic topic);

// `robots`: the ids in the scenario's order, by which turns name them.
std::string encode(const LogRecord& record, const std::vector<std::string>& robots);
// Throws InputError saying what is wrong with the bytes.
LogRecord decode(Topic topic, std::string_view bytes, const std::vector<std::string>& robots);

// The FileDescriptorSet of a message type with all that it refers to: what an MCAP schema holds.
std::string descriptor_set_of(std::string_view message_name);

}  // namespace seam::scheduler
