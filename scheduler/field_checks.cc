#include "scheduler/field_checks.h"

#include <bit>

namespace seam::scheduler {

uint64_t field_hash(int64_t value) {
  auto bits = static_cast<uint64_t>(value);
  bits ^= bits >> 33;
  bits *= 0xff51afd7ed558ccdULL;
  bits ^= bits >> 33;
  bits *= 0xc4ceb9fe1a85ec53ULL;
  return bits;
}

uint64_t field_hash(double value) { return field_hash(std::bit_cast<int64_t>(value == 0 ? 0.0 : value)); }

void FieldChecks::field(std::string_view, double& value) { add(field_hash(value)); }
void FieldChecks::field(std::string_view, int64_t& value) { add(field_hash(value)); }

void FieldChecks::add(uint64_t hash) {
  const auto check = static_cast<unsigned>(hash >> shift_) & 3;
  if (filled_ == 4) {
    bits_.push_back('\0');
    filled_ = 0;
  }
  bits_.back() = static_cast<char>(static_cast<uint8_t>(bits_.back()) | (check << (2 * filled_)));
  ++filled_;
}

}  // namespace seam::scheduler
