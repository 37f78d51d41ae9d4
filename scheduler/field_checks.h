// Two bits of each field's hash: too few to prove that fields are equal, which the fingerprint of
// the whole state does, but enough to name the one that differs once something does. Four steps in a
// row take other bits, so that a field that stays as it is shows up within them (all but 1 of 256).
#pragma once

#include <string>
#include <string_view>

#include "sim_core/state.h"

namespace seam::scheduler {

// MurmurHash3's finaliser of a field's 64 bits: every input bit reaches the top ones. -0.0 counts as 0.0, as in the
// hashes of sections.
uint64_t field_hash(double value);
uint64_t field_hash(int64_t value);

// Gathers the bits of the fields visited, four fields a byte, the lowest bits first.
class FieldChecks final : public StateVisitor {
 public:
  using StateVisitor::field;
  explicit FieldChecks(uint64_t step) : shift_(static_cast<int>(56 + 2 * (step % 4))) {}
  void field(std::string_view name, double& value) override;
  void field(std::string_view name, int64_t& value) override;

  const std::string& bits() const { return bits_; }

 private:
  void add(uint64_t hash);

  int shift_;
  std::string bits_;
  int filled_ = 4;  // Fields in the last byte.
};

}  // namespace seam::scheduler
