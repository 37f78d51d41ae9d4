#include "effects/registry.h"

#include <algorithm>
#include <cctype>

#include "effects/model.h"
#include "effects/questions.h"
#include "sim_core/base/error.h"

// The order of these lines is the order of composition.
#define SEAM_EFFECTS(X)       \
  X(rolling_shutter)          \
  X(exposure)                 \
  X(exposure_stamp)           \
  X(frame_latency)            \
  X(clock_drift)              \
  X(frame_jitter)             \
  X(frame_sync)               \
  X(ideal_servo)              \
  X(motor_servo)              \
  X(gravity_torque)           \
  X(viscous_friction)         \
  X(coulomb_friction)         \
  X(stribeck_friction)        \
  X(load_friction)            \
  X(friction_asymmetry)       \
  X(motor_heating)            \
  X(joint_inertia)            \
  X(effort_scale)             \
  X(effort_offset)            \
  X(torque_cogging)           \
  X(torque_limit)             \
  X(servo_latency)            \
  X(servo_lag)                \
  X(speed_limit)              \
  X(acceleration_limit)       \
  X(stiction)                 \
  X(elastic_joint)            \
  X(gear_ripple)              \
  X(gravity_sag)              \
  X(encoder_eccentricity)     \
  X(encoder_scale)            \
  X(encoder_offset)           \
  X(mount_sag)                \
  X(encoder_quantisation)     \
  X(joint_wander)             \
  X(command_jitter)           \
  X(backlash)                 \
  X(mount_misalignment)       \
  X(mount_offset)             \
  X(camera_pose)              \
  X(board_scale)              \
  X(board_warp)               \
  X(target_scatter)           \
  X(board_flex)               \
  X(board_sway)               \
  X(view_motion)              \
  X(flat_port)                \
  X(pupil_shift)              \
  X(pinhole)                  \
  X(fisheye)                  \
  X(spline_lens)              \
  X(radial_distortion)        \
  X(radial_polynomial)        \
  X(rational_lens)            \
  X(tangential_distortion)    \
  X(thin_prism)               \
  X(focal_length_error)       \
  X(focal_drift)              \
  X(focal_temperature)        \
  X(principal_point_offset)   \
  X(chromatic_aberration)     \
  X(focus_variation)          \
  X(point_scatter)            \
  X(lens_blur)                \
  X(vignetting)               \
  X(veiling_glare)            \
  X(amplifier_glow)           \
  X(tap_gain)                 \
  X(uneven_lighting)          \
  X(lamp_flicker)             \
  X(lamp_fluctuation)         \
  X(linear_response)          \
  X(pixel_gain_spread)        \
  X(weak_pixels)              \
  X(shot_noise)               \
  X(dark_current)             \
  X(response_gamma)           \
  X(response_cubic)           \
  X(white_balance)            \
  X(pixel_offset_spread)      \
  X(dark_current_spread)      \
  X(column_offsets)           \
  X(periodic_pattern)         \
  X(row_noise)                \
  X(hot_pixels)               \
  X(read_noise)               \
  X(saturation)               \
  X(noise_filter)             \
  X(quantisation)             \
  X(ideal_detector)           \
  X(landmark_height)          \
  X(wall_excess)              \
  X(range_depth)              \
  X(range_scale)              \
  X(range_offset)             \
  X(bearing_scale)            \
  X(bearing_offset_per_range) \
  X(range_noise)              \
  X(bearing_noise)            \
  X(range_wander)             \
  X(bearing_wander)           \
  X(heading_wander)           \
  X(landmark_bias)            \
  X(landmark_delay)           \
  X(landmark_scatter)         \
  X(range_tail)               \
  X(ideal_odometry)           \
  X(differential_drive)       \
  X(wheel_scale)              \
  X(base_scale)               \
  X(wheel_growth)             \
  X(wheel_load)               \
  X(encoder_skew)             \
  X(wheel_slip)               \
  X(odometry_scale)           \
  X(walk_lag)                 \
  X(heading_drift)            \
  X(turn_asymmetry)           \
  X(tracker_offset)           \
  X(tracker_turn)             \
  X(walk_noise)               \
  X(pose_noise)               \
  X(gyro_white_noise)         \
  X(gyro_bias_instability)    \
  X(gyro_random_walk)         \
  X(gyro_quantisation)        \
  X(gyro_scale)               \
  X(gyro_misalignment)        \
  X(gyro_g_sensitivity)       \
  X(gyro_temperature)         \
  X(gyro_bias)                \
  X(gyro_saturation)          \
  X(gyro_vibration)           \
  X(accel_white_noise)        \
  X(accel_bias_instability)   \
  X(accel_random_walk)        \
  X(accel_quantisation)       \
  X(accel_scale)              \
  X(accel_misalignment)       \
  X(accel_temperature)        \
  X(accel_bias)               \
  X(accel_saturation)         \
  X(accel_vibration)          \
  X(imu_clock)                \
  X(imu_jitter)               \
  X(camera_imu_offset)        \
  X(camera_imu_rotation)

