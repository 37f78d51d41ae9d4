// Errors of which a few are far larger than the others: a normal error, and with some probability
// something more. What takes the place of a whitened residual is z = sign sqrt(2 (l_max - l)), l
// being the log-likelihood of the residual: half its square is what the residual costs, as with a
// normal error, so that fits, scores and tests need not know the difference.
#pragma once

#include <vector>

namespace seam::measurement {

// A log-density and its derivatives by the error.
struct LogDensity {
  double value = 0;
  double slope = 0;
  double curvature = 0;
};

struct Deviance {
  double z = 0;
  double log_det = 0;  // So that -(z^2 + log 2 pi + log_det) / 2 is the log-likelihood.
};

// Of one evaluation: it keeps what it worked out, and is not for several threads.
class FewErrors {
 public:
  enum class Sort {
    exponential,  // Too large by an exponential of mean `size`.
    normal,       // A further normal error of sigma `size`.
  };

  FewErrors(Sort sort, double fraction, double size)
      : sort_(sort), fraction_(fraction), size_(size) {}

  // Of an error whose normal part has this sigma; `fraction` may differ from that of all errors (a
  // point whose other coordinate is known).
  LogDensity at(double error, double sigma, double fraction) const;
  LogDensity at(double error, double sigma) const { return at(error, sigma, fraction_); }
  Deviance deviance(double error, double sigma, double fraction) const;
  Deviance deviance(double error, double sigma) const { return deviance(error, sigma, fraction_); }
  // The likeliest error.
  double mode(double sigma) const;
  // Mean of z, which is 0 where errors lie on both sides alike.
  double mean(double sigma) const;
  // Mean of z^2, which is 1 for a normal error.
  double mean_square(double sigma) const;
  // The same of an error that has something more if another, which was seen, has.
  double mean_square_of_second(double sigma) const;
  // Of the error, something more included.
  double variance(double sigma) const;
  // The probability that this error has something more.
  double share_of_more(double error, double sigma, double fraction) const;

  double fraction() const { return fraction_; }
  double size() const { return size_; }

 private:
  struct Place {
    double mode = 0, mean = 0, mean_square = 0, mean_square_of_second = 0;
  };

  // Density of the part with something more, in units of sigma; `ratio` is size / sigma.
  LogDensity more(double x, double ratio) const;
  double mode_of(double ratio, double fraction) const;
  double width(double ratio) const;
  double mean_of(double ratio, double fraction, double step) const;
  // Of errors with this fraction; `step` of the integral over the normal part, in sigmas.
  double mean_square_of(double ratio, double fraction, double step) const;
  double mean_square_of_second_of(double ratio) const;
  Place place(double sigma, bool second) const;

  Sort sort_;
  double fraction_ = 0;
  double size_ = 0;
  mutable std::vector<Place> table_;
};

}  // namespace seam::measurement
