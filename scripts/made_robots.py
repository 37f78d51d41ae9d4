#!/usr/bin/env python3
"""Beacons, wheels and cameras whose errors are known: how often `seam discover` finds them.

    scripts/made_robots.py build/seam [--sort beacons ...] [--sets 20] [--first 0] [--keep FOLDER]

The sets are computed here, by plain formulas and Python's random numbers, not by `seam measure`; each has a robot, its
ways and its errors drawn by its number. Counts are those of made_servos.py.
"""
import math
import random
import struct
import sys
import zlib

from made_servos import search_all


def model(effects):
    return "format: seam-model/1\nname: nominal\neffects:\n" + "".join(f"  {line}\n" for line in effects)


def write_set(folder, files, yaml, nominal):
    data = folder / "data"
    data.mkdir()
    for name, lines in files.items():
        (data / name).write_text("\n".join(lines) + "\n")
    (data / "measurement.yaml").write_text("format: seam-measurement/1\n" + yaml)
    (folder / "nominal.yaml").write_text(model(nominal))


def signed(draw, least, most):
    return draw.choice((-1, 1)) * draw.uniform(least, most)


# -- a robot among radio beacons: ranges alone ---------------------------------------------------------------------------

def smooth_way(draw, extent, rate):
    """Position and heading of a body that goes where it looks."""
    waves = [(draw.uniform(0.5, 1) * extent, rate * draw.uniform(0.6, 1.4), draw.uniform(0, 6)) for _ in range(4)]

    def place(t):
        return (sum(a * math.sin(w * t + p) for a, w, p in waves[:2]),
                sum(a * math.cos(w * t + p) for a, w, p in waves[2:]))

    def pose(t):
        (x, y), (x0, y0), (x1, y1) = place(t), place(t - 1e-4), place(t + 1e-4)
        return x, y, math.atan2(y1 - y0, x1 - x0)
    return pose


def beacons(_, sort, number, folder):
    draw = random.Random(f"{sort} {number}")
    truth = {}
    for name in draw.sample(("range_scale", "range_offset", "range_depth", "frame_latency"), draw.choice((1, 1, 2))):
        truth[name] = {"range_scale": lambda: {"scale": signed(draw, 0.02, 0.1)},
                       "range_offset": lambda: {"offset_m": signed(draw, 0.15, 0.8)},
                       "range_depth": lambda: {"k": 1.0},
                       "frame_latency": lambda: {"latency_s": signed(draw, 0.06, 0.18)}}[name]()
    noise = draw.uniform(0.03, 0.12)
    count, gross, blank = draw.choice((4, 4, 5, 7)), draw.choice((0, 0.01)), draw.choice((0, 0.1))
    if gross:
        truth["range_tail"] = {}
    extent = draw.uniform(6, 14)
    pose = smooth_way(draw, extent, draw.uniform(0.08, 0.14))
    places = [(signed(draw, 0.6, 2) * extent, signed(draw, 0.6, 2) * extent) for _ in range(count)]
    # A camera's depth is seen ahead alone.
    widest = 1.1 if "range_depth" in truth else 4
    latency = truth.get("frame_latency", {}).get("latency_s", 0)
    poses, seen = ["time_s,x_m,y_m,theta_rad"], ["time_s,landmark,range_m,bearing_rad"]
    for k in range(1500):
        t = 0.1 * k
        x, y, theta = pose(t)
        poses.append(f"{t:.3f},{x:.6f},{y:.6f},{theta:.6f}")
    for k in range(20, 1480):
        t = 0.1 * k + draw.uniform(0, 0.05)
        x, y, theta = pose(t + latency)
        which = draw.randrange(count)
        dx, dy = places[which][0] - x, places[which][1] - y
        bearing = math.remainder(math.atan2(dy, dx) - theta, 2 * math.pi)
        if abs(bearing) > widest:
            continue
        value = math.hypot(dx, dy)
        value *= math.cos(bearing) ** truth.get("range_depth", {}).get("k", 0)
        value = value * (1 + truth.get("range_scale", {}).get("scale", 0))
        value += truth.get("range_offset", {}).get("offset_m", 0) + draw.gauss(0, noise)
        if draw.random() < gross:
            value += draw.uniform(4, 15)
        seen.append(f"{t:.4f},{which}," + ("" if draw.random() < blank else f"{max(value, 0.01):.4f}") + ",")
    stated = f"noise: {{range_m: {noise:.4f}}}\n" if draw.random() < 0.5 else ""
    write_set(folder, {"poses.csv": poses, "seen.csv": seen,
                       "map.csv": ["landmark,x_m,y_m"] + [f"{i},{x:.4f},{y:.4f}" for i, (x, y) in enumerate(places)]},
              f"kind: landmarks\ntitle: made\n{stated}"
              "files: {landmarks: map.csv, poses: poses.csv, observations: seen.csv}\n", ["ideal_detector: {}"])
    return truth


