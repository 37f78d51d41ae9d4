// Damped steps after Levenberg and Marquardt, and the descent made of them: the one way in which
// fits go downhill. What differs between fits (how dear a look is, what a gain is worth) is given
// by a DampingRule and a Worth. docs/design/engine.md says why it is our own.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

namespace seam::measurement {

// Half a sum of squares, or minus a log-likelihood, as it looks from where a fit stands.
struct Parabola {
  Eigen::MatrixXd curvature;  // J'J of residuals, or second derivatives.
  Eigen::VectorXd gradient;   // J'r of residuals.
  std::vector<char> held;     // Coordinates that may not move; empty: all may.
  // Along directions that curve less than this, by coordinate, nothing is told: steps there are
  // small, though a minimum lies somewhere far. Empty: 0 for all.
  Eigen::VectorXd untold;
};

// The parabola of residuals r with these derivatives.
Parabola parabola_of(const Eigen::MatrixXd& jacobian,
                     const Eigen::Ref<const Eigen::VectorXd>& residuals);

// Damping is in shares of each coordinate's own curvature, so that units do not matter.
struct DampingRule {
  double start = 1e-4;
  double shrink = 0.1;   // Factor after a step that was taken,
  double least = 1e-12;  // down to this.
  double grow = 10;      // Factor after one that was not,
  double firm = 1e-4;    // up to this at once.
  int attempts = 10;     // Steps tried from one place.
};

// What is worth a try or another look, in the unit of the parabola.
struct Worth {
  double promise = 0;  // A step that promises less is not tried.
  double again = 0;    // The same after one that was refused.
  double gain = 0;     // A step that gained less was the last.
};

// The step to the minimum of the damped parabola; coordinates that are held, or have no curvature,
// stay.
Eigen::VectorXd damped_step(const Parabola& here, double damping);

// Steps that keep their damping from one place to the next.
class DampedSteps {
 public:
  enum class Outcome { taken, worthless, refused };

  explicit DampedSteps(const DampingRule& rule) : rule_(rule), damping_(rule.start) {}

  // Tries steps from here, each more damped than the one before, until `move` takes one.
  Outcome take(const Parabola& here, const Worth& worth,
               const std::function<bool(const Eigen::VectorXd& by)>& move);
  void restart() { damping_ = rule_.start; }
  // What the last step that was tried promised to gain.
  double promised() const { return promised_; }

 private:
  DampingRule rule_;
  double damping_;
  double promised_ = 0;
};

struct Descent {
  std::function<Parabola()> look;
  std::function<bool(const Eigen::VectorXd& by)> move;  // Goes there if that is lower.
  std::function<double()> height;                       // In the unit of the parabola.
  std::function<Worth()> worth;
};

struct DescentEnd {
  enum class Reason { nothing_promised, nothing_gained, refused, steps_spent };
  Reason reason = Reason::steps_spent;
  double promised = 0;  // By the last step.
};

// Looks and steps until a step is not worth it or `most` are taken.
DescentEnd descend(const Descent& fit, const DampingRule& rule, int most);

}  // namespace seam::measurement
