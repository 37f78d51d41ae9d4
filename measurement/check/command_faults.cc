// What a command and the angle measured under it say of each other.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "measurement/check/fault_parts.h"

namespace seam::measurement {
namespace {

// A command beside the angle some rows later, over the rows in which the drive is on. A window of
// rows that is the same for all lags, so that their figures compare.
class Lagged {
 public:
  Lagged(const Numbers& command, const Numbers& measured, const std::vector<char>& acts,
         size_t most_lag)
      : command_(command), measured_(measured), acts_(acts), most_lag_(most_lag) {}

  // Root mean square of what is left of their difference without its mean.
  double miss(int lag) const {
    const Sums s = sums(lag);
    return std::sqrt(std::max(0.0, s.cc - 2 * s.cm + s.mm));
  }
  double correlation(int lag) const {
    const Sums s = sums(lag);
    return s.cc > 0 && s.mm > 0 ? s.cm / std::sqrt(s.cc * s.mm) : 0;
  }

 private:
  struct Sums {
    double cc = 0, cm = 0, mm = 0;  // Variances and covariance.
  };
  Sums sums(int lag) const {
    double n = 0, c1 = 0, m1 = 0;
    Sums s;
    for (size_t k = most_lag_; k + most_lag_ < command_.size(); ++k) {
      if (acts_[k] == 0) continue;
      const double c = command_[k] - command_[0];
      const double m = measured_[static_cast<size_t>(static_cast<int>(k) + lag)] - measured_[0];
      n += 1, c1 += c, m1 += m, s.cc += c * c, s.cm += c * m, s.mm += m * m;
    }
    if (n == 0) return {};
    return {s.cc / n - c1 * c1 / n / n, s.cm / n - c1 * m1 / n / n, s.mm / n - m1 * m1 / n / n};
  }

  const Numbers& command_;
  const Numbers& measured_;
  const std::vector<char>& acts_;
  size_t most_lag_;
};

// Whether the angle follows the command with the other sign, and not as it stands at any lag. A lag
// of half a sine's period looks the same: the shorter one is believed.
bool counts_the_other_way(const Lagged& lagged, int most_lag) {
  constexpr double kLeast = 0.8;  // Correlation; noise of short logs reaches 0.6.
  struct Best {
    double r = 0;
    int lag = 0;
  };
  Best opposite, alike_later;
  double alike = 0;
  const auto offer = [](double r, int lag, Best& best) {
    if (r > best.r) best = {r, lag};
  };
  for (int lag = -most_lag; lag <= most_lag; ++lag) {
    const double r = lagged.correlation(lag);
    alike = std::max(alike, r);
    if (lag < 0) continue;
    offer(-r, lag, opposite);
    offer(r, lag, alike_later);
  }
  if (alike_later.r > kLeast && alike_later.lag < opposite.lag) return false;
  // Half of the remaining variance separates the two.
  return opposite.r > kLeast && 1 - opposite.r * opposite.r < 0.5 * (1 - alike * alike);
}

}  // namespace

std::vector<std::string> faults_of_command(const Numbers& command, const Numbers& measured,
                                           const std::vector<char>& acts,
                                           const std::string& joint) {
  constexpr size_t kMostRows = 20, kFewestRows = 12;
  std::vector<std::string> found;
  const size_t n = command.size();
  const double span = span_of(command);
  if (n < kFewestRows || span < 1e-9 || span_of(measured) < 1e-9 || command == measured)
    return found;
  const int most = static_cast<int>(std::min(kMostRows, n / 4));
  const Lagged lagged(command, measured, acts, static_cast<size_t>(most));
  if (counts_the_other_way(lagged, most)) {
    found.push_back(fmt::format(
        "the angle of joint {0} follows its command with the opposite sign: does one of the two "
        "columns count the other way? Change the sign of one of them (seam import: --reverse {0})",
        joint));
    return found;
  }
  if (n < 3 * kMostRows) return found;
  int best = 0;
  for (int lag = -most; lag <= most; ++lag) {
    if (lagged.miss(lag) < lagged.miss(best)) best = lag;
  }
  // Later it may be: a servo that is late and else ideal.
  if (best >= 0) return found;
  const double miss = lagged.miss(best);
  if (miss < 1e-6 * span) {
    found.push_back(
        fmt::format("the command is the measurement {} rows earlier: is it a copy of it?", -best));
  } else if (miss < 0.7 * lagged.miss(0) && miss < 0.7 * lagged.miss(-best)) {
    found.push_back(fmt::format(
        "the measured angle is {} rows ahead of the command: are the two columns exchanged?",
        -best));
  }
  return found;
}

Rows rows_without_drive(const Numbers& command, const Numbers& measured,
                        const std::vector<char>& acts) {
  constexpr size_t kFewestRows = 5;
  const size_t n = command.size();
  Numbers misses, asked;
  double fastest = 0;  // Of the joint under a command, in a row.
  for (size_t k = 0; k < n; ++k) {
    if (command[k] == 0 || acts[k] == 0) continue;
    misses.push_back(std::abs(measured[k] - command[k]));
    asked.push_back(command[k]);
    if (k > 0) fastest = std::max(fastest, std::abs(measured[k] - measured[k - 1]));
  }
  if (misses.size() < kFewestRows) return {};
  std::sort(misses.begin(), misses.end());
  const double usual = misses[misses.size() * 9 / 10];
  // No command elsewhere is near 0: ticks of an encoder, say.
  const auto [least, most] = std::minmax_element(asked.begin(), asked.end());
  const bool far_from_all = *least > *most - *least || *most < *least - *most;
  Rows found;
  for (size_t first = 0; first < n; ++first) {
    if (command[first] != 0 || acts[first] == 0) continue;
    size_t end = first;
    while (end < n && command[end] == 0 && acts[end] != 0) ++end;
    const double at_start = std::abs(measured[first > 0 ? first - 1 : 0]);
    const double at_end = std::abs(measured[end - 1]);
    // A joint that tracks its commands goes to 0 as it goes elsewhere.
    const bool stays = at_end > 3 * usual && at_end > 0.5 * at_start;
    const bool could_arrive =
        far_from_all || static_cast<double>(end - first) * fastest > 0.5 * at_end;
    for (size_t k = first; k < end && stays && could_arrive; ++k) found.push_back(k);
    first = end;
  }
  return found;
}

}  // namespace seam::measurement
