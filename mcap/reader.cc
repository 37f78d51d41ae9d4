#include "mcap/reader.h"

#include <fmt/format.h>

#include "sim_core/base/error.h"

namespace seam::mcap {
namespace {

constexpr uint64_t kFooterBytes = kRecordHeadBytes + 8 + 8 + 4;

// Decodes the chunk record at this place; `bytes` keeps what the chunk points into.
Chunk chunk_at(const Input& input, const ChunkPlace& place, const Limits& limits,
               std::string& bytes) {
  if (place.length > limits.chunk_bytes) {
    throw Malformed(
        fmt::format("a chunk of {} bytes, at most {} are read", place.length, limits.chunk_bytes));
  }
  bytes = input.read(place.offset, place.length);
  ByteSource source(bytes);
  if (Opcode{source.number<uint8_t>()} != Opcode::chunk) {
    throw Malformed("no chunk stands where the index says");
  }
  return decode_chunk(source.raw(source.number<uint64_t>()));
}

// The summary section, and where it starts, by a footer whose CRC holds.
struct Summary {
  uint64_t start = 0;
  std::string records;
};

Summary summary_of(const Input& input, const Limits& limits) {
  // Magic, footer and their places.
  const uint64_t tail = kFooterBytes + kMagic.size();
  if (input.size() < kMagic.size() + tail) throw Malformed("too short for a summary");
  if (input.read(0, kMagic.size()) != kMagic) throw Malformed("no MCAP file");
  const uint64_t footer_offset = input.size() - tail;
  const std::string end = input.read(footer_offset, tail);
  if (!end.ends_with(kMagic) || Opcode(end[0]) != Opcode::footer) throw Malformed("no footer");
  const Footer footer = decode_footer(std::string_view(end).substr(kRecordHeadBytes));
  const uint64_t start = footer.summary_start;
  if (start < kMagic.size() || start > footer_offset ||
      footer_offset - start > limits.summary_bytes) {
    throw Malformed("the footer points outside of the file");
  }
  const std::string summary = input.read(start, footer_offset - start);
  const std::string_view covered = std::string_view(end).substr(0, kFooterBytes - 4);
  if (footer.summary_crc == 0 || footer.summary_crc != crc32(covered, crc32(summary))) {
    throw Malformed("the CRC of the summary does not match");
  }
  return {start, summary};
}

// Places of an index must be in order and apart: one that names a place many times would cost
// without bound.
class PlacesInOrder {
 public:
  explicit PlacesInOrder(uint64_t limit) : limit_(limit) {}
  void check(uint64_t offset, uint64_t length) {
    if (offset < end_before_ || length < kRecordHeadBytes || offset > limit_ ||
        length > limit_ - offset) {
      throw Malformed("an index that cannot be");
    }
    end_before_ = offset + length;
  }

