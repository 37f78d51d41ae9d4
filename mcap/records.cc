#include "mcap/records.h"

#include <zlib.h>

namespace seam::mcap {
namespace {

// A record whose content `write` appends, behind its opcode and length.
template <typename Write>
void append_record(ByteSink& sink, Opcode opcode, Write write) {
  ByteSink content;
  write(content);
  sink.number(static_cast<uint8_t>(opcode));
  sink.number(static_cast<uint64_t>(content.size()));
  sink.raw(content.bytes());
}

// An array or map, whose length in bytes stands before it.
template <typename Write>
void append_elements(ByteSink& sink, Write write) {
  ByteSink elements;
  write(elements);
  sink.text(elements.bytes());
}

void append_texts(ByteSink& sink, const std::map<std::string, std::string>& texts) {
  append_elements(sink, [&](ByteSink& elements) {
    for (const auto& [key, value] : texts) {
      elements.text(key);
      elements.text(value);
    }
  });
}

void append_numbers(ByteSink& sink, const std::map<uint16_t, uint64_t>& numbers) {
  append_elements(sink, [&](ByteSink& elements) {
    for (const auto& [key, value] : numbers) {
      elements.number(key);
      elements.number(value);
    }
  });
}

std::map<std::string, std::string> decode_texts(ByteSource elements) {
  std::map<std::string, std::string> texts;
  while (!elements.empty()) {
    std::string key(elements.text());
    texts.insert_or_assign(std::move(key), std::string(elements.text()));
  }
  return texts;
}

std::map<uint16_t, uint64_t> decode_numbers(ByteSource elements) {
  std::map<uint16_t, uint64_t> numbers;
  while (!elements.empty()) {
    const uint16_t key = elements.number<uint16_t>();
    numbers.insert_or_assign(key, elements.number<uint64_t>());
  }
  return numbers;
}

}  // namespace

uint32_t crc32(std::string_view bytes, uint32_t before) {
  return static_cast<uint32_t>(
      ::crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

void append(ByteSink& sink, const Header& record) {
  append_record(sink, Opcode::header, [&](ByteSink& content) {
    content.text(record.profile);
    content.text(record.library);
  });
}

void append(ByteSink& sink, const Footer& record) {
  append_record(sink, Opcode::footer, [&](ByteSink& content) {
    content.number(record.summary_start);
    content.number(record.summary_offset_start);
    content.number(record.summary_crc);
  });
}

void append(ByteSink& sink, const Schema& record) {
  append_record(sink, Opcode::schema, [&](ByteSink& content) {
    content.number(record.id);
    content.text(record.name);
    content.text(record.encoding);
    content.text(record.data);
  });
}

void append(ByteSink& sink, const Channel& record) {
  append_record(sink, Opcode::channel, [&](ByteSink& content) {
    content.number(record.id);
    content.number(record.schema_id);
    content.text(record.topic);
    content.text(record.message_encoding);
    append_texts(content, record.metadata);
  });
}

// Written in place: messages are the many, and their data can be large.
void append(ByteSink& sink, const Message& record) {
  constexpr uint64_t kFixedBytes = 2 + 4 + 8 + 8;
  sink.number(static_cast<uint8_t>(Opcode::message));
  sink.number(static_cast<uint64_t>(kFixedBytes + record.data.size()));
  sink.number(record.channel_id);
  sink.number(record.sequence);
  sink.number(record.log_time_ns);
  sink.number(record.publish_time_ns);
  sink.raw(record.data);
}

void append(ByteSink& sink, const Chunk& record) {
  append_record(sink, Opcode::chunk, [&](ByteSink& content) {
    content.number(record.start_time_ns);
    content.number(record.end_time_ns);
    content.number(record.uncompressed_size);
    content.number(record.uncompressed_crc);
    content.text(record.compression);
    content.number(static_cast<uint64_t>(record.records.size()));
    content.raw(record.records);
  });
}

void append(ByteSink& sink, const MessageIndex& record) {
  append_record(sink, Opcode::message_index, [&](ByteSink& content) {
    content.number(record.channel_id);
    append_elements(content, [&](ByteSink& elements) {
      for (const MessageIndex::Entry& entry : record.entries) {
        elements.number(entry.log_time_ns);
        elements.number(entry.offset);
      }
    });
  });
}

void append(ByteSink& sink, const ChunkIndex& record) {
  append_record(sink, Opcode::chunk_index, [&](ByteSink& content) {
    content.number(record.start_time_ns);
    content.number(record.end_time_ns);
    content.number(record.chunk_offset);
    content.number(record.chunk_length);
    append_numbers(content, record.message_index_offsets);
    content.number(record.message_index_length);
    content.text(record.compression);
    content.number(record.compressed_size);
    content.number(record.uncompressed_size);
  });
}

void append(ByteSink& sink, const Attachment& record) {
  append_record(sink, Opcode::attachment, [&](ByteSink& content) {
    content.number(record.log_time_ns);
    content.number(record.create_time_ns);
    content.text(record.name);
    content.text(record.media_type);
    content.number(static_cast<uint64_t>(record.data.size()));
    content.raw(record.data);
    content.number(crc32(content.bytes()));
  });
}

void append(ByteSink& sink, const AttachmentIndex& record) {
  append_record(sink, Opcode::attachment_index, [&](ByteSink& content) {
    content.number(record.offset);
    content.number(record.length);
    content.number(record.log_time_ns);
    content.number(record.create_time_ns);
    content.number(record.data_size);
    content.text(record.name);
    content.text(record.media_type);
  });
}

void append(ByteSink& sink, const Metadata& record) {
  append_record(sink, Opcode::metadata, [&](ByteSink& content) {
    content.text(record.name);
    append_texts(content, record.values);
  });
}

void append(ByteSink& sink, const MetadataIndex& record) {
  append_record(sink, Opcode::metadata_index, [&](ByteSink& content) {
    content.number(record.offset);
    content.number(record.length);
    content.text(record.name);
  });
}

void append(ByteSink& sink, const Statistics& record) {
  append_record(sink, Opcode::statistics, [&](ByteSink& content) {
    content.number(record.message_count);
    content.number(record.schema_count);
    content.number(record.channel_count);
    content.number(record.attachment_count);
    content.number(record.metadata_count);
    content.number(record.chunk_count);
    content.number(record.start_time_ns);
    content.number(record.end_time_ns);
    append_numbers(content, record.channel_message_counts);
  });
}

void append(ByteSink& sink, const SummaryOffset& record) {
  append_record(sink, Opcode::summary_offset, [&](ByteSink& content) {
    content.number(static_cast<uint8_t>(record.group));
    content.number(record.start);
    content.number(record.length);
  });
}

void append(ByteSink& sink, const DataEnd& record) {
  append_record(sink, Opcode::data_end,
                [&](ByteSink& content) { content.number(record.data_section_crc); });
}

Header decode_header(std::string_view content) {
  ByteSource source(content);
  Header record;
  record.profile = source.text();
  record.library = source.text();
  return record;
}

Footer decode_footer(std::string_view content) {
  ByteSource source(content);
  Footer record;
  record.summary_start = source.number<uint64_t>();
  record.summary_offset_start = source.number<uint64_t>();
  record.summary_crc = source.number<uint32_t>();
  return record;
}

Schema decode_schema(std::string_view content) {
  ByteSource source(content);
  Schema record;
  record.id = source.number<uint16_t>();
  record.name = source.text();
  record.encoding = source.text();
  record.data = source.text();
  return record;
}

Channel decode_channel(std::string_view content) {
  ByteSource source(content);
  Channel record;
  record.id = source.number<uint16_t>();
  record.schema_id = source.number<uint16_t>();
  record.topic = source.text();
  record.message_encoding = source.text();
  record.metadata = decode_texts(source.elements());
  return record;
}

Message decode_message(std::string_view content) {
  ByteSource source(content);
  Message record;
  record.channel_id = source.number<uint16_t>();
  record.sequence = source.number<uint32_t>();
  record.log_time_ns = source.number<uint64_t>();
  record.publish_time_ns = source.number<uint64_t>();
  record.data = source.raw(source.left());
  return record;
}

Chunk decode_chunk(std::string_view content) {
  ByteSource source(content);
  Chunk record;
  record.start_time_ns = source.number<uint64_t>();
  record.end_time_ns = source.number<uint64_t>();
  record.uncompressed_size = source.number<uint64_t>();
  record.uncompressed_crc = source.number<uint32_t>();
  record.compression = source.text();
  record.records = source.raw(source.number<uint64_t>());
  return record;
}

ChunkIndex decode_chunk_index(std::string_view content) {
  ByteSource source(content);
  ChunkIndex record;
  record.start_time_ns = source.number<uint64_t>();
  record.end_time_ns = source.number<uint64_t>();
  record.chunk_offset = source.number<uint64_t>();
  record.chunk_length = source.number<uint64_t>();
  record.message_index_offsets = decode_numbers(source.elements());
  record.message_index_length = source.number<uint64_t>();
  record.compression = source.text();
  record.compressed_size = source.number<uint64_t>();
  record.uncompressed_size = source.number<uint64_t>();
  return record;
}

Attachment decode_attachment(std::string_view content) {
  ByteSource source(content);
  Attachment record;
  record.log_time_ns = source.number<uint64_t>();
  record.create_time_ns = source.number<uint64_t>();
  record.name = source.text();
  record.media_type = source.text();
  record.data = source.raw(source.number<uint64_t>());
  const size_t covered = content.size() - source.left();
  const uint32_t crc = source.number<uint32_t>();
  if (crc != 0 && crc != crc32(content.substr(0, covered))) {
    throw Malformed("the CRC of attachment '" + record.name + "' does not match");
  }
  return record;
}

AttachmentIndex decode_attachment_index(std::string_view content) {
  ByteSource source(content);
  AttachmentIndex record;
  record.offset = source.number<uint64_t>();
  record.length = source.number<uint64_t>();
  record.log_time_ns = source.number<uint64_t>();
  record.create_time_ns = source.number<uint64_t>();
  record.data_size = source.number<uint64_t>();
  record.name = source.text();
  record.media_type = source.text();
  return record;
}

Metadata decode_metadata(std::string_view content) {
  ByteSource source(content);
  Metadata record;
  record.name = source.text();
  record.values = decode_texts(source.elements());
  return record;
}

MetadataIndex decode_metadata_index(std::string_view content) {
  ByteSource source(content);
  MetadataIndex record;
  record.offset = source.number<uint64_t>();
  record.length = source.number<uint64_t>();
  record.name = source.text();
  return record;
}

DataEnd decode_data_end(std::string_view content) {
  return {ByteSource(content).number<uint32_t>()};
}

}  // namespace seam::mcap
