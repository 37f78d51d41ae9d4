// The orthonormal cosine transform (DCT-II) of a series and its inverse:
//   c_0 = sum y_i / sqrt(n),  c_k = sqrt(2 / n) sum y_i cos(pi k (i + 1/2) / n)
// A length with large prime factors takes long: see `quick_length`.
#pragma once

#include <cstddef>
#include <vector>

namespace seam::measurement {

std::vector<double> cosine_transform(const std::vector<double>& series);
std::vector<double> inverse_cosine_transform(const std::vector<double>& coefficients);

// The largest number up to n whose prime factors are 2, 3 and 5; n is 1 at least.
size_t quick_length(size_t n);

}  // namespace seam::measurement
