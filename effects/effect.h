// A physical effect: its name, stage, parameters, help, the signature it leaves in residuals, its
// function, and what else is asked of it (answers.h). One definition drives the rendered images,
// the robots' joints and legs, and the prediction of measurements. Catalogue: registry.cc;
// composition of effects: model.h and the stage headers (timing.h, geometry.h, ...), each of which
// runs the hooks of one stage.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "effects/answers.h"
#include "effects/kind.h"
#include "sim_core/base/pose.h"

namespace seam::effects {

struct Timing;          // timing.h
struct JointTrack;      // joint_track.h
struct ServoModel;      // servo.h
struct JointSample;     // joint_track.h
struct ImagePoint;      // geometry.h
struct Optics;          // optics.h
struct LightWindow;     // optics.h
struct SensorChain;     // sensor.h
struct Detection;       // detector.h
struct Locomotion;      // locomotion.h
struct Noise;           // noise.h
struct VelocitySample;  // locomotion.h
struct Tracker;         // locomotion.h
struct TargetShape;     // target.h

enum class JointRole;  // joint_track.h

// Between which values a parameter lies in things that people have, and who says so. Beyond it a
// result is doubted, not forbidden: `min` and `max` of the parameter bound what has a meaning.
struct Plausible {
  double min = 0;
  double max = 0;
  std::string source;  // Empty: nobody knows such a range.
};

struct Parameter {
  std::string name;    // With its unit: line_delay_s.
  double neutral = 0;  // At this value (of all parameters) the effect is absent, bit for bit.
  double min = 0;      // Bounds of what is meaningful; a fit stays inside.
  double max = 0;
  double scale = 1;       // A typical size: where fits start and how long their steps are.
  std::string help;       // A sentence: what it is, in which unit, with which sign.
  bool integer = false;   // Counts and bits, which no fit changes.
  bool required = false;  // Has no neutral value: a model that lists the effect must give it.
  // The neutral value is infinity (a limit that never binds): a fit works on 1 / value, in which
  // the effect is absent at 0, and `scale` is a typical value, not a typical step.
  bool fit_reciprocal = false;
  // Stays at its neutral value unless the data ask for it: a fit frees it only when that pays.
  bool on_demand = false;
  // Other parameters can do all that it does: it is stated, and fitted only where a model frees it.
  bool stated = false;
  // Values closer than this give the same rounded samples: a fit knows it to no better than this /
  // sqrt(12).
  double resolution = 0;
  std::vector<Need> needs = {};  // Beside those of the effect.
  Plausible plausible = {};
};

// The values of an effect's parameters, in the order in which it declares them.
using Values = std::span<const double>;

struct EffectDefinition {
  std::string name;
  Stage stage = Stage::geometry;
  unsigned kinds = 0;  // Kind bits.
  std::vector<Parameter> parameters;
  std::string help;          // What it is, for `seam effects NAME`.
  std::string formula;       // As in the catalogue.
  std::string signature;     // What it leaves in residuals when it is missing.
  std::string example;       // One line of a model's YAML.
  bool spread_only = false;  // Changes the spread of measurements, never their mean.
  // Of a spread: each of its draws is one for the whole set and estimated with it (where the points
  // of a target truly are), so that it moves predictions, too.
  bool draws_estimated = false;
  Errors errors = Errors::independent;  // What sort of errors it makes.
  // A noise that is described by its size and length, or a lens by what it does, not by what makes
  // it: it is said to be of unknown cause, not to be missing.
  bool unknown_cause = false;
  bool has_neutral = true;           // False for a base (pinhole) or a replacement (fisheye).
  std::vector<std::string> columns;  // Further columns of a set that its formulas read.
  std::string source;                // Of an expression effect: the YAML of its definition.

  // What is asked of it by those who do not know its name.
  Base base = Base::none;            // It is the model's base of this sort,
  Base replaces_base = Base::none;   // or takes the place of one.
  Base needs_base = Base::none;      // Acts only in a model that has this one.
  Term term = Term::none;            // It is one form of this term,
  std::vector<Term> replaces_terms;  // or takes the place of every form of these.
  Family family = Family::none;
  // Effects without which it seldom helps: the search offers them with it as one move.
  std::vector<std::string> companions;
  bool remembers = false;         // The true angle depends on the encoder's log before it.
  bool shows_at_rest = false;     // A servo effect that a resting joint still shows.
  std::vector<Need> needs;        // Beside those of its stage (questions.h).
  std::vector<StartRule> starts;  // By kind; kinds without a rule start by the slope.
  std::vector<Advice> advice;

  // The hooks; an effect sets those of its stage and leaves the others empty.
  std::function<void(Values, Timing&)> timing;       // Contributes to row times.
  std::function<void(Values, JointTrack&)> encoder;  // Encoder log to true angle, in place.
  // The inverse, pointwise: what the encoder of one joint logs at a true angle.
  std::function<double(Values, JointRole, double)> logged;
  std::function<void(Values, ServoModel&)> servo;  // Command to angle.
  // Play of the robot's joint of this role; a servo log has one joint, which `servo` knows.
  std::function<double(Values, JointRole)> play_rad;
  std::function<double(Values, const JointSample&)> joint_map;  // A formula on the angle.
  std::function<void(Values, Pose&)> mount;          // X_LC of the camera in its last link.
  std::function<void(Values, TargetShape&)> target;  // Where the points of a target are.
  // The camera's lens: ray to image point, in stage order, then (u, v) after all of geometry.
  // Images and measured points follow both; an effect whose `kinds` are points alone moves no
  // image.
  std::function<void(Values, ImagePoint&)> geometry;
  std::function<void(Values, ImagePoint&)> image_map;
  // What a detector of corners does to the (u, v) that it reports, after all of the above: it acts
  // on measured points alone and never on images.
  std::function<void(Values, ImagePoint&)> corner_detector;
  std::function<void(Values, Optics&)> optics;            // Point spread, glare.
  std::function<double(Values, const ImagePoint&)> gain;  // Gain field over the image.
  // Light that the camera itself sheds on the sensor, in units of the illumination, at the first
  // frame's exposure.
  std::function<double(Values, const ImagePoint&)> own_light;
  std::function<double(Values, const LightWindow&)> light;  // Mean of the lamps in a window.
  std::function<void(Values, SensorChain&)> sensor;         // Contributes to the sensor's equation.
  std::function<void(Values, Detection&)> detector;         // Range and bearing.
  std::function<void(Values, Locomotion&)> locomotion;      // Commanded to true body velocity.
  std::function<void(Values, VelocitySample&)> velocity_map;  // A formula on the body velocity.
  // Which point of the body a measured pose is of: the body moves as it would without.
  std::function<void(Values, Tracker&)> tracker;
  std::function<void(Values, Noise&)> noise;  // Errors that are not white.
  // Keys of a scenario, by path, with the values that they have in its place.
  std::function<std::vector<std::pair<std::string, double>>(Values)> scenario;

  // Where a fit starts, from what the sensor's variances exceed the prediction by.
  std::function<std::vector<double>(const SensorExcess&)> start_from_excess;
  // Of values that give the same effect, turns these (fitted all together) into those to be shown.
  std::function<void(std::vector<double>&)> told_once;

  std::vector<Proof>
      proof;  // Two or more; a test holds the catalogue against them (proof/proof.h).
};

}  // namespace seam::effects
