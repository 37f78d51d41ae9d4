#include "scheduler/field_checks.h"

#include <bit>

namespace seam::scheduler {

void FieldChecks::field(std::string_view, double& value) {
  add(std::bit_cast<uint64_t>(value == 0 ? 0.0 : value));  // -0.0 counts as 0.0, as in hashes.
}

void FieldChecks::field(std::string_view, int64_t& value) { add(static_cast<uint64_t>(value)); }

void FieldChecks::add(uint64_t value) {
  // The finaliser of MurmurHash3: every input bit reaches the top ones.
  value ^= value >> 33;
  value *= 0xff51afd7ed558ccdULL;
  value ^= value >> 33;
  value *= 0xc4ceb9fe1a85ec53ULL;
  const auto check = static_cast<unsigned>(value >> shift_) & 3;
  if (filled_ == 4) {
    bits_.push_back('\0');
    filled_ = 0;
  }
  bits_.back() = static_cast<char>(static_cast<uint8_t>(bits_.back()) | (check << (2 * filled_)));
  ++filled_;
}

}  // namespace seam::scheduler
