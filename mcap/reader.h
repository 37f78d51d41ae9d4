// Reads an MCAP file through its index, or by a scan of the whole file where the index is missing
// or damaged. Made for hostile input: every length is checked against the file and `Limits` before
// memory is taken, and what cannot be read is reported as a loss.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mcap/chunk.h"
#include "mcap/io.h"
#include "mcap/records.h"

namespace seam::mcap {

// A part of the file that could not be read.
struct Loss {
  uint64_t offset = 0;  // Of its first byte in the file.
  uint64_t bytes = 0;
  std::string what;  // A sentence for people.
  // Whether only an index was lost, which holds nothing that is not elsewhere.
  bool index_only = false;
};

// Where a chunk stands, and which times it covers.
struct ChunkPlace {
  uint64_t offset = 0;
  uint64_t length = 0;
  uint64_t start_time_ns = 0;
  uint64_t end_time_ns = 0;
  // Messages by channel; empty when the index does not say.
  std::vector<uint16_t> channels;
};

// What a file holds, from its summary or from a scan.
struct Contents {
  Header header;
  std::map<uint16_t, Schema> schemas;
  std::map<uint16_t, Channel> channels;
  std::vector<ChunkPlace> chunks;            // In the order of the file.
  std::vector<AttachmentIndex> attachments;  // In the order of the file.
  std::vector<Metadata> metadata;
  uint64_t unpacked_bytes = 0;  // Of a scan: all its chunks, uncompressed.
  bool complete = false;        // The data section has its end: the writer finished.
  std::vector<Loss> losses;     // In the order of the file.
  // Of a scan: what stands behind the end of the file proper. Nothing reads it.
  std::optional<Loss> behind_end;
  // Of a scan: the index is whole, and differs from the data. Readers by the index are
  // misled.
  bool index_misleads = false;
};

// What is damaged of the index of a file whose writer finished: readers by the index are misled,
// though the data may be whole.
std::optional<Loss> index_damage(const Contents& scanned);

// A damaged index as a sentence: where, how large, what is wrong with it.
std::string index_sentence(const Loss& damage);

class Reader {
 public:
  // Through the summary where it is whole, else by a scan. Throws InputError where the file is no
  // MCAP file at all.
  static Reader open(std::unique_ptr<Input> input, const Limits& limits = {});
  // Always by a scan that checks every record.
  static Reader scan(std::unique_ptr<Input> input, const Limits& limits = {});

  const Contents& contents() const { return contents_; }
  const std::string& name() const { return input_->name(); }
  uint64_t file_bytes() const { return input_->size(); }

  // The uncompressed records of a chunk; throws InputError where it is damaged.
  std::string read_chunk(const ChunkPlace& place) const;
  Attachment read_attachment(const AttachmentIndex& place) const;
  // Calls `visit` for each message of a chunk in the order of writing.
  void for_each_message(const ChunkPlace& place,
                        const std::function<void(const Message&)>& visit) const;

 private:
  Reader(std::unique_ptr<Input> input, const Limits& limits)
      : input_(std::move(input)), limits_(limits) {}

  std::unique_ptr<Input> input_;
  Limits limits_;
  Contents contents_;
};

// The contents by the summary; throws Malformed where it is missing, damaged or implausible.
Contents read_summary(const Input& input, const Limits& limits);
// The contents by a walk over the file. Behind damage it looks for the next chunk whose CRC holds.
Contents scan_file(const Input& input, const Limits& limits);

// The same for files of any writer, with or without chunks, summary and indexes: calls `visit` for
// each message in the order of the file, with what is known of the file by then. One record is in
// memory at a time. A message is visited once all of its chunk was seen to be whole.
using VisitMessage = std::function<void(const Contents& so_far, const Message&)>;
Contents scan_messages(const Input& input, const Limits& limits, const VisitMessage& visit);

}  // namespace seam::mcap
