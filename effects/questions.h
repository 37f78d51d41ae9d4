// Questions to an effect's record that hold for every effect, of the catalogue, a plugin or a
// formula: what the record does not say follows from its stage.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "effects/model.h"

namespace seam::effects {

// A need in words that go on from "needs".
std::string to_string(Need need);

// What a set must hold for this parameter to be testable: needs of the stage, of the effect, and of
// the parameter, in this order.
std::vector<Need> needs_of(const EffectDefinition& effect, size_t parameter);

// Whether it says something of measured points alone (a detector of corners, a target): images,
// runs and files of other programs pass it by, whichever hooks it sets.
bool of_points_alone(const EffectDefinition& effect);
// The model without these.
Model without_points_own(const Model& model);

// Whether the simulator runs it: it changes robots or their images, not only what is reported of a
// measurement (noises, detectors, targets).
bool acts_in_runs(const EffectDefinition& effect);

// Whether the effect is a candidate in such a set.
bool acts_on(const EffectDefinition& effect, const SetFacts& set);

// Why the set does not constrain this parameter; empty: it does.
std::string reason_against(const EffectDefinition& effect, size_t parameter, const SetFacts& set);

// Where fits of the effect start in sets of this kind.
const StartRule& start_rule(const EffectDefinition& effect, unsigned kind);

// Which measurement of this kind separates `effect` from `other`; empty: neither knows one.
std::string advice_between(const std::string& effect, const std::string& other, unsigned kind);

// The effect by which a model has this base; null where it has none.
const ModelEffect* base_of(const Model& model, Base base);
// Whether it has the base, or an effect in its place.
bool has_base(const Model& model, Base base);
// The catalogue's effect that is this base, for messages.
std::string base_name(Base base);

// The base that the effect needs and the model lacks, by its name in the catalogue; empty: none.
std::string missing_base(const EffectDefinition& effect, const Model& model);

// What two effects of the model have against each other (one replaces the other, one needs a base
// that is not there), in words; empty: nothing.
std::string conflict_in(const Model& model);

// Whether the effect takes the place of every form of this term.
bool replaces(const EffectDefinition& effect, Term term);
// Whether it is a lens that replaces every other, of any form; and that of the catalogue.
bool is_any_lens(const EffectDefinition& effect);
std::shared_ptr<const EffectDefinition> any_lens();
// The effect that stands in the model beside what it should replace; null where none does.
const ModelEffect* replacement_in(const Model& model);
// The effect that replaces in the model whatever is a form of `effect`'s term; null
// where none does.
const ModelEffect* excluding(const EffectDefinition& effect, const Model& model);
// Whether `effect` has no place beside what the model holds already.
bool is_excluded(const EffectDefinition& effect, const Model& model);
// The effects that the search offers together with this one: those of its companions that the model
// lacks.
std::vector<std::shared_ptr<const EffectDefinition>> companions_of(const EffectDefinition& effect,
                                                                   const Model& model);
// Whether some effect of the model would have no base without this one.
bool has_dependents(const Model& model, const std::string& effect);
// Takes out of the model what `effect` replaces, and the base whose place it takes if that has
// nothing of its own to say.
void remove_replaced(const EffectDefinition& effect, Model& model);

}  // namespace seam::effects
