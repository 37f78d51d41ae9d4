#include "scheduler/replay/log_audit.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "scheduler/log/inputs_hash.h"
#include "sim_core/base/error.h"

namespace seam::scheduler {
namespace {

class Auditor {
 public:
  explicit Auditor(const Log& log) : log_(log) {}

  LogAudit run() {
    if (log_.file().contents().index_misleads) {
      find(SimTime(), "index", "the file's index differs from its data");
    }
    check_attachments();
    check_chunk_times();
    check_messages();
    check_inputs();
    for (const auto& [topic, count] : unknown_) {
      audit_.unproved.push_back(
          fmt::format("{} messages of the topic {}, which seam does not write", count, topic));
    }
    if (printed_ > 0) {
      audit_.unproved.push_back(
          fmt::format("{} lines that behaviours printed, which no re-run makes again", printed_));
    }
    if (!log_.file().contents().metadata.empty()) {
      audit_.unproved.emplace_back("metadata, which seam does not write");
    }
    return std::move(audit_);
  }

 private:
  void find(SimTime time, std::string field, std::string detail) {
    if (!audit_.finding) audit_.finding = {time, "log", std::move(field), std::move(detail)};
  }

  // The scenario stands in the header and, for other tools, as an attachment.
  void check_attachments() {
    for (const mcap::AttachmentIndex& place : log_.file().contents().attachments) {
      const mcap::Attachment attachment = log_.file().read_attachment(place);
      if (attachment.name != "scenario.yaml") {
        audit_.unproved.push_back(fmt::format("the attachment '{}', which seam does not write",
                                              attachment.name.substr(0, 80)));
      } else if (attachment.data != log_.header().scenario_text) {
        find(SimTime(), "attachment " + attachment.name,
             "the attachment is another text than the header's");
      }
    }
  }

  // By them readers choose where to look, and the log's end is known.
  void check_chunk_times() {
    for (const mcap::ChunkPlace& chunk : log_.file().contents().chunks) {
      uint64_t first_ns = UINT64_MAX, last_ns = 0;
      log_.file().for_each_message(chunk, [&](const mcap::Message& message) {
        first_ns = std::min(first_ns, message.log_time_ns);
        last_ns = std::max(last_ns, message.log_time_ns);
      });
      if (first_ns > last_ns) continue;  // Without messages.
      if (first_ns == chunk.start_time_ns && last_ns == chunk.end_time_ns) continue;
      find(SimTime::from_ns(static_cast<int64_t>(std::min<uint64_t>(first_ns, INT64_MAX))), "chunk",
           fmt::format("a chunk claims the times {} to {} ns and holds {} to {} ns",
                       chunk.start_time_ns, chunk.end_time_ns, first_ns, last_ns));
    }
  }

  void check_messages() {
    MessageCursor cursor(log_);
    while (const std::optional<mcap::Message> message = cursor.next()) {
      const std::optional<Topic> topic = log_.topic_of(message->channel_id);
      if (topic) {
        check_message(*topic, *message);
      } else {
        note_unknown(message->channel_id);
      }
    }
    if (!ends_.empty() && last_ != Topic::end) {
      find(ends_.front().time, "end", "records stand behind the log's end");
    }
  }

  void check_message(Topic topic, const mcap::Message& message) {
    last_ = topic;
    const LogRecord record = decode(topic, message.data, log_.header().robots);
    const SimTime time = time_of(record);
    if (topic == Topic::header) {
      if (header_.empty()) header_ = message.data;
      if (header_ != message.data) find(SimTime(), "header", "a copy of the header is another");
    } else if (log_time(time) != message.log_time_ns) {
      find(time, "time_ns",
           fmt::format("{}: a message of {} ns stands at {} ns in the file", topic_name(topic),
                       time.ns(), message.log_time_ns));
    }
    if (const auto* event = std::get_if<SimulationEvent>(&record);
        event != nullptr && event->kind == EventKind::debug) {
      find(time, "event", "the log has an event of kind debug, which no recorder writes");
    }
    if (const auto* end = std::get_if<EndRecord>(&record)) ends_.push_back(*end);
    inputs_.add(record, message.data);
  }

  void note_unknown(uint16_t channel_id) {
    const auto& channels = log_.file().contents().channels;
    const auto channel = channels.find(channel_id);
    const std::string topic = channel == channels.end() ? "?" : channel->second.topic;
    if (topic == kPrinted.topic) {
      ++printed_;
      return;
    }
    const auto& robots = log_.header().robots;
    const bool shown = topic == kTransforms.topic || topic == kSceneUpdates.topic ||
                       std::any_of(robots.begin(), robots.end(), [&](const std::string& robot) {
                         return topic == picture_topic(robot);
                       });
    if (!shown) ++unknown_[topic.substr(0, 80)];
  }

  void check_inputs() {
    if (ends_.empty()) return;
    if (ends_.size() > 1) {
      return find(ends_[1].time, "end", fmt::format("the log ends {} times", ends_.size()));
    }
    const EndRecord& end = ends_.front();
    if (end.inputs_hash == 0) {
      audit_.unproved.emplace_back(
          "what clients logged, why robots were frozen, faults and versions: the log is of an "
          "older program and has no hash of its inputs");
    } else if (end.inputs_hash != inputs_.digest(end.time, end.reason)) {
      find(end.time, "inputs_hash",
           "the header, a decision, a fault or the end is not what was recorded");
    }
  }

  const Log& log_;
  LogAudit audit_;
  std::string header_;
  InputsHash inputs_;
  std::vector<EndRecord> ends_;
  Topic last_ = Topic::header;
  std::map<std::string, uint64_t> unknown_;  // Messages by topic.
  uint64_t printed_ = 0;
};

}  // namespace

LogAudit audit(const Log& log) {
  return Auditor(log).run();
}

}  // namespace seam::scheduler
