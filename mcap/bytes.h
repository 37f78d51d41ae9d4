// The serialisation rules of MCAP: little-endian integers, strings and arrays behind a 32-bit
// length. The source never reads beyond its bytes: it throws Malformed instead.
#pragma once

#include <concepts>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>

namespace seam::mcap {

// A record that does not follow the specification. Readers catch it and add where it stands.
class Malformed : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class ByteSink {
 public:
  template <std::unsigned_integral T>
  void number(T value) {
    for (size_t i = 0; i < sizeof(T); ++i) {
      bytes_.push_back(static_cast<char>(static_cast<uint64_t>(value) >> (8 * i)));
    }
  }
  void raw(std::string_view bytes) { bytes_.append(bytes); }
  void text(std::string_view text) {
    number(static_cast<uint32_t>(text.size()));
    raw(text);
  }

  size_t size() const { return bytes_.size(); }
  void clear() { bytes_.clear(); }
  const std::string& bytes() const { return bytes_; }
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

class ByteSource {
 public:
  explicit ByteSource(std::string_view bytes) : rest_(bytes) {}

  template <std::unsigned_integral T>
  T number() {
    const std::string_view bytes = raw(sizeof(T));
    uint64_t value = 0;
    for (size_t i = 0; i < sizeof(T); ++i) {
      value |= static_cast<uint64_t>(static_cast<uint8_t>(bytes[i])) << (8 * i);
    }
    return static_cast<T>(value);
  }
  std::string_view raw(uint64_t size) {
    if (size > rest_.size()) {
      throw Malformed("a length of " + std::to_string(size) + " bytes, where " +
                      std::to_string(rest_.size()) + " are left");
    }
    const std::string_view taken = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return taken;
  }
  std::string_view text() { return raw(number<uint32_t>()); }
  // The elements of an array or map: a source over their bytes alone.
  ByteSource elements() { return ByteSource(text()); }

  bool empty() const { return rest_.empty(); }
  size_t left() const { return rest_.size(); }

 private:
  std::string_view rest_;
};

}  // namespace seam::mcap
