// What an effect's record (effect.h) answers besides its formula: what a set must hold for the
// effect to be testable, where fits start, what it replaces, what separates it from others,
// and worked examples. Questions to a record: questions.h.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "effects/kind.h"

namespace seam::effects {

// What other parts need of a model, whatever effect gives it.
enum class Base {
  none,
  projection,  // The ideal perspective: fx, fy, cx, cy in pixels.
  response,    // DN in proportion to light: gain_dn, black_dn.
  servo,
  motor,  // A servo with torque: angle and rate of its joint are a state.
  walk,
  wheels,
  detector,
};

// Terms of which a model has one form at a time.
enum class Term {
  none,
  radial,     // How the distance from the optical axis is bent.
  angular,    // The same by the ray's angle from the axis.
  one_sided,  // How points move to one side: a lens off its axis, or tilted.
  kinematic,  // Rules by which a joint goes to its command without torque.
};

// What an effect changes, where a set sees only that and not which effect of the family it was.
enum class Family {
  none,
  pointing,    // Where the camera points.
  brightness,  // How bright an image is.
  noise,       // Noise that is new in every image.
};

// How the errors of an effect of spread hang together.
enum class Errors {
  independent,
  together,      // In time or in a run: white noise takes them for structure of the mean.
  now_and_then,  // A few are far larger than the others: they look like outliers.
};

// What a set must hold for an effect to be testable.
enum class Need {
  known_pose,   // The camera's place is known beforehand, not estimated from the same points.
  known_scale,  // Some distance is known beside those on the target itself.
  joints,       // The camera hangs on joints.
  tilt_joint,   // A joint that tilts; likewise pan and roll.
  pan_joint,
  roll_joint,
  pan_turn,        // A pan joint that turns a good part of a circle.
  tilt_reversals,  // The tilt (pan, roll) comes to its angles from both sides.
  pan_reversals,
  roll_reversals,
  moving_joint,      // Observations while a joint moves.
  moving_view,       // Something moves in the image while frames are taken.
  repeating_motion,  // The head repeats its motion with one period.
  encoder_steps,     // Angles that may have been rounded to steps.
  motor_torques,     // Torques of the motor, measured.
  known_inertia,     // An inertia that is known beside these torques.
  moving_body,       // The body moves.
  forward_walk,      // It walks forward (sideways, turns) in some run.
  sideways_walk,
  turning,
  both_turns,       // It turns to the left, and to the right.
  path,             // It covers a distance.
  bearings,         // Directions, not distances alone.
  distances,        // Distances, not directions alone.
  wheels,           // A body on two wheels, whose turns are known or commanded.
  commanded_walk,   // A body whose velocity is commanded, not the turns of its wheels logged.
  landmark_places,  // Landmarks whose places are separable from errors of ranges and bearings.
  space,            // Views beyond the plane of the ground.
  flat_target,      // The points lie in a plane, or nearly so: a board.
  several_views,    // The same points seen in several images.
  unknown_poses,    // Views whose poses are estimated from the points.
  still_views,      // Images that have nothing to do with each other but the target.
  several_cameras,  // Cameras side by side, a frame being one image of each.
  wide_view,        // Rays far from the middle of the image.
  colour,           // Three colours.
  light,            // Some light.
  frame_times,      // Each image has its time.
  repeated_pixels,  // The same samples of the sensor at many brightnesses.
};

// What a set lacks, and why in words for people. Without a reason an effect that needs it is no
// candidate at all: nobody asks why.
struct Lack {
  Need need;
  std::string why;
};

// What one measurement set says of itself to the effects; its kind fills it.
struct SetFacts {
  Kind kind{};
  std::vector<Lack> lacks;
};

// How a fit finds where to start.
enum class StartSearch {
  slope,           // A small step from neutral: the data's slope says which way.
  listed,          // At the values of the rule.
  best_listed,     // At the likeliest values of the rule, before any fit.
  shapes,          // The same, with the first parameter, a size, as large as the data ask for.
  wave,            // A coarse look over the first parameter's size and the second's phase.
  frequency,       // Where residuals have their strongest wave, in time or over the image.
  ceiling,         // From the largest values seen downwards.
  outliers,        // At the share and the mean of samples far from all others.
  excess,          // From the excess of the sensor's variances (start_from_excess).
  converter_bits,  // At each count of bits that the files allow.
  motion,          // Where accelerations seen agree best with the equation of motion.
};

struct StartRule {
  unsigned kinds = 0;  // Bits of the kinds to which it applies.
  StartSearch search = StartSearch::slope;
  std::vector<std::vector<double>> values = {};  // Of all parameters; for `listed`.
};

// Variances of the sensor beyond what a model predicts, DN^2, averaged over what was seen.
struct SensorExcess {
  double temporal_dn2 = 0;     // In time.
  double per_signal_dn = 0;    // Slope of that against the signal.
  double pattern_dn2 = 0;      // Of the fixed pattern,
  double pattern_of_gain = 0;  // and its slope against the square of the signal.
  double column_dn2 = 0;       // Between columns.
  double row_dn2 = 0;          // Between rows, new in each frame.
  // Correlation of neighbours' noise in a row, in a column.
  double likeness_in_row = 0, likeness_in_column = 0;
};

// Which measurement separates the effect from others in sets of these kinds.
struct Advice {
  unsigned kinds = 0;
  std::vector<std::string> from;  // Names of the other effects; empty: any.
  std::string text;
};

struct Quantity {
  std::string name;  // With its unit.
  double value = 0;
};

// A worked example whose numbers were computed outside SEAM (quantities by stage: proof/proof.h).
struct Proof {
  std::vector<double> values;   // Of the parameters, in the order of their declaration.
  std::vector<Quantity> given;  // In order; series repeat a name.
  std::vector<Quantity> expected;
  std::string source = "closed form";  // Or the expression that gave the numbers.
  double tolerance = 1e-9;             // Relative where a number is above 1.
};

}  // namespace seam::effects
