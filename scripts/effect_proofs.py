#!/usr/bin/env python3
"""The numbers of the effects' worked examples, computed here from their formulas and not by SEAM.

  scripts/effect_proofs.py NAME...    prints them as C++ for the records in effects/catalogue/; without NAME all
  scripts/effect_proofs.py --write NAME...  puts them into the records
  scripts/effect_proofs.py --check    compares every number with the records; exit code 1 where they differ, where an
                                      effect has no record, or where its record's examples have no lines here

Each line: effect, values of its parameters, what is given, what is expected. An expectation is a
Python expression over `p` (the values) and the names given; its text is the record's `source`.
Quantities: effects/proof/proof.h."""
import glob
import math
import os
import re
import shutil
import subprocess
import sys

import effect_formulas

# A crooked lens, and rays to its corners.
CROOKED = [60] + [round(0.01 * (1 + 7 * k % 5), 2) for k in range(96)]
CORNERS = [[("x_m", x), ("y_m", y), ("z_m", 1)] for x in (-0.45, 0.45) for y in (-0.3, 0.3)]
RAY = [("x_m", 0.3), ("y_m", -0.2), ("z_m", 1.25)]  # x/z = 0.24, y/z = -0.16
OTHER_RAY = [("x_m", -0.45), ("y_m", 0.3), ("z_m", 0.75)]  # x/z = -0.6, y/z = 0.4
CORNER = [("x_m", 0.12), ("y_m", -0.08), ("z_m", 0.001), ("half_m", 0.2)]  # a = 0.6, b = -0.4
STEP = [("command_s", 0), ("command_rad", 1)]
BACK = [("command_s", 0), ("command_rad", 0.5), ("command_s", 0.1), ("command_rad", 0.2)]
TEN_MICROMETRES = 4e-5  # Of these ways: what advance_walk promises with a lag.
SMALL_STEPS = 1e-7
HALF = [("vx_mps", 0.2), ("vy_mps", -0.1), ("omega_radps", 0.5), ("for_s", 2)]
ARC = [("left_ticks", 900), ("right_ticks", 1100), ("for_s", 2)]
SPIN = [("left_ticks", -100), ("right_ticks", 100), ("for_s", 1)]
ON = [("vx_mps", 0.3), ("for_s", 0.5), ("vx_mps", 0), ("for_s", 0.5)]


def image(x, y):
    return {"u_px": f"160 * {x} + 88.5", "v_px": f"162 * {y} + 71.5"}


