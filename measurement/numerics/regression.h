// Nested regressions for tests of structure.
#pragma once

#include <vector>

namespace seam::measurement {

struct NestedTest {
  double p_value = 1;
  double explained = 0;  // Sum of squares that the extra columns explain beyond the null ones.
  double rms = 0;        // Root mean square of that, less what noise alone would explain.
  int extra = 0;         // Columns that the data can tell apart.
};

// F-test of `y` on the null columns against null and extra columns. `lost` degrees of freedom were
// used up before (fitted parameters and nuisances).
NestedTest nested_test(const std::vector<double>& y,
                       const std::vector<std::vector<double>>& null_columns,
                       const std::vector<std::vector<double>>& extra_columns, double lost);

// The same for group means: `label` numbers the groups.
NestedTest category_test(const std::vector<double>& y, const std::vector<int>& label, double lost);

// P(F > f) with these degrees of freedom; P(chi2 > x); two-sided P(|normal| > z).
double f_tail(double f, double numerator, double denominator);
double chi2_tail(double x, double freedom);
double normal_tail(double z);
// What chi2 is below with the probability that a normal score has to be below this many sigmas, to
// a few per cent (Wilson and Hilferty 1931).
double chi2_at(double sigmas, double freedom);
// The p-value of one look among so many; one too small to be told stays the smallest, 1e-300.
double corrected(double p, double looks);

// Standard normal scores of the ranks.
std::vector<double> normal_scores(const std::vector<double>& values);

}  // namespace seam::measurement
