#include "measurement/kinds/outcomes/run_statistics.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "measurement/numerics/moments.h"
#include "sim_core/base/error.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

constexpr size_t kDraws = 200;  // Bootstrap: a standard error to 5 %.
constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
const std::string kQuantile = "quantile_";

double quantile_of(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  const double place = share * static_cast<double>(values.size() - 1);
  const auto below = static_cast<size_t>(place);
  const size_t above = std::min(below + 1, values.size() - 1);
  const double part = place - static_cast<double>(below);
  return (1 - part) * values[below] + part * values[above];
}

double value_of(const std::vector<std::vector<double>>& runs, const ColumnStatistic& wanted) {
  std::vector<double> values;
  for (const std::vector<double>& run : runs) {
    if (std::isfinite(run[wanted.column])) values.push_back(run[wanted.column]);
  }
  if (values.empty() || 2 * values.size() < runs.size()) return kNothing;
  return wanted.statistic.of(std::move(values));
}

double least_variance_of_rate(double rate, double runs) {
  const double yes = rate * runs + 1, no = (1 - rate) * runs + 1, all = runs + 2;
  return yes * no / (all * all * (all + 1));
}

// A table as it might have come out: each run is another one of its stratum, moved a little as runs
// of the stratum differ, so that values between those that came out can come, and the largest be
// larger (smoothed bootstrap that keeps variances: Silverman and Young 1987). Rates keep the values
// that came out.
class DrawnAgain {
 public:
  DrawnAgain(const std::vector<std::vector<double>>& runs, size_t stratum, size_t drawn,
             const std::vector<char>& smooth)
      : runs_(runs), stratum_(stratum), drawn_(drawn), smooth_(smooth) {
    for (size_t first = 0; first < runs.size(); first += stratum) {
      std::vector<double>& means = means_.emplace_back();
      const size_t end = std::min(first + stratum, runs.size());
      for (size_t c = 0; c < smooth.size(); ++c) {
        std::vector<double> values;
        for (size_t i = first; i < end; ++i) values.push_back(runs[i][c]);
        std::erase_if(values, [](double value) { return !std::isfinite(value); });
        means.push_back(values.empty() ? kNothing : mean_of(values));
      }
    }
  }

  // A table with so many runs of each stratum as are drawn.
  void draw(uint64_t number, std::vector<std::vector<double>>& out) const {
    static const RandomStream kStream = RandomStream{.seed = 0x5EA3}.child("outcomes");
    const RandomStream stream = kStream.child(number);
    for (size_t i = 0; i < out.size(); ++i) {
      const size_t first = i / drawn_ * stratum_;
      const size_t size = std::min(stratum_, runs_.size() - first);
      const double n = static_cast<double>(size);
      // The rule of thumb for a normal density; few runs hide some of their variance.
      const double width = 1.06 * std::pow(n, -0.2);
      const double scale = std::sqrt(n / std::max(1.0, n - 1) / (1 + width * width));
      // Four runs of the stratum: one that comes again, three whose deviations move it.
      const auto bits = random_bits(stream, i);
      const auto run = [&](size_t k) -> const std::vector<double>& {
        return runs_[first + ((uint64_t{bits[k]} * size) >> 32)];
      };
      const auto sign = [&](size_t k) { return (bits[k] & 1) != 0 ? 1.0 : -1.0; };
      for (size_t c = 0; c < smooth_.size(); ++c) {
        const double base = run(0)[c], mean = means_[i / drawn_][c];
        out[i][c] = base;
        if (!smooth_[c]) continue;
        double by = 0;
        for (size_t k = 1; k < bits.size(); ++k) by += sign(k) * (run(k)[c] - mean);
        by *= width / std::sqrt(3.0);
        out[i][c] = mean + scale * (base - mean + (std::isfinite(by) ? by : 0));
      }
    }
  }

 private:
  const std::vector<std::vector<double>>& runs_;
  size_t stratum_, drawn_;
  const std::vector<char>& smooth_;         // By column.
  std::vector<std::vector<double>> means_;  // By stratum and column.
};

}  // namespace

