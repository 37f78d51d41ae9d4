// What the engine (compare, diagnose, add, fit, discover) asks of one measurement set, whatever its
// kind. A kind derives from `Problem` and implements `evaluate`; it may override `score`, `fit` and
// `structure` where sufficient statistics do better than residual vectors (photometry).
// Definitions: docs/reference/definitions.md; vocabulary: facts.h.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "effects/model.h"
#include "measurement/problem/evaluation.h"
#include "measurement/problem/facts.h"

namespace seam::measurement {

using effects::EffectDefinition;

struct ResidualView;

// Where a cause without a name may act, and what it may depend on there: a smooth function of one
// or two of the covariates, times each of the slopes (measurement/infer/smooth_field.h).
struct FieldPlace {
  std::vector<std::vector<double>> slopes;  // Of residuals over sigma, by direction and scalar.
  std::vector<Covariate> covariates;
  std::vector<int> part_of_row;  // A function of its own for each part, such as a view; empty: one.
  std::string part;              // What a part is ("view"), or what else the slopes depend on.
  // No parameter does what a function that is the same everywhere does: functions have a level.
  bool has_level = false;
  // What effects with names do there, as slopes are: it comes with a function, whose evidence is
  // what it does beside that.
  std::vector<std::vector<double>> named = {};
  // Turns a function times a slope, by scalar, into what arrives in the residuals: a torque acts on
  // all later angles. Empty: itself.
  std::function<void(std::vector<double>&)> arrives;
};

// Fewer groups than this are few (docs/reference/definitions.md, "Held-out groups").
inline constexpr size_t kFewGroups = 8;

// So many rows around one tell where its residual should lie.
inline constexpr size_t kNearRows = 8;

// What small changes of one model do to its whitened residuals, with the nuisances following at
// least as far as a first step goes.
class SmallChanges {
 public:
  virtual ~SmallChanges() = default;
  // By scalar, thread-safe. Empty: the other model predicts nothing.
  virtual std::vector<double> to(const Model& there) const = 0;
};

class Problem {
 public:
  virtual ~Problem() = default;

  const Facts& facts() const { return facts_; }

  // Thread-safe. `warm` is an earlier evaluation on the same groups, to start nuisances from.
  virtual Evaluation evaluate(const Model& model, const Groups& groups,
                              const Evaluation* warm = nullptr) const = 0;

  // Derivatives of the whitened residuals by each unknown with the nuisances following (one column
  // an unknown, by scalar). Default: differences of `evaluate`.
  virtual std::vector<std::vector<double>> jacobian(const Model& model,
                                                    const std::vector<Unknown>& unknowns,
                                                    const Groups& groups,
                                                    const Evaluation& here) const;
  // The same of changes that no parameter makes: given by column and scalar over `here.sigma`, with
  // the nuisances at rest. Default: where nothing follows and each residual is whitened by itself;
  // else empty, which says that it is not known.
  virtual std::vector<std::vector<double>> following(
      const Model& model, const Groups& groups, const Evaluation& here,
      std::vector<std::vector<double>> columns) const;

  // From this model, evaluated on these groups, which must outlive them. Default: by `evaluate`.
  virtual std::unique_ptr<SmallChanges> small_changes(const Model& model, const Groups& groups,
                                                      const Evaluation& here) const;

  // Where else than in the channels, by the set's covariates, a cause without a name may act.
  virtual std::vector<FieldPlace> field_places(const Model&, const Evaluation& /*here*/) const {
    return {};
  }

  // The problem whose residuals show causes without a name. Default: this one. A kind that has no
  // residual of each row has a table of means in its place.
  virtual const Problem& with_residuals() const { return *this; }

  virtual Score score(const Model& model, const Groups& groups) const;
  // The same for groups that are held out, given all others: where groups share draws (a target's
  // displaced points), these were estimated from the others. Default: groups share none.
  virtual Score score_held_out(const Model& model, const Groups& groups) const {
    return score(model, groups);
  }
  virtual Evaluation evaluate_held_out(const Model& model, const Groups& groups) const {
    return evaluate(model, groups);
  }
  virtual Fit fit(const Model& start, const std::vector<Unknown>& unknowns,
                  const Groups& groups) const;

  // Tests of mean and spread against every covariate and product, as strongest_first orders them.
  // Holds all tests that are significant; `fitted` parameters were estimated from these data.
  virtual std::vector<Structure> structure(const Model& model, const Groups& groups,
                                           int fitted) const;

  // Residuals beside their covariates, for plots. Default: those of `evaluate`.
  virtual ResidualView residual_view(const Model& model, const Groups& groups) const;