# -- two wheels under a motion capture -----------------------------------------------------------------------------------

def wheels(_, sort, number, folder):
    draw = random.Random(f"{sort} {number}")
    truth = {}
    for name in draw.sample(("wheel_scale", "base_scale", "wheel_slip", "frame_latency"), draw.choice((1, 2, 2, 3))):
        truth[name] = {"wheel_scale": lambda: {"left": signed(draw, 0.004, 0.04), "right": signed(draw, 0.004, 0.04)},
                       "base_scale": lambda: {"scale": signed(draw, 0.01, 0.1)},
                       "wheel_slip": lambda: {"per_radps": draw.uniform(0.03, 0.15)},
                       "frame_latency": lambda: {"latency_s": signed(draw, 0.02, 0.12)}}[name]()
    # Encoders of few counts a turn: a count is rounded by more than poses are noisy.
    tick = math.exp(draw.uniform(math.log(5e-4), math.log(1e-2))) if sort == "coarse" else draw.choice((3e-5, 6e-5, 1e-4))
    base = draw.uniform(0.15, 0.5)
    left_scale, right_scale = (truth.get("wheel_scale", {}).get(side, 0) for side in ("left", "right"))
    true_base = base * (1 + truth.get("base_scale", {}).get("scale", 0))
    slip = truth.get("wheel_slip", {}).get("per_radps", 0)
    latency = truth.get("frame_latency", {}).get("latency_s", 0)
    sigma, turn_sigma = draw.uniform(0.0003, 0.002), draw.uniform(0.0005, 0.004)
    dt, fine = draw.choice((0.02, 0.05)), 0.002
    per_row = round(dt / fine)
    rows = ["run,time_s,left_ticks,right_ticks,x_m,y_m,theta_rad"]
    for run in range(draw.choice((5, 6, 9))):
        x = y = 0.0
        theta = draw.uniform(-3, 3)
        way = [(x, y, theta)]  # At each fine step.
        rolled, counted, counts = [0.0, 0.0], [0, 0], []
        v = omega = goal_v = goal_omega = 0.0
        steps = round(24 / fine)
        for step in range(steps + round(0.4 / fine)):
            if step % round(draw.uniform(1.2, 2) / fine) == 0:
                goal_v, goal_omega = draw.choice(((0.3, 0), (0.2, 0.6), (0.25, -0.5), (0, 1.0), (0, -1.0), (0.3, 0.3)))
            v += max(-fine, min(fine, goal_v - v))
            omega += max(-4 * fine, min(4 * fine, goal_omega - omega))
            if step % per_row == 0:
                now = [round(r / tick) for r in rolled]
                counts.append([a - b for a, b in zip(now, counted)])
                counted = now
            # What the encoders say, with the nominal base, and what the body makes of it.
            turned = (v - 0.5 * omega * base, v + 0.5 * omega * base)
            rolled = [r + fine * speed for r, speed in zip(rolled, turned)]
            ground = (turned[0] * (1 + left_scale), turned[1] * (1 + right_scale))
            turn = (ground[1] - ground[0]) / true_base
            forward = 0.5 * (ground[0] + ground[1]) * max(0, 1 - slip * abs(turn))
            x += fine * forward * math.cos(theta + 0.5 * fine * turn)
            y += fine * forward * math.sin(theta + 0.5 * fine * turn)
            theta += fine * turn
            way.append((x, y, theta))
        hidden_until = -1
        for k in range(round(24 / dt)):
            if draw.random() < 0.004:
                hidden_until = k + draw.randrange(3, 25)
            at = (k * dt + latency) / fine
            low = max(0, min(len(way) - 2, math.floor(at)))
            share = max(0.0, at - low)
            px, py, ptheta = (a + share * (b - a) for a, b in zip(way[low], way[low + 1]))
            pose = f"{px + draw.gauss(0, sigma):.6f},{py + draw.gauss(0, sigma):.6f}," \
                   f"{math.remainder(ptheta + draw.gauss(0, turn_sigma), 2 * math.pi):.6f}"
            rows.append(f"{run},{k * dt:.3f},{counts[k][0]},{counts[k][1]}," + (",," if k < hidden_until else pose))
    stated = (f"noise: {{x_m: {sigma:.6f}, y_m: {sigma:.6f}, theta_rad: {turn_sigma:.6f}}}\n"
              if draw.random() < 0.5 else "")
    write_set(folder, {"odometry.csv": rows},
              f"kind: odometry\ntitle: made\ngroup: run\n{stated}files: {{odometry: odometry.csv}}\n",
              [f"differential_drive: {{metres_per_tick: {tick}, base_m: {base:.9f}}}"])
    return truth


