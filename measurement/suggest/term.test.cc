#include "measurement/suggest/term.h"

#include <gtest/gtest.h>

#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

TEST(FormulaText, HasASumForEachOutput) {
  const Term wave{.pieces = {{"u", "@"}},
                  .curve = Curve::wave,
                  .variable = "t",
                  .numbers = {2 * maths::kPi / 1.2, -0.3},
                  .coefficient = 0.31};
  const Term turn{.pieces = {{"u", "(cy - v) * t"}, {"v", "(u - cx) * t"}}, .coefficient = -0.02};
  const Term shift{.pieces = {{"v", "1"}}, .coefficient = 1.5};
  EXPECT_EQ(formula_text({wave, turn, shift}),
            "u: 0.31 * sin(2 * pi * t / 1.2 - 0.3) - 0.02 * (cy - v) * t, "
            "v: -0.02 * (u - cx) * t + 1.5");
}

}  // namespace
}  // namespace seam::measurement
