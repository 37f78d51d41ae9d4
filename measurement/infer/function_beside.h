// A smooth function beside an explanation: the evidence for it in residuals that the explanation
// leaves. Its columns count without what the explanation's parameters can follow of them; they are
// given anew each time, since those of all functions together would fill the memory.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "measurement/infer/random_effect.h"

namespace seam::measurement {

// Of the scalars that take part: in parts, each of which is predicted from the others, and in these
// by channel, since most columns are of one channel alone.
struct PartsOfScalars {
  static constexpr int kCount = 4;
  std::vector<Eigen::Index> begin_of_part;     // Of each part, then the end.
  std::vector<Eigen::Index> begin_of_segment;  // Of each channel of each part, then the end.

  auto rows(const auto& matrix, int part) const {
    return matrix.middleRows(begin_of_part[part], begin_of_part[part + 1] - begin_of_part[part]);
  }
};

class FunctionBeside {
 public:
  // Of no function.
  FunctionBeside() = default;
  // `span`: an orthonormal basis of what the parameters follow; its last columns, so many as
  // `named`, are what effects with names do that come along with the function.
  FunctionBeside(const PartsOfScalars& parts, std::shared_ptr<const Eigen::MatrixXd> span,
                 Eigen::Index named, const Eigen::MatrixXd& columns,
                 const Eigen::VectorXd& smoother);

  bool is_testable() const { return !priors_.empty(); }
  // What the function, and the effects that come along, gain of these residuals in log-evidence; 0
  // where that is not more than `least`, or where parts are not predicted from each other.
  double look(const Eigen::MatrixXd& columns, const Eigen::VectorXd& rest, double least);
  double log_evidence() const { return log_evidence_; }
  // The residuals without what it takes, where they were last looked at.
  Eigen::VectorXd left_of(const Eigen::MatrixXd& columns, const Eigen::VectorXd& rest) const;

 private:
  static constexpr int kParts = PartsOfScalars::kCount;
  Eigen::VectorXd beside_named(const Eigen::VectorXd& rest) const;
  double held_out_gain(const std::array<Eigen::VectorXd, kParts>& right_of_part) const;

  const PartsOfScalars* parts_ = nullptr;
  std::shared_ptr<const Eigen::MatrixXd> span_;
  Eigen::Index named_ = 0;
  Eigen::MatrixXd followed_, gram_;  // The columns along the span; what is left of them, squared.
  std::array<Eigen::MatrixXd, kParts> gram_of_part_;
  std::vector<RandomCoefficients> priors_;  // As rough and as smooth as FieldColumns has them.
  RandomEffect effect_;
  double log_evidence_ = 0;
};

}  // namespace seam::measurement
