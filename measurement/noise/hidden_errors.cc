#include "measurement/noise/hidden_errors.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "sim_core/base/error.h"

namespace seam::measurement {

struct HiddenErrors::Part {
  std::vector<int> hidden;
  std::vector<size_t> observed;  // In the order in which they came.
};

int HiddenErrors::add(double variance, double tau_s) {
  hidden_.push_back({variance, tau_s});
  return static_cast<int>(hidden_.size()) - 1;
}

void HiddenErrors::observe(size_t scalar, double time_s, std::span<const Share> shares,
                           const FewErrors* shape, bool same_lot) {
  const size_t first = shares_.size();
  shares_.insert(shares_.end(), shares.begin(), shares.end());
  observed_.push_back({scalar, time_s, first, shares_.size(), shape, same_lot});
}

std::vector<HiddenErrors::Part> HiddenErrors::parts(std::vector<int>& place) const {
  std::vector<int> parent(hidden_.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (const Observed& o : observed_) {
    for (size_t k = o.first + 1; k < o.last; ++k)
      parent[root(shares_[k].hidden)] = root(shares_[o.first].hidden);
  }
  std::vector<Part> parts;
  place.resize(hidden_.size());
  std::vector<int> part_of(hidden_.size(), -1);
  for (int h = 0; h < static_cast<int>(hidden_.size()); ++h) {
    int& part = part_of[root(h)];
    if (part < 0) part = static_cast<int>(parts.size()), parts.emplace_back();
    place[h] = static_cast<int>(parts[part].hidden.size());
    parts[part].hidden.push_back(h);
  }
  Part alone;
  for (size_t i = 0; i < observed_.size(); ++i) {
    const Observed& o = observed_[i];
    const bool shares = o.first < o.last;
    (shares ? parts[part_of[root(shares_[o.first].hidden)]] : alone).observed.push_back(i);
  }
  parts.push_back(std::move(alone));
  return parts;
}

namespace {

// What is known of the hidden errors of a part: mean and covariance.
class Knowledge {
 public:
  Knowledge(std::vector<double> variance, std::vector<double> tau_s)
      : n_(variance.size()),
        variance_(std::move(variance)),
        tau_s_(std::move(tau_s)),
        mean_(n_, 0),
        covariance_(n_ * n_, 0),
        decay_(n_, 1),
        along_(n_, 0) {
    for (size_t i = 0; i < n_; ++i) covariance_[i * n_ + i] = variance_[i];
  }

  // Time passes.
  void pass(double dt_s) {
    if (!(dt_s > 0)) return;
    for (size_t i = 0; i < n_; ++i) {
      const bool known = i > 0 && tau_s_[i] == tau_s_[i - 1];
      decay_[i] = known ? decay_[i - 1] : tau_s_[i] > 0 ? std::exp(-dt_s / tau_s_[i]) : 0;
    }
    for (size_t i = 0; i < n_; ++i) {
      mean_[i] *= decay_[i];
      double* row = &covariance_[i * n_];
      const double by = decay_[i];
      for (size_t k = 0; k < n_; ++k) row[k] *= by * decay_[k];
      row[i] += (1 - by * by) * variance_[i];
    }
  }

  double mean(size_t i) const { return mean_[i]; }
  double covariance(size_t i, size_t k) const { return covariance_[i * n_ + k]; }

  // Of a sum of hidden errors.
  template <typename Shares>
  void look(const Shares& shares, const std::vector<int>& place, double& mean, double& variance) {
    mean = variance = 0;
    std::fill(along_.begin(), along_.end(), 0);
    for (const auto& share : shares) {
      const size_t h = place[share.hidden];
      mean += share.slope * mean_[h];
      const double* row = &covariance_[h * n_];
      for (size_t i = 0; i < n_; ++i) along_[i] += share.slope * row[i];
    }
    for (const auto& share : shares) variance += share.slope * along_[place[share.hidden]];
  }

  // The sum that was looked at is known better now: the log-density of what was seen has these
  // derivatives by it.
  void learn(double slope, double curvature) {
    for (size_t i = 0; i < n_; ++i) {
      mean_[i] += along_[i] * slope;
      double* row = &covariance_[i * n_];
      const double by = along_[i] * curvature;
      for (size_t k = 0; k < n_; ++k) row[k] += by * along_[k];
    }
  }

 private:
  size_t n_;
  std::vector<double> variance_, tau_s_, mean_, covariance_, decay_, along_;
};

}  // namespace

void HiddenErrors::filter(const Part& part, const std::vector<int>& place, const Facts& facts,
                          Evaluation& evaluation, std::vector<Learnt>& learnt) const {
  std::vector<double> variance, tau_s;
  for (const int h : part.hidden) {
    variance.push_back(hidden_[h].variance), tau_s.push_back(hidden_[h].tau_s);
  }
  Knowledge knowledge(std::move(variance), std::move(tau_s));
  double now_s = part.observed.empty() ? 0 : observed_[part.observed.front()].time_s;
  double lot = -1;  // The probability that the last one had something more; -1: not seen.
  for (const size_t i : part.observed) {
    const Observed& o = observed_[i];
    const std::span shares(shares_.data() + o.first, o.last - o.first);
    if (!shares.empty()) {
      SEAM_CHECK(o.time_s >= now_s, "residuals of hidden errors came out of order");
      knowledge.pass(o.time_s - now_s);
      now_s = o.time_s;
    }
    if (!o.same_lot) lot = -1;
    double expected = 0, hidden = 0, own = evaluation.sigma[o.scalar];
    knowledge.look(shares, place, expected, hidden);
    double all = own * own;
    for (const Share& share : shares)
      all += share.slope * share.slope * hidden_[share.hidden].variance;
    evaluation.sigma[o.scalar] = std::sqrt(o.shape ? o.shape->variance(std::sqrt(all)) : all);
    const double sigma = std::sqrt(own * own + hidden);
    const double innovation = evaluation.residual[o.scalar] - expected;
    if (o.shape) evaluation.deviance[o.scalar] = std::abs(o.shape->deviance(innovation, sigma).z);
    if (!evaluation.used[o.scalar]) continue;
    double& log_det = evaluation.log_det[facts.group_of(o.scalar)];
    log_det -= 2 * std::log(own);
    if (o.shape) {
      const bool known = o.same_lot && lot >= 0;
      const double fraction = known ? lot : o.shape->fraction();
      const Deviance seen = o.shape->deviance(innovation, sigma, fraction);
      evaluation.whitened[o.scalar] = seen.z;
      log_det += seen.log_det;
      evaluation.mean_square[o.scalar] =
          known ? o.shape->mean_square_of_second(sigma) : o.shape->mean_square(sigma);
      evaluation.mean_whitened[o.scalar] = o.shape->mean(sigma);
      lot = o.shape->share_of_more(innovation, sigma, fraction);
      if (shares.empty()) continue;
      const LogDensity density = o.shape->at(innovation, sigma, fraction);
      knowledge.learn(-density.slope, density.curvature);
      continue;
    }
    evaluation.whitened[o.scalar] = innovation / sigma;
    log_det += 2 * std::log(sigma);
    if (!shares.empty()) knowledge.learn(innovation / (sigma * sigma), -1 / (sigma * sigma));
  }
  for (size_t i = 0; i < part.hidden.size(); ++i) {
    const bool next = i + 1 < part.hidden.size() && part.hidden[i + 1] == part.hidden[i] + 1;
    learnt[part.hidden[i]] = {knowledge.mean(i), knowledge.covariance(i, i),
                              next ? knowledge.covariance(i, i + 1) : 0};
  }
}

std::vector<HiddenErrors::Learnt> HiddenErrors::learn(const Facts& facts,
                                                      Evaluation& evaluation) const {
  const bool shaped = std::any_of(observed_.begin(), observed_.end(),
                                  [](const Observed& o) { return o.shape != nullptr; });
  if (shaped) {
    evaluation.mean_square.resize(facts.scalars(), 1);
    evaluation.mean_whitened.resize(facts.scalars(), 0);
    evaluation.deviance.resize(facts.scalars(), std::numeric_limits<double>::infinity());
  }
  std::vector<int> place;
  std::vector<Learnt> learnt(hidden_.size());
  for (const Part& part : parts(place)) filter(part, place, facts, evaluation, learnt);
  return learnt;
}

}  // namespace seam::measurement
