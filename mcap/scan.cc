// The walk over a file that may end or be damaged anywhere.
//
// Records are read one after another as long as each holds up: a chunk must unpack to its CRC, a
// message index must have exactly the length that its chunk implies, an attachment must match its
// CRC. Where one does not, lengths cannot be trusted any more, and the walk looks byte by byte for
// the next chunk whose CRC holds. That search costs time for each place that looks like a chunk,
// so its work is bounded in proportion to the file.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "mcap/reader.h"
#include "sim_core/base/error.h"

namespace seam::mcap {
namespace {

constexpr uint64_t kWindowBytes = uint64_t{1} << 20;

bool same_place(const ChunkPlace& a, const ChunkPlace& b) {
  return a.offset == b.offset && a.length == b.length && a.start_time_ns == b.start_time_ns &&
         a.end_time_ns == b.end_time_ns && a.channels == b.channels;
}

bool same_attachment(const AttachmentIndex& a, const AttachmentIndex& b) {
  return a.offset == b.offset && a.length == b.length && a.log_time_ns == b.log_time_ns &&
         a.create_time_ns == b.create_time_ns && a.data_size == b.data_size && a.name == b.name &&
         a.media_type == b.media_type;
}

bool same_metadata(const Metadata& a, const Metadata& b) {
  return a.name == b.name && a.values == b.values;
}

// An index may define what no message uses; all else stands in the data too.
template <typename Definitions>
bool same_definitions(const Definitions& index, const Definitions& data,
                      const std::set<uint16_t>& used) {
  return std::ranges::all_of(data,
                             [&](const auto& entry) {
                               const auto found = index.find(entry.first);
                               return found != index.end() && found->second == entry.second;
                             }) &&
         std::ranges::none_of(index, [&](const auto& entry) {
           return !data.contains(entry.first) && used.contains(entry.first);
         });
}

// What an index says, and what the data are.
bool same_contents(const Contents& index, const Contents& data) {
  std::set<uint16_t> used;
  for (const ChunkPlace& chunk : data.chunks) {
    used.insert(chunk.channels.begin(), chunk.channels.end());
  }
  return same_definitions(index.schemas, data.schemas, {}) &&
         same_definitions(index.channels, data.channels, used) &&
         std::ranges::equal(index.chunks, data.chunks, same_place) &&
         std::ranges::equal(index.attachments, data.attachments, same_attachment) &&
         std::ranges::equal(index.metadata, data.metadata, same_metadata);
}

class Scanner {
 public:
  // `visit`: null where only the contents are wanted; messages outside of chunks are damage then,
  // since our own writer makes none.
  Scanner(const Input& input, const Limits& limits, const VisitMessage* visit)
      : input_(input),
        limits_(limits),
        visit_(visit),
        search_budget_(16 * input.size() + (uint64_t{64} << 20)) {}

  Contents run() {
    if (input_.size() >= kMagic.size() && input_.read(0, kMagic.size()) == kMagic) {
      offset_ = kMagic.size();
    } else {
      lose_until_next_chunk(0, "the file does not start as an MCAP file");
    }
    while (offset_ < input_.size() && !contents_.complete) step();
    const bool found = !contents_.chunks.empty() || !contents_.attachments.empty() ||
                       !contents_.channels.empty() || has_header_;
    if (!found) throw InputError(input_.name() + ": not an MCAP file, or nothing of it is left");
    if (!contents_.complete && contents_.losses.empty()) {
      contents_.losses.push_back(
          {input_.size(), 0, "the file ends without an index: its writer did not finish", true});
    }
    return std::move(contents_);
  }

 private:
  // Reads the record at offset_, or finds the next good one.
  void step() {
    const uint64_t start = offset_;
    if (input_.size() - start < kRecordHeadBytes) {
      lose(start, input_.size(), "the file ends in the middle of a record");
      offset_ = input_.size();
      return;
    }
    const std::string head = input_.read(start, kRecordHeadBytes);
    ByteSource source(head);
    const Opcode opcode{source.number<uint8_t>()};
    const uint64_t length = source.number<uint64_t>();
    try {
      if (length > input_.size() - start - kRecordHeadBytes) {
        throw Malformed("the file ends in the middle of a record");
      }
      read_record(opcode, start, length);
      offset_ = start + kRecordHeadBytes + length;
    } catch (const Malformed& error) {
      lose_until_next_chunk(start, error.what());
    }
  }

  std::string content_of(uint64_t start, uint64_t length, uint64_t limit) const {
    if (length > limit) {
      throw Malformed(fmt::format("a record of {} bytes, at most {} are read", length, limit));
    }
    return input_.read(start + kRecordHeadBytes, length);
  }

