// An effect's worked examples, worked by the program: the effect beside the bases that its stage
// needs, given what the example gives.
//
// Quantities by stage; what is not given has the default in brackets, series repeat a name:
//   timing       stamp_s [0], row [0], cycle_s [0: the head repeats nothing], frame_exposure_s [0]
//                -> start_s, middle_s, end_s of the row's exposure; own_latency_rms_s of many
//                frames
//   joint        start_rad [0], limit_radps [none], warmer_k [0], then command_s and command_rad in
//                pairs, at_s
//                -> joint_rad; effects of a motor beside one with stall_rad_per_s2 200,
//                back_emf_per_s 10, gain 0.5; inertia_kg_m2 [the model's] -> effort_nm
//                logged_tilt_rad, logged_pan_rad, logged_roll_rad (series of the encoder's log)
//                -> tilt_rad, pan_rad, roll_rad after it; rounding_sigma_rad
//                true_pan_rad -> logged_pan_rad; likewise tilt, roll
//                lag_s [0] -> joint_covariance_rad2 of the log's error; command_sigma_s
//   mount        x_m, y_m, z_m in the camera -> link_x_m, link_y_m, link_z_m
//   geometry,    x_m, y_m, z_m in the camera, channel [1: green], t_s [0], temperature_c [20]
//   corner_      -> u_px, v_px, scatter_variance_px2; with fx_px 160, fy_px 162, cx_px 88.5,
//   detector     cy_px 71.5
//   radiometry,  u_px, v_px in 178 x 144 -> gain; start_s, exposure_s -> lamp;
//   light        light, mean_light -> seen_light; edge_px from an edge -> edge_light
//                lamp_sigma
//   sensor       light [0.5], exposure_s [0.01], exposure_ratio [1], channel [1: green], u_px, v_px
//                -> mean_dn, variance_dn2 (in time), row_variance_dn2, pattern_mean_dn,
//                pattern_variance_dn2, wave_dn; noise_kept (the share that a filter leaves of its
//                variance), next_in_row, next_in_column (its correlation in neighbours); value_dn
//                -> file_dn; with gain_dn 200, black_dn 8
//   detector     range_m, bearing_rad, above_m [0]; x_m, y_m [0] of the detector
//                -> range_m, bearing_rad, range_sigma_m, bearing_sigma_rad;
//                lag_s [0] -> range_covariance_m2, bearing_covariance_rad2 of one landmark's
//                errors, heading_covariance_rad2; tail_mean_m, tail_variance_m2; place_sigma_m,
//                delay_sigma_m
//   locomotion   vx_mps [0], vy_mps [0], omega_radps [0], for_s (ends a leg); or the leg's
//                left_ticks and right_ticks, of wheels with 1 mm a tick, 0.2 m apart
//                -> x_m, y_m, theta_rad, xy_sigma_m, theta_sigma_rad; pose_xy_sigma_m,
//                pose_theta_sigma_rad of a pose measured under the last command
//   target       x_m, y_m, z_m from the middle of a board that reaches half_m [1] to each side,
//                flex_m [0]; shift_x_m, turn_z_rad [0] of a sway -> x_m, y_m, z_m, scatter_m,
//                flex_sigma_m, sway_shift_sigma_m, sway_turn_sigma_rad
//   inertial     wx_radps .. az_mps2 [0], temperature_c [25] -> wx_radps .. az_mps2 as reported;
//                frequency_hz [1], rate_hz [100] -> wx_power .. az_power of the noise,
//                sample_distance_s, stamp_sigma_s
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "effects/effect.h"

namespace seam::effects {

// What the program gives for each quantity that the example expects; throws InputError for a
// quantity that its stage does not have.
std::vector<Quantity> worked(const std::shared_ptr<const EffectDefinition>& effect,
                             const Proof& proof);

// Which expected number is not met, in words; empty: all are.
std::string failed_proof(const std::shared_ptr<const EffectDefinition>& effect);

// What an effect's worked examples leave open, in words: fewer than two of them, a number that is
// not met, a parameter that no example notices, an effect that is not absent at its neutral values.
std::vector<std::string> open_proofs(const std::shared_ptr<const EffectDefinition>& effect);

}  // namespace seam::effects
