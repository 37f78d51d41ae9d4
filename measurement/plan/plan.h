// What a measurement that was not made yet will say: the standard errors of parameters, the
// smallest effect that the search finds with 95 %, and which effects it could not tell apart
// (docs/plan.md).
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "measurement/fitting/parameter_space.h"
#include "measurement/plan/information.h"
#include "measurement/search/candidates.h"

namespace seam::measurement {

struct PlannedParameter {
  std::string name;
  double sigma = 0;  // Infinite where the data say nothing of it.
  // How far from neutral, the effect's other parameters at theirs; none: not within its bounds.
  std::optional<double> smallest_found;
};

// Another effect that would be named beside this one at its smallest size.
struct PlannedTie {
  std::string effect;
  std::optional<double> apart_from;  // The size of the first parameter at which it is not.
};

struct PlannedEffect {
  std::string effect;
  bool in_model = false;  // Its parameters are refitted anyway: only their errors are given.
  std::vector<PlannedParameter> parameters;
  std::vector<PlannedTie> ties;
};

struct Plan {
  size_t residuals = 0, groups = 0;
  bool has_ties = true;  // Pairs were compared.
  double looks = 0;      // Effects that a search would look at.
  std::vector<PlannedEffect> effects;
  std::vector<NotTestable> not_planned;
};

struct PlanOptions {
  std::vector<std::string> effects;  // Empty: all that the model lacks.
  double material = kMaterial;
  // The set that another model gives by the protocol, for kinds without normal equations.
  std::function<std::unique_ptr<Problem>(const Model&)> made;
};

// How two effects differ in one set, where one of them is in truth.
struct PairGains {
  double truth = 0, other = 0;  // In log-likelihood.
  // As many sets together as it takes until they are no tie; infinite where none do.
  double repeats_to_part() const;
};

class Planner {
 public:
  // `problem` is a set that the model gives by the protocol.
  Planner(Problem& problem, const Model& model, const PlanOptions& options);

  // The same of so many sets like this one together.
  Planner repeated(double times) const;
  // Whether more groups say as much more. Where the likelihood alone is known they may share what
  // one shows, and pairs are not compared.
  bool grows_with_groups() const { return !by_likelihood_; }

  Plan plan() const;
  // With `effect` at a size along its first parameter that is found.
  PairGains gains(const std::string& effect, double size, const std::string& other) const;

 private:
  // An effect beside the model, linearised at a small size.
  struct Seen {
    std::shared_ptr<const EffectDefinition> effect;
    std::vector<size_t> free;
    Model probe;
    std::vector<Unknown> unknowns;  // Those of the base first; of a spread its own alone.
    Columns columns;
    std::string why_not;  // No plan is made of it because.
  };
  // One parameter at the smallest size that is found.
  struct Sized {
    PlannedParameter parameter;
    std::vector<double> shift;  // There; empty where none is found.
    double gain = 0;
  };

  void see(const Prospect& prospect);
  // What the effect's parameters move around this model, `there`; says `why` where that is not
  // known.
  Columns columns_of(const Seen& seen, const Model& model, const Evaluation& there,
                     std::string& why) const;
  const Seen& seen(const std::string& name) const;  // Throws where no plan is made of it.
  const Seen* find(const std::string& name) const;
  std::string why_not(const std::string& name) const;
  size_t base_columns(const Seen& seen) const { return seen.unknowns.size() - seen.free.size(); }
  // The effect's look where its one parameter is off neutral by `away` of its coordinate, and what
  // moves there; nothing where the model predicts no image.
  struct Moved {
    EffectLook look;
    std::vector<double> shift;
    double sigma = 0;
  };
  std::optional<Moved> moved(const Seen& seen, size_t parameter, double away) const;
  // What the effect must gain there to be found.
  double price_of(const Seen& seen, const Model& truth, const EffectLook& look) const;
  EffectLook look_at_truth(const Seen& seen, const Model& truth, size_t k, double away) const;
  Sized sized(const Seen& seen, size_t parameter) const;
  std::vector<PlannedTie> ties_of(const Seen& seen, const Sized& sized) const;
  double gain_beside(const Seen& other, const std::vector<double>& shift) const;
  EffectLook look_at_model() const;
  // d value by the coordinate of looks.
  double slope_at(const Coordinate& coordinate, double z) const;
  void look_at(const std::vector<const Seen*>& planned, Plan& plan) const;
  PlannedEffect of_model(const std::string& effect) const;
  static std::vector<NotTestable> each_once(const std::vector<NotTestable>& reasons,
                                            const std::vector<const Seen*>& planned);

  const Problem& problem_;
  PlanOptions options_;
  Grown base_;
  Evaluation here_;
  bool by_likelihood_ = false;  // Which is all that the kind has.
  double looks_ = 0;
  double repeats_ = 1;  // As many sets like this one together.
  std::vector<Seen> seen_;
  std::vector<NotTestable> not_testable_;
};

}  // namespace seam::measurement
