#include "measurement/report/trust/trust.h"

#include <fmt/format.h>

#include <cmath>

#include "measurement/report/trust/trust_table.h"

namespace seam::measurement {
namespace {

// Of fewer sets the interval spans more than half of all shares.
constexpr int kFewest = 5;

void add_interval(Trust& trust) {
  constexpr double kZ = 1.959964;  // Of 95 %.
  const double n = trust.sets, share = trust.right / n, spread = kZ * kZ / n;
  const double middle = (share + spread / 2) / (1 + spread);
  const double half = kZ * std::sqrt(share * (1 - share) / n + spread / (4 * n)) / (1 + spread);
  trust.low = std::max(0.0, middle - half), trust.high = std::min(1.0, middle + half);
}

}  // namespace

std::optional<Trust> trust_in(const std::string& kind, const std::string& verdict) {
  for (const TrustRow& row : kTrust) {
    if (kind != row.kind || verdict != row.verdict || row.sets < kFewest) continue;
    Trust trust{.verdict = verdict, .sets = row.sets, .right = row.right};
    add_interval(trust);
    return trust;
  }
  return std::nullopt;
}

std::optional<Trust> trust_in(const Problem& problem, const SearchResult& result) {
  return trust_in(problem.facts().kind(), result.verdict == "unexplained_structure" ? "unexplained"
                                          : result.steps.empty()                    ? "nothing"
                                                                                    : "named");
}

std::string trust_text(const std::optional<Trust>& trust) {
  if (!trust) return "";
  const char* what = trust->verdict == "named"     ? "named causes"
                     : trust->verdict == "nothing" ? "found nothing"
                                                   : "found a cause without a name";
  return fmt::format(
      "trust: of {} benchmark sets of this kind that {}, {} were right ({:.0f} to {:.0f} %)\n",
      trust->sets, what, trust->right, 100 * trust->low, 100 * trust->high);
}

}  // namespace seam::measurement