PROOFS = [
    # Timing.
    ("rolling_shutter", [2e-4], [("stamp_s", 12.5), ("row", 71)], {"start_s": "stamp_s + p[0] * row"}),
    ("rolling_shutter", [-3e-4], [("stamp_s", 0), ("row", 100)], {"middle_s": "p[0] * row"}),
    ("exposure_stamp", [0.5], [("stamp_s", 4), ("frame_exposure_s", 0.008)], {"start_s": "4.004"}),
    ("exposure_stamp", [-0.5], [("stamp_s", 1), ("row", 30), ("frame_exposure_s", 0.02)], {"middle_s": "0.99"}),
    ("exposure", [0.005], [("stamp_s", 1)], {"start_s": "stamp_s", "middle_s": "stamp_s + p[0] / 2",
                                             "end_s": "stamp_s + p[0]"}),
    ("exposure", [0.02], [("stamp_s", 2), ("row", 10)], {"middle_s": "stamp_s + p[0] / 2"}),
    ("frame_latency", [0.012], [("stamp_s", 3)], {"start_s": "stamp_s + p[0]"}),
    ("frame_latency", [-0.004], [("stamp_s", 0.5), ("row", 20)], {"end_s": "stamp_s + p[0]"}),
    ("clock_drift", [40], [("stamp_s", 100)], {"start_s": "stamp_s * (1 + p[0] * 1e-6)"}),
    ("clock_drift", [-150], [("stamp_s", 2000), ("row", 9)], {"start_s": "stamp_s * (1 + p[0] * 1e-6)"}),
    ("frame_jitter", [0.002], [], {"own_latency_rms_s": "p[0]"}, 0.03),
    ("frame_jitter", [0.03], [], {"own_latency_rms_s": "p[0]"}, 0.03),
    ("frame_sync", [25], [("stamp_s", 1.03), ("cycle_s", 2)], {"start_s": "13 * 2 / 25"}),
    ("frame_sync", [4], [("stamp_s", 0.6), ("cycle_s", 1)], {"start_s": "2 * 1 / 4"}),
    # Joints: from commands.
    ("ideal_servo", [], STEP + [("at_s", 0.01)], {"joint_rad": "1"}),
    ("ideal_servo", [], BACK + [("at_s", 0.2)], {"joint_rad": "0.2"}),
    # A motor. Its effects stand beside stall 200, back-EMF 10, gain 0.5: a spring of 100 about the command.
    ("motor_servo", [200, 10, 0.5, 0, 1], STEP + [("at_s", 0.15)], {"joint_rad": "sprung(p[0] * p[2], p[1], 1, at_s)"}),
    ("motor_servo", [300, 8, 0.4, 0.02, 1], STEP + [("at_s", 0.2)],
     {"joint_rad": "sprung(p[0] * p[2], p[1] + p[0] * p[3], 1, at_s)"}),
    ("motor_servo", [300, 20, 5, 0, 0.5], STEP + [("at_s", 0.1)],
     {"joint_rad": "p[0] * p[4] / p[1] * (at_s - (1 - math.exp(-p[1] * at_s)) / p[1])"}),
    ("gravity_torque", [60, 0], STEP + [("at_s", 0.2)], {"joint_rad": "swung(at_s, gravity=p[0])"}, SMALL_STEPS),
    ("gravity_torque", [90, 1.2], STEP + [("at_s", 0.3)], {"joint_rad": "swung(at_s, gravity=p[0], level=p[1])"},
     SMALL_STEPS),
    ("viscous_friction", [5], STEP + [("at_s", 0.2)], {"joint_rad": "sprung(100, 10 + p[0], 1, at_s)"}),
    ("viscous_friction", [2], STEP + [("at_s", 0.3)], {"joint_rad": "sprung(100, 10 + p[0], 1, at_s)"}),
    ("coulomb_friction", [30], STEP + [("at_s", 0.2)], {"joint_rad": "sprung(100, 10, 1 - p[0] / 100, at_s)"}),
    ("coulomb_friction", [30], STEP + [("at_s", 2)],
     {"joint_rad": "(1 - p[0] / 100) * (1 + math.exp(-5 * math.pi / math.sqrt(75)))"}),
    ("coulomb_friction", [100.5], STEP + [("at_s", 1)], {"joint_rad": "0"}),
    ("stribeck_friction", [20, 0.8], STEP + [("at_s", 0.2)],
     {"joint_rad": "swung(at_s, stribeck=p[0], slow=p[1])"}, SMALL_STEPS),
    ("stribeck_friction", [101, 0.5], STEP + [("at_s", 1)], {"joint_rad": "0"}),
    ("load_friction", [0.3, 0], STEP + [("at_s", 0.12)], {"joint_rad": "sprung(100 * (1 - p[0]), 10 * (1 - p[0]), 1, at_s)"}),
    ("load_friction", [0.05, 0.15], STEP + [("at_s", 0.3)], {"joint_rad": "swung(at_s, load=p[0] + p[1])"},
     SMALL_STEPS),
    ("friction_asymmetry", [20], STEP + [("at_s", 0.2)], {"joint_rad": "sprung(100, 10, 1 - p[0] / 100, at_s)"}),
    ("friction_asymmetry", [-30], STEP + [("at_s", 0.15)], {"joint_rad": "swung(at_s, pull=p[0])"}, SMALL_STEPS),
    ("torque_cogging", [20, 12, 0.5], STEP + [("at_s", 0.2)],
     {"joint_rad": "swung(at_s, cogging=p[0], waves=p[1], phase=p[2])"}, SMALL_STEPS),
    ("torque_cogging", [35, 7.5, -1], STEP + [("at_s", 0.12)],
     {"joint_rad": "swung(at_s, cogging=p[0], waves=p[1], phase=p[2])"}, SMALL_STEPS),
    ("motor_heating", [0.005], STEP + [("warmer_k", 20), ("at_s", 0.2)], {"joint_rad": "sprung(100 / 1.1, 10 / 1.1, 1, at_s)"}),
    ("motor_heating", [0.01], STEP + [("warmer_k", -30), ("at_s", 0.1)], {"joint_rad": "sprung(100 / 0.7, 10 / 0.7, 1, at_s)"}),
    ("joint_inertia", [0.02], STEP + [("at_s", 0.05)], {"effort_nm": "p[0] * driven(100, 10, at_s)"}),
    ("joint_inertia", [1.5], STEP + [("at_s", 0.3)], {"effort_nm": "p[0] * driven(100, 10, at_s)"}),
    ("effort_scale", [0.25], STEP + [("at_s", 0.1), ("inertia_kg_m2", 0.02)],
     {"effort_nm": "(1 + p[0]) * inertia_kg_m2 * driven(100, 10, at_s)"}),
    ("effort_scale", [-0.4], STEP + [("at_s", 0.02), ("inertia_kg_m2", 0.3)],
     {"effort_nm": "(1 + p[0]) * inertia_kg_m2 * driven(100, 10, at_s)"}),
    ("effort_offset", [0.05], STEP + [("at_s", 0.1), ("inertia_kg_m2", 0.02)],
     {"effort_nm": "inertia_kg_m2 * driven(100, 10, at_s) + p[0]"}),
    ("effort_offset", [-0.3], STEP + [("at_s", 0.2)], {"effort_nm": "p[0]"}),
    ("torque_limit", [30], STEP + [("at_s", 0.1)], {"joint_rad": "p[0] * at_s ** 2 / 2"}),
    ("torque_limit", [40], STEP + [("at_s", 0.25)], {"joint_rad": "swung(at_s, limit=p[0])"}, SMALL_STEPS),
    ("servo_latency", [0.016], STEP + [("at_s", 0.015)], {"joint_rad": "0"}),
    ("servo_latency", [0.016], STEP + [("at_s", 0.017)], {"joint_rad": "1"}),
    ("servo_lag", [0.04], STEP + [("at_s", 0.06)], {"joint_rad": "1 - math.exp(-at_s / p[0])"}),
    ("servo_lag", [0.1], BACK + [("at_s", 0.3)],
     {"joint_rad": "0.2 + (0.5 * (1 - math.exp(-1)) - 0.2) * math.exp(-0.2 / p[0])"}),
    ("speed_limit", [3], STEP + [("at_s", 0.2)], {"joint_rad": "p[0] * at_s"}),
    ("speed_limit", [1], BACK + [("at_s", 0.15)], {"joint_rad": "p[0] * 0.1 + p[0] * 0.05"}),
    ("speed_limit", [3], BACK + [("at_s", 0.15)], {"joint_rad": "p[0] * 0.1 - 0.1"}),
    ("acceleration_limit", [60], STEP + [("at_s", 0.1)], {"joint_rad": "p[0] * at_s ** 2 / 2"}),
    ("acceleration_limit", [60], STEP + [("at_s", 0.2)],
     {"joint_rad": "1 - p[0] * (2 * math.sqrt(1 / p[0]) - at_s) ** 2 / 2"}),
    ("stiction", [0.02], [("command_s", 0), ("command_rad", 0.015), ("at_s", 1)], {"joint_rad": "0"}),
    ("stiction", [0.02], STEP + [("limit_radps", 2), ("at_s", 1)], {"joint_rad": "1 - p[0]"}),
    ("stiction", [0.02], STEP + [("limit_radps", 2), ("at_s", 0.3)], {"joint_rad": "2 * at_s"}),
    ("gear_ripple", [0.002, 40, 0.5], BACK + [("at_s", 0.05)], {"joint_rad": "0.5 + p[0] * math.sin(20.5)"}),
    ("gear_ripple", [0.01, 7.5, -1], BACK + [("at_s", 0.2)], {"joint_rad": "0.2 + p[0] * math.sin(0.5)"}),
    ("elastic_joint", [0.25, 0.2], STEP + [("at_s", 0.1)],
     {"joint_rad": "1 - math.exp(-p[1] * 8 * math.pi * at_s) * (math.cos(8 * math.pi * math.sqrt(1 - p[1]**2) * at_s) - "
                   "p[1] / math.sqrt(1 - p[1]**2) * math.sin(8 * math.pi * math.sqrt(1 - p[1]**2) * at_s))"}),
    ("elastic_joint", [0.1, 0.05], STEP + [("limit_radps", 2), ("at_s", 0.17)],
     {"joint_rad": "elastic(p, lambda t: 2 * t, lambda t: 2, at_s)"}, SMALL_STEPS),
    ("gravity_sag", [0.02, 0], BACK + [("at_s", 0.05)], {"joint_rad": "0.5 - p[0] * math.cos(0.5)"}),
    ("gravity_sag", [0.1, 0.3], BACK + [("at_s", 0.2)], {"joint_rad": "0.2 - p[0] * math.cos(0.2 - p[1])"}),
    # Joints: from an encoder's log.
    ("mount_sag", [0.01, 0], [("logged_tilt_rad", 0.5), ("logged_pan_rad", 0.5), ("true_tilt_rad", -0.4)],
     {"tilt_rad": "0.5 + p[0] * math.cos(0.5)", "pan_rad": "0.5",
      "logged_tilt_rad": "root(lambda q: q + p[0] * math.cos(q) + 0.4, -1, 1)"}),
    ("mount_sag", [-0.03, 0.7], [("logged_tilt_rad", -1)], {"tilt_rad": "-1 + p[0] * math.cos(-1 - p[1])"}),
    ("encoder_eccentricity", [0.01, 0.4], [("logged_pan_rad", 0.7), ("logged_tilt_rad", 0.7), ("true_pan_rad", 1.1)],
     {"pan_rad": "root(lambda q: q - 0.7 - p[0] * math.sin(q + p[1]), 0, 2)", "tilt_rad": "0.7",
      "logged_pan_rad": "1.1 - p[0] * math.sin(1.1 + p[1])"}),
    ("encoder_eccentricity", [0.1, -1], [("logged_pan_rad", -0.5)],
     {"pan_rad": "root(lambda q: q + 0.5 - p[0] * math.sin(q + p[1]), -2, 2)"}),
    ("encoder_scale", [0.1, -0.02, 0.05],
     [("logged_tilt_rad", 0.5), ("logged_pan_rad", 1), ("logged_roll_rad", -0.4), ("true_pan_rad", 0.49)],
     {"tilt_rad": "0.5 * (1 + p[0])", "pan_rad": "1 + p[1]", "roll_rad": "-0.4 * (1 + p[2])",
      "logged_pan_rad": "0.49 / (1 + p[1])"}),
    ("encoder_scale", [0, 0.2, 0], [("logged_pan_rad", -0.3)], {"pan_rad": "-0.3 * (1 + p[1])"}),
    ("encoder_offset", [0.01, 0.02, -0.03],
     [("logged_tilt_rad", 0.5), ("logged_pan_rad", 1), ("logged_roll_rad", -0.4), ("true_roll_rad", 0.2)],
     {"tilt_rad": "0.5 + p[0]", "pan_rad": "1 + p[1]", "roll_rad": "-0.4 + p[2]", "logged_roll_rad": "0.2 - p[2]"}),
    ("encoder_offset", [0, -0.1, 0], [("logged_pan_rad", 0.25)], {"pan_rad": "0.25 + p[1]"}),
    ("encoder_quantisation", [0.003], [], {"rounding_sigma_rad": "p[0] / math.sqrt(12)"}),
    ("encoder_quantisation", [0.02], [], {"rounding_sigma_rad": "p[0] / math.sqrt(12)"}),
    ("backlash", [0.01, 0.02, 0],
     [("logged_pan_rad", 0), ("logged_pan_rad", 0.1), ("logged_pan_rad", 0.098),
      ("logged_tilt_rad", 0), ("logged_tilt_rad", 0.1), ("logged_tilt_rad", 0.05)],
     {"pan_rad": "play(p[0], 0, 0.1, 0.098)", "tilt_rad": "play(p[1], 0, 0.1, 0.05)"}),
    ("backlash", [0, 0, 0.03], [("logged_roll_rad", 0.3), ("logged_roll_rad", -0.2)], {"roll_rad": "-0.2 + p[2] / 2"}),
    ("backlash", [0.02, 0, 0], BACK + [("at_s", 0.2)], {"joint_rad": "play(p[0], 0, 0.5, 0.2)"}),
    # Mount.
    ("mount_misalignment", [0.1, -0.2, 0.3], RAY,
     {f"link_{c}_m": f"turned(*p, x_m, y_m, z_m)[{i}]" for i, c in enumerate("xyz")}),
    ("mount_misalignment", [0, 0.05, 0], [("z_m", 1)], {"link_x_m": "math.cos(p[1])", "link_z_m": "-math.sin(p[1])"}),
    ("mount_offset", [0.01, -0.02, 0.03], RAY,
     {"link_x_m": "z_m + p[0]", "link_y_m": "-x_m + p[1]", "link_z_m": "-y_m + p[2]"}),
    ("mount_offset", [0.2, 0, 0], OTHER_RAY, {"link_x_m": "z_m + p[0]", "link_y_m": "-x_m", "link_z_m": "-y_m"}),
    ("camera_pose", [0.1, -0.2, 0.3, 0, 0, 0], RAY,
     {"link_x_m": "z_m + p[2]", "link_y_m": "-x_m - p[0]", "link_z_m": "-y_m - p[1]"}),
    ("camera_pose", [0, 0, 0, 0, math.pi / 2, 0], OTHER_RAY, {"link_x_m": "-x_m", "link_y_m": "-z_m", "link_z_m": "-y_m"}),
    # Target.
    ("board_warp", [0.003, -0.001], CORNER,
     {"x_m": "x_m", "y_m": "y_m", "z_m": "z_m + p[0] * (1 - 0.6**2) + p[1] * (1 - 0.4**2)"}),
    ("board_warp", [0, 0.002], [("half_m", 0.1)], {"z_m": "p[1]"}),
    ("board_scale", [0.001, -0.002, 0.0005], CORNER,
     {"x_m": "0.12 * 1.001 + 0.0005 * -0.08", "y_m": "-0.08 * (1 - 0.002)", "z_m": "z_m"}),
    ("board_scale", [0, 0, 0.01], [("y_m", 0.3)], {"x_m": "0.003", "y_m": "0.3"}),
    ("target_scatter", [0.0001], CORNER, {"x_m": "x_m", "z_m": "z_m", "scatter_m": "p[0]"}),
    ("target_scatter", [0.002], [], {"scatter_m": "p[0]"}),
    ("board_flex", [0.0002], CORNER + [("flex_m", 0.001)],
     {"z_m": "z_m + 0.001 * (2 - 0.6**2 - 0.4**2) / math.sqrt(2)", "flex_sigma_m": "p[0]"}),
    ("board_flex", [0.001], [("half_m", 0.1), ("flex_m", -0.002)],
     {"z_m": "-0.002 * math.sqrt(2)", "flex_sigma_m": "p[0]"}),
    ("board_sway", [0.0004, 0.002], CORNER + [("shift_x_m", 0.001), ("turn_z_rad", 0.003)],
     {"x_m": "x_m + 0.001 - 0.003 * y_m", "y_m": "y_m + 0.003 * x_m", "z_m": "z_m",
      "sway_shift_sigma_m": "p[0]", "sway_turn_sigma_rad": "p[1]"}),
    ("board_sway", [0, 0.001], [], {"sway_shift_sigma_m": "0", "sway_turn_sigma_rad": "p[1]"}),
    ("view_motion", [0.005], [("x_m", 0.12), ("y_m", -0.08), ("turn_z_rad", 0.003)],
     {"x_m": "x_m - 0.003 * y_m", "y_m": "y_m + 0.003 * x_m", "motion_sigma_rad": "p[0]"}),
    ("view_motion", [0.01], [], {"motion_sigma_rad": "p[0]"}),
    # Geometry.
    ("pinhole", [161.9, 162.5, 88, 71], RAY, {"u_px": "p[0] * 0.24 + p[2]", "v_px": "p[1] * -0.16 + p[3]"}),
    ("pinhole", [300, 310, 159.5, 119.5], OTHER_RAY, {"u_px": "p[0] * -0.6 + p[2]", "v_px": "p[1] * 0.4 + p[3]"}),
    ("focus_variation", [0.015], RAY, {"u_px": "160 * 0.24 + 88.5", "u_focus_sigma_px": "p[0] * 160 * 0.24",
                                       "v_focus_sigma_px": "p[0] * 162 * 0.16"}),
    ("focus_variation", [0.1], OTHER_RAY, {"u_focus_sigma_px": "p[0] * 160 * 0.6", "v_focus_sigma_px": "p[0] * 162 * 0.4"}),
    ("flat_port", [1.333, 0.03, 0], RAY, image("through_port(p, x_m, y_m, z_m) * x_m", "through_port(p, x_m, y_m, z_m) * y_m")),
    ("flat_port", [1.34, 0.05, 0.02], OTHER_RAY,
     image("through_port(p, x_m, y_m, z_m) * x_m", "through_port(p, x_m, y_m, z_m) * y_m")),
    ("pupil_shift", [0.003], RAY, image("x_m / slid(p, x_m, y_m, z_m)", "y_m / slid(p, x_m, y_m, z_m)")),
    ("pupil_shift", [-0.008], OTHER_RAY, image("x_m / slid(p, x_m, y_m, z_m)", "y_m / slid(p, x_m, y_m, z_m)")),
    ("fisheye", [-0.02, 0.001, 0, 0], RAY, image("fisheye(p, x_m, y_m, z_m) * x_m", "fisheye(p, x_m, y_m, z_m) * y_m")),
    ("fisheye", [0.1, -0.02, 0.003, -0.0005], OTHER_RAY,
     image("fisheye(p, x_m, y_m, z_m) * x_m", "fisheye(p, x_m, y_m, z_m) * y_m")),
    *(("spline_lens", CROOKED, corner, image("spline_lens(p, x_m, y_m, z_m)[0]", "spline_lens(p, x_m, y_m, z_m)[1]"))
      for corner in CORNERS),
    ("radial_distortion", [-0.1], RAY,
     image("0.24 * 2 / (1 + math.sqrt(1 + 0.4 * (0.24**2 + 0.16**2)))",
           "-0.16 * 2 / (1 + math.sqrt(1 + 0.4 * (0.24**2 + 0.16**2)))")),
    ("radial_distortion", [0.3], OTHER_RAY,
     image("-0.6 * 2 / (1 + math.sqrt(1 - 1.2 * 0.52))", "0.4 * 2 / (1 + math.sqrt(1 - 1.2 * 0.52))")),
    ("radial_polynomial", [-0.12, 0.01, 0.002], OTHER_RAY,
     image("-0.6 * (1 + p[0] * 0.52 + p[1] * 0.52**2 + p[2] * 0.52**3)",
           "0.4 * (1 + p[0] * 0.52 + p[1] * 0.52**2 + p[2] * 0.52**3)")),
    ("radial_polynomial", [0.2, 0, 0], RAY, image("0.24 * (1 + p[0] * 0.0832)", "-0.16 * (1 + p[0] * 0.0832)")),
    ("rational_lens", [0.4, 0.02, 0.001, 0.7, 0.1, 0.003], OTHER_RAY,
     image("-0.6 * rational(p, 0.52)", "0.4 * rational(p, 0.52)")),
    ("rational_lens", [-0.1, 0, 0, 0.2, 0, 0], RAY, image("0.24 * rational(p, 0.0832)", "-0.16 * rational(p, 0.0832)")),
    ("thin_prism", [0.002, -0.001, 0.003, 0.004], OTHER_RAY,
     image("(-0.6 + p[0] * 0.52 + p[1] * 0.52**2)", "(0.4 + p[2] * 0.52 + p[3] * 0.52**2)")),
    ("thin_prism", [0, 0.01, -0.02, 0], RAY, image("(0.24 + p[1] * 0.0832**2)", "(-0.16 + p[2] * 0.0832)")),
    ("tangential_distortion", [0.004, -0.003], RAY, image("tangential(p, 0.24, -0.16)[0]", "tangential(p, 0.24, -0.16)[1]")),
    ("tangential_distortion", [0, 0.02], OTHER_RAY, image("tangential(p, -0.6, 0.4)[0]", "tangential(p, -0.6, 0.4)[1]")),
    ("focal_drift", [1e-4, math.inf], RAY + [("t_s", 300)], {"u_px": "160 * 1.03 * 0.24 + 88.5", "v_px": "162 * 1.03 * -0.16 + 71.5"}),
    ("focal_drift", [-2e-4, 40], OTHER_RAY + [("t_s", 100)],
     image("-0.6 * (1 - 0.008 * (1 - math.exp(-2.5)))", "0.4 * (1 - 0.008 * (1 - math.exp(-2.5)))")),
    ("focal_temperature", [1e-4, 20], RAY + [("temperature_c", 50)],
     {"u_px": "160 * 1.003 * 0.24 + 88.5", "v_px": "162 * 1.003 * -0.16 + 71.5"}),
    ("focal_temperature", [-3e-4, 45], OTHER_RAY + [("temperature_c", -15)], image("-0.6 * 1.018", "0.4 * 1.018")),
    ("focal_length_error", [0.01, -0.02], RAY, {"u_px": "160 * 1.01 * 0.24 + 88.5", "v_px": "162 * 0.98 * -0.16 + 71.5"}),
    ("focal_length_error", [-0.1, 0], OTHER_RAY, {"u_px": "160 * 0.9 * -0.6 + 88.5", "v_px": "162 * 0.4 + 71.5"}),
    ("principal_point_offset", [2.5, -1.5], RAY, {"u_px": "160 * 0.24 + 91", "v_px": "162 * -0.16 + 70"}),
    ("principal_point_offset", [0, 4], OTHER_RAY, {"u_px": "160 * -0.6 + 88.5", "v_px": "162 * 0.4 + 75.5"}),
    ("chromatic_aberration", [0.002, -0.001], RAY + [("channel", 0)], image("0.24 * (1 + p[0])", "-0.16 * (1 + p[0])")),
    ("chromatic_aberration", [0.002, -0.001], RAY + [("channel", 2)], image("0.24 * (1 + p[1])", "-0.16 * (1 + p[1])")),
    ("chromatic_aberration", [0.002, -0.001], RAY, image("0.24", "-0.16")),
    # Radiometry and light.
    ("lens_blur", [1, 0], [("edge_px", 0.5)], {"edge_light": "(1 + math.erf(edge_px / p[0] / math.sqrt(2))) / 2"}),
    ("lens_blur", [2, 0], [("edge_px", -1)], {"edge_light": "(1 + math.erf(edge_px / p[0] / math.sqrt(2))) / 2"}),
    ("vignetting", [0.28, 0.05], [("u_px", 20), ("v_px", 130)],
     {"gain": "1 - p[0] * (68.5**2 + 58.5**2) / (89**2 + 72**2) - p[1] * ((68.5**2 + 58.5**2) / (89**2 + 72**2))**2"}),
    ("vignetting", [0, 0.1], [("u_px", 88.5), ("v_px", 0)], {"gain": "1 - p[1] * (71.5**2 / (89**2 + 72**2))**2"}),
    ("veiling_glare", [0.05], [("light", 0.2), ("mean_light", 0.6)], {"seen_light": "0.95 * light + 0.05 * mean_light"}),
    ("veiling_glare", [0.3], [("light", 1), ("mean_light", 0.1)], {"seen_light": "0.7 * light + 0.3 * mean_light"}),
    ("amplifier_glow", [0.05, 0.5, 0.5, 0.05, 0.05, 1], [("u_px", 165), ("v_px", 127)],
     {"own_light": "p[0] * math.exp(-p[3] * math.hypot(177 - u_px, 143 - v_px))"}),
    ("amplifier_glow", [0.2, -0.6, 0, 0.03, 0, 2], [("u_px", 15), ("v_px", 7)],
     {"own_light": "p[0] * math.exp(-(p[3] * (u_px - 17.7))**2)"}),
    ("tap_gain", [0.02, -0.01, 0.003, 0.005], [("u_px", 89), ("v_px", 71)], {"gain": "(1 + p[0]) * (1 + p[2]) * (1 + p[3])"}),
    ("tap_gain", [0.02, -0.01, 0.003, 0.005], [("u_px", 88), ("v_px", 72)], {"gain": "1 + p[1]"}),
    ("uneven_lighting", [0.1, -0.05], [("u_px", 0), ("v_px", 143)], {"gain": "1 - p[0] / 2 + p[1] / 2"}),
    ("uneven_lighting", [0.2, 0.4], [("u_px", 132.75), ("v_px", 71.5)], {"gain": "1 + p[0] / 4"}),
    ("lamp_flicker", [100, 0.1, 0.3], [("start_s", 0.123)], {"lamp": "1 + p[1] * math.sin(2 * math.pi * p[0] * start_s + p[2])"}),
    ("lamp_flicker", [100, 0.2, -1], [("start_s", 0.004), ("exposure_s", 0.003)],
     {"lamp": "1 + p[1] * (math.cos(0.8 * math.pi + p[2]) - math.cos(1.4 * math.pi + p[2])) / (0.6 * math.pi)"}),
    ("lamp_fluctuation", [0.001], [], {"lamp_sigma": "p[0]"}),
    ("lamp_fluctuation", [0.03], [], {"lamp_sigma": "p[0]"}),
    # Sensor.
    ("linear_response", [220, 16], [("light", 0.5)], {"mean_dn": "p[0] * light + p[1]"}),
    ("linear_response", [100, -3], [("light", 0.25), ("exposure_ratio", 2)], {"mean_dn": "p[0] * light * 2 + p[1]"}),
    ("pixel_gain_spread", [0.01], [("light", 0.5)], {"pattern_variance_dn2": "(p[0] * 100)**2"}),
    ("pixel_gain_spread", [0.03], [("light", 1)], {"pattern_variance_dn2": "(p[0] * 200)**2"}),
    ("shot_noise", [50], [("light", 0.5)], {"mean_dn": "108", "variance_dn2": "100 / p[0]"}),
    ("shot_noise", [8], [("light", 1)], {"mean_dn": "208", "variance_dn2": "200 / p[0]"}),
    ("dark_current", [2000], [("light", 0), ("exposure_s", 0.01)], {"mean_dn": "8 + p[0] * exposure_s"}),
    ("dark_current", [500], [("light", 0.5), ("exposure_s", 0.1)], {"mean_dn": "108 + p[0] * exposure_s"}),
    ("response_gamma", [0.8], [("light", 0.5)], {"mean_dn": "200 * light**p[0] + 8"}),
    ("response_gamma", [2.2], [("light", 0.25)], {"mean_dn": "200 * light**p[0] + 8"}),
    ("response_cubic", [-0.1, 0.05], [("light", 0.51)], {"mean_dn": "102 * (1 + p[0] * 0.4 + p[1] * 0.16) + 8"}),
    ("response_cubic", [0.2, 0], [("light", 1.275)], {"mean_dn": "255 * (1 + p[0]) + 8"}),
    ("white_balance", [1.2, 0.9], [("channel", 0)], {"mean_dn": "100 * p[0] + 8"}),
    ("white_balance", [1.2, 0.9], [("channel", 2)], {"mean_dn": "100 * p[1] + 8"}),
    ("white_balance", [1.2, 0.9], [("channel", 1)], {"mean_dn": "108"}),
    ("pixel_offset_spread", [0.8], [], {"pattern_variance_dn2": "p[0]**2"}),
    ("pixel_offset_spread", [3], [("light", 1)], {"pattern_variance_dn2": "p[0]**2"}),
    ("dark_current_spread", [20], [("exposure_s", 0.1)], {"pattern_variance_dn2": "(p[0] * exposure_s)**2"}),
    ("dark_current_spread", [1500], [("light", 1), ("exposure_s", 0.02)], {"pattern_variance_dn2": "(p[0] * exposure_s)**2"}),
    ("column_offsets", [0.8], [], {"pattern_variance_dn2": "p[0]**2"}),
    ("column_offsets", [2], [("light", 1)], {"pattern_variance_dn2": "p[0]**2"}),
    ("periodic_pattern", [2, 8, 0, 0.5], [("u_px", 3), ("v_px", 11)], {"wave_dn": "p[0] * math.sin(2 * math.pi * u_px / p[1] + p[3])"}),
    ("periodic_pattern", [3, 25, 1, -2], [("u_px", 100), ("v_px", 7)], {"wave_dn": "p[0] * math.sin(2 * math.pi * (u_px * math.cos(p[2]) + v_px * math.sin(p[2])) / p[1] + p[3])"}),
    ("row_noise", [0.8], [], {"row_variance_dn2": "p[0]**2", "variance_dn2": "0"}),
    ("row_noise", [2.5], [("light", 1)], {"row_variance_dn2": "p[0]**2"}),
    ("hot_pixels", [0.001, 40], [], {"pattern_mean_dn": "p[0] * p[1]", "pattern_variance_dn2": "p[0] * (1 - p[0]) * p[1]**2"}),
    ("hot_pixels", [0.1, -20], [], {"pattern_mean_dn": "p[0] * p[1]", "pattern_variance_dn2": "p[0] * (1 - p[0]) * p[1]**2"}),
    ("weak_pixels", [0.001, 0.7], [("light", 0.5)], {"pattern_mean_dn": "-100 * p[0] * (1 - p[1])", "pattern_variance_dn2": "p[0] * (1 - p[0]) * (100 * (1 - p[1]))**2"}),
    ("weak_pixels", [0.1, 0.5], [("light", 1)], {"pattern_mean_dn": "-200 * p[0] * (1 - p[1])", "pattern_variance_dn2": "p[0] * (1 - p[0]) * (200 * (1 - p[1]))**2"}),
    ("read_noise", [1.4], [], {"variance_dn2": "p[0]**2", "mean_dn": "108"}),
    ("read_noise", [3], [("light", 0)], {"variance_dn2": "p[0]**2", "mean_dn": "8"}),
    ("noise_filter", [0.1, 0], [], {"noise_kept": "0.8**2 + 2 * 0.1**2", "next_in_row": "2 * 0.1 * 0.8 / (0.8**2 + 2 * 0.1**2)",
                                    "next_in_column": "0"}, 1e-6),
    ("noise_filter", [0.2, -0.05], [], {"noise_kept": "sum((a * b)**2 for a in (0.2, 0.6, 0.2) for b in (-0.05, 1.1, -0.05))",
                                        "next_in_column": "2 * -0.05 * 1.1 / (2 * 0.05**2 + 1.1**2)"}, 1e-6),
    ("saturation", [235], [("value_dn", 240)], {"file_dn": "235"}),
    ("saturation", [235], [("value_dn", 100.4)], {"file_dn": "100"}),
    ("quantisation", [6], [("value_dn", 101)], {"file_dn": "round(101 / 4) * 4"}),
    ("quantisation", [5], [("value_dn", 117)], {"file_dn": "round(117 / 8) * 8"}),
    # Detector.
    ("ideal_detector", [], [("range_m", 1.7), ("bearing_rad", -0.3)], {"range_m": "1.7", "bearing_rad": "-0.3"}),
    ("ideal_detector", [], [("range_m", 0.4), ("bearing_rad", 1)], {"range_m": "0.4", "bearing_rad": "1", "range_sigma_m": "0"}),
    ("range_depth", [1], [("range_m", 2), ("bearing_rad", 0.5)],
     {"range_m": "range_m * math.cos(bearing_rad)", "bearing_rad": "0.5"}),
    ("range_depth", [-0.4], [("range_m", 1.5), ("bearing_rad", -2.4)],
     {"range_m": "range_m * abs(math.cos(bearing_rad)) ** p[0]"}),
    ("range_scale", [0.05], [("range_m", 2), ("bearing_rad", 0.3)], {"range_m": "2 * 1.05", "bearing_rad": "0.3"}),
    ("range_scale", [-0.2], [("range_m", 0.7)], {"range_m": "0.7 * 0.8"}),
    ("range_offset", [0.03], [("range_m", 2)], {"range_m": "2.03"}),
    ("range_offset", [-0.1], [("range_m", 0.7), ("bearing_rad", 0.2)], {"range_m": "0.7 - 0.1", "bearing_rad": "0.2"}),
    ("bearing_scale", [-0.03], [("range_m", 2), ("bearing_rad", 0.5)], {"range_m": "2", "bearing_rad": "0.5 * 0.97"}),
    ("bearing_scale", [0.1], [("bearing_rad", -0.7)], {"bearing_rad": "-0.7 * 1.1"}),
    ("bearing_offset_per_range", [0.004], [("range_m", 2.5), ("bearing_rad", 0.3)],
     {"bearing_rad": "bearing_rad + p[0] * range_m", "range_m": "range_m"}),
    ("bearing_offset_per_range", [-0.02], [("range_m", 1.5), ("bearing_rad", -0.7)],
     {"bearing_rad": "bearing_rad + p[0] * range_m"}),
    ("range_noise", [0.02, 0.03], [("range_m", 2)], {"range_sigma_m": "math.hypot(p[0], p[1] * range_m)", "range_m": "2"}),
    ("range_noise", [0, 0.1], [("range_m", 0.5)], {"range_sigma_m": "p[1] * range_m"}),
    ("bearing_noise", [0.01], [("range_m", 2), ("bearing_rad", 0.5)], {"bearing_sigma_rad": "p[0]", "bearing_rad": "0.5"}),
    ("bearing_noise", [0.2], [("range_m", 1)], {"bearing_sigma_rad": "p[0]", "range_sigma_m": "0"}),
    ("range_wander", [0.05, 2.5], [("lag_s", 0.5)], {"range_covariance_m2": "p[0]**2 * math.exp(-lag_s / p[1])"}),
    ("range_wander", [0.2, 0.4], [("lag_s", 1)], {"range_covariance_m2": "p[0]**2 * math.exp(-lag_s / p[1])"}),
    ("bearing_wander", [0.01, 2], [("lag_s", 1)], {"bearing_covariance_rad2": "p[0]**2 * math.exp(-lag_s / p[1])"}),
    ("bearing_wander", [0.3, 5], [("lag_s", 10)], {"bearing_covariance_rad2": "p[0]**2 * math.exp(-lag_s / p[1])", "heading_covariance_rad2": "0"}),
    ("heading_wander", [0.024, 2.3], [("lag_s", 2.3)], {"heading_covariance_rad2": "p[0]**2 / math.e", "bearing_covariance_rad2": "0"}),
    ("heading_wander", [0.1, 1], [("lag_s", 0.25)], {"heading_covariance_rad2": "p[0]**2 * math.exp(-lag_s / p[1])"}),
    ("landmark_scatter", [0.03], [("range_m", 2)], {"place_sigma_m": "p[0]", "range_m": "range_m"}),
    ("landmark_scatter", [0.2], [("range_m", 1)], {"place_sigma_m": "p[0]", "range_covariance_m2": "0"}),
    ("landmark_height", [2.2], [("range_m", 3)], {"range_m": "math.sqrt(9 + p[0]**2)"}),
    ("landmark_height", [-0.5], [("range_m", 2), ("above_m", 1.2)], {"range_m": "math.sqrt(4 - 1.44 + (1.2 + p[0])**2)"}),
    ("wall_excess", [0.3, 0, 2, 0.8], [("range_m", 3), ("x_m", 1.2), ("y_m", 5)],
     {"range_m": "3 + p[0] * math.exp(-(x_m - p[2])**2 / (2 * p[3]**2))"}),
    ("wall_excess", [-0.1, 2.2, -1, 0.5], [("range_m", 2), ("bearing_rad", 0.3), ("x_m", 0.4), ("y_m", -1.1)],
     {"range_m": "2 + p[0] * math.exp(-(x_m * math.cos(p[1]) + y_m * math.sin(p[1]) - p[2])**2 / (2 * p[3]**2))",
      "bearing_rad": "bearing_rad"}),
    ("landmark_delay", [0.1], [("range_m", 2)], {"delay_sigma_m": "p[0]", "place_sigma_m": "0"}),
    ("landmark_delay", [0.3], [("range_m", 1), ("lag_s", 5)], {"delay_sigma_m": "p[0]", "range_covariance_m2": "0"}),
    ("landmark_bias", [0.03, 0.1], [("lag_s", 5)], {"range_covariance_m2": "p[0]**2", "bearing_covariance_rad2": "p[1]**2"}),
    ("landmark_bias", [0.2, 0.05], [], {"range_covariance_m2": "p[0]**2", "bearing_covariance_rad2": "p[1]**2"}),
    ("range_tail", [0.03, 0.4], [("range_m", 2)], {"tail_mean_m": "p[0] * p[1]", "tail_variance_m2": "p[0] * (2 - p[0]) * p[1]**2"}),
    ("range_tail", [0.2, 1.5], [], {"tail_mean_m": "p[0] * p[1]", "tail_variance_m2": "p[0] * (2 - p[0]) * p[1]**2"}),
    # Locomotion.
    ("ideal_odometry", [], [("vx_mps", 0.2), ("for_s", 3)], {"x_m": "0.2 * 3", "y_m": "0", "theta_rad": "0"}),
    ("ideal_odometry", [], HALF, {"x_m": "walked(p, [((0.2, -0.1, 0.5), 2)])[0]",
                                  "y_m": "walked(p, [((0.2, -0.1, 0.5), 2)])[1]", "theta_rad": "1"}),
    ("odometry_scale", [-0.1, 0.2, 0.05], HALF,
     {"x_m": "walked(p, [((0.18, -0.12, 0.525), 2)])[0]", "y_m": "walked(p, [((0.18, -0.12, 0.525), 2)])[1]",
      "theta_rad": "0.525 * 2"}),
    ("odometry_scale", [0.5, 0, 0], [("vx_mps", 0.2), ("vy_mps", 0.1), ("for_s", 3)], {"x_m": "0.9", "y_m": "0.3"}),
    ("differential_drive", [0.001, 0.2], ARC, {"x_m": "math.sin(1)", "y_m": "1 - math.cos(1)", "theta_rad": "1"}),
    ("differential_drive", [0.002, 0.5], SPIN, {"x_m": "0", "theta_rad": "200 * p[0] / p[1]"}),
    ("wheel_scale", [0.1, -0.1], [("left_ticks", 500), ("right_ticks", 500), ("for_s", 4)],
     {"x_m": "math.sin(0.5)", "y_m": "math.cos(0.5) - 1", "theta_rad": "(0.45 - 0.55) / 0.2"}),
    ("wheel_scale", [0.02, 0.02], [("vx_mps", 0.3), ("for_s", 2)], {"x_m": "0.6 * (1 + p[0])", "theta_rad": "0"}),
    ("base_scale", [0.25], SPIN, {"x_m": "0", "theta_rad": "200 * 0.001 / (0.2 * 1.25)"}),
    ("base_scale", [-0.2], [("omega_radps", 0.4), ("for_s", 2)], {"theta_rad": "0.8 / (1 + p[0])"}),
    ("wheel_growth", [0.5], [("left_ticks", 500), ("right_ticks", 500), ("for_s", 2)],
     {"x_m": "0.5 * (1 + p[0] * 0.25)", "theta_rad": "0"}),
    ("wheel_growth", [-0.2], ARC,
     {f"{c}": f"rolled([((0.45, 0.55), 2)], *[lambda w, v, omega: w * (1 + p[0] * abs(w))] * 2)[{i}]"
      for i, c in enumerate(("x_m", "y_m", "theta_rad"))}),
    ("wheel_load", [0.1], ARC,
     {f"{c}": f"rolled([((0.45, 0.55), 2)], lambda w, v, omega: w * (1 + p[0] * v * omega), lambda w, v, omega: w * (1 - "
              f"p[0] * v * omega))[{i}]" for i, c in enumerate(("x_m", "y_m", "theta_rad"))}),
    ("wheel_load", [0.4], [("left_ticks", 550), ("right_ticks", 450), ("for_s", 1)],
     {"theta_rad": "(0.45 * (1 + p[0] * 0.25) - 0.55 * (1 - p[0] * 0.25)) / 0.2"}),
    ("encoder_skew", [0.1], [("left_ticks", 100), ("right_ticks", 100), ("for_s", 1), ("left_ticks", 200),
                             ("right_ticks", 200), ("for_s", 1)],
     {"theta_rad": "(0.1 * (1 - p[0]) + 0.2 * (1 - p[0]) + 0.1 * p[0] - 0.3) / 0.2"}),
    ("encoder_skew", [-0.2], [("left_ticks", 0), ("right_ticks", 100), ("for_s", 1)], {"theta_rad": "0.1 / 0.2"}),
    ("wheel_slip", [0.2], ARC, {"x_m": "0.9 * math.sin(1)", "y_m": "0.9 * (1 - math.cos(1))", "theta_rad": "1"}),
    ("wheel_slip", [0.5], [("left_ticks", 500), ("right_ticks", 500), ("for_s", 1)], {"x_m": "0.5"}),
    ("wheel_slip", [0.3], [("left_ticks", 1100), ("right_ticks", 900), ("for_s", 1)],
     {"x_m": "(1 - p[0]) * math.sin(1)", "theta_rad": "-1"}),
    ("walk_lag", [0.2], [("vx_mps", 0.3), ("for_s", 1)], {"x_m": "0.3 * (1 - p[0] * (1 - math.exp(-1 / p[0])))"}, TEN_MICROMETRES),
    ("walk_lag", [0.2], ON,
     {"x_m": "0.3 * (0.5 - p[0] * (1 - math.exp(-2.5))) + 0.3 * (1 - math.exp(-2.5)) * p[0] * (1 - math.exp(-2.5))"}, TEN_MICROMETRES),
    ("tracker_offset", [0.08, 0.02], [("vx_mps", 0.2), ("omega_radps", 0.5), ("for_s", 2)],
     {"x_m": "walked(p, [((0.2, 0, 0.5), 2)], beside)[0]", "y_m": "walked(p, [((0.2, 0, 0.5), 2)], beside)[1]",
      "theta_rad": "1"}),
    ("tracker_offset", [-0.3, 0.1], [("omega_radps", -1), ("for_s", 1.5)],
     {"x_m": "-p[0] + p[0] * math.cos(1.5) + p[1] * math.sin(1.5)",
      "y_m": "-p[1] - p[0] * math.sin(1.5) + p[1] * math.cos(1.5)"}),
    ("tracker_turn", [0.1], [("vx_mps", 0.3), ("for_s", 2)],
     {"x_m": "0.6 * math.cos(p[0])", "y_m": "-0.6 * math.sin(p[0])", "theta_rad": "0"}),
    ("tracker_turn", [-0.4], HALF,
     {"x_m": "math.cos(p[0]) * walked(p, [((0.2, -0.1, 0.5), 2)])[0] + math.sin(p[0]) * walked(p, [((0.2, -0.1, 0.5), 2)])[1]",
      "y_m": "math.cos(p[0]) * walked(p, [((0.2, -0.1, 0.5), 2)])[1] - math.sin(p[0]) * walked(p, [((0.2, -0.1, 0.5), 2)])[0]",
      "theta_rad": "1"}),
    ("turn_asymmetry", [0.025], [("omega_radps", 0.8), ("for_s", 2), ("omega_radps", -0.8), ("for_s", 3)],
     {"theta_rad": "1.6 * (1 + p[0]) - 2.4"}),
    ("turn_asymmetry", [-0.1], [("vx_mps", 0.3), ("omega_radps", 0.5), ("for_s", 2)],
     {"x_m": "0.3 / 0.45 * math.sin(0.9)", "y_m": "0.3 / 0.45 * (1 - math.cos(0.9))", "theta_rad": "0.9"}),
    ("heading_drift", [0.05], [("vx_mps", 0.2), ("for_s", 5)],
     {"x_m": "math.sin(p[0]) / p[0]", "y_m": "(1 - math.cos(p[0])) / p[0]", "theta_rad": "p[0]"}),
    ("heading_drift", [-1], [("vx_mps", 0.3), ("vy_mps", 0.4), ("for_s", 2)], {"theta_rad": "p[0] * 0.5 * 2"}),
    ("walk_noise", [0.01, 0.02], [("vx_mps", 0.2), ("for_s", 5)], {"xy_sigma_m": "p[0]", "theta_sigma_rad": "p[1]"}),
    ("walk_noise", [0.03, 0.1], [("vx_mps", 0.3), ("vy_mps", -0.4), ("for_s", 8)],
     {"xy_sigma_m": "p[0] * 2", "theta_sigma_rad": "p[1] * 2"}),
    ("pose_noise", [0.001, 0.002, 10, 1.5], [("vx_mps", 0.3), ("vy_mps", -0.4), ("omega_radps", -0.8), ("for_s", 2)],
     {"pose_xy_sigma_m": "p[0] * (1 + p[2] * 0.5 + p[3] * 0.8)", "pose_theta_sigma_rad": "p[1] * (1 + p[2] * 0.5 + p[3] * 0.8)"}),
    ("pose_noise", [0.04, 0.05, 2, 0.5], [("vx_mps", 0.2), ("omega_radps", 1), ("for_s", 2)],
     {"pose_xy_sigma_m": "p[0] * 1.9", "pose_theta_sigma_rad": "p[1] * 1.9"}),
    # Noise that is not white, of other kinds.
    ("command_jitter", [0.003], [], {"command_sigma_s": "p[0]", "joint_covariance_rad2": "0"}),
    ("command_jitter", [0.02], [], {"command_sigma_s": "p[0]"}),
    ("joint_wander", [0.004, 0.5], [("lag_s", 0.25)], {"joint_covariance_rad2": "p[0]**2 * math.exp(-lag_s / p[1])"}),
    ("point_scatter", [0.03, 1.5], [("x_m", 0.1), ("z_m", 1)], {"scatter_variance_px2": "p[0] * p[1]**2"}),
    ("point_scatter", [0.2, 4], [("x_m", 0.1), ("z_m", 1)], {"scatter_variance_px2": "p[0] * p[1]**2"}),
    ("joint_wander", [0.02, 3], [("lag_s", 1.5)], {"joint_covariance_rad2": "p[0]**2 * math.exp(-lag_s / p[1])"}),
    # Inertial sensors: powers at omega = 2 pi f / rate.
    ("gyro_white_noise", [0.01, 0.02, 0.03], [("frequency_hz", 1), ("rate_hz", 100)],
     {"wx_power": "p[0]**2 * rate_hz", "wy_power": "p[1]**2 * rate_hz", "wz_power": "p[2]**2 * rate_hz"}),
    ("gyro_white_noise", [0.3, 0.1, 0.2], [("frequency_hz", 40), ("rate_hz", 200)],
     {"wx_power": "p[0]**2 * rate_hz", "wy_power": "p[1]**2 * rate_hz", "wz_power": "p[2]**2 * rate_hz"}),
    ("gyro_bias_instability", [0.01, 0.02, 0.03], [("frequency_hz", 1), ("rate_hz", 100)],
     {"wx_power": "p[0]**2 / (2 * math.sin(math.pi * frequency_hz / rate_hz))", "wy_power": "p[1]**2 / (2 * math.sin(math.pi * frequency_hz / rate_hz))", "wz_power": "p[2]**2 / (2 * math.sin(math.pi * frequency_hz / rate_hz))"}),
    ("gyro_bias_instability", [0.3, 0.1, 0.2], [("frequency_hz", 40), ("rate_hz", 200)],
     {"wx_power": "p[0]**2 / (2 * math.sin(math.pi * frequency_hz / rate_hz))", "wy_power": "p[1]**2 / (2 * math.sin(math.pi * frequency_hz / rate_hz))", "wz_power": "p[2]**2 / (2 * math.sin(math.pi * frequency_hz / rate_hz))"}),
    ("gyro_random_walk", [0.01, 0.02, 0.03], [("frequency_hz", 1), ("rate_hz", 100)],
     {"wx_power": "p[0]**2 / rate_hz / (2 * math.sin(math.pi * frequency_hz / rate_hz))**2", "wy_power": "p[1]**2 / rate_hz / (2 * math.sin(math.pi * frequency_hz / rate_hz))**2", "wz_power": "p[2]**2 / rate_hz / (2 * math.sin(math.pi * frequency_hz / rate_hz))**2"}),
    ("gyro_random_walk", [0.3, 0.1, 0.2], [("frequency_hz", 40), ("rate_hz", 200)],
     {"wx_power": "p[0]**2 / rate_hz / (2 * math.sin(math.pi * frequency_hz / rate_hz))**2", "wy_power": "p[1]**2 / rate_hz / (2 * math.sin(math.pi * frequency_hz / rate_hz))**2", "wz_power": "p[2]**2 / rate_hz / (2 * math.sin(math.pi * frequency_hz / rate_hz))**2"}),
    ("gyro_quantisation", [0.01, 0.02, 0.03], [("frequency_hz", 1), ("rate_hz", 100)],
     {"wx_power": "(p[0] * rate_hz * 2 * math.sin(math.pi * frequency_hz / rate_hz))**2", "wy_power": "(p[1] * rate_hz * 2 * math.sin(math.pi * frequency_hz / rate_hz))**2", "wz_power": "(p[2] * rate_hz * 2 * math.sin(math.pi * frequency_hz / rate_hz))**2"}),
    ("gyro_quantisation", [0.3, 0.1, 0.2], [("frequency_hz", 40), ("rate_hz", 200)],
     {"wx_power": "(p[0] * rate_hz * 2 * math.sin(math.pi * frequency_hz / rate_hz))**2", "wy_power": "(p[1] * rate_hz * 2 * math.sin(math.pi * frequency_hz / rate_hz))**2", "wz_power": "(p[2] * rate_hz * 2 * math.sin(math.pi * frequency_hz / rate_hz))**2"}),
    ("gyro_vibration", [0.01, 0.02, 0.03, 20, 40, 0], [("frequency_hz", 20.5), ("rate_hz", 100)],
     {"wx_power": "p[0]**2 * vibrating(p[3], p[3] / p[4], p[5], frequency_hz, rate_hz)", "wy_power": "p[1]**2 * vibrating(p[3], p[3] / p[4], p[5], frequency_hz, rate_hz)", "wz_power": "p[2]**2 * vibrating(p[3], p[3] / p[4], p[5], frequency_hz, rate_hz)"}),
    ("gyro_vibration", [0.3, 0.1, 0.2, 90, 30, 0.8], [("frequency_hz", 30), ("rate_hz", 200)],
     {"wx_power": "p[0]**2 * vibrating(p[3], p[3] / p[4], p[5], frequency_hz, rate_hz)", "wy_power": "p[1]**2 * vibrating(p[3], p[3] / p[4], p[5], frequency_hz, rate_hz)", "wz_power": "p[2]**2 * vibrating(p[3], p[3] / p[4], p[5], frequency_hz, rate_hz)"}),
    ("accel_vibration", [0.01, 0.02, 0.03, 20, 40, 0], [("frequency_hz", 20.5), ("rate_hz", 100)],
     {"ax_power": "p[0]**2 * vibrating(p[3], p[3] / p[4], p[5], frequency_hz, rate_hz)", "ay_power": "p[1]**2 * vibrating(p[3], p[3] / p[4], p[5], frequency_hz, rate_hz)", "az_power": "p[2]**2 * vibrating(p[3], p[3] / p[4], p[5], frequency_hz, rate_hz)"}),
    ("accel_vibration", [0.3, 0.1, 0.2, 90, 30, 0.8], [("frequency_hz", 30), ("rate_hz", 200)],
     {"ax_power": "p[0]**2 * vibrating(p[3], p[3] / p[4], p[5], frequency_hz, rate_hz)", "ay_power": "p[1]**2 * vibrating(p[3], p[3] / p[4], p[5], frequency_hz, rate_hz)", "az_power": "p[2]**2 * vibrating(p[3], p[3] / p[4], p[5], frequency_hz, rate_hz)"}),
    ("imu_clock", [4000], [("rate_hz", 200)], {"sample_distance_s": "1 / (rate_hz * (1 + p[0] * 1e-6))"}),
    ("imu_clock", [-150], [], {"sample_distance_s": "1 / (100 * (1 + p[0] * 1e-6))"}),
    ("imu_jitter", [0.001], [], {"stamp_sigma_s": "p[0]"}),
    ("imu_jitter", [0.02], [], {"stamp_sigma_s": "p[0]"}),
    ("camera_imu_offset", [0.005, 0.5], [("exposure_s", 0.008)], {"camera_offset_s": "p[0] + p[1] * exposure_s"}),
    ("camera_imu_offset", [-0.02, -0.5], [("exposure_s", 0.01)], {"camera_offset_s": "p[0] + p[1] * exposure_s"}),
    ("camera_imu_rotation", [0.3, -0.2, 0.4], [("wx_camera_radps", 1), ("wy_camera_radps", 2), ("wz_camera_radps", 3)],
     {f"w{axis}_turned_radps": f"spun(p, 1, 2, 3)[{number}]" for number, axis in enumerate("xyz")}),
    ("camera_imu_rotation", [-1.5, 0.1, 0.2], [("wx_camera_radps", 0.5)],
     {f"w{axis}_turned_radps": f"spun(p, 0.5, 0, 0)[{number}]" for number, axis in enumerate("xyz")}),
    ("gyro_bias", [0.01, -0.02, 0.03], [], {"wx_radps": "p[0]", "wy_radps": "p[1]", "wz_radps": "p[2]"}),
    ("gyro_bias", [-0.5, 0.25, 0.125], [("wx_radps", 1), ("wy_radps", 2), ("wz_radps", 3)], {"wx_radps": "1 + p[0]", "wy_radps": "2 + p[1]", "wz_radps": "3 + p[2]"}),
    ("gyro_scale", [0.01, -0.02, 0.03], [("wx_radps", 1), ("wy_radps", 2), ("wz_radps", -3)], {"wx_radps": "1 + p[0]", "wy_radps": "2 * (1 + p[1])", "wz_radps": "-3 * (1 + p[2])"}),
    ("gyro_scale", [0.2, 0.1, -0.1], [("wx_radps", 9), ("wy_radps", -8), ("wz_radps", 7)], {"wx_radps": "9 * (1 + p[0])", "wy_radps": "-8 * (1 + p[1])", "wz_radps": "7 * (1 + p[2])"}),
    ("gyro_misalignment", [0.01, -0.02, 0.03, 0.04, -0.05, 0.06], [("wx_radps", 1), ("wy_radps", 2), ("wz_radps", 3)],
     {"wx_radps": "1 + p[0] * 2 + p[1] * 3", "wy_radps": "2 + p[2] * 1 + p[3] * 3", "wz_radps": "3 + p[4] * 1 + p[5] * 2"}),
    ("gyro_misalignment", [0.1, 0.2, -0.3, 0.15, 0.25, -0.35], [("wx_radps", 5), ("wy_radps", -4), ("wz_radps", 2)],
     {"wx_radps": "5 + p[0] * -4 + p[1] * 2", "wy_radps": "-4 + p[2] * 5 + p[3] * 2", "wz_radps": "2 + p[4] * 5 + p[5] * -4"}),
    ("gyro_temperature", [0.01, -0.02, 0.03], [("temperature_c", 35)], {"wx_radps": "10 * p[0]", "wy_radps": "10 * p[1]", "wz_radps": "10 * p[2]"}),
    ("gyro_temperature", [0.1, 0.2, 0.3], [("temperature_c", 5)], {"wx_radps": "-20 * p[0]", "wy_radps": "-20 * p[1]", "wz_radps": "-20 * p[2]"}),
    ("gyro_saturation", [2], [("wx_radps", 1), ("wy_radps", 5), ("wz_radps", -6)], {"wx_radps": "1", "wy_radps": "p[0]", "wz_radps": "-p[0]"}),
    ("gyro_saturation", [7.5], [("wx_radps", 8), ("wy_radps", -9), ("wz_radps", 3)], {"wx_radps": "p[0]", "wy_radps": "-p[0]", "wz_radps": "3"}),
    ("accel_white_noise", [0.01, 0.02, 0.03], [("frequency_hz", 1), ("rate_hz", 100)],
     {"ax_power": "p[0]**2 * rate_hz", "ay_power": "p[1]**2 * rate_hz", "az_power": "p[2]**2 * rate_hz"}),
    ("accel_white_noise", [0.3, 0.1, 0.2], [("frequency_hz", 40), ("rate_hz", 200)],
     {"ax_power": "p[0]**2 * rate_hz", "ay_power": "p[1]**2 * rate_hz", "az_power": "p[2]**2 * rate_hz"}),
    ("accel_bias_instability", [0.01, 0.02, 0.03], [("frequency_hz", 1), ("rate_hz", 100)],
     {"ax_power": "p[0]**2 / (2 * math.sin(math.pi * frequency_hz / rate_hz))", "ay_power": "p[1]**2 / (2 * math.sin(math.pi * frequency_hz / rate_hz))", "az_power": "p[2]**2 / (2 * math.sin(math.pi * frequency_hz / rate_hz))"}),
    ("accel_bias_instability", [0.3, 0.1, 0.2], [("frequency_hz", 40), ("rate_hz", 200)],
     {"ax_power": "p[0]**2 / (2 * math.sin(math.pi * frequency_hz / rate_hz))", "ay_power": "p[1]**2 / (2 * math.sin(math.pi * frequency_hz / rate_hz))", "az_power": "p[2]**2 / (2 * math.sin(math.pi * frequency_hz / rate_hz))"}),
    ("accel_random_walk", [0.01, 0.02, 0.03], [("frequency_hz", 1), ("rate_hz", 100)],
     {"ax_power": "p[0]**2 / rate_hz / (2 * math.sin(math.pi * frequency_hz / rate_hz))**2", "ay_power": "p[1]**2 / rate_hz / (2 * math.sin(math.pi * frequency_hz / rate_hz))**2", "az_power": "p[2]**2 / rate_hz / (2 * math.sin(math.pi * frequency_hz / rate_hz))**2"}),
    ("accel_random_walk", [0.3, 0.1, 0.2], [("frequency_hz", 40), ("rate_hz", 200)],
     {"ax_power": "p[0]**2 / rate_hz / (2 * math.sin(math.pi * frequency_hz / rate_hz))**2", "ay_power": "p[1]**2 / rate_hz / (2 * math.sin(math.pi * frequency_hz / rate_hz))**2", "az_power": "p[2]**2 / rate_hz / (2 * math.sin(math.pi * frequency_hz / rate_hz))**2"}),
    ("accel_quantisation", [0.01, 0.02, 0.03], [("frequency_hz", 1), ("rate_hz", 100)],
     {"ax_power": "(p[0] * rate_hz * 2 * math.sin(math.pi * frequency_hz / rate_hz))**2", "ay_power": "(p[1] * rate_hz * 2 * math.sin(math.pi * frequency_hz / rate_hz))**2", "az_power": "(p[2] * rate_hz * 2 * math.sin(math.pi * frequency_hz / rate_hz))**2"}),
    ("accel_quantisation", [0.3, 0.1, 0.2], [("frequency_hz", 40), ("rate_hz", 200)],
     {"ax_power": "(p[0] * rate_hz * 2 * math.sin(math.pi * frequency_hz / rate_hz))**2", "ay_power": "(p[1] * rate_hz * 2 * math.sin(math.pi * frequency_hz / rate_hz))**2", "az_power": "(p[2] * rate_hz * 2 * math.sin(math.pi * frequency_hz / rate_hz))**2"}),
    ("accel_bias", [0.01, -0.02, 0.03], [], {"ax_mps2": "p[0]", "ay_mps2": "p[1]", "az_mps2": "p[2]"}),
    ("accel_bias", [-0.5, 0.25, 0.125], [("ax_mps2", 1), ("ay_mps2", 2), ("az_mps2", 3)], {"ax_mps2": "1 + p[0]", "ay_mps2": "2 + p[1]", "az_mps2": "3 + p[2]"}),
    ("accel_scale", [0.01, -0.02, 0.03], [("ax_mps2", 1), ("ay_mps2", 2), ("az_mps2", -3)], {"ax_mps2": "1 + p[0]", "ay_mps2": "2 * (1 + p[1])", "az_mps2": "-3 * (1 + p[2])"}),
    ("accel_scale", [0.2, 0.1, -0.1], [("ax_mps2", 9), ("ay_mps2", -8), ("az_mps2", 7)], {"ax_mps2": "9 * (1 + p[0])", "ay_mps2": "-8 * (1 + p[1])", "az_mps2": "7 * (1 + p[2])"}),
    ("accel_misalignment", [0.01, -0.02, 0.03], [("ax_mps2", 1), ("ay_mps2", 2), ("az_mps2", 3)],
     {"ax_mps2": "1", "ay_mps2": "2 + p[0] * 1", "az_mps2": "3 + p[1] * 1 + p[2] * 2"}),
    ("accel_misalignment", [0.1, 0.2, -0.3], [("ax_mps2", 5), ("ay_mps2", -4), ("az_mps2", 2)],
     {"ax_mps2": "5", "ay_mps2": "-4 + p[0] * 5", "az_mps2": "2 + p[1] * 5 + p[2] * -4"}),
    ("accel_temperature", [0.01, -0.02, 0.03], [("temperature_c", 35)], {"ax_mps2": "10 * p[0]", "ay_mps2": "10 * p[1]", "az_mps2": "10 * p[2]"}),
    ("accel_temperature", [0.1, 0.2, 0.3], [("temperature_c", 5)], {"ax_mps2": "-20 * p[0]", "ay_mps2": "-20 * p[1]", "az_mps2": "-20 * p[2]"}),
    ("accel_saturation", [2], [("ax_mps2", 1), ("ay_mps2", 5), ("az_mps2", -6)], {"ax_mps2": "1", "ay_mps2": "p[0]", "az_mps2": "-p[0]"}),
    ("accel_saturation", [7.5], [("ax_mps2", 8), ("ay_mps2", -9), ("az_mps2", 3)], {"ax_mps2": "p[0]", "ay_mps2": "-p[0]", "az_mps2": "3"}),
    ("gyro_g_sensitivity", [0.001, 0.002, -0.003], [("wx_radps", 1), ("ax_mps2", 2), ("ay_mps2", 3), ("az_mps2", 9)],
     {"wx_radps": "1 + 2 * p[0]", "wy_radps": "3 * p[1]", "wz_radps": "9 * p[2]"}),
    ("gyro_g_sensitivity", [-0.01, 0.02, 0.03], [("ax_mps2", 9.8), ("ay_mps2", -9.8), ("az_mps2", 4)],
     {"wx_radps": "9.8 * p[0]", "wy_radps": "-9.8 * p[1]", "wz_radps": "4 * p[2]"}),
]


