// The terms that a formula may be made of, and how much each would take of what a model leaves.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "measurement/fitting/assess.h"
#include "measurement/fitting/few_groups.h"
#include "measurement/suggest/along.h"

namespace seam::measurement {

// The model with an effect of these terms.
Model with_formula(Model model, const std::shared_ptr<const EffectDefinition>& effect,
                   const std::vector<Term>& terms);

class TermLibrary {
 public:
  // Terms of the vocabulary, and curves at places of its variables, looked at beside a model on
  // some 4,000 residuals of training groups, so that they know nothing of held-out ones.
  TermLibrary(const Problem& problem, const Model& base, const Vocabulary& vocabulary);

  bool valid() const { return start_.valid && !start_.whitened.empty(); }
  // Terms that are looked at for one.
  double looks() const;
  // Of all residuals that take part.
  double count() const { return count_; }
  // A few terms that gain more than they cost beside what a model fits, the best first, each unlike
  // those before it: the gain is that of one linear step, of which some fits make nothing.
  std::vector<Term> best_terms(const Assessment& here);

 private:
  using ByScalar = std::vector<double>;

  struct Worth {
    double worth = 0;
    Term term;
    ByScalar own;  // Its column beyond what is fitted, of unit length.
  };

  double dot(const ByScalar& a, const ByScalar& b) const;
  void take_out(const ByScalar& direction, ByScalar& from) const;
  // Tries that step first, where one is given, and leaves the one that was taken.
  ByScalar derivative(const Term& term, double* step_to_try = nullptr) const;
  void look_from(const Assessment& here);
  ByScalar beyond(ByScalar column) const;
  Worth worth_of(Term term, const ByScalar& column) const;
  std::vector<Worth> worths() const;
  static void sort(std::vector<Worth>& worths);
  std::vector<Worth> unlike(std::vector<Worth> worths, size_t most) const;
  void set_coefficient(const ByScalar& column, const ByScalar& own, Term& term) const;
  void add_curves(const Term& carrier, const std::string& variable, std::vector<double> values);
  void add_terms();
  std::vector<FieldPlace> places_of() const;
  Term moved_to_the_best(Term term) const;
  double price_of_number() const;
  std::vector<double> rest_of(const Along& along) const;
  std::optional<Term> best_wave(const Along& along, double& gain) const;
  std::optional<Term> best_bump(const Along& along) const;

  const Model& base_;
  const Vocabulary& vocabulary_;
  FewRows rows_;
  double count_ = 0;
  double share_ = 1;  // How many residuals there are for each that is looked at.
  Evaluation start_;  // Of the base.
  std::unique_ptr<SmallChanges> changes_;  // From there.
  std::vector<Term> terms_;
  std::vector<ByScalar> library_;  // Derivatives by each term's coefficient.
  std::vector<Along> along_;       // In which waves are looked for.
  std::vector<ByScalar> basis_;    // What the fitted parameters span, orthonormal.
  ByScalar rest_;                  // What they leave.
  double misfit_ = 1;
};

}  // namespace seam::measurement
