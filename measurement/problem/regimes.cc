#include "measurement/problem/regimes.h"

#include <algorithm>
#include <cmath>
#include <compare>
#include <map>

#include "measurement/sets/set.h"

namespace seam::measurement {
namespace {

// How many regimes no group on a side shows.
struct Missing {
  int trained = 0, held = 0;
  auto operator<=>(const Missing&) const = default;
};

class Split {
 public:
  Split(Groups held, const std::vector<Groups>& regimes)
      : held_(std::move(held)), shown_by_(held_.size()) {
    for (const Groups& regime : regimes) {
      const auto shown = std::count(regime.begin(), regime.end(), 1);
      if (shown == 0 || shown == std::ssize(regime)) continue;
      regimes_.push_back({&regime, shown});
      for (size_t g = 0; g < held_.size(); ++g) {
        if (!regime[g]) continue;
        shown_by_[g].push_back(regimes_.size() - 1);
        regimes_.back().held += held_[g] != 0;
      }
    }
    for (const Regime& regime : regimes_) add(regime, regime.held, 1, missing_);
  }

  // The exchange after which the fewest are missing, the first of equals; false: none helps. One
  // that helps brings a group of a regime that is missing on the other side.
  bool exchange() {
    Missing least = missing_;
    size_t in = held_.size(), out = held_.size();
    const Groups wanted = of_missing();
    for (size_t a = 0; a < held_.size(); ++a) {
      if (!held_[a] || least == Missing{}) continue;
      for (size_t b = 0; b < held_.size(); ++b) {
        if (!wanted[a] && !wanted[b]) continue;
        const Missing then = held_[b] ? least : missing(a, b);
        if (then < least) least = then, in = a, out = b;
      }
    }
    if (in == held_.size()) return false;
    for (const size_t r : shown_by_[in]) --regimes_[r].held;
    for (const size_t r : shown_by_[out]) ++regimes_[r].held;
    held_[in] = 0, held_[out] = 1, missing_ = least;
    return true;
  }
  const Groups& held() const { return held_; }

 private:
  struct Regime {
    const Groups* shows;
    std::ptrdiff_t shown, held = 0;
  };

  // Groups of the regimes that one side lacks.
  Groups of_missing() const {
    Groups wanted(held_.size(), 0);
    for (const Regime& regime : regimes_) {
      if (regime.held != 0 && regime.held != regime.shown) continue;
      for (size_t g = 0; g < held_.size(); ++g) wanted[g] |= (*regime.shows)[g];
    }
    return wanted;
  }

  // What a regime adds, were so many of its groups held out.
  static void add(const Regime& regime, std::ptrdiff_t held, int sign, Missing& missing) {
    missing.trained += sign * (held == regime.shown);
    missing.held += sign * (held == 0 && regime.shown > 1);
  }
  // Where `in` trains and `out` is held out in its place.
  Missing missing(size_t in, size_t out) const {
    Missing then = missing_;
    const auto move = [&](size_t group, size_t other, int by) {
      for (const size_t r : shown_by_[group]) {
        const Regime& regime = regimes_[r];
        if ((*regime.shows)[other]) continue;
        add(regime, regime.held, -1, then), add(regime, regime.held + by, 1, then);
      }
    };
    move(in, out, -1), move(out, in, 1);
    return then;
  }

  Groups held_;
  std::vector<Regime> regimes_;
  std::vector<std::vector<size_t>> shown_by_;  // By group.
  Missing missing_;
};

}  // namespace

Groups held_out_of_each(const std::vector<std::string>& names, const std::vector<Groups>& regimes) {
  Split split(held_out_groups(names), regimes);
  while (split.exchange()) {
  }
  return split.held();
}

std::vector<Groups> regimes_of_labels(const Facts& facts) {
  std::vector<Groups> regimes;
  for (const Covariate& covariate : facts.covariates) {
    const bool is_label = covariate.type == Covariate::Type::category;
    if (covariate.of_measured || covariate.values.size() != facts.rows() ||
        (!is_label && covariate.type != Covariate::Type::sign))
      continue;
    // More labels are numbers of things and no conditions.
    constexpr size_t kMostLabels = 256;
    std::map<double, Groups> shown;
    for (size_t row = 0; row < facts.rows() && shown.size() <= kMostLabels; ++row) {
      const double value = covariate.values[row];
      // No motion is no direction.
      if (std::isnan(value) || (!is_label && value == 0)) continue;
      Groups& groups = shown.try_emplace(value, facts.groups.size(), 0).first->second;
      groups[static_cast<size_t>(facts.group_of_row[row])] = 1;
    }
    if (shown.size() > kMostLabels) continue;
    // Labels of which each is one group's number groups or parts of them.
    if (std::none_of(shown.begin(), shown.end(),
                     [](const auto& label) {
                       return std::count(label.second.begin(), label.second.end(), 1) > 1;
                     }) &&
        is_label)
      continue;
    for (auto& [value, groups] : shown) regimes.push_back(std::move(groups));
  }
  return regimes;
}

}  // namespace seam::measurement