def number(value):
    return "INFINITY" if math.isinf(value) else f"{value:.15g}"


def proof_of(effect, values, given, expected, tolerance=None):
    names = {name: value for name, value in given}
    names.update(vars(effect_formulas), p=values)
    found = {name: eval(text, dict(names)) for name, text in expected.items()}
    pairs = lambda items: "{" + ", ".join(f'{{"{name}", {number(value)}}}' for name, value in items) + "}"
    text = f"{{.values = {{{', '.join(number(v) for v in values)}}}"
    if given:
        text += f", .given = {pairs(given)}"
    text += f", .expected = {pairs(found.items())}"
    source = ", ".join(dict.fromkeys(expected.values()))
    text += f', .source = "python: {source}"'
    if tolerance is not None:
        text += f", .tolerance = {tolerance}"
    return text + "}"


def blocks():
    all_proofs = {}
    for proof in PROOFS:
        all_proofs.setdefault(proof[0], []).append(proof_of(*proof))
    return {name: "{" + ", ".join(proofs) + "}" for name, proofs in all_proofs.items()}


def without_layout(text):
    return re.sub(r"\s+", "", re.sub(r'"\s*\n\s*"', "", text))


def with_proof(record, block):
    """The record with this block instead of the one that is there: behind `.proof =`, or in a function of its own."""
    start = re.search(r"(?:\.proof =|\breturn)\s*(?=\{\{\.values)", record).end()
    depth = end = 0
    for piece in re.finditer(r'"(?:[^"\\]|\\.)*"|[{}]', record[start:]):
        depth += {"{": 1, "}": -1}.get(piece.group(), 0)
        if depth == 0:
            end = start + piece.end()
            break
    return record[:start] + block + record[end:]


