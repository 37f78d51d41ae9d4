#include "effects/questions.h"

#include <algorithm>

#include "effects/registry.h"
#include "sim_core/base/error.h"

namespace seam::effects {
namespace {

const Lack* lack_of(const SetFacts& set, Need need) {
  const auto found = std::find_if(set.lacks.begin(), set.lacks.end(),
                                  [&](const Lack& lack) { return lack.need == need; });
  return found == set.lacks.end() ? nullptr : &*found;
}

std::vector<Need> needs_of_stage(const EffectDefinition& effect) {
  std::vector<Need> needs;
  // Where one camera of several is shows beside the others.
  const bool beside_others = effect.stage == Stage::mount && !camera_of(effect.name).empty();
  const bool told_without_pose = effect.stage == Stage::geometry || effect.stage == Stage::target ||
                                 effect.stage == Stage::corner_detector || beside_others;
  if (!told_without_pose && (effect.kinds & kPoints) != 0) needs.push_back(Need::known_pose);
  if (effect.stage == Stage::timing) needs.push_back(Need::moving_view);
  if (effect.stage == Stage::locomotion) needs.push_back(Need::moving_body);
  if (effect.stage == Stage::joint) needs.push_back(Need::joints);
  if (effect.servo && !effect.shows_at_rest) needs.push_back(Need::moving_joint);
  return needs;
}

// An encoder effect has one parameter a joint, whose name begins with the joint's.
Need joint_of(const Parameter& parameter) {
  if (parameter.name.starts_with("tilt")) return Need::tilt_joint;
  return parameter.name.starts_with("roll") ? Need::roll_joint : Need::pan_joint;
}

const Advice* advice_of(const std::string& name, const std::string& other, unsigned kind) {
  const auto effect = find_effect(name);
  if (!effect) return nullptr;
  for (const Advice& advice : effect->advice) {
    const bool meant = other.empty() ? advice.from.empty()
                                     : std::find(advice.from.begin(), advice.from.end(), other) !=
                                           advice.from.end();
    if (meant && (advice.kinds & kind) != 0) return &advice;
  }
  return nullptr;
}

// What the way of a body must show or have beside it.
std::string of_ways(Need need) {
  switch (need) {
    case Need::moving_body:
      return "a body that moves";
    case Need::forward_walk:
      return "a walk forward";
    case Need::sideways_walk:
      return "a walk sideways";
    case Need::turning:
      return "a turn";
    case Need::both_turns:
      return "turns to the left and to the right";
    case Need::path:
      return "a walk";
    case Need::wheels:
      return "a body on two wheels";
    case Need::commanded_walk:
      return "commanded velocities";
    default:
      return "";
  }
}

// What a set's images must show or have beside them.
std::string of_images(Need need) {
  switch (need) {
    case Need::several_cameras:
      return "frames seen by several cameras at once";
    case Need::wide_view:
      return "rays far from the middle of the image";
    case Need::colour:
      return "colours";
    case Need::light:
      return "light";
    case Need::several_views:
      return "the same points in three views or more";
    case Need::unknown_poses:
      return "views with unknown poses";
    case Need::still_views:
      return "a target in still views";
    case Need::frame_times:
      return "times of the frames";
    case Need::repeated_pixels:
      return "the same samples at many brightnesses";
    default:
      return "";
  }
}

}  // namespace

std::string to_string(Need need) {
  switch (need) {
    case Need::known_pose:
      return "a camera whose place is known";
    case Need::known_scale:
      return "a distance that is known beside those on the target";
    case Need::joints:
      return "joints";
    case Need::motor_torques:
      return "measured torques of the motor";
    case Need::known_inertia:
      return "a joint whose inertia is stated";
    case Need::tilt_joint:
      return "a tilt joint";
    case Need::pan_joint:
      return "a pan joint";
    case Need::roll_joint:
      return "a roll joint";
    case Need::pan_turn:
      return "a pan joint that turns far";
    case Need::tilt_reversals:
      return "a tilt joint that comes to its angles from both sides";
    case Need::pan_reversals:
      return "a joint that comes to its angles from both sides";
    case Need::roll_reversals:
      return "a roll joint that comes to its angles from both sides";
    case Need::moving_joint:
      return "a joint that moves";
    case Need::moving_view:
      return "something that moves in the image";
    case Need::repeating_motion:
      return "a head that repeats its motion";
    case Need::encoder_steps:
      return "angles that may have been rounded";
    case Need::bearings:
      return "bearings";
    case Need::distances:
      return "ranges";
    case Need::landmark_places:
      return "landmarks seen from several sides";
    case Need::space:
      return "views beyond the plane of the ground";
    case Need::flat_target:
      return "points in a plane";
    case Need::moving_body:
    case Need::forward_walk:
    case Need::sideways_walk:
    case Need::turning:
    case Need::both_turns:
    case Need::path:
    case Need::wheels:
    case Need::commanded_walk:
      return of_ways(need);
    case Need::several_views:
    case Need::unknown_poses:
    case Need::still_views:
    case Need::several_cameras:
    case Need::wide_view:
    case Need::colour:
    case Need::light:
    case Need::frame_times:
    case Need::repeated_pixels:
      return of_images(need);
  }
  return "";
}

std::vector<Need> needs_of(const EffectDefinition& effect, size_t parameter) {
  std::vector<Need> needs = needs_of_stage(effect);
  needs.insert(needs.end(), effect.needs.begin(), effect.needs.end());
  const std::vector<Need>& own = effect.parameters[parameter].needs;
  needs.insert(needs.end(), own.begin(), own.end());
  if (own.empty() && effect.encoder && !effect.spread_only)
    needs.push_back(joint_of(effect.parameters[parameter]));
  return needs;
}

bool of_points_alone(const EffectDefinition& effect) {
  return effect.kinds == kPoints;
}

Model without_points_own(const Model& model) {
  Model rest = model;
  for (const ModelEffect& effect : model.effects()) {
    if (of_points_alone(*effect.definition)) rest.remove(effect.definition->name);
  }
  return rest;
}

bool acts_in_runs(const EffectDefinition& effect) {
  if (of_points_alone(effect)) return false;
  return effect.timing || effect.encoder || effect.logged || effect.servo || effect.play_rad ||
         effect.joint_map || effect.mount || effect.geometry || effect.image_map || effect.optics ||
         effect.gain || effect.own_light || effect.light || effect.sensor || effect.locomotion ||
         effect.velocity_map || effect.scenario;
}

bool acts_on(const EffectDefinition& effect, const SetFacts& set) {
  const bool acts = set.kind == kOutcomes ? acts_in_runs(effect) : (effect.kinds & set.kind) != 0;
  return acts && std::none_of(effect.needs.begin(), effect.needs.end(), [&](Need need) {
           const Lack* lack = lack_of(set, need);
           return lack != nullptr && lack->why.empty();
         });
}

std::string reason_against(const EffectDefinition& effect, size_t parameter, const SetFacts& set) {
  for (const Need need : needs_of(effect, parameter)) {
    if (const Lack* lack = lack_of(set, need)) return lack->why;
  }
  return "";
}

const StartRule& start_rule(const EffectDefinition& effect, unsigned kind) {
  static const StartRule by_slope;
  const auto found = std::find_if(effect.starts.begin(), effect.starts.end(),
                                  [&](const StartRule& rule) { return (rule.kinds & kind) != 0; });
  return found == effect.starts.end() ? by_slope : *found;
}

std::string advice_between(const std::string& effect, const std::string& other, unsigned kind) {
  for (const Advice* advice : {advice_of(effect, other, kind), advice_of(other, effect, kind),
                               advice_of(effect, "", kind), advice_of(other, "", kind)}) {
    if (advice != nullptr) return advice->text;
  }
  return "";
}

const ModelEffect* base_of(const Model& model, Base base) {
  const auto found =
      std::find_if(model.effects().begin(), model.effects().end(),
                   [&](const ModelEffect& effect) { return effect.definition->base == base; });
  return found == model.effects().end() ? nullptr : &*found;
}

bool has_base(const Model& model, Base base) {
  return std::any_of(
      model.effects().begin(), model.effects().end(), [&](const ModelEffect& effect) {
        return effect.definition->base == base || effect.definition->replaces_base == base;
      });
}

std::string base_name(Base base) {
  const auto found = std::find_if(catalogue().begin(), catalogue().end(),
                                  [&](const auto& effect) { return effect->base == base; });
  return found == catalogue().end() ? "" : (*found)->name;
}

bool replaces(const EffectDefinition& effect, Term term) {
  const std::vector<Term>& all = effect.replaces_terms;
  return std::find(all.begin(), all.end(), term) != all.end();
}

bool is_any_lens(const EffectDefinition& effect) {
  return replaces(effect, Term::radial) && replaces(effect, Term::angular);
}

std::shared_ptr<const EffectDefinition> any_lens() {
  const auto found = std::find_if(catalogue().begin(), catalogue().end(),
                                  [](const auto& effect) { return is_any_lens(*effect); });
  return found == catalogue().end() ? nullptr : *found;
}

const ModelEffect* replacement_in(const Model& model) {
  for (const ModelEffect& effect : model.effects()) {
    for (const ModelEffect& other : model.effects()) {
      if (replaces(*effect.definition, other.definition->term)) return &effect;
    }
  }
  return nullptr;
}

std::string missing_base(const EffectDefinition& effect, const Model& model) {
  const bool missing = effect.needs_base != Base::none && !has_base(model, effect.needs_base);
  return missing ? base_name(effect.needs_base) : "";
}

std::string conflict_in(const Model& model) {
  for (const ModelEffect& effect : model.effects()) {
    const EffectDefinition& definition = *effect.definition;
    if (const std::string base = missing_base(definition, model); !base.empty()) {
      return fmt::format("effect '{}' acts in a model with '{}', expected one", definition.name,
                         base);
    }
    if (const ModelEffect* other = excluding(definition, model)) {
      return fmt::format("effect '{}' has no place beside '{}', which replaces it: expected one",
                         definition.name, other->definition->name);
    }
  }
  return "";
}

const ModelEffect* excluding(const EffectDefinition& effect, const Model& model) {
  if (effect.term == Term::none) return nullptr;
  const auto found =
      std::find_if(model.effects().begin(), model.effects().end(), [&](const ModelEffect& other) {
        return replaces(*other.definition, effect.term) &&
               meet(effect.name, other.definition->name, model);
      });
  return found == model.effects().end() ? nullptr : &*found;
}

bool is_excluded(const EffectDefinition& effect, const Model& model) {
  return !missing_base(effect, model).empty() || excluding(effect, model) != nullptr;
}

std::vector<std::shared_ptr<const EffectDefinition>> companions_of(const EffectDefinition& effect,
                                                                   const Model& model) {
  std::vector<std::shared_ptr<const EffectDefinition>> companions;
  for (const std::string& name : effect.companions) {
    if (!model.has(name)) companions.push_back(find_effect(name));
  }
  return companions;
}

bool has_dependents(const Model& model, const std::string& effect) {
  const Base base = model.find(effect)->definition->base;
  return base != Base::none &&
         std::any_of(model.effects().begin(), model.effects().end(), [&](const ModelEffect& other) {
           return other.definition->needs_base == base;
         });
}

void remove_replaced(const EffectDefinition& effect, Model& model) {
  std::vector<std::string> replaced;
  for (const ModelEffect& other : model.effects()) {
    const EffectDefinition& definition = *other.definition;
    const bool term = replaces(effect, definition.term);
    const bool base = effect.replaces_base != Base::none &&
                      definition.base == effect.replaces_base && definition.parameters.empty();
    const std::string camera = camera_of(effect.name);
    if (!camera.empty() && camera != camera_of(definition.name)) continue;
    if (term || base) replaced.push_back(definition.name);
  }
  for (const std::string& name : replaced) model.remove(name);
}

}  // namespace seam::effects
