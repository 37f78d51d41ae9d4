#include "app/logs/log_copy.h"

#include <map>

#include "mcap/writer.h"
#include "scheduler/log/inputs_hash.h"

namespace seam::app {
namespace {

using scheduler::EndRecord;
using scheduler::Log;
using scheduler::LogRecord;
using scheduler::Topic;
using scheduler::TurnRecord;

class Copy {
 public:
  Copy(const Log& log, mcap::Output& output, const std::function<bool(TurnRecord&)>& change)
      : log_(log),
        change_(change),
        writer_(output, {.profile = log.file().contents().header.profile,
                         .chunk_bytes = uint64_t{64} << 20}) {}

  void run() {
    const mcap::Contents& contents = log_.file().contents();
    std::map<uint16_t, uint16_t> schemas;
    for (const auto& [id, schema] : contents.schemas)
      schemas[id] = writer_.add_schema(schema.name, schema.encoding, schema.data);
    for (const auto& [id, channel] : contents.channels)
      channels_[id] = writer_.add_channel(schemas[channel.schema_id], channel.topic,
                                          channel.message_encoding, channel.metadata);
    for (const mcap::AttachmentIndex& attachment : contents.attachments)
      writer_.attach(log_.file().read_attachment(attachment));
    for (const mcap::Metadata& metadata : contents.metadata) writer_.add_metadata(metadata);
    for (const mcap::ChunkPlace& chunk : contents.chunks) {
      log_.file().for_each_message(chunk, [&](const mcap::Message& message) { copy(message); });
      writer_.flush();
    }
    writer_.finish();
  }

 private:
  void copy(const mcap::Message& message) {
    const std::optional<Topic> topic = log_.topic_of(message.channel_id);
    std::string bytes(message.data);
    if (topic) bytes = changed(*topic, std::move(bytes));
    writer_.write(channels_.at(message.channel_id), message.log_time_ns, message.publish_time_ns,
                  bytes);
  }
  std::string changed(Topic topic, std::string bytes) {
    // Those that the inputs' hash is over, and the end that holds it.
    if (topic != Topic::header && topic != Topic::turn && topic != Topic::event &&
        topic != Topic::end)
      return bytes;
    const std::vector<std::string>& robots = log_.header().robots;
    LogRecord record = decode(topic, bytes, robots);
    // As its writer did it: with each copy of the header stand the definitions.
    if (topic == Topic::header && std::exchange(has_header_, true)) writer_.repeat_definitions();
    auto* turn = std::get_if<TurnRecord>(&record);
    if (turn != nullptr && change_(*turn)) bytes = encode(record, robots);
    auto* end = std::get_if<EndRecord>(&record);
    if (end != nullptr && end->inputs_hash != 0) {
      end->inputs_hash = inputs_.digest(end->time, end->reason);
      bytes = encode(record, robots);
    }
    inputs_.add(record, bytes);
    return bytes;
  }

  const Log& log_;
  const std::function<bool(TurnRecord&)>& change_;
  mcap::Writer writer_;
  std::map<uint16_t, uint16_t> channels_;
  scheduler::InputsHash inputs_;
  bool has_header_ = false;
};

}  // namespace

void copy_log(const Log& log, mcap::Output& output,
              const std::function<bool(TurnRecord&)>& change) {
  Copy(log, output, change).run();
}

}  // namespace seam::app
