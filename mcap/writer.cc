#include "mcap/writer.h"

#include <algorithm>

#include "sim_core/base/error.h"

namespace seam::mcap {

Writer::Writer(Output& output, const WriterOptions& options)
    : output_(output), options_(options), compressor_(options.zstd_level) {
  ByteSink sink;
  sink.raw(kMagic);
  append(sink, Header{options.profile, options.library});
  emit_data(sink);
}

void Writer::emit(std::string_view bytes) {
  SEAM_CHECK(!finished_, "written to after finish()");
  output_.write(bytes);
  offset_ += bytes.size();
}

void Writer::emit_data(const ByteSink& sink) {
  data_crc_ = crc32(sink.bytes(), data_crc_);
  emit(sink.bytes());
}

uint16_t Writer::add_schema(std::string name, std::string encoding, std::string data) {
  SEAM_CHECK(schemas_.size() < 0xFFFF);
  schemas_.push_back({static_cast<uint16_t>(schemas_.size() + 1), std::move(name),
                      std::move(encoding), std::move(data)});
  ByteSink sink;
  append(sink, schemas_.back());
  emit_data(sink);
  return schemas_.back().id;
}

uint16_t Writer::add_channel(uint16_t schema_id, std::string topic, std::string message_encoding,
                             std::map<std::string, std::string> metadata) {
  SEAM_CHECK(schema_id <= schemas_.size(), "schema {} of {}", schema_id, schemas_.size());
  SEAM_CHECK(channels_.size() < 0xFFFF);
  channels_.push_back({static_cast<uint16_t>(channels_.size() + 1), schema_id, std::move(topic),
                       std::move(message_encoding), std::move(metadata)});
  sequences_.push_back(0);
  ByteSink sink;
  append(sink, channels_.back());
  emit_data(sink);
  return channels_.back().id;
}

void Writer::repeat_definitions() {
  for (const Schema& schema : schemas_) append(chunk_, schema);
  for (const Channel& channel : channels_) append(chunk_, channel);
}

void Writer::write(uint16_t channel_id, uint64_t log_time_ns, uint64_t publish_time_ns,
                   std::string_view data) {
  SEAM_CHECK(channel_id >= 1 && channel_id <= channels_.size(), "channel {}", channel_id);
  const bool first_message = chunk_messages_.empty();
  chunk_start_ns_ = first_message ? log_time_ns : std::min(chunk_start_ns_, log_time_ns);
  chunk_end_ns_ = first_message ? log_time_ns : std::max(chunk_end_ns_, log_time_ns);
  MessageIndex& index = chunk_messages_[channel_id];
  index.channel_id = channel_id;
  index.entries.push_back({log_time_ns, chunk_.size()});
  append(chunk_,
         Message{channel_id, sequences_[channel_id - 1]++, log_time_ns, publish_time_ns, data});
  if (chunk_.size() >= options_.chunk_bytes) flush();
}

void Writer::attach(const Attachment& attachment) {
  flush();  // Keeps the file in the order of time.
  ByteSink sink;
  append(sink, attachment);
  attachment_indexes_.push_back({offset_, sink.size(), attachment.log_time_ns,
                                 attachment.create_time_ns, attachment.data.size(), attachment.name,
                                 attachment.media_type});
  emit_data(sink);
}

void Writer::add_metadata(const Metadata& metadata) {
  ByteSink sink;
  append(sink, metadata);
  metadata_indexes_.push_back({offset_, sink.size(), metadata.name});
  emit_data(sink);
}

void Writer::flush() {
  if (chunk_.size() == 0) return;
  const bool has_messages = !chunk_messages_.empty();
  ChunkIndex index;
  index.start_time_ns = has_messages ? chunk_start_ns_ : 0;
  index.end_time_ns = has_messages ? chunk_end_ns_ : 0;
  index.chunk_offset = offset_;
  std::string packed;
  compressor_.pack(chunk_.bytes(), index.compression, packed);
  index.compressed_size = packed.size();
  index.uncompressed_size = chunk_.size();

  ByteSink sink;
  append(sink, Chunk{index.start_time_ns, index.end_time_ns, chunk_.size(), crc32(chunk_.bytes()),
                     index.compression, packed});
  index.chunk_length = sink.size();
  for (const auto& [channel_id, messages] : chunk_messages_) {
    index.message_index_offsets[channel_id] = offset_ + sink.size();
    append(sink, messages);
    statistics_.channel_message_counts[channel_id] += messages.entries.size();
    statistics_.message_count += messages.entries.size();
  }
  index.message_index_length = sink.size() - index.chunk_length;
  if (has_messages) {
    const bool first = statistics_.message_count == 0 || chunk_indexes_.empty();
    statistics_.start_time_ns =
        first ? index.start_time_ns : std::min(statistics_.start_time_ns, index.start_time_ns);
    statistics_.end_time_ns = std::max(statistics_.end_time_ns, index.end_time_ns);
  }
  chunk_indexes_.push_back(std::move(index));
  emit_data(sink);
  output_.sync();
  chunk_.clear();
  chunk_messages_.clear();
}

std::string Writer::summary() const {
  ByteSink sink;
  ByteSink offsets;
  const auto group = [&](Opcode opcode, const auto& records) {
    const uint64_t start = sink.size();
    for (const auto& record : records) append(sink, record);
    if (sink.size() == start) return;
    append(offsets, SummaryOffset{opcode, offset_ + start, sink.size() - start});
  };
  Statistics statistics = statistics_;
  statistics.schema_count = static_cast<uint16_t>(schemas_.size());
  statistics.channel_count = static_cast<uint32_t>(channels_.size());
  statistics.attachment_count = static_cast<uint32_t>(attachment_indexes_.size());
  statistics.metadata_count = static_cast<uint32_t>(metadata_indexes_.size());
  statistics.chunk_count = static_cast<uint32_t>(chunk_indexes_.size());

  group(Opcode::schema, schemas_);
  group(Opcode::channel, channels_);
  group(Opcode::statistics, std::vector{statistics});
  group(Opcode::chunk_index, chunk_indexes_);
  group(Opcode::attachment_index, attachment_indexes_);
  group(Opcode::metadata_index, metadata_indexes_);

  Footer footer;
  footer.summary_start = offset_;
  footer.summary_offset_start = offset_ + sink.size();
  sink.raw(offsets.bytes());
  // The summary's CRC covers the footer up to the CRC itself.
  ByteSink footer_record;
  append(footer_record, footer);
  const std::string_view covered =
      std::string_view(footer_record.bytes()).substr(0, footer_record.size() - 4);
  footer.summary_crc = crc32(covered, crc32(sink.bytes()));
  append(sink, footer);
  sink.raw(kMagic);
  return sink.take();
}

void Writer::finish() {
  flush();
  ByteSink sink;
  append(sink, DataEnd{data_crc_});
  emit(sink.bytes());
  emit(summary());
  finished_ = true;
}

}  // namespace seam::mcap
