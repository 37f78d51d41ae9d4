// The contents of a chunk: compressing, and taking apart with hostile input in mind.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "mcap/records.h"

struct ZSTD_CCtx_s;

namespace seam::mcap {

// What a reader accepts. Every length in a file is checked against these before memory is taken,
// so that no file makes a reader use more.
struct Limits {
  uint64_t chunk_bytes = uint64_t{64} << 20;  // Uncompressed.
  uint64_t attachment_bytes = uint64_t{64} << 20;
  uint64_t definition_bytes = uint64_t{1} << 20;  // Header, schema, channel, metadata.
  uint64_t summary_bytes = uint64_t{256} << 20;
  // A chunk may unpack to this many times (its compressed size + 256 bytes): more is a bomb.
  // The writer stores a chunk uncompressed rather than beyond it.
  uint64_t expansion = 250;
  // All chunks of a file together, uncompressed, where a scan reads them all: beyond it the scan
  // throws InputError.
  uint64_t all_chunks_bytes = ~uint64_t{0};
};

// Whether a chunk of this compressed size may unpack to this size.
bool within_expansion(uint64_t compressed, uint64_t uncompressed, const Limits& limits);

class Compressor {
 public:
  // zstd levels 1 to 19; 0 stores without compression.
  explicit Compressor(int level);
  ~Compressor();
  Compressor(Compressor&&) noexcept;
  Compressor& operator=(Compressor&&) noexcept;

  // Fills `compression` and `packed`; falls back to "" where zstd would not be read back.
  void pack(std::string_view records, std::string& compression, std::string& packed);

 private:
  struct Free {
    void operator()(ZSTD_CCtx_s* context) const;
  };
  std::unique_ptr<ZSTD_CCtx_s, Free> context_;
  int level_;
};

// A frame of LZ4 that unpacks to exactly this size; throws Malformed.
std::string unpack_lz4(std::string_view packed, uint64_t size);

// The uncompressed records of a chunk, checked against its size and CRC; throws Malformed.
std::string unpack(const Chunk& chunk, const Limits& limits);

// Calls `visit` for each record: its opcode, its content, and the offset of its opcode; throws
// Malformed where a length runs beyond the bytes.
void for_each_record(std::string_view records,
                     const std::function<void(Opcode, std::string_view, uint64_t)>& visit);

}  // namespace seam::mcap
