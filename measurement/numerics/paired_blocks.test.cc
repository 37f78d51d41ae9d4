// The solver of views and points beside the same equations written out as one dense matrix.
#include "measurement/numerics/paired_blocks.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <ostream>

#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

struct Case {
  std::vector<Index> views;
  size_t points;

  friend void PrintTo(const Case& c, std::ostream* out) {
    *out << c.views.size() << " views of " << c.points << " points";
  }
};

class PairedBlocksOf : public testing::TestWithParam<Case> {};

TEST_P(PairedBlocksOf, AgreeWithOneDenseMatrix) {
  const Case& c = GetParam();
  PairedBlocks blocks(c.views, c.points);
  const Index first_point = blocks.view_unknowns(), n = first_point + blocks.point_unknowns();
  MatrixXd dense = MatrixXd::Zero(n, n);
  uint64_t draw = 0;
  const auto random = [&](Index rows, Index cols) {
    MatrixXd m(rows, cols);
    for (Index i = 0; i < m.size(); ++i) m(i) = normal({.seed = 5, .stream = 2}, draw++);
    return m;
  };
  for (size_t v = 0; v < c.views.size(); ++v) {
    for (size_t p = 0; p < c.points; ++p) {
      if ((v + 2 * p) % 5 == 0) continue;  // Not every view sees every point.
      for (int again = 0; again < (p == 1 ? 2 : 1); ++again) {
        // Of a view's many unknowns each observation hangs on a few.
        const Index count = std::min<Index>(c.views[v], 7);
        const Index from = static_cast<Index>(p + again) % (c.views[v] - count + 1);
        const MatrixXd by_view = random(2, count), by_point = random(2, 3);
        blocks.add(v, from, by_view, p, by_point);
        MatrixXd row = MatrixXd::Zero(2, n);
        row.middleCols(blocks.view_at(v) + from, count) = by_view;
        row.middleCols(first_point + 3 * static_cast<Index>(p), 3) = by_point;
        dense += row.transpose() * row;
      }
    }
    for (Index i = 0; i < c.views[v]; ++i) {
      blocks.add_prior(v, i, 0.5);
      dense(blocks.view_at(v) + i, blocks.view_at(v) + i) += 0.5;
    }
  }
  for (size_t p = 0; p < c.points; ++p) {
    const MatrixXd half = random(3, 3);
    const Eigen::Matrix3d prior = half * half.transpose() + Eigen::Matrix3d::Identity();
    blocks.add_prior(p, prior);
    dense.block(first_point + 3 * static_cast<Index>(p), first_point + 3 * static_cast<Index>(p), 3,
                3) += prior;
  }
  const MatrixXd right = random(n, 2);
  MatrixXd views = right.topRows(first_point), points = right.bottomRows(n - first_point);
  ASSERT_TRUE(blocks.factor(0));
  blocks.solve(views, points);
  const MatrixXd expected = dense.fullPivLu().solve(right);
  EXPECT_LT((views - expected.topRows(first_point)).norm(), 1e-9 * expected.norm());
  EXPECT_LT((points - expected.bottomRows(n - first_point)).norm(), 1e-9 * expected.norm());
  EXPECT_NEAR(blocks.log_det(), std::log(dense.fullPivLu().determinant()), 1e-8);
  const MatrixXd inverse = dense.inverse();
  const auto covariances = blocks.point_covariances();
  for (size_t p = 0; p < c.points; ++p) {
    const Index at = first_point + 3 * static_cast<Index>(p);
    EXPECT_LT((covariances[p] - inverse.block(at, at, 3, 3)).norm(), 1e-9 * inverse.norm());
  }
  const auto of_views = blocks.view_covariances();
  for (size_t v = 0; v < c.views.size(); ++v) {
    const Index at = blocks.view_at(v), size = c.views[v];
    ASSERT_EQ(of_views[v].rows(), size);
    EXPECT_LE((of_views[v] - inverse.block(at, at, size, size)).norm(), 1e-9 * inverse.norm());
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes, PairedBlocksOf,
                         testing::Values(Case{{7, 6, 0, 7}, 20},          // Points are eliminated,
                                         Case{{7, 7, 6, 7, 0, 7, 6}, 3},  // or views.
                                         Case{{1, 1, 1}, 4}, Case{{0, 0}, 5}, Case{{24, 12}, 30},
                                         Case{{30, 9}, 6}));

TEST(PairedBlocks, SaysWhereUnknownsAreNotDetermined) {
  PairedBlocks blocks({2}, 0);
  EXPECT_FALSE(blocks.factor(0));
}

}  // namespace
}  // namespace seam::measurement
