// What the engine (compare, diagnose, add, fit, discover) needs to know of one measurement set,
// whatever its kind. A kind derives from `Problem` and implements `evaluate`; it may override
// `score`, `fit` and `structure` where sufficient statistics do better than residual vectors
// (photometry). Definitions: docs/definitions.md.
//
// Vocabulary: a *row* is one line of the observation file; a *scalar* is one residual (a row of
// points has two, u and v). Vectors over scalars always have the length of all scalars; entries
// outside the chosen groups, or left out as outliers, have `used` 0.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "effects/model.h"
#include "effects/questions.h"
#include "sim_core/base/random.h"

namespace seam::measurement {

using effects::EffectDefinition;
using effects::Model;

// One flag a group: whether it takes part.
using Groups = std::vector<char>;

struct Channel {
  std::string name;        // The residual's name with its unit: u_px.
  double noise = 1;        // One sigma of a single observation, in that unit.
  bool estimated = false;  // The set left its noise unknown.
};

struct Covariate {
  enum class Type {
    smooth,    // A quantity.
    sign,      // -1, 0, 1.
    cyclic,    // An angle in radians.
    category,  // A label, numbered from 0: structure is a mean for each.
  };
  std::string name;  // As docs/definitions.md, "What remains", has it.
  Type type = Type::smooth;
  std::vector<double> values;  // One a row; NaN where unknown.
  bool in_products = true;     // Whether `a*b` with the other covariates is looked at.
};

// A residual made of two channels of a row, such as that along the radius; its weights are of unit
// length, so that it has the noise of its parts.
struct CombinedChannel {
  std::string name;
  int channel_a = 0, channel_b = 1;
  std::vector<double> weight_a, weight_b;  // By row.
};

// What never changes: filled by the kind when it reads the set.
struct Facts {
  effects::SetFacts set;  // What it says of itself to the effects: its kind, what it lacks.
  std::string title;
  std::string fingerprint;
  std::string file;  // Of the observations, for messages.
  std::vector<int> line_of_row;
  std::vector<Channel> channels;
  std::vector<std::string> groups;  // Their names.
  std::vector<int> group_of_row;
  std::vector<double> time_of_row;  // Seconds since the set's reference; orders neighbours.
  // Neighbours for outliers and correlation: rows of one series (a landmark's track in a run, a
  // joint log's run), numbered; empty: the group is the series.
  std::vector<int> series_of_row;
  bool tests_neighbours = true;  // Whether the structure tests look for correlation in a series.
  std::vector<int> row_of;       // By scalar.
  std::vector<int> channel_of;   // By scalar.
  std::vector<Covariate> covariates;
  std::vector<std::string> notes;         // What of the set takes no part, and why: sentences.
  std::vector<CombinedChannel> combined;  // Looked at by the structure tests beside the channels.

  std::string kind() const { return effects::kind_facts(set.kind).name; }
  size_t scalars() const { return row_of.size(); }
  size_t rows() const { return line_of_row.size(); }
  int group_of(size_t scalar) const { return group_of_row[row_of[scalar]]; }
};

// A parameter that a fit may change.
struct Unknown {
  std::string effect;
  size_t parameter = 0;
};

// Residuals of a model with the best nuisances (unknown poses, true starts of runs).
struct Evaluation {
  std::vector<char> used;        // By scalar.
  std::vector<double> residual;  // Observed - predicted, in the channel's unit.
  std::vector<double> whitened;  // L^-1 residual with S = L L' = set noise + model noise effects.
  std::vector<double> sigma;     // By scalar: square root of the diagonal of S.
  std::vector<double> log_det;   // By group: log det S (groups are independent of each other).
  int64_t nuisances = 0;         // Fitted on these groups.
  std::vector<double> nuisance_values;  // For a warm start; layout is the kind's own.
  bool valid = true;  // False where the model cannot predict an observation (no image point).
  // For a kind's own use: what it need not compute again from a warm start. `mean_key` holds the
  // parameters of the mean; `reusable` may lag behind them (a fit evaluates afresh between rounds).
  std::vector<double> mean_key;
  std::shared_ptr<const void> reusable;
};

// The parameters of a model that act on the mean, in order.
std::vector<double> mean_parameters(const Model& model);

// How well a model does on some groups.
struct Score {
  double chi2 = 0;  // r' S^-1 r.
  int64_t n = 0;    // Residuals.
  int64_t nuisances = 0;
  double log_likelihood = 0;
  std::vector<double> by_group;     // Log-likelihood of each group; 0 outside the chosen ones.
  std::vector<double> native;       // By channel: plain root mean square of the residuals.
  std::vector<double> native_sum2;  // By channel, so that folds can be pooled.
  std::vector<int64_t> native_count;
  bool valid = true;

  double error() const;
};

struct Fit {
  Model model;                // At the estimate; sigmas of the unknowns are not written into it.
  std::vector<double> value;  // By unknown.
  std::vector<double> sigma;  // By unknown; infinite where the data say nothing of it.
  std::vector<char> at_bound;
  std::vector<double> covariance;  // Row-major, unknowns x unknowns.
  double log_likelihood = 0;       // On the fitted groups.
  bool converged = false;
};

// A structure of the residuals that should not be there.
struct Structure {
  std::string residual;   // Channel.
  std::string moment;     // mean | spread
  std::string covariate;  // row*pan_rate
  double strength = 0;    // Root mean square of the explained part, in the residual's unit.
  double p_value = 1;     // Corrected for the number of looks.
  double explained = 0;   // Share of the residual's sum of squares.
};

// The noise of a residual's channel, or of the first of the two that a combined one is made of.
double noise_of(const Facts& facts, const std::string& residual);

// Surest first. Values of p that are cut (1e-300) are no order: of these, and of equals, the one
// that is stronger in units of its channel's noise goes first.
void strongest_first(const Facts& facts, std::vector<Structure>& structures);

struct Outlier {
  int line = 0;
  size_t scalar = 0;
  double residual = 0;
};

struct ResidualView;

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

