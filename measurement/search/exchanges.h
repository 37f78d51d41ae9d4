// One added effect in the place of another.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "measurement/problem/memo.h"
#include "measurement/search/candidates.h"

namespace seam::measurement {

// Whether one lens can take the place of another that no other can stand beside, or of one of a
// wider family.
bool stands_for(const EffectDefinition& leaving, const EffectDefinition& in);

// By name, among the catalogue's and the user's own.
using EffectByName =
    std::function<std::shared_ptr<const EffectDefinition>(const std::string& name)>;

struct Exchange {
  std::string out, in;
  bool operator==(const Exchange&) const = default;
};

// Which added effect might go for which other: lenses for lenses, and all for those that were
// significant in some look.
std::vector<Exchange> possible_exchanges(const Problem& problem, const Grown& grown,
                                         const std::vector<std::string>& promising,
                                         const EffectByName& effect_by_name);

// Which of these exchanges is clearly ahead in evidence; nothing where none is.
std::optional<size_t> best_exchange(const Grown& grown,
                                    const std::vector<std::optional<Grown>>& tried);

// Exchanges of one effect for another, each worked out once: the search asks for them where it
// would end, and then again which of them tie with its steps.
class Exchanges {
 public:
  explicit Exchanges(const Problem& problem) : problem_(problem) {}

  // The model with one added effect exchanged, where the whole becomes clearly better.
  std::optional<Grown> better(const Grown& grown, const std::vector<std::string>& promising,
                              const EffectByName& effect_by_name) const;

  // The model with one added effect in the place of another; nothing where few groups show that it
  // is far behind.
  std::optional<Grown> with_other(const Grown& grown, const std::string& out,
                                  const std::shared_ptr<const EffectDefinition>& in) const;

 private:
  static constexpr size_t kKept = 64;

  std::vector<std::optional<Grown>> tried(const Grown& grown, const std::vector<Exchange>& moves,
                                          const EffectByName& effect_by_name) const;

  const Problem& problem_;
  Memo<std::optional<Grown>> tried_{1, kKept};
};

}  // namespace seam::measurement
