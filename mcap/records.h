// The records of an MCAP file as the open specification defines them (https://mcap.dev/spec), with
// one encoder each, and one decoder each of those that are read. Decoders throw Malformed.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "mcap/bytes.h"

namespace seam::mcap {

inline constexpr std::string_view kMagic{"\x89MCAP0\r\n", 8};
// Opcode and 64-bit length before each record's content.
inline constexpr uint64_t kRecordHeadBytes = 9;

enum class Opcode : uint8_t {
  header = 0x01,
  footer = 0x02,
  schema = 0x03,
  channel = 0x04,
  message = 0x05,
  chunk = 0x06,
  message_index = 0x07,
  chunk_index = 0x08,
  attachment = 0x09,
  attachment_index = 0x0A,
  statistics = 0x0B,
  metadata = 0x0C,
  metadata_index = 0x0D,
  summary_offset = 0x0E,
  data_end = 0x0F,
};

struct Header {
  std::string profile;
  std::string library;
};

struct Footer {
  uint64_t summary_start = 0;         // 0: no summary.
  uint64_t summary_offset_start = 0;  // 0: no summary offsets.
  uint32_t summary_crc = 0;           // 0: not available.
};

struct Schema {
  uint16_t id = 0;  // Never 0.
  std::string name;
  std::string encoding;  // "protobuf": data is a FileDescriptorSet.
  std::string data;
  bool operator==(const Schema&) const = default;
};

struct Channel {
  uint16_t id = 0;
  uint16_t schema_id = 0;  // 0: no schema.
  std::string topic;
  std::string message_encoding;
  std::map<std::string, std::string> metadata;
  bool operator==(const Channel&) const = default;
};

// Points into the bytes that it was decoded from.
struct Message {
  uint16_t channel_id = 0;
  uint32_t sequence = 0;
  uint64_t log_time_ns = 0;
  uint64_t publish_time_ns = 0;
  std::string_view data;
};

// Points into the bytes that it was decoded from.
struct Chunk {
  uint64_t start_time_ns = 0;
  uint64_t end_time_ns = 0;
  uint64_t uncompressed_size = 0;
  uint32_t uncompressed_crc = 0;  // 0: not available.
  std::string_view compression;   // "zstd", "lz4" or "".
  std::string_view records;
};

struct MessageIndex {
  struct Entry {
    uint64_t log_time_ns;
    uint64_t offset;  // Of the message's record in the uncompressed chunk.
  };
  uint16_t channel_id = 0;
  std::vector<Entry> entries;
};

struct ChunkIndex {
  uint64_t start_time_ns = 0;
  uint64_t end_time_ns = 0;
  uint64_t chunk_offset = 0;  // Of the chunk's record in the file.
  uint64_t chunk_length = 0;  // Opcode and length included.
  std::map<uint16_t, uint64_t> message_index_offsets;
  uint64_t message_index_length = 0;
  std::string compression;
  uint64_t compressed_size = 0;
  uint64_t uncompressed_size = 0;
};

struct Attachment {
  uint64_t log_time_ns = 0;
  uint64_t create_time_ns = 0;
  std::string name;
  std::string media_type;
  std::string data;
};

struct AttachmentIndex {
  uint64_t offset = 0;
  uint64_t length = 0;
  uint64_t log_time_ns = 0;
  uint64_t create_time_ns = 0;
  uint64_t data_size = 0;
  std::string name;
  std::string media_type;
};

struct Metadata {
  std::string name;
  std::map<std::string, std::string> values;
};

struct MetadataIndex {
  uint64_t offset = 0;
  uint64_t length = 0;
  std::string name;
};

struct Statistics {
  uint64_t message_count = 0;
  uint16_t schema_count = 0;
  uint32_t channel_count = 0;
  uint32_t attachment_count = 0;
  uint32_t metadata_count = 0;
  uint32_t chunk_count = 0;
  uint64_t start_time_ns = 0;
  uint64_t end_time_ns = 0;
  std::map<uint16_t, uint64_t> channel_message_counts;
};

struct SummaryOffset {
  Opcode group = Opcode::schema;
  uint64_t start = 0;
  uint64_t length = 0;
};

struct DataEnd {
  uint32_t data_section_crc = 0;  // 0: not available.
};

// Each appends a whole record: opcode, length, content.
void append(ByteSink& sink, const Header& record);
void append(ByteSink& sink, const Footer& record);
void append(ByteSink& sink, const Schema& record);
void append(ByteSink& sink, const Channel& record);
void append(ByteSink& sink, const Message& record);
void append(ByteSink& sink, const Chunk& record);
void append(ByteSink& sink, const MessageIndex& record);
void append(ByteSink& sink, const ChunkIndex& record);
void append(ByteSink& sink, const Attachment& record);  // Computes the CRC.
void append(ByteSink& sink, const AttachmentIndex& record);
void append(ByteSink& sink, const Metadata& record);
void append(ByteSink& sink, const MetadataIndex& record);
void append(ByteSink& sink, const Statistics& record);
void append(ByteSink& sink, const SummaryOffset& record);
void append(ByteSink& sink, const DataEnd& record);

// Each takes a record's content. Bytes behind the known fields are ignored, as the specification
// asks, so that later versions can add fields.
Header decode_header(std::string_view content);
Footer decode_footer(std::string_view content);
Schema decode_schema(std::string_view content);
Channel decode_channel(std::string_view content);
Message decode_message(std::string_view content);
Chunk decode_chunk(std::string_view content);
ChunkIndex decode_chunk_index(std::string_view content);
Attachment decode_attachment(std::string_view content);  // Checks the CRC.
AttachmentIndex decode_attachment_index(std::string_view content);
Metadata decode_metadata(std::string_view content);
MetadataIndex decode_metadata_index(std::string_view content);
DataEnd decode_data_end(std::string_view content);

// CRC-32 (IEEE 802.3, as zlib's), continued from `before`.
uint32_t crc32(std::string_view bytes, uint32_t before = 0);

}  // namespace seam::mcap
