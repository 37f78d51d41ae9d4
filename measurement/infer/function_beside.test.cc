#include "measurement/infer/function_beside.h"

#include <gtest/gtest.h>

#include <Eigen/QR>

#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd drawn_matrix(Index rows, Index cols, uint64_t stream) {
  MatrixXd m(rows, cols);
  for (Index i = 0; i < m.size(); ++i) m.data()[i] = normal({11, stream}, static_cast<uint64_t>(i));
  return m;
}

// 80 scalars in four parts of two channels; each column is of one channel.
struct TwoChannels {
  PartsOfScalars parts{{0, 20, 40, 60, 80}, {0, 10, 20, 30, 40, 50, 60, 70, 80}};
  MatrixXd columns = drawn_matrix(80, 6, 1);
  std::shared_ptr<const MatrixXd> span;
  VectorXd smoother = VectorXd::LinSpaced(6, 1, 0.2);

  TwoChannels() {
    for (Index i = 0; i < 80; ++i) {
      for (Index k = 0; k < 6; ++k) {
        if (i / 10 % 2 != k % 2) columns(i, k) = 0;
      }
    }
    const MatrixXd q = Eigen::HouseholderQR<MatrixXd>(drawn_matrix(80, 3, 2)).householderQ() *
                       MatrixXd::Identity(80, 3);
    span = std::make_shared<const MatrixXd>(q);
  }
  VectorXd rest_of(const VectorXd& coefficients) const {
    const VectorXd all = columns * coefficients + drawn_matrix(80, 1, 3);
    const auto fitted = span->leftCols(2);
    return all - fitted * (fitted.transpose() * all);
  }
};

// The last column of the span comes along with the function.
TEST(FunctionBeside, ItsEvidenceIsThatOfColumnsWithoutWhatFollowsThem) {
  const TwoChannels set;
  const VectorXd rest = set.rest_of(2 * VectorXd::Ones(6));
  FunctionBeside function(set.parts, set.span, 1, set.columns, set.smoother);
  ASSERT_TRUE(function.is_testable());
  const double gain = function.look(set.columns, rest, 4.6);

  const MatrixXd own = set.columns - *set.span * (set.span->transpose() * set.columns);
  const VectorXd right = own.transpose() * rest;
  const MatrixXd gram = own.transpose() * own;
  RandomEffect best = RandomCoefficients(gram, VectorXd::Ones(6)).effect(right);
  const RandomEffect smooth = RandomCoefficients(gram, set.smoother).effect(right);
  if (smooth.log_evidence > best.log_evidence) best = smooth;
  const auto named = set.span->rightCols(1);
  const VectorXd beside = rest - named * (named.transpose() * rest);
  const double along = 0.5 * (rest.squaredNorm() - beside.squaredNorm()) - 0.5 * std::log(80.0);
  EXPECT_NEAR(gain, best.log_evidence + std::max(0.0, along), 1e-6);
  EXPECT_GT(gain, 20);
  EXPECT_LT((function.left_of(set.columns, rest) - (beside - own * best.coefficients)).norm(),
            1e-8);
}

TEST(FunctionBeside, OfNoiseGainsNothing) {
  const TwoChannels set;
  FunctionBeside function(set.parts, set.span, 1, set.columns, set.smoother);
  EXPECT_LT(function.look(set.columns, set.rest_of(VectorXd::Zero(6)), 4.6), 4.6);
}

// What one part alone shows is not predicted from the others.
TEST(FunctionBeside, AskedOfEachPartByTheOthers) {
  TwoChannels set;
  VectorXd rest = VectorXd::Zero(80);
  rest.head(20) = 5 * set.columns.topRows(20) * VectorXd::Ones(6);
  rest.segment(20, 20) = -5 * set.columns.middleRows(20, 20) * VectorXd::Ones(6);
  FunctionBeside function(set.parts, std::make_shared<const MatrixXd>(80, 0), 0, set.columns,
                          set.smoother);
  EXPECT_EQ(function.look(set.columns, rest, 4.6), 0);
}

}  // namespace
}  // namespace seam::measurement
