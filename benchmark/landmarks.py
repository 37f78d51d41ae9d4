"""Ranges and bearings of known landmarks from a robot whose pose is measured by other means (`landmarks`)."""
import math

import numpy as np

import outside
from draws import Draw
from sets import MadeSet, TRACE_SIZE, noise_line, rows

POSSIBLE = ("range_scale", "range_offset", "bearing_scale", "frame_latency", "mount_misalignment", "mount_offset",
            "bearing_offset_per_range", "range_wander", "landmark_scatter")
# Of one line only one at a time: they answer alike on most ways.
ALIKE = (("frame_latency", "mount_offset"),)
STRANGE = ("rotating mirror", "warming")
POSE_S = 0.05


def wrapped(angle):
    return (angle + math.pi) % (2 * math.pi) - math.pi


def smooth_way(draw):
    """Place and heading at any time, of a body that goes where it looks."""
    waves = [(draw.uniform(0.8, 2), draw.uniform(0.15, 0.45), draw.uniform(0, 6)) for _ in range(4)]

    def way(t):
        x = sum(a * np.sin(w * t + p) for a, w, p in waves[:2])
        y = sum(a * np.cos(w * t + p) for a, w, p in waves[2:])
        vx = sum(a * w * np.cos(w * t + p) for a, w, p in waves[:2])
        vy = sum(-a * w * np.sin(w * t + p) for a, w, p in waves[2:])
        return x, y, np.unwrap(np.arctan2(vy, vx))
    return way


def straight_way(draw, speed):
    """A line at one speed: a late clock and a shifted sensor answer alike."""
    heading, x0, y0 = draw.uniform(-3, 3), draw.uniform(-1, 1), draw.uniform(-1, 1)

    def way(t):
        along = speed * (t - 6)
        return x0 + along * math.cos(heading), y0 + along * math.sin(heading), np.full(np.shape(t), heading)
    return way


def draw_effect(draw, name, noise):
    return {"range_scale": lambda: {"scale": draw.signed(0.01, 0.06)},
            "range_offset": lambda: {"offset_m": draw.signed(1, 4) * noise["range_m"]},
            "bearing_scale": lambda: {"scale": draw.signed(0.015, 0.06)},
            "frame_latency": lambda: {"latency_s": draw.signed(0.03, 0.12)},
            "mount_misalignment": lambda: {"yaw_rad": draw.signed(1, 5) * noise["bearing_rad"]},
            "mount_offset": lambda: {name: draw.signed(1, 4) * noise["range_m"] for name in ("x_m", "y_m")},
            "bearing_offset_per_range": lambda: {"rad_per_m": draw.signed(0.5, 2) * noise["bearing_rad"]},
            "range_wander": lambda: {"sigma_m": draw.uniform(1, 3) * noise["range_m"], "tau_s": draw.uniform(0.5, 3)},
            "landmark_scatter": lambda: {"sigma_m": draw.uniform(1, 3) * noise["range_m"]},
            "landmark_delay": lambda: {"sigma_m": draw.uniform(1, 3) * noise["range_m"]},
            # At two metres a range is longer by half to five times the noise.
            "landmark_height": lambda: {"z_m": math.sqrt(4 * draw.uniform(0.5, 5) * noise["range_m"])},
            "wall_excess": lambda: {"size_m": draw.uniform(3, 10) * noise["range_m"],
                                    "direction_rad": draw.choice((0, math.pi / 2, draw.uniform(0, math.pi / 2))),
                                    "at_m": draw.signed(0.6, 1.6), "reach_m": draw.uniform(0.25, 0.8)},
            "rotating mirror": lambda: {"m": draw.uniform(1.5, 4) * noise["range_m"], "a_turn": draw.choice((2, 3)),
                                        "phase_rad": draw.uniform(-3, 3)},
            "warming": lambda: {"m": draw.signed(3, 8) * noise["range_m"], "time_s": draw.uniform(10, 25)}}.get(
                name, lambda: outside.draw_of_detector(draw, name, noise))()


def speed_at(way, times):
    """By differences over a tenth of a second."""
    (xa, ya, _), (xb, yb, _) = way(times - 0.05), way(times + 0.05)
    return np.hypot(xb - xa, yb - ya) / 0.1


def excess_at(wall, x, y):
    """A bump of ranges over the distance to a wall."""
    away = (np.cos(wall["direction_rad"]) * x + np.sin(wall["direction_rad"]) * y - wall["at_m"]) / wall["reach_m"]
    return wall["size_m"] * np.exp(-away ** 2 / 2)


def observed(effects, way, times, which, places, heights, delays):
    """Range and bearing without single errors, of landmarks at these places and heights, with these delays in metres."""
    x, y, theta = way(times + effects.get("frame_latency", {}).get("latency_s", 0))
    shift = effects.get("mount_offset", {"x_m": 0, "y_m": 0})
    px, py = places[which].T
    dx = px - x - shift["x_m"] * np.cos(theta) + shift["y_m"] * np.sin(theta)
    dy = py - y - shift["x_m"] * np.sin(theta) - shift["y_m"] * np.cos(theta)
    distance = np.hypot(dx, dy)
    bearing = wrapped(np.arctan2(dy, dx) - theta - effects.get("mount_misalignment", {}).get("yaw_rad", 0))
    distance = np.hypot(distance, heights[which] + outside.of(effects, "landmark_height", "z_m"))
    seen = distance * (1 + effects.get("range_scale", {}).get("scale", 0)) + delays[which]
    seen = seen + effects.get("range_offset", {}).get("offset_m", 0)
    if "wall_excess" in effects:
        seen = seen + excess_at(effects["wall_excess"], x, y)
    mirror, warming = effects.get("rotating mirror"), effects.get("warming")
    if mirror:
        seen = seen + mirror["m"] * np.sin(mirror["a_turn"] * bearing + mirror["phase_rad"])
    if warming:
        seen = seen + warming["m"] * (1 - np.exp(-times / warming["time_s"]))
    said = bearing * (1 + effects.get("bearing_scale", {}).get("scale", 0))
    said = said + effects.get("bearing_offset_per_range", {}).get("rad_per_m", 0) * distance
    longer, aside = outside.seen_beside(effects, distance, bearing, speed_at(way, times), times, which)
    return seen + longer, said + aside, bearing