  // How far free predictions go wrong: over a second, over a whole run. Empty where each
  // observation is predicted by itself.
  virtual std::vector<FreeError> free_prediction(const Model&, const Groups&) const { return {}; }

  // What this model finds in all groups beside the values of its parameters.
  virtual std::vector<Finding> findings(const Model&) const { return {}; }

  // Figures of the field's standard that follow from a model: those that facts have of the
  // measurements (facts().figures) can be held against them. Without errors (figures_told.h).
  virtual std::vector<Figure> figures(const Model&) const { return {}; }

  // Further columns of the set that a formula of this kind may read.
  virtual std::vector<std::string> formula_columns() const { return {}; }

  // Called once with the model that the user gave, before anything else.
  void prepare(const Model& given) {
    given_ = given;
    place(given);
    if (beginnings_.problem) beginnings_.problem->prepare(given);
  }
  // Its values are where a fit may start from, too, where those fitted without an effect lead
  // nowhere with it: a perspective lens that was bent to a wide-angle one is far from the fisheye
  // that it is.
  const Model& given() const { return given_; }

  // Whether a model can be held against this set at all; throws InputError with the reason (a
  // points set needs a projection, ...).
  virtual void check_model(const Model& model) const = 0;

  // Whether this model's predictions are smooth in the parameters of effects of the mean, so that
  // one step of Gauss and Newton from a small start says about what a fit would reach.
  virtual bool is_smooth(const Model&) const { return false; }
  // Whether groups have errors of their own alone. Where they share some (fixed patterns of a
  // sensor, points of a target), the likelihood of all of them is not the sum over training and
  // held-out groups.
  virtual bool groups_are_independent(const Model&) const { return true; }
  // Whether a fit to training groups is as likely to all groups as one to all is, but for what
  // chance allows: not where parts of the set tell parameters in unlike directions.
  virtual bool training_stands_for_all() const { return true; }
  // What the set and this model can say together, beside any number: views that it finds no pose
  // for, how far the data reach, what they cannot tell. Sentences.
  virtual std::vector<std::string> remarks(const Model&) const { return {}; }
  // Why a model that was fitted is no result, however much it gains; empty: nothing speaks against
  // it.
  virtual std::string no_result_because(const Model&) const { return ""; }
  // Where the model puts the points of a target, with what is drawn once and estimated; empty
  // where it leaves them at their plan.
  virtual std::vector<PlacedPoint> placed_points(const Model&) const { return {}; }
  // Where predictions are dear: the few training groups on which candidates are screened before any
  // is fitted to all of them.
  virtual std::optional<Groups> screening_groups() const { return std::nullopt; }
  // Whether two models' predictions differ by more than the accuracy of predicting. Where they do
  // not, no gain of likelihood speaks for either.
  virtual bool is_visible(const Model&, const Model&) const { return true; }

  // Whether the effect is a candidate here: its record knows.
  virtual bool acts(const EffectDefinition& effect) const;
  // Why a parameter cannot be tested with these data before any look at numbers; empty: it can.
  // Default: what the effect needs (its record) and this set lacks.
  virtual std::string not_testable(const Model& model, const EffectDefinition& effect,
                                   size_t parameter) const;
  // Values from which fits of a candidate start (all are tried, the best is kept). Default: those
  // that the effect's record lists, else a small step from neutral in each direction. A kind that
  // knows where its companions start says that behind them.
  virtual std::vector<std::vector<double>> starts(const Model& model,
                                                  const EffectDefinition& effect) const;
  using EffectList = std::vector<std::shared_ptr<const EffectDefinition>>;
  virtual std::vector<std::vector<double>> starts_together(const Model& model,
                                                           const EffectDefinition& effect,
                                                           const EffectList& companions) const;
  // The same for a fit to these groups alone. Default: where likely values are looked for, they are
  // looked for there; else the starts are those of any fit.
  virtual std::vector<std::vector<double>> starts_on(const Groups& groups, const Model& model,
                                                     const EffectDefinition& effect,
                                                     const EffectList& companions) const;
  // The values of a rule that are the likeliest on these groups, before any fit.
  std::vector<double> likeliest(const Model& model, const EffectDefinition& effect,
                                const effects::StartRule& rule, const Groups& groups) const;
  // At how many independent places the starts of an effect looked for the best one (frequencies,
  // counts): so many looks it counts for. Default: its starts where it has counts.
  virtual double looks(const Model& model, const EffectDefinition& effect) const;
  // By scalar: rows in which a residual is more than 6 robust sigmas from the median of its
  // neighbours' under this model: of the nearest, or of more of them where bursts of errors are
  // most of the nearest.
  virtual std::vector<char> find_outliers(const Model& model) const;
  // Why this kind looks for no outliers, for people who miss them; empty: it does.
  virtual std::string no_outliers_because() const { return ""; }
  // Up to `count` rows whose residuals should be like this one's, the nearest first. Default: the
  // nearest in time of its series.
  virtual std::vector<int> neighbours(size_t row, size_t count) const;
  // What measurement would separate two effects or give an untestable one leverage; may be empty.
  // Default: what their records say.
  virtual std::string advice(const std::string& effect, const std::string& other) const;