  void read_record(Opcode opcode, uint64_t start, uint64_t length) {
    if (opcode != Opcode::message_index) expected_indexes_.clear();
    switch (opcode) {
      case Opcode::header:
        contents_.header = decode_header(content_of(start, length, limits_.definition_bytes));
        has_header_ = true;
        break;
      case Opcode::schema:
        add_schema(content_of(start, length, limits_.definition_bytes));
        break;
      case Opcode::channel:
        add_channel(content_of(start, length, limits_.definition_bytes));
        break;
      case Opcode::chunk:
        add_chunk(start, content_of(start, length, limits_.chunk_bytes));
        break;
      case Opcode::message_index:
        check_message_index(start, length);
        break;
      case Opcode::message:
        if (visit_ == nullptr) throw Malformed("a message outside of a chunk");
        (*visit_)(contents_, decode_message(content_of(start, length, limits_.chunk_bytes)));
        break;
      case Opcode::attachment: {
        const Attachment attachment =
            decode_attachment(content_of(start, length, limits_.attachment_bytes));
        contents_.attachments.push_back({start, kRecordHeadBytes + length, attachment.log_time_ns,
                                         attachment.create_time_ns, attachment.data.size(),
                                         attachment.name, attachment.media_type});
        break;
      }
      case Opcode::metadata:
        contents_.metadata.push_back(
            decode_metadata(content_of(start, length, limits_.definition_bytes)));
        break;
      case Opcode::data_end:
        check_data_end(start, length);
        break;
      default:
        // Applications may add records from 0x80 on; anything else has no place here.
        if (static_cast<uint8_t>(opcode) < 0x80) {
          throw Malformed(
              fmt::format("a record of unknown type {:#04x}", static_cast<unsigned>(opcode)));
        }
    }
  }

  void add_schema(std::string_view content) {
    Schema schema = decode_schema(content);
    // The first one stays: a repeated definition must be equal.
    if (schema.id != 0) contents_.schemas.try_emplace(schema.id, std::move(schema));
  }

  void add_channel(std::string_view content) {
    Channel channel = decode_channel(content);
    contents_.channels.try_emplace(channel.id, std::move(channel));
  }

  // A chunk counts only when it is whole: unpacked, its CRC right, its records well formed.
  void add_chunk(uint64_t start, std::string_view content) {
    const Chunk chunk = decode_chunk(content);
    if (chunk.uncompressed_size > limits_.all_chunks_bytes - contents_.unpacked_bytes)
      throw InputError(fmt::format("{}: byte {}: its chunks unpack to more than {} MB",
                                   input_.name(), start, limits_.all_chunks_bytes >> 20));
    contents_.unpacked_bytes += chunk.uncompressed_size;
    const std::string records = unpack(chunk, limits_);
    ChunkPlace place{
        start, kRecordHeadBytes + content.size(), chunk.start_time_ns, chunk.end_time_ns, {}};
    std::map<uint16_t, uint64_t> counts;
    std::vector<std::string_view> schemas;
    std::vector<std::string_view> channels;
    for_each_record(records, [&](Opcode opcode, std::string_view record, uint64_t) {
      if (opcode == Opcode::message) ++counts[decode_message(record).channel_id];
      if (opcode == Opcode::schema) schemas.push_back(record);
      if (opcode == Opcode::channel) channels.push_back(record);
    });
    for (const std::string_view schema : schemas) add_schema(schema);
    for (const std::string_view channel : channels) add_channel(channel);
    for (const auto& [channel, count] : counts) place.channels.push_back(channel);
    contents_.chunks.push_back(std::move(place));
    expected_indexes_ = std::move(counts);
    if (visit_ == nullptr) return;
    for_each_record(records, [&](Opcode opcode, std::string_view record, uint64_t) {
      if (opcode == Opcode::message) (*visit_)(contents_, decode_message(record));
    });
  }

  // An index holds nothing that its chunk does not; only its length matters for the way on. Other
  // writers' indexes name channels without messages, and come after other records.
  void check_message_index(uint64_t start, uint64_t length) {
    if (visit_ != nullptr) return;
    const std::string head = content_of(start, std::min<uint64_t>(length, 2), 2);
    const uint16_t channel = ByteSource(head).number<uint16_t>();
    const auto expected = expected_indexes_.find(channel);
    if (expected == expected_indexes_.end() || length != 2 + 4 + 16 * expected->second) {
      throw Malformed("a message index that does not fit its chunk");
    }
    expected_indexes_.erase(expected);
  }

  // The data section's CRC is not checked: each chunk and attachment has one of its own, and a
  // damaged file has reported its losses by now.
  void check_data_end(uint64_t start, uint64_t length) {
    decode_data_end(content_of(start, length, limits_.definition_bytes));
    contents_.complete = true;
    if (const uint64_t end = end_of_file(start + kRecordHeadBytes + length); end < input_.size()) {
      contents_.behind_end = Loss{end, input_.size() - end, what_stands_behind(end)};
      return;
    }
    try {
      contents_.index_misleads = !same_contents(read_summary(input_, limits_), contents_);
    } catch (const Malformed& error) {
      lose(start, input_.size(), error.what(), true);
    }
  }

