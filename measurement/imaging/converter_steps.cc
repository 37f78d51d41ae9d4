#include "measurement/imaging/converter_steps.h"

#include <algorithm>
#include <bit>

namespace seam::measurement {

int fewest_bits(const std::vector<std::vector<uint16_t>>& images, int file_bits) {
  constexpr double kStrays = 0.01;
  const uint32_t top = (1u << file_bits) - 1;
  std::vector<size_t> by_zeros(static_cast<size_t>(file_bits) + 1,
                               0);  // Values by their trailing binary zeros.
  size_t all = 0;
  for (const auto& image : images) {
    for (const uint16_t value : image) {
      const int zeros = value == 0 || value == top ? file_bits : std::countr_zero(value);
      ++by_zeros[static_cast<size_t>(std::min(zeros, file_bits))];
    }
    all += image.size();
  }
  int bits = file_bits;
  size_t finer = 0;  // Values that are no multiples of the step of one bit less.
  while (bits > 1) {
    finer += by_zeros[static_cast<size_t>(file_bits - bits)];
    if (static_cast<double>(finer) > kStrays * static_cast<double>(all)) break;
    --bits;
  }
  return bits;
}

}  // namespace seam::measurement
