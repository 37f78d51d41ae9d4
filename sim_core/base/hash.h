// Fingerprints of state and frames: XXH3-64 over the canonical bytes of fields (little-endian,
// fixed width, stated order), never over padded structs, text or Protocol Buffers bytes.
#pragma once

#include <bit>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

struct XXH3_state_s;

namespace seam {

class Hasher {
 public:
  Hasher();
  ~Hasher();
  Hasher(Hasher&&) noexcept;
  Hasher& operator=(Hasher&&) noexcept;

  void add(uint64_t value);
  void add(int64_t value) { add(static_cast<uint64_t>(value)); }
  // -0.0 counts as 0.0, so that equal states have equal hashes.
  void add(double value) { add(std::bit_cast<uint64_t>(value == 0 ? 0.0 : value)); }
  // The length first, then the bytes.
  void add(std::string_view text);
  void add_bytes(std::span<const uint8_t> bytes);

  uint64_t digest() const;

 private:
  struct Free {
    void operator()(XXH3_state_s* state) const;
  };
  std::unique_ptr<XXH3_state_s, Free> state_;
};

// 16 lower-case hexadecimal digits.
std::string to_hex(uint64_t fingerprint);

}  // namespace seam
