#include "sim_core/base/hash.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <array>

namespace seam {

Hasher::Hasher() : state_(XXH3_createState()) {
  XXH3_64bits_reset(state_.get());
}
Hasher::~Hasher() = default;
Hasher::Hasher(Hasher&&) noexcept = default;
Hasher& Hasher::operator=(Hasher&&) noexcept = default;

void Hasher::Free::operator()(XXH3_state_s* state) const {
  XXH3_freeState(state);
}

void Hasher::add(uint64_t value) {
  std::array<uint8_t, 8> bytes;
  for (int i = 0; i < 8; ++i) bytes[i] = static_cast<uint8_t>(value >> (8 * i));
  XXH3_64bits_update(state_.get(), bytes.data(), bytes.size());
}

void Hasher::add(std::string_view text) {
  add(static_cast<uint64_t>(text.size()));
  XXH3_64bits_update(state_.get(), text.data(), text.size());
}

void Hasher::add_bytes(std::span<const uint8_t> bytes) {
  add(static_cast<uint64_t>(bytes.size()));
  XXH3_64bits_update(state_.get(), bytes.data(), bytes.size());
}

uint64_t Hasher::digest() const {
  return XXH3_64bits_digest(state_.get());
}

std::string to_hex(uint64_t fingerprint) {
  return fmt::format("{:016x}", fingerprint);
}

}  // namespace seam
