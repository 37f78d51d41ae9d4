// Whitening of residuals whose errors hang together: hidden errors that wander (Ornstein-Uhlenbeck,
// any time steps), last, or are new at each time, each shared by some of the residuals. S is their
// covariance and the residuals' own variance; a Kalman filter gives L^-1 r with S = L L' and
// log det S in time that grows as the number of residuals, without S itself.
//
// Hidden errors are independent of each other. Residuals that share none, directly or through
// others, are filtered apart, so that a landmark's ranges cost nothing more where others are seen
// beside it.
#pragma once

#include <limits>
#include <span>
#include <vector>

#include "measurement/noise/few_errors.h"
#include "measurement/problem/problem.h"

namespace seam::measurement {

inline constexpr double kLasting =
    std::numeric_limits<double>::infinity();  // A memory without end.

class HiddenErrors {
 public:
  // What a residual has of a hidden error.
  struct Share {
    int hidden = 0;
    double slope = 1;
  };

  // What was learnt of a hidden error that lasts.
  struct Learnt {
    double mean = 0;
    double variance = 0;
    double with_next = 0;  // Covariance with the one that was added after it.
  };

  // A hidden error; tau_s 0: new at each time. Its first value has this variance, too.
  int add(double variance, double tau_s);

  // A residual, in order of time among those with which it shares hidden errors. `shape`: of its
  // own error, where that is not normal alone. `same_lot`: it has something more if the one that
  // was observed before it has (the other coordinate of a point).
  void observe(size_t scalar, double time_s, std::span<const Share> shares,
               const FewErrors* shape = nullptr, bool same_lot = false);

  // Takes residuals and sigmas of their own (whitened by these already, as whiten_diagonal leaves
  // them); whitens those that are used, adds what is missing to their group's log det, and to the
  // sigmas of all.
  void whiten(const Facts& facts, Evaluation& evaluation) const { learn(facts, evaluation); }
  // Does so, and returns by hidden error what all residuals say of it.
  std::vector<Learnt> learn(const Facts& facts, Evaluation& evaluation) const;

 private:
  struct Hidden {
    double variance = 0;
    double tau_s = 0;
  };
  struct Observed {
    size_t scalar = 0;
    double time_s = 0;
    size_t first = 0, last = 0;  // Of its shares.
    const FewErrors* shape = nullptr;
    bool same_lot = false;
  };
  struct Part;  // Of hidden errors and residuals that hang together.

  // `place` of each hidden error in its part.
  std::vector<Part> parts(std::vector<int>& place) const;
  void filter(const Part& part, const std::vector<int>& place, const Facts& facts,
              Evaluation& evaluation, std::vector<Learnt>& learnt) const;

  std::vector<Hidden> hidden_;
  std::vector<Observed> observed_;
  std::vector<Share> shares_;
};

}  // namespace seam::measurement
