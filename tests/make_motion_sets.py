#!/usr/bin/env python3
"""Measurement sets of kinds joints and odometry with hidden effects, by brute force: small Euler
steps written from the definitions, nothing of SEAM's own code. Writes SETS/NAME/ and
SETS/answers.json, as the scoring script of the shared sets reads them.

make_motion_sets.py SETS [--only a,b] [--seed N] [--small]
"""
import argparse
import json
import math
import os
import random


def servo(p, times, commands, q0, load_of_row, h=1e-4):
    """Angles just before each row's command acts."""
    if "acceleration_limit" in p:
        h = 2e-5  # Braking starts and ends at instants that a wide step misses by more than the noise.
    tau = p.get("servo_lag", {}).get("tau_s", 0)
    latency = p.get("servo_latency", {}).get("latency_s", 0)
    vmax = p.get("speed_limit", {}).get("rad_per_s", math.inf)
    amax = p.get("acceleration_limit", {}).get("rad_per_s2", math.inf)
    band = p.get("stiction", {}).get("dead_band_rad", 0)
    width = p.get("backlash", {}).get("width_rad", 0)
    sag, level = p.get("gravity_sag", {}).get("rad", 0), p.get("gravity_sag", {}).get("level_rad", 0)
    resonance, friction = p.get("resonance"), p.get("load_friction")
    q, v, load = q0, 0.0, q0
    command, next_command, out = None, 0, []
    spring, spring_v = q0, 0.0
    for row, t in enumerate(times):
        start = times[row - 1] if row else t
        steps = max(1, round((t - start) / h)) if row else 0
        for i in range(steps):
            now = start + (t - start) * i / steps
            dt = (t - start) / steps
            while next_command < len(times) and times[next_command] + latency <= now + 1e-9 and next_command < row:
                command, next_command = commands[next_command], next_command + 1
            if command is None:
                continue
            e, v_before = command - q, v
            effective_band = band + (friction["rad_per_nm"] * abs(load_of_row[row]) if friction else 0)
            if abs(e) < effective_band or e == 0:
                v = 0.0
            else:
                want = e * -math.expm1(-dt / tau) / dt if tau else e / dt
                want = max(-vmax, min(vmax, want))
                if amax < math.inf:
                    brake = math.sqrt(2 * amax * abs(e))
                    want = max(-brake, min(brake, want))
                    v += max(-amax * dt, min(amax * dt, want - v))
                else:
                    v = want
            q += (0.5 * (v_before + v) if amax < math.inf else v) * dt
            load = max(q - width / 2, min(q + width / 2, load))
            if resonance:
                w, z = 2 * math.pi * resonance["hz"], resonance["damping"]
                spring_v += dt * (w * w * (load - spring) - 2 * z * w * spring_v)
                spring += dt * spring_v
        angle = spring if resonance else load
        out.append(angle - sag * math.cos(angle - level))
    return out


def encoder(p, joint, true):
    offset = p.get("encoder_offset", {}).get(f"{joint}_rad", 0)
    scale = p.get("encoder_scale", {}).get(f"{joint}_scale", 0)
    ecc = p.get("encoder_eccentricity", {})
    angle = (true - offset) / (1 + scale)
    return angle - ecc.get("amplitude_rad", 0) * math.sin(angle + ecc.get("phase_rad", 0))


def command_at(kind, t, rng_state):
    if kind == 0:  # Steps of several heights.
        return rng_state["steps"][int(t / 0.5) % len(rng_state["steps"])]
    if kind == 1:  # A chirp.
        return 0.5 * math.sin(2 * math.pi * (0.2 + 0.25 * t) * t)
    if kind == 2:  # A triangle.
        x = (t / 1.6) % 1
        return 0.8 * (4 * x - 1 if x < 0.5 else 3 - 4 * x)
    return rng_state["walk"][int(t / 0.1) % len(rng_state["walk"])]


