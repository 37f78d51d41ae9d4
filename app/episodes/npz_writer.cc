// The format of an array: numpy.lib.format (npy).
#include "app/episodes/npz_writer.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <bit>

namespace seam::app {

namespace {

static_assert(std::endian::native == std::endian::little);

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

}  // namespace

NpzWriter::NpzWriter(const std::filesystem::path& file)
    : file_(file),
      zip_([this](std::string_view bytes) { file_.write(bytes); },
           fmt::format("{}: an episode of more than 4 GiB cannot be written: leave frames out, or "
                       "record shorter runs",
                       file.string())) {}

void NpzWriter::add_array(const std::string& name, const std::string& type,
                          const std::vector<size_t>& shape, std::string_view bytes) {
  zip_.add(name + ".npy", npy_head(type, shape), bytes);
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
  zip_.finish();
  file_.commit();
}

}  // namespace seam::app
