#include "mcap/chunk.h"

#include <fmt/format.h>
#include <lz4frame.h>
#include <zstd.h>

#include "sim_core/base/error.h"

namespace seam::mcap {

bool within_expansion(uint64_t compressed, uint64_t uncompressed, const Limits& limits) {
  return uncompressed <= limits.chunk_bytes && uncompressed / limits.expansion <= compressed + 256;
}

void Compressor::Free::operator()(ZSTD_CCtx_s* context) const {
  ZSTD_freeCCtx(context);
}

Compressor::Compressor(int level) : context_(ZSTD_createCCtx()), level_(level) {
  SEAM_CHECK(level >= 0 && level <= 19, "zstd level {}", level);
  SEAM_CHECK(context_ != nullptr);
}
Compressor::~Compressor() = default;
Compressor::Compressor(Compressor&&) noexcept = default;
Compressor& Compressor::operator=(Compressor&&) noexcept = default;

void Compressor::pack(std::string_view records, std::string& compression, std::string& packed) {
  compression.clear();
  packed.clear();
  if (level_ > 0) {
    packed.resize(ZSTD_compressBound(records.size()));
    const size_t size = ZSTD_compressCCtx(context_.get(), packed.data(), packed.size(),
                                          records.data(), records.size(), level_);
    SEAM_CHECK(!ZSTD_isError(size), "zstd: {}", ZSTD_getErrorName(size));
    if (within_expansion(size, records.size(), Limits{})) {
      packed.resize(size);
      compression = "zstd";
      return;
    }
  }
  packed.assign(records);
}

std::string unpack_lz4(std::string_view packed, uint64_t size) {
  LZ4F_dctx* context = nullptr;
  const size_t made = LZ4F_createDecompressionContext(&context, LZ4F_VERSION);
  if (LZ4F_isError(made)) throw Malformed(fmt::format("lz4: {}", LZ4F_getErrorName(made)));
  std::string out(size, '\0');
  size_t from = 0, to = 0, left = 1;
  while (left != 0 && from < packed.size()) {
    size_t taken = packed.size() - from, given = out.size() - to;
    left = LZ4F_decompress(context, out.data() + to, &given, packed.data() + from, &taken, nullptr);
    if (LZ4F_isError(left) || (taken == 0 && given == 0)) break;
    from += taken, to += given;
  }
  LZ4F_freeDecompressionContext(context);
  if (left != 0 || to != size)
    throw Malformed(fmt::format("lz4: {} of {} bytes came out", to, size));
  return out;
}

std::string unpack(const Chunk& chunk, const Limits& limits) {
  std::string records;
  const bool packed = chunk.compression == "zstd" || chunk.compression == "lz4";
  if (packed && !within_expansion(chunk.records.size(), chunk.uncompressed_size, limits))
    throw Malformed(fmt::format("a chunk of {} bytes that claims to unpack to {} bytes",
                                chunk.records.size(), chunk.uncompressed_size));
  if (chunk.compression == "lz4") {
    records = unpack_lz4(chunk.records, chunk.uncompressed_size);
  } else if (chunk.compression == "zstd") {
    records.resize(chunk.uncompressed_size);
    const size_t size =
        ZSTD_decompress(records.data(), records.size(), chunk.records.data(), chunk.records.size());
    if (ZSTD_isError(size)) throw Malformed(fmt::format("zstd: {}", ZSTD_getErrorName(size)));
    records.resize(size);
  } else if (chunk.compression.empty()) {
    records = chunk.records;
  } else {
    throw Malformed(fmt::format("a chunk compressed by '{}', expected zstd, lz4 or none",
                                chunk.compression.substr(0, 32)));
  }
  if (records.size() != chunk.uncompressed_size) {
    throw Malformed(
        fmt::format("a chunk of {} bytes, expected {}", records.size(), chunk.uncompressed_size));
  }
  if (chunk.uncompressed_crc != 0 && crc32(records) != chunk.uncompressed_crc) {
    throw Malformed("the CRC of a chunk does not match");
  }
  return records;
}

void for_each_record(std::string_view records,
                     const std::function<void(Opcode, std::string_view, uint64_t)>& visit) {
  ByteSource source(records);
  while (!source.empty()) {
    const uint64_t offset = records.size() - source.left();
    const Opcode opcode{source.number<uint8_t>()};
    visit(opcode, source.raw(source.number<uint64_t>()), offset);
  }
}

}  // namespace seam::mcap
