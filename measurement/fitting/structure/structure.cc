// Structure tests: does the mean or the spread of the residuals depend on anything?
#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "measurement/fitting/structure/strongest_wave.h"
#include "measurement/numerics/legendre.h"
#include "measurement/numerics/parallel_for.h"
#include "measurement/numerics/regression.h"
#include "measurement/problem/neighbour.h"
#include "measurement/problem/problem.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

// Residuals of one channel (or of two combined): whitened values and the rows they belong to.
struct Signal {
  std::string name;
  std::vector<double> z;
  std::vector<int> row;
  double native2 = 0, whitened2 = 0;  // Sums of squares.

  void add(size_t at, double whitened, double native) {
    z.push_back(whitened);
    row.push_back(static_cast<int>(at));
    whitened2 += whitened * whitened, native2 += native * native;
  }
  // Of the native residual for one of the whitened: strength in the unit of the data.
  double sigma() const { return whitened2 > 0 ? std::sqrt(native2 / whitened2) : 1; }
};

// By row: 1 where the row is the first of its series and a start fitted to it took all of its
// residual (a servo at rest until its first command). Such rows have no spread, which would look
// like a structure of whatever is special at the start.
std::vector<char> taken_by_a_start(const Facts& facts, const Evaluation& evaluation) {
  constexpr double kNothing = 1e-6;  // Of the noise.
  std::vector<char> taken(facts.rows(), 0);
  if (facts.series_of_row.empty() || evaluation.nuisances == 0) return taken;
  std::vector<int> first(
      1 + *std::max_element(facts.series_of_row.begin(), facts.series_of_row.end()), -1);
  for (size_t i = 0; i < facts.scalars(); ++i) {
    int& start = first[facts.series_of_row[facts.row_of[i]]];
    const auto time = [&](int scalar) { return facts.time_of_row[facts.row_of[scalar]]; };
    if (start < 0 || time(static_cast<int>(i)) < time(start)) start = static_cast<int>(i);
  }
  for (const int i : first) {
    if (i >= 0 && std::abs(evaluation.whitened[i]) < kNothing) taken[facts.row_of[i]] = 1;
  }
  return taken;
}

std::vector<Signal> signals_of(const Facts& facts, const Evaluation& evaluation) {
  std::vector<Signal> signals;
  std::vector<std::vector<int>> scalar_of(facts.channels.size(),
                                          std::vector<int>(facts.rows(), -1));
  std::vector<char> taken = taken_by_a_start(facts, evaluation);
  for (size_t row = 0; row < facts.shares_error.size(); ++row)
    taken[row] |= facts.shares_error[row];
  for (size_t i = 0; i < facts.scalars(); ++i) {
    if (evaluation.used[i] && !taken[facts.row_of[i]])
      scalar_of[facts.channel_of[i]][facts.row_of[i]] = static_cast<int>(i);
  }
  for (size_t c = 0; c < facts.channels.size(); ++c) {
    Signal signal{.name = facts.channels[c].name};
    for (size_t row = 0; row < facts.rows(); ++row) {
      const int i = scalar_of[c][row];
      if (i >= 0) signal.add(row, evaluation.beyond_mean(i), evaluation.residual[i]);
    }
    if (signal.z.size() >= 8) signals.push_back(std::move(signal));
  }
  for (const CombinedChannel& combined : facts.combined) {
    Signal signal{.name = combined.name};
    for (size_t row = 0; row < facts.rows(); ++row) {
      const int a = scalar_of[combined.channel_a][row], b = scalar_of[combined.channel_b][row];
      if (a < 0 || b < 0) continue;
      const auto combine = [&](double of_a, double of_b) {
        return combined.weight_a[row] * of_a + combined.weight_b[row] * of_b;
      };
      signal.add(row, combine(evaluation.beyond_mean(a), evaluation.beyond_mean(b)),
                 combine(evaluation.residual[a], evaluation.residual[b]));
    }
    if (signal.z.size() >= 8) signals.push_back(std::move(signal));
  }
  return signals;
}

// The covariate at the signal's rows, scaled to [-1, 1]; false where it is constant or unknown.
bool scaled_column(const std::vector<double>& values, const std::vector<int>& rows,
                   std::vector<double>& out) {
  out.resize(rows.size());
  for (size_t i = 0; i < rows.size(); ++i) out[i] = values[rows[i]];
  return scale_to_range(out);
}

