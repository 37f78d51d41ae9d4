#include "app/import/files/inflate.h"

#include <zlib.h>

#include <algorithm>
#include <memory>

#include "sim_core/base/error.h"

namespace seam::app {
namespace {

// Inflates into pieces; `take` gets each. False where the bytes are damaged or do not end.
template <typename Take>
bool inflate_pieces(std::string_view packed, Deflate form, std::string& piece, const Take& take) {
  z_stream stream{};
  if (inflateInit2(&stream, form == Deflate::zlib ? 15 : -15) != Z_OK) return false;
  // Ends the stream where `take` throws, too.
  const std::unique_ptr<z_stream, int (*)(z_stream*)> guard(&stream, inflateEnd);
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
  stream.avail_in = static_cast<uInt>(std::min<size_t>(packed.size(), 0xFFFFFFFFu));
  int status = Z_OK;
  while (status == Z_OK) {
    stream.next_out = reinterpret_cast<Bytef*>(piece.data());
    stream.avail_out = static_cast<uInt>(piece.size());
    status = inflate(&stream, Z_NO_FLUSH);
    const size_t made = piece.size() - stream.avail_out;
    take(std::string_view(piece).substr(0, made));
    if (status == Z_OK && made == 0 && stream.avail_in == 0) return false;
  }
  return status == Z_STREAM_END;
}

}  // namespace

std::string inflated(std::string_view packed, Deflate form, UnpackBudget& budget,
                     const std::string& where) {
  std::string piece(size_t{1} << 16, '\0');
  // The size first: it costs time alone, where a string that grows would take thrice the memory.
  size_t size = 0;
  const bool whole = inflate_pieces(packed, form, piece, [&](std::string_view made) {
    budget.take(made.size());
    size += made.size();
  });
  if (!whole)
    throw InputError(fmt::format("{}: damaged or cut: its compressed bytes do not end", where));
  std::string out;
  out.reserve(size);
  inflate_pieces(packed, form, piece, [&](std::string_view made) { out += made; });
  return out;
}

}  // namespace seam::app