def findings(computed, files):
    """What does not agree between what is computed here and the records."""
    for name, block in computed.items():
        if name not in files:
            yield f"{name}: no record effects/catalogue/STAGE/{name}.cc: correct the name here, or add the record"
        elif without_layout(block) not in without_layout(open(files[name]).read()):
            yield f"{name}: its record holds other numbers than this script computes: copy what `scripts/effect_proofs.py {name}` prints"
    for name in files:
        if name not in computed:
            yield f"{name}: its record is there, its numbers are not computed here: add lines to PROOFS"


def main():
    root_folder = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
    files = {os.path.basename(f)[:-3]: f for f in sorted(glob.glob(os.path.join(root_folder, "effects/catalogue/*/*.cc")))}
    computed, names, write = blocks(), sys.argv[1:], "--write" in sys.argv
    names = [name for name in names if name != "--write"]
    if write and not names:
        sys.exit("--write: expected the NAME of an effect")
    if names == ["--check"]:
        found = list(findings(computed, files))
        print("\n".join(found) or f"{len(computed)} effects: records and numbers agree")
        return 1 if found else 0
    missing = [name for name in names if name not in computed or (write and name not in files)]
    for name in missing:
        lacks = [*(["no record effects/catalogue/STAGE/%s.cc" % name] if name not in files else []),
                 *(["no lines in PROOFS of this script"] if name not in computed else [])]
        print(f"{name}: {' and '.join(lacks)}", file=sys.stderr)
    for name in names or computed:
        if write and name in computed and name in files:
            with open(files[name]) as file:
                record = with_proof(file.read(), computed[name])
            with open(files[name], "w") as file:
                file.write(record)
            if shutil.which("clang-format"):
                subprocess.run(["clang-format", "-i", files[name]], check=True)
        elif name in computed:
            print(f"{name}\n      .proof = {computed[name]},\n")
    return 1 if missing else 0


if __name__ == "__main__":
    sys.exit(main())