  virtual Score score(const Model& model, const Groups& groups) const;
  virtual Fit fit(const Model& start, const std::vector<Unknown>& unknowns,
                  const Groups& groups) const;

  // Tests of mean and spread against every covariate and product, as strongest_first orders them.
  // Holds all tests that are significant; `fitted` parameters were estimated from these data.
  virtual std::vector<Structure> structure(const Model& model, const Groups& groups,
                                           int fitted) const;

  // Residuals beside their covariates, for plots. Default: those of `evaluate`.
  virtual ResidualView residual_view(const Model& model, const Groups& groups) const;

  // Further columns of the set that a formula of this kind may read.
  virtual std::vector<std::string> formula_columns() const { return {}; }

  // Called once with the model that the user gave, before anything else.
  void prepare(const Model& given) {
    given_ = given;
    place(given);
  }
  // Its values are where a fit may start from, too, where those fitted without an effect lead
  // nowhere with it: a perspective lens that was bent to a wide-angle one is far from the fisheye
  // that it is.
  const Model& given() const { return given_; }

  // Whether a model can be held against this set at all; throws InputError with the reason (a
  // points set needs a projection, ...).
  virtual void check_model(const Model& model) const = 0;

  // Whether predictions are smooth in the parameters of effects of the mean, so that one step of
  // Gauss and Newton from a small start says about what a fit would reach.
  virtual bool is_smooth() const { return false; }
  // Whether groups have errors of their own alone. Where they share some (fixed patterns of a
  // sensor), the likelihood of all of them is not the sum over training and held-out groups.
  virtual bool groups_are_independent() const { return true; }
  // Whether one effect can do about what several others do together, so that the best first step
  // may be a blind alley and the search begins with others too.
  virtual bool effects_imitate() const { return false; }
  // Where predictions are dear: the few training groups on which candidates are screened before any
  // is fitted to all of them.
  virtual std::optional<Groups> screening_groups() const { return std::nullopt; }
  // Whether two models' predictions differ by more than the accuracy of predicting. Where they do
  // not, no gain of likelihood speaks for either.
  virtual bool is_visible(const Model&, const Model&) const { return true; }

  // Whether the effect is a candidate here: its record knows.
  bool acts(const EffectDefinition& effect) const;
  // Why a parameter cannot be tested with these data before any look at numbers; empty: it can.
  // Default: what the effect needs (its record) and this set lacks.
  virtual std::string not_testable(const Model& model, const EffectDefinition& effect,
                                   size_t parameter) const;
  // Values from which fits of a candidate start (all are tried, the best is kept). Default: those
  // that the effect's record lists, else a small step from neutral in each direction.
  virtual std::vector<std::vector<double>> starts(const Model& model,
                                                  const EffectDefinition& effect) const;
  // At how many independent places the starts of an effect looked for the best one (frequencies,
  // counts): so many looks it counts for. Default: its starts where it has counts.
  virtual double looks(const Model& model, const EffectDefinition& effect) const;
  // By scalar: rows in which a residual is more than 6 robust sigmas from the median of its
  // neighbours' under this model.
  virtual std::vector<char> find_outliers(const Model& model) const;
  // Why this kind looks for no outliers, for people who miss them; empty: it does.
  virtual std::string no_outliers_because() const { return ""; }
  // Rows whose residuals should be like this one's. Default: the nearest in time of its series.
  virtual std::vector<int> neighbours(size_t row) const;
  // What measurement would separate two effects or give an untestable one leverage; may be empty.
  // Default: what their records say.
  virtual std::string advice(const std::string& effect, const std::string& other) const;

  // By scalar: 1 leaves it out of everything.
  void leave_out(std::vector<char> outliers) { left_out_ = std::move(outliers); }
  bool left_out(size_t scalar) const { return !left_out_.empty() && left_out_[scalar]; }
  const std::vector<char>& left_out() const { return left_out_; }

  // Held-out folds: one (30 %) with 4 groups or more, else each group in turn.
  virtual const std::vector<Groups>& folds() const;
  // What is fitted while the first fold is held out; one group alone cannot be held out and is
  // both.
  Groups training_groups() const;
  Groups all_groups() const { return Groups(facts_.groups.size(), 1); }

 protected:
  // Covariates that stand for a place in the image are taken from the given model's prediction,
  // since a measured place holds the very noise that stands in the residual.
  virtual void place(const Model&) {}

  Facts facts_;

 private:
  Model given_;
  std::vector<char> left_out_;
  mutable std::vector<Groups> folds_;
  mutable std::vector<int> series_order_;  // Rows by series and time, and each row's place in it.
  mutable std::vector<int> series_place_;
};

Groups complement(const Groups& groups);

// Fills used, residual, whitened and log_det of an evaluation whose S is diagonal, from `residual`
// and `sigma` by scalar.
void whiten_diagonal(const Problem& problem, const Groups& groups, Evaluation& evaluation);

// Score of an evaluation; what Problem::score does with evaluate's result.
Score score_of(const Problem& problem, const Evaluation& evaluation);

}  // namespace seam::measurement
