#include "measurement/imaging/converter_steps.h"

#include <gtest/gtest.h>

namespace seam::measurement {
namespace {

// Every value that a converter of so many bits gives, as a file of 8 bits holds it.
std::vector<uint16_t> values_of(int bits) {
  std::vector<uint16_t> values;
  const int step = 1 << (8 - bits);
  for (int k = 0; k <= 1 << bits; ++k)
    values.push_back(static_cast<uint16_t>(std::min(k * step, 255)));
  return values;
}

TEST(ConverterSteps, FewestBitsAreThoseOfTheConverter) {
  for (int bits = 1; bits <= 8; ++bits)
    EXPECT_EQ(fewest_bits({values_of(bits), values_of(1)}, 8), bits);
  EXPECT_EQ(fewest_bits({{0, 0, 255}}, 8), 1);
}

TEST(ConverterSteps, StraysDoNotCount) {
  std::vector<uint16_t> values(1000, 64);
  values[3] = 33, values[500] = 7;
  EXPECT_EQ(fewest_bits({values}, 8), 2);
  std::fill_n(values.begin(), 20, 65);
  EXPECT_EQ(fewest_bits({values}, 8), 8);
}

}  // namespace
}  // namespace seam::measurement
