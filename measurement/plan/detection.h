// How surely the search finds an effect of a given size: its rules (judge/judge.h), applied to
// what a fit gains when residuals are linear in the parameters and errors are normal.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace seam::measurement {

// What a part of a set says of some columns J of derivatives: a group, or all that a fit sees.
struct PartInformation {
  Eigen::MatrixXd information;  // J'J.
  Eigen::VectorXd score;        // J'm, where m is by what the effect moves whitened residuals.
};

// A look at one effect. Of the columns the first `base` are refitted with and without the effect.
struct EffectLook {
  size_t base = 0;
  std::vector<PartInformation> held;  // Groups that are held out, each by itself.
  // All groups that are fitted and never held out; empty: each held group is left out in turn.
  PartInformation trained;
  // By channel the held-out J'J over their number of residuals: how far predictions move.
  std::vector<Eigen::MatrixXd> movement;
  // The share of what the parts say one by one that they say together: a pattern that groups have
  // in common is seen once.
  double together = 1;
  double residuals = 0;  // Held out; 0: so many that their error is 1.
  double price = 0;      // Log-likelihood that the effect must gain to be ahead in evidence.
  double material = 0;   // The least change of predictions that counts, in noise units.

  bool in_turn() const { return trained.information.size() == 0; }
  size_t columns() const { return static_cast<size_t>(held.front().information.rows()); }
  // Of all groups together.
  PartInformation whole() const;
  // Of those that the values come from which a model states.
  PartInformation fitted() const;
};

// The chance that the search calls an effect significant and material that moves residuals by
// `scale` times the look's scores.
class Detection {
 public:
  explicit Detection(const EffectLook& look);
  double chance(double scale) const;
  // The scale with a chance of 95 %; infinite where none up to `most` has it.
  double scale_found(double most) const;

 private:
  // By the scale c: of c^2, of c, and without it.
  struct Quadratic {
    double square = 0, linear = 0, constant = 0;
    double at(double scale) const { return (square * scale + linear) * scale + constant; }
  };
  struct Draw {
    Quadratic trained;            // Log-likelihood gained where the values come from.
    std::vector<Quadratic> held;  // By held-out group.
    std::vector<Quadratic> moved2;
    double misfit = 1;  // By which likelihood ratios are worth less.
  };
  // From scores to estimates, with the effect and without it.
  struct Estimators {
    Eigen::MatrixXd with, without;
  };
  Estimators estimators_of(const Eigen::MatrixXd& information) const;
  Draw drawn(uint64_t number) const;
  bool is_found(const Draw& draw, double scale) const;

  const EffectLook& look_;
  PartInformation fitted_;
  Estimators of_fitted_;
  std::vector<Estimators> of_rest_;     // Without a held group, where each is left out in turn.
  std::vector<Eigen::MatrixXd> roots_;  // Of the parts' information: held ones, what is trained.
  std::vector<Draw> draws_;
};

// By column, of the values that a model states; infinite where nothing is said of one.
std::vector<double> standard_errors(const EffectLook& look);

// What the effect gains on average where nothing is held out: half the squared length of the part
// of the shift that its columns explain and the base's do not.
double gain_of(const PartInformation& whole, size_t base);

}  // namespace seam::measurement
