#include "app/import/files/inflate.h"

#include <zlib.h>

#include <algorithm>

#include "sim_core/base/error.h"

namespace seam::app {

std::string inflated(std::string_view packed, Deflate form, uint64_t limit_bytes,
                     const std::string& where) {
  z_stream stream{};
  if (inflateInit2(&stream, form == Deflate::zlib ? 15 : -15) != Z_OK)
    throw InputError(fmt::format("{}: cannot be unpacked", where));
  std::string out;
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
  stream.avail_in = static_cast<uInt>(std::min<size_t>(packed.size(), 0xFFFFFFFFu));
  int status = Z_OK;
  while (status == Z_OK && out.size() <= limit_bytes) {
    const size_t before = out.size();
    out.resize(before + std::max<size_t>(size_t{1} << 16, before / 2));
    stream.next_out = reinterpret_cast<Bytef*>(out.data() + before);
    stream.avail_out = static_cast<uInt>(out.size() - before);
    status = inflate(&stream, Z_NO_FLUSH);
    out.erase(out.size() - stream.avail_out);
    if (status == Z_OK && out.size() == before && stream.avail_in == 0) break;
  }
  inflateEnd(&stream);
  if (out.size() > limit_bytes)
    throw InputError(fmt::format("{}: unpacks to more than {} bytes", where, limit_bytes));
  if (status != Z_STREAM_END)
    throw InputError(fmt::format("{}: damaged or cut: its compressed bytes do not end", where));
  return out;
}

}  // namespace seam::app