RunStatistic RunStatistic::named(const std::string& name) {
  static const std::vector<std::string> kPlain = {"mean", "spread",  "rms",    "min",
                                                  "max",  "largest", "median", "rate"};
  RunStatistic statistic;
  statistic.name_ = name;
  if (std::find(kPlain.begin(), kPlain.end(), name) != kPlain.end()) return statistic;
  if (name.starts_with(kQuantile)) {
    const char* begin = name.data() + kQuantile.size();
    const char* end = name.data() + name.size();
    const auto [rest, error] = std::from_chars(begin, end, statistic.quantile_);
    if (error == std::errc() && rest == end && statistic.quantile_ >= 0 && statistic.quantile_ <= 1)
      return statistic;
  }
  throw InputError(
      fmt::format("mean, spread, rms, min, max, largest, median, rate or quantile_P with "
                  "P from 0 to 1{}",
                  suggestion_for(name, kPlain)));
}

double RunStatistic::of(std::vector<double> values) const {
  if (name_ == "mean") return mean_of(values);
  if (name_ == "spread") return deviation_of(values);
  if (name_ == "min") return *std::min_element(values.begin(), values.end());
  if (name_ == "max") return *std::max_element(values.begin(), values.end());
  if (name_ == "median") return quantile_of(std::move(values), 0.5);
  if (name_ == "rms") {
    for (double& value : values) value *= value;
    return std::sqrt(mean_of(values));
  }
  if (name_ == "largest") {
    for (double& value : values) value = std::abs(value);
    return *std::max_element(values.begin(), values.end());
  }
  if (is_rate()) {
    for (double& value : values) value = value != 0 ? 1 : 0;
    return mean_of(values);
  }
  return quantile_of(std::move(values), quantile_);
}

StatisticsOfRuns statistics_of(const std::vector<std::vector<double>>& runs, size_t alike,
                               const std::vector<ColumnStatistic>& wanted) {
  StatisticsOfRuns out;
  for (const ColumnStatistic& w : wanted) out.value.push_back(value_of(runs, w));
  const size_t stratum = alike < 2 ? runs.size() : alike;
  out.covariance = covariance_of(runs, stratum, stratum, wanted);
  return out;
}

Eigen::MatrixXd covariance_of(const std::vector<std::vector<double>>& runs, size_t alike,
                              size_t drawn, const std::vector<ColumnStatistic>& wanted) {
  const auto n = static_cast<Eigen::Index>(wanted.size());
  if (runs.size() < 2) return Eigen::MatrixXd::Zero(n, n);
  const std::vector<char> all(runs.front().size(), 1), none(runs.front().size(), 0);
  const DrawnAgain smooth(runs, alike, drawn, all), plain(runs, alike, drawn, none);
  const bool any_rate = std::any_of(wanted.begin(), wanted.end(),
                                    [](const auto& w) { return w.statistic.is_rate(); });
  const size_t of_table = runs.size() / alike * drawn;
  std::vector<std::vector<double>> moved(of_table, runs.front()), kept = moved;
  Eigen::MatrixXd draws(static_cast<Eigen::Index>(kDraws), n);
  std::vector<double> values;
  for (const ColumnStatistic& w : wanted) values.push_back(value_of(runs, w));
  for (size_t draw = 0; draw < kDraws; ++draw) {
    smooth.draw(draw, moved);
    if (any_rate) plain.draw(draw, kept);
    for (size_t k = 0; k < wanted.size(); ++k) {
      const double value = value_of(wanted[k].statistic.is_rate() ? kept : moved, wanted[k]);
      draws(static_cast<Eigen::Index>(draw), static_cast<Eigen::Index>(k)) =
          std::isfinite(value) ? value : values[k];
    }
  }
  const Eigen::MatrixXd centred = draws.rowwise() - draws.colwise().mean();
  Eigen::MatrixXd covariance = centred.transpose() * centred / static_cast<double>(kDraws - 1);
  for (size_t k = 0; k < wanted.size(); ++k) {
    if (!wanted[k].statistic.is_rate()) continue;
    double& variance = covariance(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(k));
    const double hidden =
        static_cast<double>(alike) / static_cast<double>(std::max<size_t>(alike, 2) - 1);
    variance = std::max(hidden * variance,
                        least_variance_of_rate(values[k], static_cast<double>(of_table)));
  }
  return covariance;
}

}  // namespace seam::measurement