  // Where the file ends that began at its first byte: behind the magic behind the next footer. The
  // end of the input where the records up to there do not hold up.
  uint64_t end_of_file(uint64_t offset) const {
    while (input_.size() - offset >= kRecordHeadBytes) {
      const std::string head = input_.read(offset, kRecordHeadBytes);
      ByteSource source(head);
      const Opcode opcode{source.number<uint8_t>()};
      const uint64_t length = source.number<uint64_t>();
      offset += kRecordHeadBytes;
      if (length > input_.size() - offset) break;
      offset += length;
      if (opcode != Opcode::footer) continue;
      if (input_.size() - offset < kMagic.size() || input_.read(offset, kMagic.size()) != kMagic) {
        break;
      }
      return offset + kMagic.size();
    }
    return input_.size();
  }

  std::string what_stands_behind(uint64_t end) const {
    const bool is_mcap =
        input_.size() - end >= kMagic.size() && input_.read(end, kMagic.size()) == kMagic;
    return is_mcap ? fmt::format("another MCAP file, which is not read (tail -c +{} takes it out)",
                                 end + 1)
                   : "bytes that are no MCAP file";
  }

  void lose(uint64_t begin, uint64_t end, std::string what, bool index_only = false) {
    contents_.losses.push_back({begin, end - begin, std::move(what), index_only});
  }

  void lose_until_next_chunk(uint64_t start, const std::string& why) {
    // What is still to come of the last chunk's indexes: they hold nothing of their own.
    uint64_t index_bytes = 0;
    for (const auto& [channel, count] : expected_indexes_) {
      index_bytes += kRecordHeadBytes + 2 + 4 + 16 * count;
    }
    expected_indexes_.clear();
    const uint64_t next = find_chunk(start + 1);
    lose(start, next, why, next - start == index_bytes);
    offset_ = next;
  }

  // The next place from `from` on where a whole chunk stands, or the end of the file.
  uint64_t find_chunk(uint64_t from) {
    while (from < input_.size()) {
      const uint64_t size = std::min(kWindowBytes, input_.size() - from);
      const std::string window = input_.read(from, size);
      for (size_t at = window.find('\x06'); at != std::string::npos;
           at = window.find('\x06', at + 1)) {
        if (search_budget_ == 0) return input_.size();
        if (is_chunk(from + at)) return from + at;
      }
      from += size;
    }
    return input_.size();
  }

  bool is_chunk(uint64_t start) {
    // The cheap tests first: length, order of times, sizes, name of the compression.
    constexpr uint64_t kFixedBytes = 8 + 8 + 8 + 4 + 4;
    constexpr uint64_t kProbeBytes = kRecordHeadBytes + kFixedBytes + 4 + 8;
    if (input_.size() - start < kProbeBytes) return false;
    const std::string probe = input_.read(start, kProbeBytes);
    ByteSource source(std::string_view(probe).substr(1));
    const uint64_t length = source.number<uint64_t>();
    if (length > limits_.chunk_bytes || length > input_.size() - start - kRecordHeadBytes) {
      return false;
    }
    const uint64_t start_time = source.number<uint64_t>();
    if (start_time > source.number<uint64_t>()) return false;
    const uint64_t uncompressed = source.number<uint64_t>();
    if (!within_expansion(length, uncompressed, limits_)) return false;
    if (source.number<uint32_t>() == 0) return false;  // Without a CRC nothing proves it.
    const uint32_t name_bytes = source.number<uint32_t>();
    if (name_bytes > 4) return false;
    const std::string_view compression = source.raw(name_bytes);
    if (!compression.empty() && compression != "zstd" && compression != "lz4") return false;

    search_budget_ -= std::min(search_budget_, length + uncompressed);
    try {
      unpack(decode_chunk(std::string_view(input_.read(start + kRecordHeadBytes, length))),
             limits_);
      return true;
    } catch (const Malformed&) {
      return false;
    }
  }

  const Input& input_;
  const Limits& limits_;
  const VisitMessage* visit_;
  uint64_t search_budget_;  // Bytes that the search may still unpack.
  uint64_t offset_ = 0;
  bool has_header_ = false;
  std::map<uint16_t, uint64_t> expected_indexes_;  // Of the last chunk: messages by channel.
  Contents contents_;
};

}  // namespace

std::optional<Loss> index_damage(const Contents& scanned) {
  for (const Loss& loss : scanned.losses) {
    // Without a byte lost, and without an end: the writer was killed before it wrote the index.
    if (loss.index_only && (scanned.complete || loss.bytes > 0)) return loss;
  }
  return std::nullopt;
}

std::string index_sentence(const Loss& damage) {
  return fmt::format("the index is damaged at offset {} ({} bytes): {}", damage.offset,
                     damage.bytes, damage.what);
}

Contents scan_file(const Input& input, const Limits& limits) {
  return Scanner(input, limits, nullptr).run();
}

Contents scan_messages(const Input& input, const Limits& limits, const VisitMessage& visit) {
  return Scanner(input, limits, &visit).run();
}

}  // namespace seam::mcap
