#include "scheduler/log/field_checks.h"

namespace seam::scheduler {

std::string field_checks(std::span<const int64_t> words, uint64_t step) {
  const int shift = static_cast<int>(56 + 2 * (step % 4));
  std::string bits((words.size() + 3) / 4, '\0');
  for (size_t i = 0; i < words.size(); ++i) {
    const auto check = static_cast<unsigned>(field_hash(words[i]) >> shift) & 3;
    bits[i / 4] = static_cast<char>(static_cast<uint8_t>(bits[i / 4]) | (check << (2 * (i % 4))));
  }
  return bits;
}

}  // namespace seam::scheduler