// Legendre polynomials of degree 1 to 4: slow changes; waves of 1 to 6 periods: fast ones.
std::vector<std::vector<double>> slow_basis(const std::vector<double>& x) {
  std::vector<std::vector<double>> basis(4, std::vector<double>(x.size()));
  for (size_t i = 0; i < x.size(); ++i) {
    for (int degree = 1; degree <= 4; ++degree)
      basis[static_cast<size_t>(degree) - 1][i] = legendre(degree, x[i]);
  }
  return basis;
}

std::vector<std::vector<double>> wave_basis(const std::vector<double>& x, double periods_scale) {
  constexpr int kWaves = 6;
  std::vector<std::vector<double>> basis(2 * kWaves, std::vector<double>(x.size()));
  for (size_t i = 0; i < x.size(); ++i) {
    const double angle = maths::kPi * x[i] * periods_scale;
    const double c1 = std::cos(angle), s1 = std::sin(angle);
    double c = c1, s = s1;
    for (int k = 0; k < kWaves; ++k) {
      basis[2 * k][i] = c;
      basis[2 * k + 1][i] = s;
      const double next = c * c1 - s * s1;
      s = s * c1 + c * s1;
      c = next;
    }
  }
  return basis;
}

class Tester {
 public:
  Tester(const Problem& problem, const Evaluation& evaluation, int fitted)
      : facts_(problem.facts()), signals_(signals_of(facts_, evaluation)) {
    double n = 0;
    for (const char used : evaluation.used) n += used;
    lost_share_ =
        n > 0 ? (static_cast<double>(evaluation.nuisances) + evaluation.absorbed + fitted) / n : 0;
  }

  std::vector<Structure> run() {
    std::vector<Tester> by_signal(signals_.size(), Tester(facts_, lost_share_));
    parallel_for(signals_.size(), [&](size_t i) { by_signal[i].test(signals_[i]); });
    for (const Tester& one : by_signal) {
      looks_ += one.looks_;
      found_.insert(found_.end(), one.found_.begin(), one.found_.end());
    }
    for (Structure& found : found_) found.p_value = corrected(found.p_value, looks_);
    std::erase_if(found_, [](const Structure& s) { return s.p_value > kLeastSure; });
    // Of two tests of one thing the surer one stays.
    std::stable_sort(found_.begin(), found_.end(), [](const Structure& a, const Structure& b) {
      return std::pair(a.p_value, -a.explained) < std::pair(b.p_value, -b.explained);
    });
    keep_strongest();
    strongest_first(facts_, found_);
    return found_;
  }

 private:
  // For the signals of another one by one.
  Tester(const Facts& facts, double lost_share) : facts_(facts), lost_share_(lost_share) {}
  void test(const Signal& signal) {
    test_mean(signal);
    test_products(signal);
    test_order(signal);
    test_spread(signal);
  }

  // One line for each residual, moment and covariate.
  void keep_strongest() {
    std::vector<Structure> kept;
    for (const Structure& s : found_) {
      const auto same = [&](const Structure& k) {
        return k.residual == s.residual && k.moment == s.moment && k.covariate == s.covariate;
      };
      if (std::none_of(kept.begin(), kept.end(), same)) kept.push_back(s);
    }
    found_ = std::move(kept);
  }

  void note(const Signal& signal, const std::string& moment, const std::string& covariate,
            const NestedTest& test, double rms, double looks = 1) {
    looks_ += looks;
    double total = 0;
    for (const double z : signal.z) total += z * z;
    const double explained = static_cast<double>(signal.z.size()) * test.rms * test.rms;
    found_.push_back(
        {.residual = signal.name,
         .moment = moment,
         .covariate = covariate,
         .strength = rms * signal.sigma(),
         .p_value = test.p_value <= 1e-297 ? 1e-300 : std::min(1.0, test.p_value * looks),
         .explained = moment == "mean" && total > 0 ? explained / total : 0});
  }

  double lost(const Signal& signal) const {
    return lost_share_ * static_cast<double>(signal.z.size());
  }
  void test_mean(const Signal& signal);
  void test_products(const Signal& signal);
  void test_order(const Signal& signal);
  void test_spread(const Signal& signal);
  void test_waves_in_time(const Signal& signal);

  const Facts& facts_;
  std::vector<Signal> signals_;
  double lost_share_ = 0;
  double looks_ = 0;
  std::vector<Structure> found_;
};