namespace seam::effects {

#define SEAM_DECLARE(name) EffectDefinition name();
SEAM_EFFECTS(SEAM_DECLARE)
#undef SEAM_DECLARE

namespace {

std::vector<std::shared_ptr<const EffectDefinition>>& mutable_catalogue() {
  static std::vector<std::shared_ptr<const EffectDefinition>> effects = {
#define SEAM_REGISTER(name) std::make_shared<const EffectDefinition>(name()),
      SEAM_EFFECTS(SEAM_REGISTER)
#undef SEAM_REGISTER
  };
  return effects;
}

}  // namespace

const std::vector<std::shared_ptr<const EffectDefinition>>& catalogue() {
  return mutable_catalogue();
}

namespace {

// What belongs to a camera and its place, and moves means.
bool may_be_one_cameras(const EffectDefinition& effect) {
  const bool its_own = effect.stage == Stage::geometry || effect.stage == Stage::mount ||
                       effect.stage == Stage::timing || effect.stage == Stage::corner_detector;
  return its_own && !effect.spread_only && (effect.kinds & kPoints) != 0;
}

bool is_cameras_name(const std::string& name) {
  return !name.empty() && std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '-';
  });
}

}  // namespace

std::string camera_of(const std::string& effect) {
  const size_t at = effect.find('@');
  return at == std::string::npos ? "" : effect.substr(at + 1);
}

std::string plain_name(const std::string& effect) {
  return effect.substr(0, effect.find('@'));
}

bool meet(const std::string& a, const std::string& b, const Model& model) {
  const std::string of_a = camera_of(a), of_b = camera_of(b);
  if (of_a == of_b) return true;
  if (!of_a.empty() && !of_b.empty()) return false;
  return of_a.empty() ? !model.has(plain_name(a) + "@" + of_b)
                      : !model.has(plain_name(b) + "@" + of_a);
}

std::shared_ptr<const EffectDefinition> find_effect(const std::string& name) {
  const std::string plain = plain_name(name);
  for (const auto& effect : catalogue()) {
    if (effect->name != plain) continue;
    if (plain == name) return effect;
    if (!may_be_one_cameras(*effect) || !is_cameras_name(camera_of(name))) return nullptr;
    EffectDefinition own = *effect;
    own.name = name;
    own.companions.clear();
    return std::make_shared<const EffectDefinition>(std::move(own));
  }
  return nullptr;
}

std::vector<std::string> effect_names() {
  std::vector<std::string> names;
  for (const auto& effect : catalogue()) names.push_back(effect->name);
  return names;
}

void register_effect(EffectDefinition definition) {
  if (find_effect(definition.name)) {
    throw InputError(
        fmt::format("effect '{}' exists already, expected a new name", definition.name));
  }
  if (definition.corner_detector && !of_points_alone(definition)) {
    throw InputError(
        fmt::format("effect '{}': a detector of corners acts on measured points alone, expected "
                    ".kinds = kPoints (what images show, too, is a `geometry` or `image_map` hook)",
                    definition.name));
  }
  mutable_catalogue().push_back(std::make_shared<const EffectDefinition>(std::move(definition)));
}

}  // namespace seam::effects
