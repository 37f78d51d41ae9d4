// The format: APPNOTE.TXT of PKWARE.
#include "app/bundle/zip_writer.h"

#include <zlib.h>

#include "sim_core/base/error.h"

namespace seam::app {
namespace {

constexpr uint64_t kMostBytes = 0xFFFFFFFF;

void put(std::string& out, uint64_t value, size_t bytes) {
  for (size_t i = 0; i < bytes; ++i) out += static_cast<char>(value >> (8 * i));
}

// The common fields of an entry's two heads, from its version on.
void put_entry(std::string& out, uint32_t crc, uint32_t size, const std::string& name) {
  put(out, 20, 2);          // Needs version 2.0.
  put(out, 0, 2 + 2);       // No flags; stored.
  put(out, 0x00210000, 4);  // The first day that the format knows: no clock is asked.
  put(out, crc, 4);
  put(out, size, 4);
  put(out, size, 4);
  put(out, name.size(), 2);
  put(out, 0, 2);  // No extra field.
}

}  // namespace

void ZipWriter::write(std::string_view bytes) {
  written_ += bytes.size();
  if (written_ > kMostBytes) throw InputError(too_long_);
  sink_(bytes);
}

void ZipWriter::add(const std::string& name, std::string_view first, std::string_view rest) {
  const auto crc_of = [](uLong before, std::string_view part) {
    // Without a place in memory zlib begins anew.
    if (part.empty()) return before;
    return crc32_z(before, reinterpret_cast<const Bytef*>(part.data()), part.size());
  };
  if (first.size() + rest.size() > kMostBytes) throw InputError(too_long_);
  Entry entry{name, static_cast<uint32_t>(crc_of(crc_of(0, first), rest)),
              static_cast<uint32_t>(first.size() + rest.size()), static_cast<uint32_t>(written_)};
  std::string local = "PK\x03\x04";
  put_entry(local, entry.crc, entry.size, entry.name);
  local += entry.name;
  write(local.append(first));
  write(rest);
  entries_.push_back(std::move(entry));
}

void ZipWriter::finish() {
  const uint64_t start = written_;
  std::string list;
  for (const Entry& entry : entries_) {
    list += "PK\x01\x02";
    put(list, 20, 2);  // Made by version 2.0.
    put_entry(list, entry.crc, entry.size, entry.name);
    put(list, 0, 2 + 2 + 2);  // No comment, the first disk, no attributes.
    put(list, 0, 4);
    put(list, entry.place, 4);
    list += entry.name;
  }
  std::string end = "PK\x05\x06";
  put(end, 0, 2 + 2);  // Disks.
  put(end, entries_.size(), 2);
  put(end, entries_.size(), 2);
  put(end, list.size(), 4);
  put(end, start, 4);
  put(end, 0, 2);  // No comment.
  write(list + end);
}

}  // namespace seam::app