void Tester::test_mean(const Signal& signal) {
  const std::vector<std::vector<double>> constant{std::vector<double>(signal.z.size(), 1)};
  const bool native = signal.name != "tangential_px" && signal.name != "radial_px";
  if (native) {
    const NestedTest offset = nested_test(signal.z, {}, constant, lost(signal));
    note(signal, "mean", "constant", offset, offset.rms);
  }
  std::vector<double> x;
  for (const Covariate& covariate : facts_.covariates) {
    if (covariate.type == Covariate::Type::category) {
      std::vector<int> label;
      bool known = true;
      for (const int row : signal.row) {
        known = known && std::isfinite(covariate.values[row]);
        label.push_back(known ? static_cast<int>(covariate.values[row]) : 0);
      }
      if (!known) continue;
      const NestedTest test = category_test(signal.z, label, lost(signal));
      if (test.extra > 0) note(signal, "mean", covariate.name, test, test.rms);
      continue;
    }
    if (!scaled_column(covariate.values, signal.row, x)) continue;
    if (covariate.type == Covariate::Type::sign) {
      const NestedTest test = nested_test(signal.z, constant, {x}, lost(signal));
      note(signal, "mean", covariate.name, test, test.rms);
      continue;
    }
    const NestedTest slow = nested_test(signal.z, constant, slow_basis(x), lost(signal));
    note(signal, "mean", covariate.name, slow, slow.rms);
    const NestedTest waves = nested_test(signal.z, constant, wave_basis(x, 1), lost(signal));
    note(signal, "mean", covariate.name, waves, waves.rms);
    if (covariate.name == "time") test_waves_in_time(signal);
  }
}

void Tester::test_products(const Signal& signal) {
  const std::vector<double> ones(signal.z.size(), 1);
  std::vector<double> a, b, product(signal.z.size()), raw(signal.z.size());
  for (size_t i = 0; i < facts_.covariates.size(); ++i) {
    const Covariate& first = facts_.covariates[i];
    if (!first.in_products || first.type == Covariate::Type::category ||
        !scaled_column(first.values, signal.row, a))
      continue;
    for (size_t j = i + 1; j < facts_.covariates.size(); ++j) {
      const Covariate& second = facts_.covariates[j];
      if (!second.in_products || second.type == Covariate::Type::category) continue;
      if (second.name == "sign(" + first.name + ")") continue;
      if (!scaled_column(second.values, signal.row, b)) continue;
      for (size_t k = 0; k < product.size(); ++k) {
        product[k] = a[k] * b[k];
        raw[k] = first.values[signal.row[k]] * second.values[signal.row[k]];
      }
      const NestedTest test = nested_test(signal.z, {ones, a, b}, {product}, lost(signal));
      if (test.extra == 0) continue;
      const NestedTest alone = nested_test(signal.z, {ones}, {raw}, lost(signal));
      note(signal, "mean", first.name + "*" + second.name, test, std::max(test.rms, alone.rms));
    }
  }
}

// Correlation between neighbours in each series.
void Tester::test_order(const Signal& signal) {
  if (facts_.series_of_row.empty() || !facts_.tests_neighbours) return;
  std::vector<size_t> order(signal.z.size());
  std::iota(order.begin(), order.end(), 0);
  const auto key = [&](size_t i) {
    return std::pair(facts_.series_of_row[signal.row[i]], facts_.time_of_row[signal.row[i]]);
  };
  std::stable_sort(order.begin(), order.end(), [&](size_t i, size_t j) { return key(i) < key(j); });
  double sum = 0, variance = 0;
  size_t count = 0;
  for (const double z : signal.z) variance += z * z;
  variance /= static_cast<double>(signal.z.size());
  for (size_t k = 0; k + 1 < order.size(); ++k) {
    if (key(order[k]).first != key(order[k + 1]).first) continue;
    sum += signal.z[order[k]] * signal.z[order[k + 1]];
    ++count;
  }
  if (count < 20 || !(variance > 0)) return;
  const double score = sum / variance / std::sqrt(static_cast<double>(count));
  const double correlation = std::clamp(sum / variance / static_cast<double>(count), -1.0, 1.0);
  // Estimated nuisances make neighbours slightly opposed: only agreement is a structure.
  note(signal, "mean", kNeighbour, {.p_value = score > 0 ? 0.5 * normal_tail(score) : 1},
       std::sqrt(variance * std::max(0.0, correlation)));
}

