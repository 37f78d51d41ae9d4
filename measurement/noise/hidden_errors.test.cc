// The filter against dense covariances, whose determinants and quadratic forms Eigen works out.
#include "measurement/noise/hidden_errors.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "measurement/noise/draw.h"

namespace seam::measurement {
namespace {

constexpr RandomStream kStream{.seed = 15, .stream = 4};

struct Track {
  std::vector<double> time_s, own;
  std::vector<std::vector<HiddenErrors::Share>> shares;
};

struct Kept {
  double variance, tau_s;
};

// Residuals at uneven times, three at some of them, each with one or two of the hidden errors.
Track uneven(size_t n, int hidden) {
  Track track;
  double t = 0;
  for (size_t i = 0; i < n; ++i) {
    if (i % 3 != 1) t += 2 * uniform(kStream.child("step"), i);
    track.time_s.push_back(t);
    track.own.push_back(0.2 + uniform(kStream.child("own"), i));
    std::vector<HiddenErrors::Share> shares;
    for (int h = 0; h < hidden; ++h) {
      if (uniform(kStream.child("has").child(h), i) < 0.6)
        shares.push_back({h, normal(kStream.child("slope").child(h), i)});
    }
    track.shares.push_back(shares);
  }
  return track;
}

Facts facts_of(size_t n) {
  Facts facts;
  facts.groups = {"all"};
  facts.channels = {{.name = "y"}};
  for (size_t i = 0; i < n; ++i) {
    facts.line_of_row.push_back(static_cast<int>(i));
    facts.group_of_row.push_back(0);
    facts.row_of.push_back(static_cast<int>(i));
    facts.channel_of.push_back(0);
  }
  return facts;
}

Eigen::MatrixXd dense(const Track& track, const std::vector<Kept>& hidden) {
  const auto n = static_cast<Eigen::Index>(track.time_s.size());
  Eigen::MatrixXd S = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    S(i, i) += track.own[i] * track.own[i];
    for (Eigen::Index k = 0; k < n; ++k) {
      const double lag = std::abs(track.time_s[i] - track.time_s[k]);
      for (const auto& a : track.shares[i]) {
        for (const auto& b : track.shares[k]) {
          if (a.hidden != b.hidden) continue;
          const Kept& h = hidden[a.hidden];
          const double left = lag == 0 ? 1 : h.tau_s > 0 ? std::exp(-lag / h.tau_s) : 0;
          S(i, k) += a.slope * b.slope * h.variance * left;
        }
      }
    }
  }
  return S;
}

Evaluation evaluation_of(const Track& track, const std::vector<double>& residual) {
  Evaluation e;
  e.used.assign(residual.size(), 1);
  e.residual = residual;
  e.sigma = track.own;
  e.log_det = {0};
  for (size_t i = 0; i < residual.size(); ++i) {
    e.whitened.push_back(residual[i] / track.own[i]);
    e.log_det[0] += 2 * std::log(track.own[i]);
  }
  return e;
}

HiddenErrors errors_of(const Track& track, const std::vector<Kept>& hidden) {
  HiddenErrors errors;
  for (const Kept& h : hidden) errors.add(h.variance, h.tau_s);
  for (size_t i = 0; i < track.time_s.size(); ++i)
    errors.observe(i, track.time_s[i], track.shares[i]);
  return errors;
}

void expect_dense(const std::vector<Kept>& hidden, size_t n) {
  const Track track = uneven(n, static_cast<int>(hidden.size()));
  std::vector<double> residual;
  for (size_t i = 0; i < n; ++i) residual.push_back(2 * normal(kStream.child("r"), i));
  Evaluation e = evaluation_of(track, residual);
  errors_of(track, hidden).whiten(facts_of(n), e);
  const Eigen::MatrixXd S = dense(track, hidden);
  const Eigen::LLT<Eigen::MatrixXd> llt(S);
  const Eigen::Map<const Eigen::VectorXd> r(residual.data(), static_cast<Eigen::Index>(n));
  double log_det = 0, square = 0;
  for (Eigen::Index i = 0; i < S.rows(); ++i) log_det += 2 * std::log(llt.matrixL()(i, i));
  for (const double z : e.whitened) square += z * z;
  EXPECT_NEAR(e.log_det[0], log_det, 1e-9 * n);
  EXPECT_NEAR(square, r.dot(llt.solve(r)), 1e-9 * n);
  for (size_t i = 0; i < n; ++i)
    EXPECT_NEAR(e.sigma[i],
                std::sqrt(S(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i))), 1e-12);
}