def write_joints(folder, p, rng, small, blank_noise=False, outliers=0, joint="pan"):
    runs, rows, dt, noise = (6, 170, 0.008, 0.0006) if small else (12, 500, 0.008, 0.0006)
    dt = 0.016 if small else dt
    step = p.get("encoder_quantisation", {}).get("step_rad", 0)
    lines = ["run,time_s,joint,command_rad,measured_rad" + (",load_nm" if "load_friction" in p else "")]
    for run in range(runs):
        state = {"steps": [rng.uniform(-1, 1) for _ in range(8)], "walk": []}
        at = 0.0
        for _ in range(200):
            at = max(-0.9, min(0.9, at + rng.uniform(-0.12, 0.12)))
            state["walk"].append(at)
        times, t = [], 0.0
        for _ in range(rows):
            times.append(t)
            t = round(t + dt, 6)
        commands = [command_at(run % 4, t, state) for t in times]
        loads = [rng.uniform(0, 0.5)] * rows
        loads = [loads[0] if i < rows // 2 else 0.5 - loads[0] for i in range(rows)]
        truth = servo(p, times, commands, commands[0] + (0.05 if run % 3 == 2 else 0), loads)
        for k in range(rows):
            measured = encoder(p, joint, truth[k]) + rng.gauss(0, noise)
            if step:
                measured = round(measured / step) * step
            if rng.random() < outliers:
                measured += rng.choice([-1, 1]) * rng.uniform(0.05, 0.5)
            tail = f",{loads[k]:.4f}" if "load_friction" in p else ""
            lines.append(f"{run},{times[k]:.6f},{joint},{commands[k]:.6f},{measured:.6f}{tail}")
    with open(f"{folder}/joints.csv", "w") as f:
        f.write("\n".join(lines) + "\n")
    noise_line = "" if blank_noise else f"noise: {{measured_rad: {noise}}}\n"
    with open(f"{folder}/measurement.yaml", "w") as f:
        f.write(f"format: seam-measurement/1\nkind: joints\ntitle: made joints\n{noise_line}group: run\nfiles: {{joints: joints.csv}}\n")
    with open(f"{folder}/nominal.yaml", "w") as f:
        f.write("format: seam-model/1\nname: nominal\neffects:\n  ideal_servo: {}\n")


def walk(p, times, commands, start, rng, slip=None):
    scale = p.get("odometry_scale", {})
    tau = p.get("walk_lag", {}).get("tau_s", 0)
    drift = p.get("heading_drift", {}).get("rad_per_m", 0)
    noise = p.get("walk_noise", {})
    x, y, theta = start
    vx = vy = om = 0.0
    poses = [(x, y, theta)]
    for k in range(1, len(times)):
        steps = 200
        h = (times[k] - times[k - 1]) / steps
        c = commands[k - 1]
        path = 0.0
        for _ in range(steps):
            if tau:
                gain = 1 - math.exp(-h / tau)
                mx, my, mo = vx + (c[0] - vx) * gain / 2, vy + (c[1] - vy) * gain / 2, om + (c[2] - om) * gain / 2
                vx, vy, om = vx + (c[0] - vx) * gain, vy + (c[1] - vy) * gain, om + (c[2] - om) * gain
            else:
                mx, my, mo = c
            ax, ay = mx * (1 + scale.get("vx_scale", 0)), my * (1 + scale.get("vy_scale", 0))
            if slip:  # Sideways slip in turns: in no catalogue.
                ay += slip * mx * mo
            s = math.hypot(ax, ay) * h
            turn = mo * (1 + scale.get("omega_scale", 0)) * h + drift * s
            mid = theta + turn / 2
            x += (math.cos(mid) * ax - math.sin(mid) * ay) * h
            y += (math.sin(mid) * ax + math.cos(mid) * ay) * h
            theta += turn
            path += s
        root = math.sqrt(path)
        nx, ny = rng.gauss(0, noise.get("xy_sigma", 0) * root), rng.gauss(0, noise.get("xy_sigma", 0) * root)
        x += math.cos(theta) * nx - math.sin(theta) * ny
        y += math.sin(theta) * nx + math.cos(theta) * ny
        theta += rng.gauss(0, noise.get("theta_sigma", 0) * root)
        poses.append((x, y, theta))
    return poses


def write_odometry(folder, p, rng, small, blank_noise=False, outliers=0):
    runs, rows = (8, 45) if small else (24, 41)
    sigma = (0.002, 0.002, 0.003)
    lines = ["run,time_s,vx_cmd_mps,vy_cmd_mps,omega_cmd_radps,x_m,y_m,theta_rad"]
    for run in range(runs):
        times = [0.2 * k for k in range(rows)]
        commands, current = [], None
        for k in range(rows):
            if k % 8 == 0:
                current = (rng.uniform(-0.15, 0.3), rng.uniform(-0.1, 0.1), rng.uniform(-0.9, 0.9))
            commands.append(current)
        start = (rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-3.1, 3.1))
        for k, pose in enumerate(walk(p, times, commands, start, rng, p.get("turn_slip", {}).get("s", None))):
            x, y, theta = (a + rng.gauss(0, s) for a, s in zip(pose, sigma))
            if rng.random() < outliers:
                x += rng.choice([-1, 1]) * rng.uniform(0.1, 1)
            theta = math.atan2(math.sin(theta), math.cos(theta))
            c = commands[k]
            lines.append(f"{run},{times[k]:.3f},{c[0]:.5f},{c[1]:.5f},{c[2]:.5f},{x:.5f},{y:.5f},{theta:.5f}")
    with open(f"{folder}/odometry.csv", "w") as f:
        f.write("\n".join(lines) + "\n")
    noise_line = "" if blank_noise else "noise: {x_m: 0.002, y_m: 0.002, theta_rad: 0.003}\n"
    with open(f"{folder}/measurement.yaml", "w") as f:
        f.write(f"format: seam-measurement/1\nkind: odometry\ntitle: made walks\n{noise_line}group: run\nfiles: {{odometry: odometry.csv}}\n")
    with open(f"{folder}/nominal.yaml", "w") as f:
        f.write("format: seam-model/1\nname: nominal\neffects:\n  ideal_odometry: {}\n")