# -- a camera for science ------------------------------------------------------------------------------------------------

def png16(path, width, values):
    raw = b"".join(b"\0" + struct.pack(f">{width}H", *values[at:at + width]) for at in range(0, len(values), width))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    path.write_bytes(b"\x89PNG\r\n\x1a\n"
                     + chunk(b"IHDR", struct.pack(">IIBBBBB", width, len(values) // width, 16, 0, 0, 0, 0))
                     + chunk(b"IDAT", zlib.compress(raw)) + chunk(b"IEND", b""))


def electrons(draw, mean):
    if mean > 40:
        return mean + math.sqrt(mean) * draw.gauss(0, 1)
    count, product, limit = 0, draw.random(), math.exp(-max(mean, 0))
    while product > limit:
        count, product = count + 1, product * draw.random()
    return count


# Bits; electrons that fill the range; black level, in noises of a dark value or as a share of the range; levels; frames of
# a level and of the dark; whether the light is an exposure, with dark frames at each; light at the top over the range.
CAMERAS = {
    "camera": {"bits": (12, 14, 16), "black": None, "levels": (8, 11), "frames": (4, 6), "series": False, "most": 0.92},
    # Dark frames cut off at 0 by their own noise.
    "cut": {"bits": (12, 14, 16), "black": (0, 1.5), "levels": (8, 11), "frames": (4, 6), "series": False, "most": 0.92},
    # As EMVA 1288 asks for: pairs at growing exposures up to saturation, dark frames at the same.
    "series": {"bits": (8, 10, 12, 14, 16), "black": (2, 8), "levels": (12, 20), "frames": (2, 2), "series": True,
               "most": 1.15},
}


def noises_of_camera(sort, draw):
    """Bits a value, DN an electron, and the noises of a value in the dark and in the middle."""
    bits = draw.choice(CAMERAS[sort]["bits"])
    top = 2 ** bits - 1
    if sort == "series":
        gain = top / math.exp(draw.uniform(math.log(5000), math.log(60000)))
        read = draw.uniform(3, 15) * gain
    else:
        gain = math.exp(draw.uniform(math.log(0.05), math.log(2))) * {12: 1, 14: 2, 16: 4}[bits]
        read = draw.uniform(3, 10) * gain + 0.5
    # In the middle: less than this does not matter.
    return bits, gain, read, math.hypot(read, math.sqrt(0.5 * top * gain))


def effects_of_camera(sort, draw, top, gain, seen):
    truth = {"shot_noise": {"electrons_per_dn": 1 / gain}}
    possible = {
        "pixel_gain_spread": lambda: {"sigma": draw.uniform(0.005, 0.02)},
        "pixel_offset_spread": lambda: {"sigma_dn": seen * draw.uniform(0.6, 2)},
        "row_noise": lambda: {"sigma_dn": seen * draw.uniform(0.6, 1.5)},
        "response_cubic": lambda: {"k2": signed(draw, 0.03, 0.12), "k3": 0.0},
        "lamp_fluctuation": lambda: {"sigma": 2 * seen / top * draw.uniform(0.4, 1.5)},
        "periodic_pattern": lambda: {"amplitude_dn": seen * draw.uniform(0.3, 1.5), "period_px": draw.uniform(4, 20),
                                     "angle_rad": draw.uniform(-1.4, 1.4), "phase_rad": draw.uniform(-3, 3)}}
    for name in draw.sample(tuple(possible), draw.choice((1, 2, 3))):
        truth[name] = possible[name]()
    return truth


def levels_of_camera(sort, draw):
    """Of each frame: light as a share of the brightest, as exposure and illumination state it."""
    form = CAMERAS[sort]
    levels = draw.choice(form["levels"])
    lit, dark = form["frames"]
    shares = [(level + 1) / levels for level in range(levels)]
    if not form["series"]:
        return [(share, 0.01, share) for share in [0] * (dark // lit) + shares for _ in range(lit)] + [
            (0, 0.01, 0)] * (dark % lit)
    longest = 10 ** draw.uniform(-3, -1)
    return [(lamp * share, longest * share, lamp) for lamp in (1, 0) for share in shares for _ in range(lit)]


def camera(_, sort, number, folder):
    draw = random.Random(f"{sort} {number}")
    width, height = 56, 44
    bits, gain, read, seen = noises_of_camera(sort, draw)
    top = 2 ** bits - 1
    truth = effects_of_camera(sort, draw, top, gain, seen)
    cubic = truth.get("response_cubic", {"k2": 0, "k3": 0})
    row_sigma = truth.get("row_noise", {}).get("sigma_dn", 0)
    lamp_sigma = truth.get("lamp_fluctuation", {}).get("sigma", 0)
    offset_sigma = truth.get("pixel_offset_spread", {}).get("sigma_dn", 0)
    wave = truth.get("periodic_pattern")
    fixed_gain = [1 + truth.get("pixel_gain_spread", {}).get("sigma", 0) * draw.gauss(0, 1)
                  for _ in range(width * height)]
    fixed = [offset_sigma * draw.gauss(0, 1) for _ in fixed_gain]
    for i in range(len(fixed) if wave else 0):
        along = i % width * math.cos(wave["angle_rad"]) + i // width * math.sin(wave["angle_rad"])
        fixed[i] += wave["amplitude_dn"] * math.sin(2 * math.pi * along / wave["period_px"] + wave["phase_rad"])
    noise = math.hypot(read, row_sigma, offset_sigma)
    black = CAMERAS[sort]["black"]
    dark = draw.uniform(*black) * noise if black else max(draw.uniform(0.005, 0.03) * top, 5 * noise)
    unit = 10 ** draw.uniform(-4, 4)  # In which the lamp's light is stated.
    full = CAMERAS[sort]["most"] * (top - dark) / (1 + max(0, cubic["k2"]))
    (folder / "data" / "frames").mkdir(parents=True)
    lines = ["frame,file,time_s,exposure_s,illumination"]
    frames = levels_of_camera(sort, draw)
    for frame, (share, exposure_s, lamp) in enumerate(frames):
        light = share * full * (1 + lamp_sigma * draw.gauss(0, 1))  # DN.
        values = []
        for v in range(height):
            row = row_sigma * draw.gauss(0, 1) if row_sigma else 0
            for i in range(v * width, (v + 1) * width):
                signal = gain * electrons(draw, light * fixed_gain[i] / gain)
                s = signal / top
                dn = signal * (1 + cubic["k2"] * s + cubic["k3"] * s * s)
                dn += dark + fixed[i] + row + draw.gauss(0, read)
                values.append(max(0, min(top, round(dn))))
        png16(folder / "data" / "frames" / f"{frame:03}.png", width, values)
        lines.append(f"{frame},frames/{frame:03}.png,{0.5 * frame},{exposure_s:.6g},{lamp * unit:.6g}")
    (folder / "data" / "frames.csv").write_text("\n".join(lines) + "\n")
    # Twelve bits in files of 16, and nobody said so: the most that the camera gives is to be found.
    stated = draw.choice((bits, 16)) if sort == "series" else bits
    if stated != bits:
        truth["saturation"] = {"full_dn": top}
    (folder / "data" / "measurement.yaml").write_text(
        "format: seam-measurement/1\nkind: photometry\ntitle: made\n"
        f"camera: {{width_px: {width}, height_px: {height}, channels: grey, bits: {stated}}}\ngroup: frame\n"
        "files: {frames: frames.csv}\n")
    first = next((share, lamp) for share, _, lamp in frames)
    per_light = first[0] / first[1] if CAMERAS[sort]["series"] else 1
    (folder / "nominal.yaml").write_text(model([
        f"linear_response: {{gain_dn: {{value: {0.5 * top / unit * per_light:.6g}, free: true}}, "
        f"black_dn: {{value: {0.01 * top:.4g}, free: true}}}}",
        f"read_noise: {{sigma_dn: {{value: {2 * read:.3g}, free: true}}}}"]))
    # A bend is relative to the range that is stated.
    for power, name in enumerate(("k2", "k3"), 1):
        if "response_cubic" in truth:
            truth["response_cubic"][name] *= ((2 ** stated - 1) / top) ** power
    return truth


def deviations(truth, values):
    """In stated errors, of what both know; phases are whole turns apart from themselves."""
    return [(name, (math.remainder(value - true, 2 * math.pi) if name.endswith("phase_rad") else value - true) / sigma)
            for name, (value, sigma) in values.items() if sigma
            for true in [truth.get(name.split(".")[0], {}).get(name.split(".")[1])] if true is not None]


SORTS = {"beacons": beacons, "wheels": wheels, "coarse": wheels} | {sort: camera for sort in CAMERAS}


def make(binary, sort, number, folder):
    return SORTS[sort](binary, sort, number, folder)


if __name__ == "__main__":
    sys.exit(search_all(__doc__.splitlines()[0], SORTS, make, deviations))