 private:
  uint64_t limit_;
  uint64_t end_before_ = kMagic.size();
};

ChunkPlace chunk_place(const ChunkIndex& index) {
  if (index.start_time_ns > index.end_time_ns) throw Malformed("a chunk that ends too early");
  ChunkPlace place{
      index.chunk_offset, index.chunk_length, index.start_time_ns, index.end_time_ns, {}};
  for (const auto& [channel, offset] : index.message_index_offsets) {
    place.channels.push_back(channel);
  }
  return place;
}

std::string content_at(const Input& input, const Limits& limits, uint64_t offset, uint64_t length,
                       Opcode opcode) {
  if (length > limits.definition_bytes) throw Malformed("a record of absurd length");
  const std::string bytes = input.read(offset, length);
  ByteSource source(bytes);
  if (Opcode{source.number<uint8_t>()} != opcode) throw Malformed("an index that is wrong");
  return std::string(source.raw(source.number<uint64_t>()));
}

// The first record of the file.
Header header_of(const Input& input, const Limits& limits) {
  const std::string head = input.read(kMagic.size(), kRecordHeadBytes);
  ByteSource source(std::string_view(head).substr(1));
  const uint64_t bytes = source.number<uint64_t>();
  if (bytes > limits.definition_bytes) throw Malformed("a header of absurd length");
  return decode_header(
      content_at(input, limits, kMagic.size(), kRecordHeadBytes + bytes, Opcode::header));
}

}  // namespace

Reader Reader::open(std::unique_ptr<Input> input, const Limits& limits) {
  Reader reader(std::move(input), limits);
  try {
    reader.contents_ = read_summary(*reader.input_, limits);
  } catch (const Malformed&) {
    reader.contents_ = scan_file(*reader.input_, limits);
  }
  return reader;
}

Reader Reader::scan(std::unique_ptr<Input> input, const Limits& limits) {
  Reader reader(std::move(input), limits);
  reader.contents_ = scan_file(*reader.input_, limits);
  return reader;
}

std::string Reader::read_chunk(const ChunkPlace& place) const {
  try {
    std::string bytes;
    return unpack(chunk_at(*input_, place, limits_, bytes), limits_);
  } catch (const Malformed& error) {
    throw InputError(fmt::format("{}: offset {}: {}", name(), place.offset, error.what()));
  }
}

Attachment Reader::read_attachment(const AttachmentIndex& place) const {
  try {
    if (place.length < kRecordHeadBytes || place.length > limits_.attachment_bytes) {
      throw Malformed(fmt::format("an attachment of {} bytes", place.length));
    }
    const std::string bytes = input_->read(place.offset, place.length);
    ByteSource source(bytes);
    if (Opcode{source.number<uint8_t>()} != Opcode::attachment) {
      throw Malformed("no attachment stands where the index says");
    }
    return decode_attachment(source.raw(source.number<uint64_t>()));
  } catch (const Malformed& error) {
    throw InputError(fmt::format("{}: offset {}: {}", name(), place.offset, error.what()));
  }
}

void Reader::for_each_message(const ChunkPlace& place,
                              const std::function<void(const Message&)>& visit) const {
  const std::string records = read_chunk(place);
  try {
    for_each_record(records, [&](Opcode opcode, std::string_view content, uint64_t) {
      if (opcode == Opcode::message) visit(decode_message(content));
    });
  } catch (const Malformed& error) {
    throw InputError(fmt::format("{}: chunk at offset {}: {}", name(), place.offset, error.what()));
  }
}

Contents read_summary(const Input& input, const Limits& limits) {
  const Summary summary = summary_of(input, limits);
  Contents contents;
  contents.complete = true;
  std::vector<MetadataIndex> metadata;
  PlacesInOrder chunks(summary.start), attachments(summary.start), metadata_places(summary.start);
  for_each_record(summary.records, [&](Opcode opcode, std::string_view content, uint64_t) {
    if (opcode == Opcode::schema) {
      Schema schema = decode_schema(content);
      contents.schemas.insert_or_assign(schema.id, std::move(schema));
    } else if (opcode == Opcode::channel) {
      Channel channel = decode_channel(content);
      contents.channels.insert_or_assign(channel.id, std::move(channel));
    } else if (opcode == Opcode::chunk_index) {
      const ChunkIndex index = decode_chunk_index(content);
      chunks.check(index.chunk_offset, index.chunk_length);
      contents.chunks.push_back(chunk_place(index));
    } else if (opcode == Opcode::attachment_index) {
      contents.attachments.push_back(decode_attachment_index(content));
      attachments.check(contents.attachments.back().offset, contents.attachments.back().length);
    } else if (opcode == Opcode::metadata_index) {
      metadata.push_back(decode_metadata_index(content));
      metadata_places.check(metadata.back().offset, metadata.back().length);
    }
  });
  contents.header = header_of(input, limits);
  for (const MetadataIndex& index : metadata) {
    contents.metadata.push_back(
        decode_metadata(content_at(input, limits, index.offset, index.length, Opcode::metadata)));
  }
  return contents;
}

}  // namespace seam::mcap