// A line in the spectrum over time: the best of many frequencies, counted as that many looks.
void Tester::test_waves_in_time(const Signal& signal) {
  std::vector<double> times;
  for (const int row : signal.row) times.push_back(facts_.time_of_row[row]);
  std::vector<double> distinct = times;
  std::sort(distinct.begin(), distinct.end());
  distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
  if (distinct.size() < 16) return;
  const double span = distinct.back() - distinct.front();
  std::vector<double> steps;
  for (size_t i = 0; i + 1 < distinct.size(); ++i) steps.push_back(distinct[i + 1] - distinct[i]);
  std::nth_element(steps.begin(), steps.begin() + steps.size() / 2, steps.end());
  const double df = 0.5 / span;
  const int count = static_cast<int>(std::min(2000.0, 0.5 / steps[steps.size() / 2] / df));
  if (count < 14) return;
  const int best = strongest_wave(distinct, times, signal.z, df, count);
  std::vector<std::vector<double>> wave(2, std::vector<double>(times.size()));
  for (size_t i = 0; i < times.size(); ++i) {
    const double angle = 2 * maths::kPi * df * (best + 1) * (times[i] - distinct.front());
    wave[0][i] = std::cos(angle), wave[1][i] = std::sin(angle);
  }
  const NestedTest test =
      nested_test(signal.z, {std::vector<double>(times.size(), 1)}, wave, lost(signal));
  note(signal, "mean", "time", test, test.rms, count);
}

void Tester::test_spread(const Signal& signal) {
  if (signal.name == "radial_px" || signal.name == "tangential_px") return;
  // Scores know no size: what is nearly no residual would have a spread as large as the noise.
  constexpr double kNothing = 1e-2;  // Of the noise.
  if (std::sqrt(signal.whitened2 / static_cast<double>(signal.z.size())) < kNothing) return;
  std::vector<double> size;
  for (const double z : signal.z) size.push_back(std::abs(z));
  const std::vector<double> scores = normal_scores(size);
  const std::vector<std::vector<double>> constant{std::vector<double>(scores.size(), 1)};
  std::vector<double> x;
  for (const Covariate& covariate : facts_.covariates) {
    if (covariate.type == Covariate::Type::category ||
        !scaled_column(covariate.values, signal.row, x))
      continue;
    const auto extra = covariate.type == Covariate::Type::sign ? std::vector<std::vector<double>>{x}
                                                               : slow_basis(x);
    const NestedTest test = nested_test(scores, constant, extra, lost(signal));
    // A normal score of size s is about a change of the spread by 0.6 s.
    note(signal, "spread", covariate.name, test, 0.6 * test.rms);
  }
}

}  // namespace

double noise_of(const Facts& facts, const std::string& residual) {
  for (const Channel& channel : facts.channels) {
    if (channel.name == residual) return channel.noise;
  }
  for (const CombinedChannel& combined : facts.combined) {
    if (combined.name == residual) return facts.channels[combined.channel_a].noise;
  }
  return 1;
}

bool is_label(const Facts& facts, const std::string& covariate) {
  return std::any_of(facts.covariates.begin(), facts.covariates.end(), [&](const Covariate& c) {
    return c.name == covariate && c.type == Covariate::Type::category;
  });
}

void strongest_first(const Facts& facts, std::vector<Structure>& structures) {
  // Rows of one label follow whatever is smooth over them, which names the cause where it takes as
  // much, but for what its curve misses.
  constexpr double kOfLabel = 0.75;
  const auto key = [&](const Structure& s) {
    const double noise = noise_of(facts, s.residual);
    const double strength = (is_label(facts, s.covariate) ? kOfLabel : 1) * s.strength;
    // That neighbours agree tells that something smooth is missing, which the others name.
    return std::tuple(s.p_value, s.covariate == kNeighbour,
                      noise > 0 ? -strength / noise : -strength);
  };
  std::stable_sort(structures.begin(), structures.end(),
                   [&](const Structure& a, const Structure& b) { return key(a) < key(b); });
}

std::vector<Structure> Problem::structure(const Model& model, const Groups& groups,
                                          int fitted) const {
  const Evaluation evaluation = evaluate(model, groups);
  return Tester(*this, evaluation, fitted).run();
}

}  // namespace seam::measurement
