#include "scheduler/log/log_recovery.h"

#include <fmt/format.h>

#include <map>

#include "mcap/writer.h"
#include "scheduler/log/log_records.h"
#include "sim_core/base/error.h"

namespace seam::scheduler {
namespace {

SimTime sim_time(uint64_t ns) {
  return SimTime::from_ns(static_cast<int64_t>(std::min<uint64_t>(ns, INT64_MAX)));
}

// Where the definitions of a log are lost, its first channels are still known: a recorder numbers
// the topics of seam-log/1 from 1 in their order (replays/FORMAT.md).
void add_conventional_channels(mcap::Contents& contents) {
  uint16_t id = 0;
  for (const Topic topic : kTopics) {
    ++id;
    if (contents.channels.contains(id) || contents.schemas.contains(id)) continue;
    const std::string schema(schema_name(topic));
    contents.schemas[id] = {id, schema, "protobuf", descriptor_set_of(schema)};
    contents.channels[id] = {id, id, std::string(topic_name(topic)), "protobuf", {}};
  }
}

std::vector<Recovery::Loss> losses_in_time(const mcap::Contents& contents) {
  std::vector<Recovery::Loss> losses;
  for (const mcap::Loss& loss : contents.losses) {
    // A file without an end did lose its last moments, though no byte of it is bad. What else is
    // lost of an index is written anew.
    if (loss.index_only && (contents.complete || loss.bytes > 0)) continue;
    Recovery::Loss in_time{loss, SimTime(), std::nullopt};
    for (const mcap::ChunkPlace& chunk : contents.chunks) {
      if (chunk.offset < loss.offset) in_time.from = sim_time(chunk.end_time_ns);
      if (chunk.offset >= loss.offset + loss.bytes && !in_time.to) {
        in_time.to = sim_time(chunk.start_time_ns);
      }
    }
    losses.push_back(std::move(in_time));
  }
  return losses;
}

}  // namespace

Recovery recover_log(std::unique_ptr<mcap::Input> input, mcap::Output& output) {
  const mcap::Reader reader = mcap::Reader::scan(std::move(input));
  mcap::Contents contents = reader.contents();
  Recovery recovery;
  recovery.losses = losses_in_time(contents);
  recovery.behind_end = contents.behind_end;
  recovery.index = mcap::index_damage(contents);
  if (contents.chunks.empty()) {
    throw InputError(reader.name() + ": no message is left to recover");
  }
  const std::string profile =
      contents.header.profile.empty() ? std::string(kLogFormat) : contents.header.profile;
  if (profile == kLogFormat) add_conventional_channels(contents);

  mcap::Writer writer(output, {.profile = profile, .chunk_bytes = uint64_t{64} << 20});
  std::map<uint16_t, uint16_t> schema_ids, channel_ids;
  for (const auto& [id, schema] : contents.schemas) {
    schema_ids[id] = writer.add_schema(schema.name, schema.encoding, schema.data);
  }
  for (const auto& [id, channel] : contents.channels) {
    const auto schema = schema_ids.find(channel.schema_id);
    const uint16_t schema_id = schema == schema_ids.end() ? uint16_t{0} : schema->second;
    channel_ids[id] =
        writer.add_channel(schema_id, channel.topic, channel.message_encoding, channel.metadata);
  }
  for (const mcap::AttachmentIndex& attachment : contents.attachments) {
    writer.attach(reader.read_attachment(attachment));
    ++recovery.attachments;
  }
  for (const mcap::Metadata& metadata : contents.metadata) writer.add_metadata(metadata);
  for (const mcap::ChunkPlace& chunk : contents.chunks) {
    reader.for_each_message(chunk, [&](const mcap::Message& message) {
      const auto channel = channel_ids.find(message.channel_id);
      if (channel == channel_ids.end()) {
        ++recovery.unknown_messages;
        return;
      }
      writer.write(channel->second, message.log_time_ns, message.publish_time_ns, message.data);
      ++recovery.messages;
    });
    writer.flush();
    ++recovery.chunks;
  }
  writer.finish();
  if (recovery.messages == 0) throw InputError(reader.name() + ": no message is left to recover");
  return recovery;
}

}  // namespace seam::scheduler