CASES = {
    "j-none": ("joints", {}, {}),
    "j-lag": ("joints", {"servo_lag": {"tau_s": 0.03}}, {}),
    "j-latency": ("joints", {"servo_latency": {"latency_s": 0.02}}, {}),
    "j-lag-latency": ("joints", {"servo_lag": {"tau_s": 0.05}, "servo_latency": {"latency_s": 0.013}}, {}),
    "j-speed": ("joints", {"speed_limit": {"rad_per_s": 2.5}}, {}),
    "j-accel": ("joints", {"acceleration_limit": {"rad_per_s2": 40}}, {}),
    "j-lag-accel": ("joints", {"servo_lag": {"tau_s": 0.04}, "acceleration_limit": {"rad_per_s2": 60}}, {}),
    "j-lag-speed": ("joints", {"servo_lag": {"tau_s": 0.04}, "speed_limit": {"rad_per_s": 3}}, {}),
    "j-speed-accel": ("joints", {"speed_limit": {"rad_per_s": 3}, "acceleration_limit": {"rad_per_s2": 50}}, {}),
    "j-stiction": ("joints", {"stiction": {"dead_band_rad": 0.02}}, {}),
    "j-lag-stiction": ("joints", {"servo_lag": {"tau_s": 0.03}, "stiction": {"dead_band_rad": 0.01}}, {}),
    "j-backlash": ("joints", {"backlash": {"width_rad": 0.02}}, {}),
    "j-lag-backlash": ("joints", {"servo_lag": {"tau_s": 0.03}, "backlash": {"width_rad": 0.012}}, {}),
    "j-sag": ("joints", {"gravity_sag": {"rad": 0.015}}, {}),
    "j-lag-sag": ("joints", {"servo_lag": {"tau_s": 0.06}, "gravity_sag": {"rad": -0.02}}, {}),
    "j-sag-level": ("joints", {"gravity_sag": {"rad": 0.02, "level_rad": 1.2}}, {}),
    "j-offset": ("joints", {"encoder_offset": {"pan_rad": 0.008}}, {}),
    "j-scale": ("joints", {"encoder_scale": {"pan_scale": -0.02}}, {}),
    "j-three": ("joints", {"servo_lag": {"tau_s": 0.03}, "speed_limit": {"rad_per_s": 2.5}, "backlash": {"width_rad": 0.01}}, {}),
    "j-lag-outliers": ("joints", {"servo_lag": {"tau_s": 0.03}}, {"outliers": 0.01}),
    "j-lag-blank": ("joints", {"servo_lag": {"tau_s": 0.03}}, {"blank_noise": True}),
    "j-none-blank": ("joints", {}, {"blank_noise": True}),
    "j-quantisation": ("joints", {"servo_lag": {"tau_s": 0.03}, "encoder_quantisation": {"step_rad": 0.005}}, {}),
    "j-resonance": ("joints", {"resonance": {"hz": 9, "damping": 0.15}}, {}),
    "j-load-friction": ("joints", {"servo_lag": {"tau_s": 0.02}, "load_friction": {"rad_per_nm": 0.08}}, {}),
    "o-none": ("odometry", {}, {}),
    "o-scale": ("odometry", {"odometry_scale": {"vx_scale": 0.05, "vy_scale": -0.08, "omega_scale": 0.03}}, {}),
    "o-omega": ("odometry", {"odometry_scale": {"vx_scale": 0, "vy_scale": 0, "omega_scale": -0.06}}, {}),
    "o-drift": ("odometry", {"heading_drift": {"rad_per_m": 0.08}}, {}),
    "o-lag": ("odometry", {"walk_lag": {"tau_s": 0.15}}, {}),
    "o-noise": ("odometry", {"walk_noise": {"xy_sigma": 0.02, "theta_sigma": 0.05}}, {}),
    "o-scale-noise": ("odometry", {"odometry_scale": {"vx_scale": -0.1, "vy_scale": 0, "omega_scale": 0}, "walk_noise": {"xy_sigma": 0.01, "theta_sigma": 0.03}}, {}),
    "o-lag-drift": ("odometry", {"walk_lag": {"tau_s": 0.2}, "heading_drift": {"rad_per_m": -0.1}}, {}),
    "o-outliers": ("odometry", {"heading_drift": {"rad_per_m": 0.1}}, {"outliers": 0.01}),
    "o-blank": ("odometry", {"odometry_scale": {"vx_scale": 0.1, "vy_scale": 0, "omega_scale": 0}}, {"blank_noise": True}),
    "o-none-blank": ("odometry", {}, {"blank_noise": True}),
    "o-slip": ("odometry", {"turn_slip": {"s": 0.3}}, {}),
}


def main():
    args = argparse.ArgumentParser()
    args.add_argument("sets")
    args.add_argument("--only")
    args.add_argument("--seed", type=int, default=1)
    args.add_argument("--small", action="store_true")
    args = args.parse_args()
    answers = {}
    for name, (kind, hidden, options) in CASES.items():
        if args.only and name not in args.only.split(","):
            continue
        rng = random.Random(f"{name} {args.seed}")
        folder = f"{args.sets}/{name}"
        os.makedirs(folder, exist_ok=True)
        (write_joints if kind == "joints" else write_odometry)(folder, hidden, rng, args.small, **options)
        answers[name] = hidden
    with open(f"{args.sets}/answers.json", "w") as f:
        json.dump(answers, f, indent=1)


main()
