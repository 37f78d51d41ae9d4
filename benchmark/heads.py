"""A camera on a head that tilts and pans before known points (`heads`): each set hides one cause or none."""
import math

import numpy as np

import outside
from draws import Draw
from sets import Free, MadeSet, noise_line, rows

EFFECTS = ("mount_sag", "backlash", "exposure_stamp", "exposure")
WIDTH, HEIGHT, PERIOD_S = 320, 240, 0.04
FRAMES, SEEN_A_FRAME, LOG_S, LENGTH_S = 80, 30, 0.008, 10.4
# Above the floor, from the tilt joint up to the pan joint, and ahead from there, metres.
NECK_M, HEAD_M, NOSE_M = 0.2, 0.05, 0.07
CHAIN = f"""rig:
  chain:
    - {{translate_m: [0, 0, {NECK_M}]}}
    - {{joint: tilt, axis: [0, 1, 0]}}
    - {{translate_m: [0, 0, {HEAD_M}]}}
    - {{joint: pan, axis: [0, 0, 1]}}
    - {{translate_m: [{NOSE_M}, 0, 0]}}
"""


def draw_effect(draw, name, per_px):
    """`per_px`: radians in the middle of the image that are a pixel's noise."""
    return {"mount_sag": lambda: {"tilt_rad": draw.signed(0.6, 10) * per_px},
            "backlash": lambda: {"width_rad": draw.uniform(1, 12) * per_px, "tilt_width_rad": draw.uniform(1, 12) * per_px},
            "exposure_stamp": lambda: {"per_exposure": draw.choice((-0.5, 0.5))},
            "exposure": lambda: {"exposure_s": draw.log_uniform(0.0004, 0.006)}}[name]()


def swing(draw, middle, size):
    """An angle at any time: two waves."""
    waves = [(share * size, 2 * math.pi * draw.uniform(0.2, 0.7), draw.uniform(0, 6)) for share in (0.8, 0.25)]
    return lambda t: middle + sum(a * np.sin(w * t + p) for a, w, p in waves)


def behind_play(width, angles):
    """Of a load that a motor with play takes along."""
    load = np.array(angles)
    for k in range(1, len(load)):
        load[k] = min(max(load[k - 1], angles[k] - width / 2), angles[k] + width / 2)
    return load


def true_angles(effects, logged, times):
    """Tilt and pan of the camera at these times."""
    fine = np.arange(-0.2, times.max() + 0.1, 0.0005)
    play = effects.get("backlash", {"width_rad": 0, "tilt_width_rad": 0})
    tilt, pan = (np.interp(times, fine, behind_play(play[name], way(fine))) if play[name] else way(times)
                 for name, way in zip(("tilt_width_rad", "width_rad"), logged))
    return tilt + outside.of(effects, "mount_sag", "tilt_rad") * np.cos(tilt), pan


def before_camera(points, tilt, pan):
    """Points ahead of the camera, to its left and above it."""
    x, y, z = points[:, 0], points[:, 1], points[:, 2] - NECK_M
    x, z = x * np.cos(tilt) - z * np.sin(tilt), x * np.sin(tilt) + z * np.cos(tilt) - HEAD_M
    x, y = x * np.cos(pan) + y * np.sin(pan) - NOSE_M, y * np.cos(pan) - x * np.sin(pan)
    return x, y, z


def draw_room(draw, count=900):
    """Points all around, a metre or two away."""
    away, azimuth, height = draw.uniform(1, 2.5, size=count), draw.uniform(-3, 3, size=count), draw.uniform(-1, 1, size=count)
    level = np.sqrt(1 - height ** 2)
    points = away[:, None] * np.stack([level * np.cos(azimuth), level * np.sin(azimuth), height], -1)
    return np.round(points + (0, 0, NECK_M), 5)


def heads(plan):
    draw = Draw(plan.sort, plan.number)
    noise, stated = draw.uniform(0.08, 0.3), draw.chance(0.6)
    f = draw.uniform(0.8, 1.1) * WIDTH
    camera = {"fx_px": round(f, 2), "fy_px": round(f * draw.uniform(0.99, 1.01), 2), "cx_px": 159.5, "cy_px": 119.5}
    logged = swing(draw, draw.uniform(-0.3, 0.1), draw.uniform(0.5, 0.9)), swing(draw, 0, draw.uniform(0.5, 1.2))
    hidden = {name: draw_effect(draw, name, noise / f) for name in plan.names(draw, ())}
    points = draw_room(draw.of("room"))
    # Some light is dim: exposures differ five times, where the set tells them.
    tells = plan.cause == "exposure_stamp"
    exposures = draw.log_uniform(0.0002, 0.002) * 5 ** draw.of("light").uniform(size=FRAMES)
    exposures = np.round(exposures, 6)
    columns = [[] for _ in range(9)]
    for frame in range(FRAMES):
        one, stamp = draw.of(f"frame {frame}"), 3 * PERIOD_S * frame
        late = outside.of(hidden, "exposure_stamp", "per_exposure") * exposures[frame]
        late += 0.5 * outside.of(hidden, "exposure", "exposure_s")
        tilt, pan = (float(q[0]) for q in true_angles(hidden, logged, np.array([stamp + late])))
        x, y, z = before_camera(points, tilt, pan)
        ahead = np.where(x > 0.3, x, math.inf)
        u, v = camera["cx_px"] - camera["fx_px"] * y / ahead, camera["cy_px"] - camera["fy_px"] * z / ahead
        shown = np.flatnonzero((x > 0.3) & (u > 2) & (u < WIDTH - 3) & (v > 2) & (v < HEIGHT - 3))
        which = np.sort(np.array(one.sample(shown.tolist(), SEEN_A_FRAME)))
        at = np.stack([u, v], -1)[which] + one.normal(noise, size=(len(which), 2))
        for column, values in zip(columns, (np.full(len(which), frame), np.full(len(which), stamp), which, *points[which].T,
                                            *at.T, np.full(len(which), exposures[frame]))):
            column.extend(values.tolist())
    times = np.round(np.arange(-0.2, LENGTH_S, LOG_S), 4)
    tables = {"points.csv": rows("frame,time_s,point,x_m,y_m,z_m,u_px,v_px" + ",exposure_s" * tells,
                                 ("d", ".4f", "d", *[".5f"] * 3, *[".4f"] * 2, ".6f")[:8 + tells], *columns[:8 + tells]),
              "joints.csv": rows("time_s,tilt_rad,pan_rad", (".4f", ".7f", ".7f"), times, *(way(times) for way in logged))}
    settings = (f"camera: {{width_px: {WIDTH}, height_px: {HEIGHT}, frame_period_s: {PERIOD_S}}}\ngroup: frame\n"
                + noise_line(stated, u_px=noise, v_px=noise) + "files: {points: points.csv, joints: joints.csv}\n" + CHAIN)
    # Seen as its middle is, an exposure is a late clock.
    ties = {"exposure": ["frame_latency"]} if "exposure" in hidden else {}
    # In every second pair of sets nobody calibrated the camera.
    nominal, nuisance, free = {"pinhole": camera}, {}, plan.number % 4 < 2
    if free:
        start = draw.of("nominal")
        nominal = {"pinhole": {name: Free(value * math.exp(start.uniform(-0.05, 0.05))) for name, value in camera.items()}}
        nuisance = {"pinhole": {name: Free(value) for name, value in camera.items()}}
    return MadeSet(kind="points", settings=settings, tables=tables, nominal=nominal, nuisance=nuisance, hidden=hidden, ties=ties,
                   noise_stated=stated)
