#include "measurement/report/trust/trust.h"

#include <fmt/format.h>

#include "measurement/report/trust/trust_table.h"

namespace seam::measurement {
namespace {

// Of fewer sets the interval spans more than half of all shares.
constexpr int kFewest = 5;

}  // namespace

std::optional<Trust> trust_in(const std::string& kind, const std::string& verdict) {
  for (const TrustRow& row : kTrust) {
    if (kind != row.kind || verdict != row.verdict || row.sets < kFewest) continue;
    return Trust{.verdict = verdict, .right = {row.right, row.sets}};
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
      trust->right.trials, what, trust->right.hits, 100 * trust->right.low(),
      100 * trust->right.high());
}

}  // namespace seam::measurement