def draw_names(plan, draw):
    if plan.course == "tie":
        return ["frame_latency"]
    possible = POSSIBLE if plan.course not in ("trace", "gross") else POSSIBLE[:7]
    names = plan.names(draw, possible)
    if plan.cause:
        return names
    for alike in ALIKE:
        names = [name for name in names if name not in alike[1:] or alike[0] not in names]
    return names + draw.sample([name for name in possible if name not in names and not any(
        name in alike for alike in ALIKE)], plan.count - len(names))


def landmarks(plan):
    draw = Draw(plan.sort, plan.number)
    noise = {"range_m": draw.uniform(0.01, 0.04), "bearing_rad": draw.uniform(0.003, 0.012)}
    runs, length_s, speed = 6, 12.0, draw.uniform(0.5, 0.8)
    places = np.stack([draw.uniform(-5, 5, size=8), draw.uniform(-5, 5, size=8)], -1)
    names = draw_names(plan, draw)
    hidden = {name: draw_effect(draw, name, noise) for name in names}
    if plan.course == "tie":
        hidden = {"frame_latency": {"latency_s": draw.signed(0.04, 0.15)}}
    strange = plan.strange(STRANGE)
    traces = {"range_offset": {"offset_m": TRACE_SIZE * noise["range_m"]}} if plan.course == "trace" else {}
    if traces and "range_offset" in hidden:
        traces = {"mount_misalignment": {"yaw_rad": TRACE_SIZE * noise["bearing_rad"]}}
    effects = hidden | traces | ({strange: draw_effect(draw, strange, noise)} if strange else {})
    there = places
    if "landmark_scatter" in effects:
        there = places + draw.of("scatter").normal(effects["landmark_scatter"]["sigma_m"], size=places.shape)
    delays = draw.of("delays").normal(outside.of(effects, "landmark_delay", "sigma_m"), size=len(places))
    # A map with heights, in every second pair of sets: the robot's tag may then also be higher than it says.
    tall = plan.cause == "landmark_height" and plan.number % 4 >= 2
    heights = draw.of("heights").uniform(0.3, 1.5, size=len(places)) if tall else np.zeros(len(places))
    if tall and "landmark_height" in hidden:
        hidden["landmark_height"]["z_m"] *= draw.of("up").choice((-0.5, 0.5))
    stated = draw.chance(0.6) or "range_wander" in effects
    seen_rows, pose_rows = [[] for _ in range(5)], [[] for _ in range(5)]
    for run in range(runs):
        one = draw.of(f"run {run}")
        way = straight_way(one, speed) if plan.course == "tie" else smooth_way(one)
        at = np.round(np.arange(-1.0, length_s + 1, POSE_S), 4)
        for column, values in zip(pose_rows, ([run] * len(at), at, *way(at))):
            column.extend(np.asarray(values).tolist())
        times = np.round(np.sort(one.uniform(0, length_s, size=130)), 4)
        times = np.unique(times)
        which = np.floor(one.uniform(0, 8, size=len(times))).astype(int)
        ranges, bearings, true = observed(effects, way, times, which, there, heights, delays)
        if "range_wander" in effects:
            ranges = ranges + one.wander(times, effects["range_wander"]["sigma_m"], effects["range_wander"]["tau_s"])
        ranges = ranges + one.normal(noise["range_m"], size=len(times))
        bearings = wrapped(bearings + one.normal(noise["bearing_rad"], size=len(times)))
        ranges = np.where(one.uniform(size=len(times)) < plan.gross, one.uniform(0.3, 9, size=len(times)), ranges)
        keep = (np.abs(true) < 1.9) & (ranges > 0.1)
        for column, values in zip(seen_rows, (np.full(len(times), run), times, which, ranges, bearings)):
            column.extend(values[keep].tolist())
    tables = {"observations.csv": rows("run,time_s,landmark,range_m,bearing_rad", ("d", ".4f", "d", ".6f", ".7f"),
                                       *seen_rows),
              "poses.csv": rows("run,time_s,x_m,y_m,theta_rad", ("d", ".3f", ".6f", ".6f", ".7f"), *pose_rows),
              "map.csv": rows("landmark,x_m,y_m" + ",z_m" * tall, ("d", *[".6f"] * 3), range(8), *places.T.tolist(),
                              *[heights.tolist()] * tall)}
    settings = ("group: run\n" + noise_line(stated, **noise)
                + "files: {landmarks: map.csv, poses: poses.csv, observations: observations.csv}\n")
    ties = {"frame_latency": ["mount_offset"]} if plan.course == "tie" else {}
    return MadeSet(kind="landmarks", settings=settings, tables=tables, nominal={"ideal_detector": {}}, hidden=hidden,
                   traces=traces, ties=ties, outside=strange, noise_stated=stated,
                   allowed=["range_tail"] if plan.gross else [])
