#!/usr/bin/env python3
"""Cameras before boards whose lenses and targets are known: how often `seam discover` finds them.

    scripts/made_boards.py build/seam [--sort wide ...] [--sets 20] [--first 0] [--keep FOLDER]

The sets are computed here, by plain formulas and Python's random numbers, not by `seam measure`; each has an image
size, a lens, a target, views and a nominal model drawn by its number. Counts are those of made_servos.py.
"""
import math
import random
import sys

from made_robots import signed, write_set
from made_servos import search_all

SIZES = ((640, 480), (752, 480), (1280, 720), (1280, 960), (1920, 1080), (2448, 2048), (4000, 3000))


# -- rotations and poses -------------------------------------------------------------------------------------------------

def turn(axis, angle):
    length = math.hypot(*axis)
    x, y, z = (a / length for a in axis) if length else (1.0, 0.0, 0.0)
    c, s = math.cos(angle), math.sin(angle)
    return [[c + x * x * (1 - c), x * y * (1 - c) - z * s, x * z * (1 - c) + y * s],
            [y * x * (1 - c) + z * s, c + y * y * (1 - c), y * z * (1 - c) - x * s],
            [z * x * (1 - c) - y * s, z * y * (1 - c) + x * s, c + z * z * (1 - c)]]


def product(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def applied(rotation, shift, point):
    return [sum(row[k] * point[k] for k in range(3)) + s for row, s in zip(rotation, shift)]


# -- lenses --------------------------------------------------------------------------------------------------------------

def lens_radius(truth, r):
    """Of a ray at r = tan(angle), or at the angle itself before a fisheye."""
    if "fisheye" in truth:
        k = truth["fisheye"]
        return r * (1 + k["k1"] * r**2 + k["k2"] * r**4 + k["k3"] * r**6 + k["k4"] * r**8)
    if "rational_lens" in truth:
        k = truth["rational_lens"]
        return r * ((1 + k["k1"] * r**2 + k["k2"] * r**4 + k["k3"] * r**6)
                    / (1 + k["k4"] * r**2 + k["k5"] * r**4 + k["k6"] * r**6))
    k = truth.get("radial_polynomial", {"k1": 0, "k2": 0, "k3": 0})
    return r * (1 + k["k1"] * r**2 + k["k2"] * r**4 + k["k3"] * r**6)


def pixel(camera, truth, p):
    """Where a point in the camera's frame is seen; nothing where it is behind or beyond the lens's own field."""
    X, Y, Z = p
    across = math.hypot(X, Y)
    angle = math.atan2(across, Z)
    if angle > camera["widest"]:
        return None
    if "fisheye" in truth:
        far = lens_radius(truth, angle) / across if across > 1e-12 else 1
        x, y = X * far, Y * far
    else:
        x, y = X / Z, Y / Z
        r2 = x * x + y * y
        grown = lens_radius(truth, math.sqrt(r2)) / math.sqrt(r2) if r2 > 1e-24 else 1
        t = truth.get("tangential_distortion", {"p1": 0, "p2": 0})
        s = truth.get("thin_prism", {"s1": 0, "s2": 0, "s3": 0, "s4": 0})
        x, y = (x * grown + 2 * t["p1"] * x * y + t["p2"] * (r2 + 2 * x * x) + s["s1"] * r2 + s["s2"] * r2 * r2,
                y * grown + t["p1"] * (r2 + 2 * y * y) + 2 * t["p2"] * x * y + s["s3"] * r2 + s["s4"] * r2 * r2)
    return camera["fx_px"] * x + camera["cx_px"], camera["fy_px"] * y + camera["cy_px"]


def draw_camera(draw, size, half_angle):
    """A camera whose corners see this far from the axis, without a lens."""
    w, h = size
    f = 0.5 * math.hypot(w, h) / math.tan(half_angle)
    return {"size": size, "fx_px": f, "fy_px": f * draw.uniform(0.99, 1.01),
            "cx_px": (w - 1) / 2 + w * draw.uniform(-0.05, 0.05), "cy_px": (h - 1) / 2 + h * draw.uniform(-0.05, 0.05)}


def draw_lens(draw, family, size):
    """Camera and effects of a family, plain to see at the image's corners and one-to-one over the image."""
    truth = {}
    if family == "fisheye":
        truth["fisheye"] = {"k1": draw.uniform(-0.06, 0.03), "k2": draw.uniform(-0.01, 0.01), "k3": 0.0, "k4": 0.0}
        camera = draw_camera(draw, size, 0.8)
        reach = draw.uniform(1.2, 1.57)  # What is seen half-way up the longer side, from the axis.
        camera["fx_px"] = 0.5 * size[0] / lens_radius(truth, reach)
        camera["fy_px"] = camera["fx_px"] * draw.uniform(0.995, 1.005)
        camera["widest"] = 1.65
        return camera, truth
    camera = draw_camera(draw, size, draw.uniform(0.35, 0.75) if family != "rational" else draw.uniform(0.9, 1.05))
    camera["widest"] = 1.4
    r = 0.5 * math.hypot(*size) / camera["fx_px"]
    if family in ("radial", "tangential", "prism"):
        first = signed(draw, 0.02, 0.2)
        second = -first * draw.uniform(0, 0.4)
        truth["radial_polynomial"] = {"k1": first / r**2, "k2": second / r**4, "k3": 0.0}
    if family == "rational":
        # A wide lens between perspective and fisheye: tan(a / 2) or so for tan(a).
        truth["rational_lens"] = {"k1": 0.42 * draw.uniform(0.9, 1.1), "k2": 0.01 * draw.uniform(0, 1), "k3": 0.0,
                                  "k4": 0.72 * draw.uniform(0.95, 1.05), "k5": 0.055 * draw.uniform(0.5, 1.5), "k6": 0.0}
    if family in ("tangential", "rational"):
        truth["tangential_distortion"] = {"p1": signed(draw, 2e-4, 2e-3), "p2": signed(draw, 2e-4, 2e-3)}
    if family == "prism":
        truth["thin_prism"] = {"s1": signed(draw, 1e-3, 4e-3), "s2": 0.0, "s3": signed(draw, 1e-3, 4e-3), "s4": 0.0}
    fold = next((0.01 * k for k in range(1, 600)
                 if lens_radius(truth, 0.01 * (k + 1)) <= lens_radius(truth, 0.01 * k)), 6)
    camera["widest"] = min(camera["widest"], math.atan(0.9 * fold))
    return camera, truth


# -- targets -------------------------------------------------------------------------------------------------------------

def draw_plan(draw, kind):
    """Points of a board about the origin, metres, x right and y down."""
    pitch = draw.choice((0.01, 0.025, 0.03, 0.06))
    columns, lines = draw.choice(((8, 6), (9, 7), (11, 8), (14, 10), (20, 14)))
    if kind == "circles":
        points = [((2 * i + j % 2) * 0.5 * pitch, 0.5 * j * pitch) for j in range(2 * lines - 3) for i in range(columns)]
    elif kind == "tags":
        side, step = pitch, 1.3 * pitch
        points = [(i * step + a * side, j * step + b * side) for j in range(lines // 2) for i in range(columns // 2)
                  for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
    else:
        points = [(i * pitch, j * pitch) for j in range(lines) for i in range(columns)]
    middle = [0.5 * (min(p[k] for p in points) + max(p[k] for p in points)) for k in (0, 1)]
    return [(x - middle[0], y - middle[1], 0.0) for x, y in points]


def draw_target(draw, plan, names):
    """The points as they truly are, and the effects of it."""
    truth = {}
    extent = [max(abs(p[k]) for p in plan) for k in (0, 1)]
    for name in names:
        truth[name] = {"board_warp": lambda: {"x_m": signed(draw, 0.002, 0.008) * extent[0],
                                              "y_m": signed(draw, 0.002, 0.008) * extent[1]},
                       "board_scale": lambda: {"x_scale": signed(draw, 0.001, 0.005), "y_scale": 0.0,
                                               "shear": signed(draw, 0.001, 0.005)},
                       "target_scatter": lambda: {"sigma_m": draw.uniform(5e-4, 1.5e-3) * max(extent)}}[name]()
    warp = truth.get("board_warp", {"x_m": 0, "y_m": 0})
    scale = truth.get("board_scale", {"x_scale": 0, "shear": 0})
    sigma = truth.get("target_scatter", {"sigma_m": 0})["sigma_m"]
    there = []
    for x, y, z in plan:
        a, b = x / extent[0], y / extent[1]
        there.append(tuple(at + sigma * draw.gauss(0, 1) for at in (
            x * (1 + scale["x_scale"]) + scale["shear"] * y, y,
            z + warp["x_m"] * (1 - a * a) + warp["y_m"] * (1 - b * b))))
    return there, truth


# -- views ---------------------------------------------------------------------------------------------------------------

def aimed(draw, camera, truth, extent, tilt, fills):
    """A pose of the board: at a drawn place of the image, tilted, filling so much of it."""
    w, h = camera["size"]
    for _ in range(200):
        angle, azimuth = camera["widest"] * 0.75 * math.sqrt(draw.random()), draw.uniform(-math.pi, math.pi)
        across = math.sin(angle)
        ray = [across * math.cos(azimuth), across * math.sin(azimuth), math.cos(angle)]
        seen = pixel(camera, truth, ray)
        if seen and 0.15 * w < seen[0] < 0.85 * w and 0.15 * h < seen[1] < 0.85 * h:
            break
    distance = 2 * extent * camera["fx_px"] / (fills * w)
    # Faces the camera where it is aside, as a hand holds it before a wide lens.
    facing = turn([-ray[1], ray[0], 0], angle) if camera["widest"] > 1.45 else turn([1, 0, 0], 0)
    way = draw.uniform(-math.pi, math.pi)
    rotation = product(facing, product(turn([math.cos(way), math.sin(way), 0], tilt * math.sqrt(draw.random())),
                                       turn([0, 0, 1], draw.choice((0, 0, 1)) * draw.uniform(-math.pi, math.pi)
                                            + draw.gauss(0, 0.1))))
    return rotation, [distance * r for r in ray]


HEADER = "frame,time_s,point,x_m,y_m,z_m,u_px,v_px"


def seen_rows(draw, camera, truth, plan, there, pose, noise, missing=0.0):
    """(point, u, v) of the points that fall into the image."""
    w, h = camera["size"]
    rows = []
    for number, point in enumerate(there):
        at = pixel(camera, truth, applied(*pose, point))
        if at and 0 <= at[0] < w - 1 and 0 <= at[1] < h - 1 and draw.random() >= missing:
            rows.append((number, at[0] + draw.gauss(0, noise), at[1] + draw.gauss(0, noise)))
    return rows


def line(frame, time, plan, row, extra=""):
    number, u, v = row
    x, y, z = plan[number]
    return f"{frame},{time:.4f},{number},{x:.6f},{y:.6f},{z:.6f},{u:.4f},{v:.4f}{extra}"


def nominal_pinhole(draw, camera, off):
    w, h = camera["size"]
    f = camera["fx_px"] * math.exp(draw.uniform(-1, 1) * math.log(off))
    return "{" + ", ".join(f"{name}: {{value: {value:.6g}, free: true}}" for name, value in (
        ("fx_px", f), ("fy_px", f), ("cx_px", (w - 1) / 2), ("cy_px", (h - 1) / 2))) + "}"


def points_yaml(camera, noise, rig, draw):
    stated = f"noise: {{u_px: {noise:.4f}, v_px: {noise:.4f}}}\n" if draw.random() < 0.5 else ""
    return (f"kind: points\ntitle: made\ncamera: {{width_px: {camera['size'][0]}, height_px: {camera['size'][1]}, "
            f"frame_period_s: 0.04}}\n{stated}group: frame\nfiles: {{points: points.csv}}\nrig: {rig}\n")


FEWEST = 12  # Points of a view that is kept.


def still(families, target_choice, views_choice, tilt=0.7, plan_of=None, missing=0.0, off=2.0):
    def make_set(_, sort, number, folder):
        draw = random.Random(f"{sort} {number}")
        size = draw.choice(SIZES)
        camera, truth = draw_lens(draw, draw.choice(families), size)
        plan = plan_of(draw) if plan_of else draw_plan(draw, draw.choice(("chess", "circles", "tags")))
        there, target = draw_target(draw, plan, draw.choice(target_choice))
        truth.update(target)
        extent = max(abs(p[0]) for p in plan)
        noise = math.exp(draw.uniform(math.log(0.04), math.log(0.3))) * (size[0] / 1280) ** 0.3
        rows = [HEADER]
        views = draw.choice(views_choice)
        frame = 0
        while frame < views:
            pose = aimed(draw, camera, truth, extent, tilt, draw.uniform(0.35, 0.9))
            seen = seen_rows(draw, camera, truth, plan, there, pose, noise, missing)
            if len(seen) >= FEWEST + 0.3 * (1 - missing) * len(plan):
                rows += [line(frame, frame, plan, row) for row in seen]
                frame += 1
        write_set(folder, {"points.csv": rows}, points_yaml(camera, noise, "{pose: unknown}", draw),
                  ["pinhole: " + nominal_pinhole(draw, camera, off)])
        truth["pinhole"] = {k: camera[k] for k in ("fx_px", "fy_px", "cx_px", "cy_px")}
        return truth
    return make_set


def corner_of_boards(draw):
    """Two or three boards that stand on each other, as in a box's corner."""
    board = draw_plan(draw, "chess")
    reach = [max(abs(p[k]) for p in board) for k in (0, 1)]
    points = [(x, y, 0.0) for x, y, _ in board]
    points += [(reach[0] * 1.2, y, -(x + reach[0] * 1.2)) for x, y, _ in board]
    if draw.random() < 0.5:
        points += [(x, reach[1] * 1.2, -(y + reach[1] * 1.2)) for x, y, _ in board]
    return [(x - 0.5 * reach[0], y, z + 0.5 * reach[0]) for x, y, z in points]


def rough_board(draw):
    """Known heights of a millimetre or so out of the plane."""
    return [(x, y, draw.gauss(0, 0.001)) for x, y, _ in draw_plan(draw, "chess")]


# -- a camera in the hand ------------------------------------------------------------------------------------------------

def wave(draw, size, slow, fast):
    parts = [(size * draw.uniform(0.3, 1), draw.uniform(slow, fast), draw.uniform(0, 6)) for _ in range(3)]
    return lambda t: sum(a * math.sin(w * t + p) for a, w, p in parts)


def video(_, sort, number, folder, target_choice=()):
    draw = random.Random(f"{sort} {number}")
    of_target = random.Random(f"{sort} {number} target")
    size = draw.choice(SIZES[:5])
    family = draw.choice(("none", "none", "radial"))
    camera, truth = draw_lens(draw, family, size)
    plan = draw_plan(draw, draw.choice(("chess", "tags")))
    there = plan
    if target_choice:
        there, target = draw_target(of_target, plan, of_target.choice(target_choice))
        truth.update(target)
    extent = max(abs(p[0]) for p in plan)
    noise = math.exp(draw.uniform(math.log(0.08), math.log(0.3))) * (size[0] / 1280) ** 0.3
    period = draw.choice((1 / 25, 1 / 30, 1 / 60))
    delay = draw.choice((0, draw.choice((-1, 1)) * draw.uniform(0.3, 0.95) * period / size[1]))
    if delay:
        truth["rolling_shutter"] = {"line_delay_s": delay}
    distance = 2 * extent * camera["fx_px"] / (draw.uniform(0.4, 0.6) * size[0])
    angles = [wave(draw, a, 2, 5) for a in (0.2, 0.2, 0.15)]
    places = [wave(draw, 0.07 * distance, 1.5, 4) for _ in range(3)]

    def pose(t):
        rotation = turn([1, 0, 0], angles[0](t))
        rotation = product(turn([0, 1, 0], angles[1](t)), product(turn([0, 0, 1], angles[2](t)), rotation))
        return rotation, [places[0](t), places[1](t), distance + places[2](t)]
    rows, frame, skip = [HEADER], 0, 0
    gap_share = draw.choice((0, 0, 0.04))
    for k in range(draw.choice((40, 60, 120))):
        if skip or draw.random() < gap_share:
            skip = skip - 1 if skip else draw.choice((1, 4, 12))
            continue
        time = k * period
        seen = []
        for which, point in enumerate(there):
            at, v = None, 0.5 * size[1]
            for _ in range(8):
                at = pixel(camera, truth, applied(*pose(time + delay * v), point))
                if not at:
                    break
                v = at[1]
            if at and 0 <= at[0] < size[0] - 1 and 0 <= at[1] < size[1] - 1:
                seen.append((which, at[0] + draw.gauss(0, noise), at[1] + draw.gauss(0, noise)))
        if len(seen) >= FEWEST:
            rows += [line(k, time, plan, row) for row in seen]
    write_set(folder, {"points.csv": rows}, points_yaml(camera, noise, "{pose: unknown, motion: spline}", draw),
              ["pinhole: " + nominal_pinhole(draw, camera, 1.3)])
    truth["pinhole"] = {k: camera[k] for k in ("fx_px", "fy_px", "cx_px", "cy_px")}
    return truth


# -- cameras on one rig --------------------------------------------------------------------------------------------------

def rig(_, sort, number, folder):
    draw = random.Random(f"{sort} {number}")
    size = draw.choice(SIZES[:5])
    names = ["left", "right", "third"][:draw.choice((2, 2, 3))]
    cameras, lenses = [], []
    for _ in names:
        camera, lens = draw_lens(draw, draw.choice(("none", "radial")), size)
        cameras.append(camera)
        lenses.append(lens)
    plan = draw_plan(draw, draw.choice(("chess", "tags")))
    there, target = draw_target(draw, plan, draw.choice(((), ("board_warp",))))
    extent = max(abs(p[0]) for p in plan)
    noise = draw.uniform(0.08, 0.25)
    reach = 2 * extent * cameras[0]["fx_px"] / (0.5 * size[0])
    shifts = [[0.0, 0.0, 0.0]] + [[0.15 * reach * (k + 1) * draw.choice((-1, 1)), draw.gauss(0, 0.02 * reach),
                                   draw.gauss(0, 0.02 * reach)] for k in range(len(names) - 1)]
    turns = [turn([1, 0, 0], 0)] + [turn([draw.gauss(0, 1) for _ in range(3)], 0.08) for _ in names[1:]]
    rows, frame, wanted = [HEADER + ",camera"], 0, draw.choice((8, 15, 25))
    while frame < wanted:
        pose = aimed(draw, cameras[0], lenses[0], extent, 0.7, draw.uniform(0.35, 0.7))
        shots = []
        for camera, lens, shift, rotation in zip(cameras, lenses, shifts, turns):
            # p_first = R p_camera + shift, so p_camera = R' (p_first - shift).
            back = [list(column) for column in zip(*rotation)]
            moved = applied(back, [0, 0, 0], [a - b for a, b in zip(pose[1], shift)])
            shots.append(seen_rows(draw, camera, lens, plan, there, (product(back, pose[0]), moved), noise))
        if sum(len(shot) >= FEWEST for shot in shots) >= (1 if draw.random() < 0.15 else 2):
            for name, shot in zip(names, shots):
                if len(shot) >= FEWEST:
                    rows += [line(frame, frame, plan, row, f",{name}") for row in shot]
            frame += 1
    effects = [f"pinhole@{name}: {nominal_pinhole(draw, camera, 1.3)}" for name, camera in zip(names, cameras)]
    zero = ", ".join(f"{k}: {{value: 0, free: true}}" for k in ("x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad"))
    effects += [f"camera_pose@{name}: {{{zero}}}" for name in names[1:]]
    write_set(folder, {"points.csv": rows}, points_yaml(cameras[0], noise, "{pose: unknown}", draw), effects)
    truth = dict(target)
    for name, camera, lens in zip(names, cameras, lenses):
        truth.update({f"{effect}@{name}": values for effect, values in lens.items()})
        truth[f"pinhole@{name}"] = {k: camera[k] for k in ("fx_px", "fy_px", "cx_px", "cy_px")}
    return truth


def deviations(truth, values):
    """In stated errors, of what both know."""
    return [(name, (value - true) / sigma)
            for name, (value, sigma) in values.items() if sigma
            for true in [truth.get(name.split(".")[0], {}).get(name.split(".")[1])] if true is not None]


FLAT, BENT = ((),), ((), ("board_warp",), ("board_scale",), ("target_scatter",), ("board_warp", "target_scatter"))
SORTS = {
    "plain": still(("none", "radial", "tangential"), BENT, (15, 25, 40)),
    "prism": still(("prism", "tangential"), FLAT, (25, 40)),
    "rational": still(("rational",), BENT, (25, 40)),
    "wide": still(("fisheye",), BENT, (15, 25, 40)),
    "few": still(("none", "radial"), FLAT, (1, 2, 3, 5)),
    "many": still(("radial", "fisheye"), BENT, (100, 200)),
    "frontal": still(("none", "radial"), FLAT, (10, 20), tilt=0.0),
    "facing": still(("none", "radial"), FLAT, (1, 1), tilt=0.0),
    "hidden": still(("radial", "tangential"), BENT, (20,), missing=0.4),
    "corner": still(("none", "radial", "fisheye"), FLAT, (10, 20), plan_of=corner_of_boards),
    "rough": still(("none", "radial"), FLAT, (10, 20), plan_of=rough_board),
    "video": video,
    "printed": lambda *given: video(*given, target_choice=BENT[1:]),
    "rig": rig,
}


def make(binary, sort, number, folder):
    truth = SORTS[sort](binary, sort, number, folder)
    # No step, but part of every model.
    return {name: values for name, values in truth.items() if not name.startswith("pinhole")}


if __name__ == "__main__":
    sys.exit(search_all(__doc__.splitlines()[0], SORTS, make, deviations))
