// The formats: APPNOTE.TXT of PKWARE (zip), and numpy.lib.format (npy).
#include "app/episodes/npz_writer.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <zlib.h>

#include <algorithm>
#include <bit>

#include "sim_core/base/error.h"

namespace seam::app {

namespace {

static_assert(std::endian::native == std::endian::little);
constexpr uint64_t kMostBytes = 0xFFFFFFFF;  // Of a zip without its extension for larger ones.

template <class T>
std::string_view bytes_of(std::span<const T> values) {
  return {reinterpret_cast<const char*>(values.data()), values.size_bytes()};
}

void put(std::string& out, uint64_t value, size_t bytes) {
  for (size_t i = 0; i < bytes; ++i) out += static_cast<char>(value >> (8 * i));
}

// What stands before the values of an array. Its length is a multiple of 64, as numpy wants it.
std::string npy_head(const std::string& type, const std::vector<size_t>& shape) {
  std::string facts = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({}{}), }}",
                                  type, fmt::join(shape, ", "), shape.size() == 1 ? "," : "");
  constexpr size_t kFixed = 10;
  facts.append(63 - (kFixed + facts.size()) % 64, ' ');
  facts += '\n';
  std::string head("\x93NUMPY\x01\x00", 8);
  put(head, facts.size(), 2);
  return head + facts;
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

void NpzWriter::write(std::string_view bytes) {
  written_ += bytes.size();
  if (written_ > kMostBytes)
    throw InputError(
        fmt::format("{}: an episode of more than 4 GiB cannot be written: leave frames "
                    "out, or record shorter runs",
                    file_.path().string()));
  file_.write(bytes);
}

void NpzWriter::add_array(const std::string& name, const std::string& type,
                          const std::vector<size_t>& shape, std::string_view bytes) {
  const std::string head = npy_head(type, shape);
  const auto crc_of = [](uLong before, std::string_view part) {
    return crc32_z(before, reinterpret_cast<const Bytef*>(part.data()), part.size());
  };
  if (bytes.size() > kMostBytes) write(bytes);  // Throws.
  Entry entry{name + ".npy", static_cast<uint32_t>(crc_of(crc_of(0, head), bytes)),
              static_cast<uint32_t>(head.size() + bytes.size()), static_cast<uint32_t>(written_)};
  std::string local = "PK\x03\x04";
  put_entry(local, entry.crc, entry.size, entry.name);
  write(local + entry.name + head);
  write(bytes);
  entries_.push_back(std::move(entry));
}

void NpzWriter::add(const std::string& name, const std::vector<size_t>& shape,
                    std::span<const double> values) {
  add_array(name, "<f8", shape, bytes_of(values));
}

void NpzWriter::add(const std::string& name, const std::vector<size_t>& shape,
                    std::span<const int64_t> values) {
  add_array(name, "<i8", shape, bytes_of(values));
}

void NpzWriter::add(const std::string& name, const std::vector<size_t>& shape,
                    std::span<const uint8_t> values) {
  add_array(name, "|u1", shape, bytes_of(values));
}

void NpzWriter::add(const std::string& name, const std::vector<std::string>& texts) {
  size_t width = 1;
  for (const std::string& text : texts) width = std::max(width, text.size());
  std::string bytes;
  for (const std::string& text : texts) {
    for (size_t i = 0; i < width; ++i)
      put(bytes, i < text.size() ? static_cast<unsigned char>(text[i]) : 0, 4);
  }
  add_array(name, fmt::format("<U{}", width), {texts.size()}, bytes);
}

void NpzWriter::finish() {
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
  file_.commit();
}

}  // namespace seam::app