TEST(HiddenErrors, AgreeWithDenseCovariances) {
  expect_dense({}, 5);
  expect_dense({{0.5, 1.5}}, 80);
  expect_dense({{0.5, 1.5}, {2, kLasting}, {0.3, 0}}, 120);
  expect_dense({{4, 0.02}, {0.1, 300}, {1, 2}, {1, 2}, {0.7, kLasting}}, 150);
}

// Residuals that are left out tell nothing and change nothing.
TEST(HiddenErrors, LeaveOutWhatIsNotUsed) {
  const std::vector<Kept> hidden = {{0.5, 1.5}, {2, kLasting}};
  const size_t n = 60;
  const Track track = uneven(n, 2);
  std::vector<double> residual;
  for (size_t i = 0; i < n; ++i) residual.push_back(normal(kStream.child("r"), i));
  Evaluation some = evaluation_of(track, residual);
  Track fewer;
  std::vector<double> fewer_residual;
  for (size_t i = 0; i < n; ++i) {
    if (i % 4 == 2) {
      some.used[i] = 0, some.log_det[0] -= 2 * std::log(track.own[i]);
      continue;
    }
    fewer.time_s.push_back(track.time_s[i]), fewer.own.push_back(track.own[i]);
    fewer.shares.push_back(track.shares[i]), fewer_residual.push_back(residual[i]);
  }
  Evaluation other = evaluation_of(fewer, fewer_residual);
  errors_of(track, hidden).whiten(facts_of(n), some);
  errors_of(fewer, hidden).whiten(facts_of(fewer.own.size()), other);
  EXPECT_NEAR(some.log_det[0], other.log_det[0], 1e-9);
  size_t at = 0;
  for (size_t i = 0; i < n; ++i) {
    if (some.used[i]) {
      EXPECT_NEAR(some.whitened[i], other.whitened[at++], 1e-12);
    }
  }
}

// What is drawn has the covariance that is whitened: squares of whitened errors have mean 1, and
// neighbours do not agree.
TEST(HiddenErrors, WhitenWhatIsDrawn) {
  const size_t n = 40000;
  const effects::Wander wander{.sigma = 0.7, .tau_s = 3};
  Track track;
  double t = 0;
  std::vector<size_t> rows;
  for (size_t i = 0; i < n; ++i) {
    t += -0.5 * std::log(uniform(kStream.child("gap"), i));
    track.time_s.push_back(t), track.own.push_back(0.3), track.shares.push_back({{0, 1}});
    rows.push_back(i);
  }
  std::vector<double> residual;
  for (size_t i = 0; i < n; ++i) residual.push_back(0.3 * normal(kStream.child("white"), i));
  add_wander(wander, track.time_s, rows, kStream.child("wander"), residual);
  Evaluation e = evaluation_of(track, residual);
  errors_of(track, {{0.49, 3}}).whiten(facts_of(n), e);
  double square = 0, neighbours = 0, plain = 0;
  for (size_t i = 0; i < n; ++i) {
    square += e.whitened[i] * e.whitened[i] / n;
    if (i > 0) neighbours += e.whitened[i] * e.whitened[i - 1] / n;
    if (i > 0) plain += residual[i] * residual[i - 1] / n;
  }
  const double error = 1 / std::sqrt(static_cast<double>(n));
  EXPECT_NEAR(square, 1, 4 * std::sqrt(2.0) * error);
  EXPECT_NEAR(neighbours, 0, 4 * error);
  // An exponential gap of mean 0.5 leaves 1 / (1 + 0.5 / 3) of the covariance.
  EXPECT_NEAR(plain, 0.49 / (1 + 0.5 / 3), 0.03);
}

}  // namespace
}  // namespace seam::measurement
