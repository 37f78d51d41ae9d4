// Writes an MCAP file as a stream: messages gather in a chunk, and each finished chunk reaches the
// operating system in one write, so that after a crash everything up to the last chunk is there; it
// is synced then, where the output is durable.
// The file ends with an index (`finish`); a file without it is still readable, by a scan.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "mcap/chunk.h"
#include "mcap/io.h"
#include "mcap/records.h"

namespace seam::mcap {

struct WriterOptions {
  std::string profile;
  std::string library = "seam";
  // A chunk is closed when it holds this much; callers close chunks earlier by `flush`.
  uint64_t chunk_bytes = uint64_t{1} << 20;
  int zstd_level = 3;  // 0: chunks are stored uncompressed.
};

class Writer {
 public:
  // Writes magic and header. `output` must outlive the writer.
  Writer(Output& output, const WriterOptions& options);

  // Definitions are written to the data section at once, outside of chunks.
  uint16_t add_schema(std::string name, std::string encoding, std::string data);
  uint16_t add_channel(uint16_t schema_id, std::string topic, std::string message_encoding,
                       std::map<std::string, std::string> metadata = {});
  // Writes all definitions once more into the current chunk, for readers of a file whose start is
  // damaged.
  void repeat_definitions();

  void write(uint16_t channel_id, uint64_t log_time_ns, uint64_t publish_time_ns,
             std::string_view data);
  void write(uint16_t channel_id, uint64_t log_time_ns, std::string_view data) {
    write(channel_id, log_time_ns, log_time_ns, data);
  }
  void attach(const Attachment& attachment);
  void add_metadata(const Metadata& metadata);

  // Closes the current chunk; does nothing where it is empty.
  void flush();
  // Closes the last chunk and writes the index. Nothing may be written afterwards.
  void finish();

  uint64_t bytes_written() const { return offset_; }

 private:
  void emit(std::string_view bytes);
  void emit_data(const ByteSink& sink);
  std::string summary() const;

  Output& output_;
  WriterOptions options_;
  Compressor compressor_;
  uint64_t offset_ = 0;
  uint32_t data_crc_ = 0;
  bool finished_ = false;

  std::vector<Schema> schemas_;
  std::vector<Channel> channels_;
  std::vector<uint32_t> sequences_;  // The next one of each channel.

  ByteSink chunk_;
  std::map<uint16_t, MessageIndex> chunk_messages_;
  uint64_t chunk_start_ns_ = 0;
  uint64_t chunk_end_ns_ = 0;

  std::vector<ChunkIndex> chunk_indexes_;
  std::vector<AttachmentIndex> attachment_indexes_;
  std::vector<MetadataIndex> metadata_indexes_;
  Statistics statistics_;
};

}  // namespace seam::mcap
