#include "measurement/kinds/odometry/rolled_way.h"

#include <Eigen/LU>
#include <algorithm>
#include <boost/math/quadrature/gauss.hpp>
#include <cmath>
#include <numbers>

namespace seam::measurement {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

Matrix2d moved(double dt_s) {
  Matrix2d F;
  F << 1, dt_s, 0, 1;
  return F;
}

// Covariance of what jolts add to way and speed.
Matrix2d jolted(double jolt, double dt_s) {
  const double across = jolt * dt_s * dt_s / 2;
  Matrix2d Q;
  Q << jolt * dt_s * dt_s * dt_s / 3, across, across, jolt * dt_s;
  return Q;
}

// A normal error within half a tick of `count`.
struct Bounded {
  double mean = 0, variance = 0, log_chance = 0;
};

Bounded bounded(double mean, double variance, double count) {
  const double low = count - 0.5 - mean, high = count + 0.5 - mean;  // About the mean.
  // Where the density is highest, and how far from there it counts: some sigmas, or less where
  // it falls steeply.
  constexpr double kFar = 6;
  const double sigma = std::sqrt(variance), top = std::clamp(0.0, low, high);
  const double steepness = std::abs(top) / sigma;
  const double reach = sigma * 2 * kFar * kFar / (steepness + std::hypot(steepness, 2 * kFar));
  const double from = std::max(low, top - reach), to = std::min(high, top + reach);
  double area = 0, first = 0, second = 0;
  const auto add = [&](double place, double weight) {
    const double x = 0.5 * ((to - from) * place + from + to);
    const double density = weight * std::exp(0.5 * (top * top - x * x) / variance);
    area += density, first += density * (x - top), second += density * (x - top) * (x - top);
  };
  using Rule = boost::math::quadrature::gauss<double, 20>;
  for (size_t i = 0; i < Rule::abscissa().size(); ++i) {
    add(Rule::abscissa()[i], Rule::weights()[i]);
    add(-Rule::abscissa()[i], Rule::weights()[i]);
  }
  first /= area, second /= area;
  return {.mean = mean + top + first,
          .variance = second - first * first,
          .log_chance = std::log(0.5 * (to - from) * area / sigma) - 0.5 * steepness * steepness -
                        0.5 * std::log(2 * std::numbers::pi)};
}

// Way and speed as the rows so far tell them.
struct Told {
  Vector2d mean;
  Matrix2d covariance;

  void move(double jolt, double dt_s) {
    const Matrix2d F = moved(dt_s);
    mean = F * mean;
    covariance = F * covariance * F.transpose() + jolted(jolt, dt_s);
  }
  void learn(double precision, double weighted) {
    const Vector2d column = covariance.col(0);
    const double share = 1 / (1 + precision * column[0]);
    mean += share * (weighted - precision * mean[0]) * column;
    covariance -= share * precision * column * column.transpose();
  }
};

// A wheel may start anywhere within its first count, as fast as it ever goes.
Told at_first(const CountedWay& counted) {
  double fastest = 0;
  for (size_t k = 1; k < counted.ticks.size(); ++k) {
    const double rate = (std::abs(counted.ticks[k] - counted.ticks[k - 1]) + 1) /
                        (counted.time_s[k] - counted.time_s[k - 1]);
    fastest = std::max(fastest, rate);
  }
  Told told{{counted.ticks[0], 0}, Matrix2d::Zero()};
  told.covariance(0, 0) = 1, told.covariance(1, 1) = fastest * fastest;
  return told;
}

}  // namespace

// What comes after is known: the row's own is found by what all others say of its way.
void RolledWay::forward(const CountedWay& counted) {
  Told told = at_first(counted);
  for (size_t k = 0; k < time_s_.size(); ++k) {
    if (k > 0) told.move(jolt_[k], time_s_[k] - time_s_[k - 1]);
    const Message& later = later_[k];
    const Matrix2d joined = (Matrix2d::Identity() + told.covariance * later.precision).inverse();
    const Vector2d mean = joined * (told.mean + told.covariance * later.weighted);
    const Matrix2d covariance = joined * told.covariance;
    const double variance = covariance(0, 0);
    const Bounded here = bounded(mean[0], variance, counted.ticks[k]);
    sites_[k] = {.precision = std::max(0.0, 1 / here.variance - 1 / variance),
                 .weighted = here.mean / here.variance - mean[0] / variance};
    mean_[k] = here.mean;
    told.learn(sites_[k].precision, sites_[k].weighted);
    if (k > 0) continue;
    Told first{mean, covariance};
    first.learn(sites_[k].precision, sites_[k].weighted);
    at_start_ = first.covariance;
  }
}

RolledWay::Message RolledWay::from(size_t row) const {
  Message all = later_[row];
  all.precision(0, 0) += sites_[row].precision;
  all.weighted[0] += sites_[row].weighted;
  return all;
}

RolledWay::Message RolledWay::before(const Message& after, double dt_s, double jolt) {
  const Matrix2d F = moved(dt_s);
  const Matrix2d share = (Matrix2d::Identity() + after.precision * jolted(jolt, dt_s)).inverse();
  return {F.transpose() * share * after.precision * F, F.transpose() * share * after.weighted};
}

void RolledWay::backward() {
  for (size_t k = time_s_.size() - 1; k > 0; --k)
    later_[k - 1] = before(from(k), time_s_[k] - time_s_[k - 1], jolt_[k]);
}

