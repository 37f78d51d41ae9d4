// The search for the set of effects that the data support: forward steps, then dropping and
// exchanging, until nothing improves; then the test of what structure remains.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "measurement/infer/unnamed.h"
#include "measurement/judge/material.h"
#include "measurement/search/candidates.h"
#include "measurement/suggest/suggest.h"

namespace seam::measurement {

struct Step {
  std::string effect;
  Assessment after;  // The model with this step and those before it.
  double error_before = 0;
  double error_after = 0;
  double moved = 0;  // By how many noise units it moves predictions.
  std::vector<std::string> indistinguishable_from;
  std::vector<std::string> doubts;  // Why it is no cause established, whatever it gains.
};

// A trace that stays in the model, since a value is told wrong without it (kept.h).
struct KeptTrace {
  std::string effect;
  Unknown value;      // That it moves most,
  double errors = 0;  // by so many of its own errors.
  double error_before = 0;
  double error_after = 0;
};

// A lens of splines that no lens with a formula reaches (empirical_lens.h).
struct EmpiricalLens {
  std::string effect;
  std::vector<std::string> beside;      // Effects found by the search that it was fitted with.
  std::vector<std::string> named;       // Of the best model whose lens has a formula: its lens.
  double lead = 0;                      // Log-evidence ahead of that model.
  double error = 0, named_error = 0;    // On held-out groups, of both,
  double rms_px = 0, named_rms_px = 0;  // and in pixels.
  Assessment assessment;
};

struct SearchResult {
  Grown base;  // The model given, refitted.
  std::vector<Structure> base_structure;
  std::vector<Structure> base_traces;  // Significant, but not material.
  Looks first;                         // Candidates for the first step.
  // Whether under the marks of outliers that stand in the end; else under earlier ones.
  bool first_is_of_base = false;
  Grown best;                        // With all effects found.
  std::vector<Step> steps;           // In the order in which they help most.
  std::vector<KeptTrace> kept;       // In `best` beside the steps.
  std::vector<Structure> remaining;  // Significant structure after the last step.
  std::vector<Structure> remaining_traces;
  // What no effect with a name explains as well: smooth functions, and a formula beside `best`.
  // Effects that only imitate it were found, and are no steps.
  std::optional<UnnamedCause> unnamed;
  std::optional<Suggestion> suggestion;
  std::vector<std::string> mimics;
  std::optional<EmpiricalLens> splines;
  std::vector<TriedFunction> functions;  // Smooth ones, beside `best`.
  bool formula_sought = false;
  bool ties_sought = false;            // Not where a cause is unexplained.
  double mimics_error = 0;             // Of the model that has them.
  std::vector<Candidate> last_traces;  // Effects that are traces beside the best model.
  double material = 0;                 // The least that counts, in noise units.
  std::vector<Outlier> outliers;       // Of the best model.
  size_t outliers_of_given = 0;        // As many has the model given.
  double outlier_share = 0;            // Above kMostOutliers none is left out.
  std::string verdict;                 // Of diagnose.
  double errors_widened = 1;  // Those of the best model, at most so much, since groups differ.
};

using Progress = std::function<void(const std::string&)>;

// Leaves the problem with its outliers marked.
SearchResult search(Problem& problem, const Model& model, const EffectList& own,
                    const Progress& progress, double material = kMaterial);

// Whether an effect that makes large errors now and then was added to the given model.
bool estimates_large_errors(const Model& given, const Model& model);

// The model that says what an outlier is: the best one, without the large errors now and then that
// a search gave it where fewer than ten rows have such, which tell no distribution: they are gross.
// Where as many or more were left out, one by one, and an effect explains them, with this effect.
// `in_vain`: they were given back before, and no effect took them: the model as it is. `proven`: an
// effect that makes them was found with them left out: fitted to all rows, it says which it makes.
enum class LargeErrors { open, in_vain, proven };
Model judge_of_outliers(Problem& problem, const Model& given, const Grown& best,
                        LargeErrors large_errors);

// The error of a model on all rows but its outliers, where these are few: gross errors say nothing
// against it.
double error_beside_outliers(const Problem& problem, const Model& model);

// Marks outliers under this model, beside those marked before if these are to be kept; returns
// whether the marks changed.
bool mark_outliers(Problem& problem, const Model& model, SearchResult& result, bool keep = false);

// The size of a noise that the set leaves unknown is estimated from the measurements before any
// model is fitted, and may be wrong by more than chance. Where the noises that were found say no
// more than another size of it would: gives the problem that size, and returns true. All that was
// fitted before is then out of date.
bool correct_noise(Problem& problem, const Grown& best);

}  // namespace seam::measurement
