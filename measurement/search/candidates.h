// Effects that might be missing: each is fitted beside what the model has, and compared.
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "measurement/fitting/few_groups.h"
#include "measurement/judge/judge.h"

namespace seam::measurement {

struct NotTestable {
  std::string effect;
  std::string parameter;  // Empty: the whole effect.
  std::string why;
};

struct Looks {
  std::vector<Candidate> candidates;  // Best first.
  std::vector<NotTestable> not_testable;
  double tried = 0;  // Effects that were looked at, for the correction of p-values.
};

// The effect as a set of this kind sees it: noises move statistics of whole runs, and are there
// looked for as everything else is that moves predictions.
std::shared_ptr<const EffectDefinition> as_tried(
    const Problem& problem, const std::shared_ptr<const EffectDefinition>& effect);

// The effects of the catalogue that act on this set, and the user's own, less those in the model.
EffectList absent_effects(const Problem& problem, const Model& model, const EffectList& own);

// Whether some effect of the model draws numbers that are estimated with it.
bool has_draws(const Model& model);

// What one linearisation says of an effect beside a model, before anything is fitted.
struct Prospect {
  std::shared_ptr<const EffectDefinition> effect;
  EffectList companions;                    // Fitted with it.
  std::vector<std::vector<double>> starts;  // Of its parameters, then of its companions'.
  std::vector<size_t> free;                 // Its parameters that the data can see.
  // Total log-likelihood after one step of Gauss and Newton in all unknowns (the score test);
  // infinite where such a step says nothing: spreads, counts, servos, replacements.
  double expected_ll = std::numeric_limits<double>::infinity();
  std::optional<Model> step_to;  // Where one such step ends, however little it may say.
  // The same if predictions are dear and a fit can be expected to end about there.
  std::optional<Model> end_of_step;
  std::optional<FewRows> few;  // Looked at, and to be fitted, on these rows alone.
};

// The model with the effect and its companions at these values; replacements push out what they
// replace. Companions without values are small.
Model with_effect(Model model, const Prospect& prospect, const std::vector<double>& values);

// Nothing where the effect cannot be tested (and says why in `reasons`). The companions of its
// record come with it unless it is wanted `alone`. `near` is the base's own evaluation where there
// is one: with a small effect more, nuisances hardly move. Where `few` groups are given, these
// alone are looked at, and `near` is of them.
std::optional<Prospect> prospect_of(const Problem& problem, const Grown& base,
                                    const std::shared_ptr<const EffectDefinition>& effect,
                                    std::vector<NotTestable>& reasons, bool alone = true,
                                    const Evaluation* near = nullptr, const FewRows* few = nullptr);

// What prospects beside a model may start from; nothing where they are no steps of Gauss and Newton
// on all groups.
std::optional<Evaluation> start_of_prospects(const Problem& problem, const Model& model,
                                             const Evaluation* near = nullptr);

// Fits a prospect beside the model it was seen with.
std::optional<Candidate> fit_prospect(const Problem& problem, const Grown& base,
                                      const Prospect& prospect, std::vector<NotTestable>& reasons);

// Both in one.
std::optional<Candidate> try_effect(const Problem& problem, const Grown& base,
                                    const std::shared_ptr<const EffectDefinition>& effect,
                                    std::vector<NotTestable>& reasons);

// Whether the model can have the effect: beside those that cameras share, and others of its like.
bool has_place(const EffectDefinition& effect, Model model);

// Names an added effect of all cameras by the one camera that has none of its own of that name: it
// acts there alone, and may be exchanged there.
Grown named_by_camera(const Problem& problem, Grown grown);

// Fits every effect of the list beside the model. With `promising_only` or where predictions are
// dear (screening_groups), and where the problem is smooth, those whose score test says that they
// would not be significant are left out, of the others the best few are fitted, and spreads only
// where no effect of the mean clearly helps.
// Where rows are many, few groups may be asked first; what leads, and what gains a little, is
// fitted to all.
enum class Asked { all_rows, few_first };
Looks look_at(const Problem& problem, const Grown& base, const EffectList& effects, double material,
              bool promising_only = false, Asked asked = Asked::all_rows);

// Puts what another look found beside what this one did.
void join(Looks other, Looks& looks);

// Fits a candidate of few groups to all rows, and judges it as the look did that tried so many.
// `here` is the base's evaluation on the scored groups.
void ask_all_rows(const Problem& problem, const Grown& base, const Evaluation& here, double tried,
                  double material, Candidate& candidate);

}  // namespace seam::measurement