void RolledWay::settle(const CountedWay& counted) {
  constexpr int kSweeps = 20;
  constexpr double kStill_ticks = 1e-4;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    const std::vector<double> last = mean_;
    forward(counted);
    backward();
    double change = 0;
    for (size_t k = 0; k < mean_.size(); ++k)
      change = std::max(change, std::abs(mean_[k] - last[k]));
    if (change < kStill_ticks) break;
  }
}

// Wheels roll evenly and are then pushed. Of each row's jolt: its size in the mean, over the share
// of it that counts tell at all (MacKay 1992). Few rows tell little, so that those about a row
// count as one, beside a little of the jolt over all.
std::vector<double> RolledWay::jolts_about(const CountedWay& counted, double jolt) const {
  constexpr size_t kAbout = 5;
  constexpr double kOfAll = 0.1;
  const size_t rows = time_s_.size();
  std::vector<double> size(rows, 0), told_of(rows, 0), all(rows, jolt);
  Told told = at_first(counted);
  told.learn(sites_[0].precision, sites_[0].weighted);
  for (size_t k = 1; k < rows; ++k) {
    const Matrix2d Q = jolted(jolt_[k], time_s_[k] - time_s_[k - 1]);
    told.move(jolt_[k], time_s_[k] - time_s_[k - 1]);
    const Message after = from(k);
    // By how much, in the mean, and of which covariance less than Q's.
    const Matrix2d surprise = (Matrix2d::Identity() + after.precision * told.covariance).inverse();
    const Vector2d push = surprise * (after.weighted - after.precision * told.mean);
    size[k] = jolt_[k] * push.dot(Q * push);
    told_of[k] = (surprise * after.precision * Q).trace();
    told.learn(sites_[k].precision, sites_[k].weighted);
  }
  for (size_t k = 1; k < rows; ++k) {
    double sum = kOfAll * jolt, count = kOfAll;
    for (size_t i = std::max<size_t>(k, kAbout + 1) - kAbout; i <= std::min(k + kAbout, rows - 1);
         ++i)
      sum += size[i], count += told_of[i];
    all[k] = sum / count;
  }
  return all;
}

RolledWay::RolledWay(const CountedWay& counted, std::vector<double> jolt)
    : time_s_(counted.time_s),
      jolt_(std::move(jolt)),
      mean_(counted.ticks),
      sites_(counted.ticks.size()),
      later_(counted.ticks.size()) {
  settle(counted);
}

RolledWay::RolledWay(const CountedWay& counted, double jolt)
    : RolledWay(counted, std::vector<double>(counted.ticks.size(), jolt)) {
  constexpr int kTimes = 5;
  for (int time = 0; time < kTimes; ++time) {
    jolt_ = jolts_about(counted, jolt);
    settle(counted);
  }
}

RolledWay::Step RolledWay::step(double from_s, double to_s) const {
  Step all;
  auto row = static_cast<size_t>(std::upper_bound(time_s_.begin(), time_s_.end(), from_s) -
                                 time_s_.begin());
  for (double at_s = from_s; at_s < to_s; ++row) {
    const bool ends = row == time_s_.size();
    const double next_s = ends ? to_s : std::min(to_s, time_s_[row]);
    const double jolt = ends ? jolt_.back() : jolt_[row];
    const Message after = ends ? Message{} : before(from(row), time_s_[row] - next_s, jolt);
    const Matrix2d Q = jolted(jolt, next_s - at_s);
    const Matrix2d joined = (Matrix2d::Identity() + Q * after.precision).inverse();
    const Matrix2d kept = joined * moved(next_s - at_s);
    all.kept = kept * all.kept;
    all.fresh = kept * all.fresh * kept.transpose() + joined * Q;
    at_s = next_s;
  }
  return all;
}

double RolledWay::log_chance(const CountedWay& counted, double jolt) {
  double sum = 0;
  Told told = at_first(counted);
  for (size_t k = 0; k < counted.ticks.size(); ++k) {
    if (k > 0) told.move(jolt, counted.time_s[k] - counted.time_s[k - 1]);
    const double variance = told.covariance(0, 0);
    const Bounded here = bounded(told.mean[0], variance, counted.ticks[k]);
    sum += here.log_chance;
    told.learn(std::max(0.0, 1 / here.variance - 1 / variance),
               here.mean / here.variance - told.mean[0] / variance);
  }
  return sum;
}

double jolt_of(const std::vector<CountedWay>& counted) {
  constexpr size_t kEnoughRows = 20'000;
  const auto cost = [&](double decade) {
    double sum = 0;
    size_t rows = 0;
    for (const CountedWay& way : counted) {
      if (rows > kEnoughRows) break;
      sum -= RolledWay::log_chance(way, std::pow(10.0, decade));
      rows += way.ticks.size();
    }
    return sum;
  };
  // By decades, and then by ever finer steps about the best.
  double best = 0, least = HUGE_VAL;
  for (int decade = -9; decade <= 12; ++decade) {
    const double here = cost(decade);
    if (here < least) least = here, best = decade;
  }
  for (double step = 0.5; step > 0.1; step /= 2) {
    const double middle = best;
    for (const double there : {middle - step, middle + step}) {
      const double here = cost(there);
      if (here < least) least = here, best = there;
    }
  }
  return std::pow(10.0, best);
}

}  // namespace seam::measurement