  // Rows that a person left out when the set was read.
  void say_left_out(const LeftOut& rows);

  // By scalar: 1 leaves it out of everything.
  void leave_out(std::vector<char> outliers);
  bool left_out(size_t scalar) const {
    return (!left_out_.empty() && left_out_[scalar]) || (!gross_.empty() && gross_[scalar]);
  }
  const std::vector<char>& left_out() const { return left_out_; }
  // Each channel's noise, so many times as large.
  void resize_noise(const std::vector<double>& factor_of_channel);

  // The same set with the first rows of each group alone, where groups are long: fits and looks go
  // most of their way there (fitting/few_groups.h). A group's first rows are predicted without
  // those that follow.
  struct Beginnings {
    std::unique_ptr<Problem> problem;
    std::vector<size_t> scalar;  // In the whole set, of each of its scalars.
  };
  void have_beginnings(Beginnings beginnings) { beginnings_ = std::move(beginnings); }
  const Problem* beginnings() const { return beginnings_.problem.get(); }

  // Tells sets of marks and noises apart, for what is kept of predictions that depend on them.
  int64_t times_marked() const { return times_marked_; }

  // Held-out folds: one (30 %) where groups are many, else each group in turn.
  virtual const std::vector<Groups>& folds() const;
  // So many groups are many: below, a third of them is too few to say anything by its scatter.
  virtual size_t groups_for_one_fold() const { return kFewGroups; }
  // What the inputs of some groups show and those of others do not, such as a level of light: by
  // regime the groups that show it, of which some train and some are held out in that one fold.
  // Default: each label, and each sign.
  virtual std::vector<Groups> regimes() const;
  // The groups that `error` is about: the held-out ones of the one fold, else all.
  Groups scored_groups() const;
  // By scalar: its block, a stretch of its group in time. Where groups are few their blocks stand
  // in for them: the scatter of gains is told from them, and those of one group alone are held out
  // in turn. Empty where groups are many.
  const std::vector<int>& blocks() const;
  size_t block_count() const { return block_count_; }  // Known after blocks().
  // What is fitted while the first fold is held out; one group alone cannot be held out and is
  // both.
  Groups training_groups() const;
  Groups all_groups() const { return Groups(facts_.groups.size(), 1); }

 protected:
  // Throws InputError where a formula of one of these stages reads a column that the set lacks.
  void check_columns(const Model& model, const std::vector<effects::Stage>& stages) const;
  // Covariates that stand for a place in the image are taken from the given model's prediction,
  // since a measured place holds the very noise that stands in the residual.
  virtual void place(const Model&) {}

  Facts facts_;
  // By scalar: 1 where no model could explain the row (a corner with another's name): it is left
  // out whatever the model.
  std::vector<char> gross_;

 private:
  Model given_;
  std::vector<char> left_out_;
  int64_t times_marked_ = 0;
  Beginnings beginnings_;
  void cut_blocks() const;

  mutable std::once_flag folds_cut_, blocks_cut_;
  mutable std::vector<Groups> folds_;
  mutable std::vector<int> blocks_;
  mutable size_t block_count_ = 0;
  mutable std::vector<int> series_order_;  // Rows by series and time, and each row's place in it.
  mutable std::vector<int> series_place_;
};

Groups complement(const Groups& groups);

// Fills used, residual, whitened and log_det of an evaluation whose S is diagonal, from `residual`
// and `sigma` by scalar.
void whiten_diagonal(const Problem& problem, const Groups& groups, Evaluation& evaluation);

// Score of an evaluation; what Problem::score does with evaluate's result.
Score score_of(const Problem& problem, const Evaluation& evaluation);
// Its log-likelihood alone, which fits ask for at every step.
double log_likelihood_of(const Problem& problem, const Evaluation& evaluation);
// The same of the scalars in one block alone.
Score score_of_block(const Problem& problem, const Evaluation& evaluation, int block);

}  // namespace seam::measurement
