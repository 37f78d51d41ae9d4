"""Causes that no catalogue has: how large each is, what it does, and what residuals depend on because of it.

A sort with such a cause (`servos+floor_shakes`) hides it alone in each of its numbers. Names of causes have blanks, those of
sorts underscores. Every cause has a formula of its own here or in its sort's generator.
"""
import math

import numpy as np

IMAGE = ("column", "row", "radius", "view")
BOARD = ("target x", "target y", "target z")
ANGLE = ("joint", "command_rad")
MOTION = (*ANGLE, "command_rate", "joint_rate", "joint_acceleration", "sign(joint_rate)")
PIXELS = ("row", "column", "radius", "neighbouring_pixel", "pixel")

# Of each sort its causes, and on what residuals depend: any of these names is right.
DEPENDS_ON = {
    "boards": {"glass": IMAGE, "twisted board": BOARD, "pixel phase": (*IMAGE, "column phase", "row phase"), "moire": IMAGE,
               "tiled sensor": IMAGE, "creeping centre": ("time", "view"), "windscreen": IMAGE, "odd lens": IMAGE, "rippled paper": BOARD,
               "folded board": BOARD},
    "videos": {"twisted board": BOARD, "glass": IMAGE, "hunting focus": ("time", "view")},
    "servos": {"slow drift": ("time",), "potentiometer": ("command_rad",), "floor shakes": ("time",),
               "one sided gain": ANGLE, "creep": (*MOTION, "time"), "warm mount": ("temperature_c", "time"),
               "coarse clock": (*MOTION[2:], "time")},
    "motors": {"rubber stop": ANGLE, "warming motor": ("time",), "air drag": MOTION[2:], "cable": ANGLE,
               "stiff spot": MOTION},
    "landmarks": {"rotating mirror": ("bearing",), "warming": ("time",), "multipath": ("range",), "near field": ("range",),
                  "edge of lens": ("bearing",), "leaning body": ("speed",), "beacon clocks": ("time", "landmark")},
    "walks": {"crab walk": ("vx_cmd_mps",), "tiring": ("time",), "slope": ("heading",), "compass": ("heading",),
              "slippery speed": ("vx_cmd_mps",), "stiff start": ("time",)},
    "wheels": {"oval wheel": ("distance",), "slope": ("heading",), "warm tyres": ("time", "distance"),
               "carpet": ("x_moved", "y_moved"), "compass": ("heading",)},
    "flats": {"dust ring": PIXELS, "image lag": ("time", "illumination"), "dew": (*PIXELS, "time"), "Newton rings": PIXELS,
              "light leak": (*PIXELS, "exposure_s"), "fading lamp": ("time",)},
}


def cause_of(sort):
    """The cause that a sort such as `servos+floor_shakes` names, or nothing."""
    base, _, cause = sort.partition("+")
    name = cause.replace("_", " ")
    return name if name in DEPENDS_ON.get(base, ()) else ""


def sorts():
    return [f"{base}+{cause.replace(' ', '_')}" for base, causes in DEPENDS_ON.items() for cause in causes]


def of(effects, cause, parameter, absent=0.0):
    return effects.get(cause, {}).get(parameter, absent)


# -- cameras ----------------------------------------------------------------------------------------------------------

def draw_of_camera(draw, cause, extent, corner):
    """`extent`: half the board's width in metres; `corner`: the tangent of the image's half angle."""
    return {"moire": lambda: {"px": draw.uniform(0.2, 0.5), "period_px": draw.uniform(60, 200)},
            "tiled sensor": lambda: {"px": draw.signed(0.3, 0.8)},
            "creeping centre": lambda: {"u_px_per_s": draw.signed(0.05, 0.15), "v_px_per_s": draw.signed(0.05, 0.15)},
            "windscreen": lambda: {"a": draw.signed(0.01, 0.03) / corner ** 2},
            "odd lens": lambda: {"px": draw.uniform(0.4, 1.6), "waves": [
                {"way_rad": draw.uniform(-math.pi, math.pi), "per_width": draw.uniform(0.4, 1.2),
                 "phase_rad": draw.uniform(-math.pi, math.pi), "to_rad": draw.uniform(-math.pi, math.pi)} for _ in range(4)]},
            "rippled paper": lambda: {"m": draw.uniform(0.004, 0.01) * extent, "period_m": extent * draw.uniform(0.5, 0.9)},
            "folded board": lambda: {"m": draw.signed(0.01, 0.03) * extent},
            "hunting focus": lambda: {"share": draw.uniform(0.002, 0.006), "hz": draw.uniform(0.7, 2)}}[cause]()


def through_odd_lens(effects, width, u, v):
    """Moulded, and not quite what its drawing says: smooth waves over the image, in no direction's favour."""
    x, y = u / width, v / width
    for wave in of(effects, "odd lens", "waves", ()):
        along = x * math.cos(wave["way_rad"]) + y * math.sin(wave["way_rad"])
        moved = of(effects, "odd lens", "px") * np.sin(2 * math.pi * wave["per_width"] * along + wave["phase_rad"])
        u, v = u + moved * math.cos(wave["to_rad"]), v + moved * math.sin(wave["to_rad"])
    return u, v


def in_image(effects, camera, u, v):
    """What acts on pixels: a beat of the sensor with the target, two halves of a sensor, a mount that warms up."""
    u, v = through_odd_lens(effects, camera["size"][0], u, v)
    size, period = of(effects, "moire", "px"), of(effects, "moire", "period_px", 1.0)
    u, v = u + size * np.sin(2 * math.pi * u / period), v + size * np.sin(2 * math.pi * v / period)
    u = u + of(effects, "tiled sensor", "px") * (u > 0.5 * camera["size"][0])
    t = camera.get("t", 0.0)
    return (u + of(effects, "creeping centre", "u_px_per_s") * t, v + of(effects, "creeping centre", "v_px_per_s") * t)


def out_of_plane(effects, x, y):
    """A glued sheet with waves, and a board with a fold along its middle."""
    waves = of(effects, "rippled paper", "m") * np.sin(2 * math.pi * x / of(effects, "rippled paper", "period_m", 1.0))
    return waves + of(effects, "folded board", "m") * np.abs(x) / np.max(np.abs(x))


# -- servos -----------------------------------------------------------------------------------------------------------

def draw_of_servo(draw, cause, noise):
    return {"potentiometer": lambda: {"a": draw.signed(4, 12) * noise},
            "floor shakes": lambda: {"rad": draw.uniform(2, 5) * noise, "hz": draw.uniform(1, 6),
                                     "phase_rad": draw.uniform(-3, 3)},
            "one sided gain": lambda: {"share": draw.signed(6, 20) * noise},
            "creep": lambda: {"share": draw.uniform(0.006, 0.02), "tau_s": draw.uniform(0.3, 0.8)},
            "warm mount": lambda: {"rad_per_k": draw.signed(0.2, 0.6) * noise},
            "coarse clock": lambda: {"step_s": draw.uniform(0.02, 0.05)}}[cause]()


def said_beside(effects, q, t, celsius):
    """What an encoder says beyond the angle, a row a run: its law, its holder, a tape's law of creep, a coarse clock."""
    shakes, creep, clock = effects.get("floor shakes"), effects.get("creep"), effects.get("coarse clock")
    said = of(effects, "potentiometer", "a") * q ** 2 + of(effects, "one sided gain", "share") * np.maximum(q, 0)
    said = said + of(effects, "warm mount", "rad_per_k") * celsius
    if shakes:
        said = said + shakes["rad"] * np.sin(2 * math.pi * shakes["hz"] * t + shakes["phase_rad"])
    if creep:
        slow, keep = np.array(q), math.exp(-(t[1] - t[0]) / creep["tau_s"])
        for k in range(1, q.shape[1]):
            slow[:, k] = q[:, k] + keep * (slow[:, k - 1] - q[:, k])
        said = said + creep["share"] * (slow - q)
    if clock:
        at = np.floor(t / clock["step_s"]) * clock["step_s"]
        said = said + np.stack([np.interp(at, t, row) for row in q]) - q
    return said


def draw_of_motor(draw, cause, typical):
    return {"air drag": lambda: {"per_rad": draw.uniform(0.2, 0.5)},
            "cable": lambda: {"per_s2": typical * draw.uniform(0.15, 0.4), "rad": draw.uniform(-0.5, 0.5)},
            "stiff spot": lambda: {"rad_per_s2": typical * draw.uniform(0.15, 0.4), "rad": draw.uniform(-0.5, 0.5),
                                   "width_rad": draw.uniform(0.1, 0.25)},
            "rubber stop": lambda: {"per_s2": typical * draw.uniform(0.6, 1.5), "rad": draw.uniform(0.1, 0.4)}}[cause]()


def load_of(effects, q, w):
    """Of a motor: drag by the square of the rate, a cable that pulls back, and a soft stop that the arm leans on."""
    pulls = of(effects, "cable", "per_s2") * (q - of(effects, "cable", "rad"))
    pulls += of(effects, "rubber stop", "per_s2") * max(q - of(effects, "rubber stop", "rad"), 0)
    return of(effects, "air drag", "per_rad") * w * abs(w) + pulls


def friction_at(effects, q):
    spot = effects.get("stiff spot")
    return spot["rad_per_s2"] * math.exp(-((q - spot["rad"]) / spot["width_rad"]) ** 2) if spot else 0.0


# -- ranges and bearings ----------------------------------------------------------------------------------------------

def draw_of_detector(draw, cause, noise):
    m = noise["range_m"]
    return {"multipath": lambda: {"m": draw.uniform(1.5, 4) * m, "wave_m": draw.uniform(0.8, 2.5),
                                  "phase_rad": draw.uniform(-3, 3)},
            "near field": lambda: {"m": draw.signed(8, 20) * m, "reach_m": draw.uniform(0.8, 2)},
            "edge of lens": lambda: {"per_rad2": draw.signed(1, 3) * noise["bearing_rad"]},
            "leaning body": lambda: {"s2_per_m": draw.signed(3, 8) * m},
            "beacon clocks": lambda: {"mps": draw.uniform(0.3, 1.0) * m}}[cause]()


def seen_beside(effects, distance, bearing, speed, times, which):
    """Errors of a range, and of a bearing."""
    path, near = effects.get("multipath"), effects.get("near field")
    longer = of(effects, "leaning body", "s2_per_m") * speed ** 2
    # Clocks of eight beacons run at rates of their own, by the golden angle.
    longer = longer + of(effects, "beacon clocks", "mps") * np.sin(2.4 * which) * times
    if path:
        longer = longer + path["m"] * np.sin(2 * math.pi * distance / path["wave_m"] + path["phase_rad"])
    if near:
        longer = longer + near["m"] * np.exp(-distance / near["reach_m"])
    return longer, of(effects, "edge of lens", "per_rad2") * bearing ** 3


# -- bodies -----------------------------------------------------------------------------------------------------------

def draw_of_body(draw, cause):
    return {"slope": lambda: {"share": draw.uniform(0.03, 0.1), "way_rad": draw.uniform(-3, 3)},
            "compass": lambda: {"rad": draw.uniform(0.02, 0.06), "phase_rad": draw.uniform(-3, 3)},
            "slippery speed": lambda: {"s_per_m": draw.uniform(0.2, 0.6)},
            "stiff start": lambda: {"share": draw.uniform(0.1, 0.3), "tau_s": draw.uniform(1, 3)},
            "warm tyres": lambda: {"share": draw.signed(0.02, 0.05)},
            "carpet": lambda: {"share": draw.signed(0.03, 0.08), "edge_m": draw.signed(0.05, 0.3)}}[cause]()


def walks_beside(effects, vx, vy, theta, t):
    """The body's velocity on a slope, which takes it aside, on a floor that is slippery to the fast, with cold joints."""
    down = of(effects, "slope", "share") * math.hypot(vx, vy)
    way = of(effects, "slope", "way_rad") - theta
    start = effects.get("stiff start", {"share": 0, "tau_s": 1})
    less = (1 - of(effects, "slippery speed", "s_per_m") * math.hypot(vx, vy)) * (
        1 - start["share"] * math.exp(-t / start["tau_s"]))
    return vx * less + down * math.cos(way), vy * less + down * math.sin(way)


def said_heading(effects, theta):
    """By a compass near iron."""
    return theta + of(effects, "compass", "rad") * np.sin(theta + of(effects, "compass", "phase_rad"))


# -- flat fields ------------------------------------------------------------------------------------------------------

def draw_of_sensor(draw, cause, share):
    """`share`: the noise of a value over the value."""
    return {"dew": lambda: {"depth": draw.uniform(4, 10) * share}, "Newton rings": lambda: {
                "depth": draw.uniform(1, 3) * share, "rings": draw.uniform(3, 6)},
            "light leak": lambda: {"dn": draw.uniform(20, 60)},
            "fading lamp": lambda: {"share": draw.uniform(3, 8) * share}}[cause]()


def gain_beside(effects, u, v, width, height, at):
    """A further factor of the light on each pixel; `at` runs from 0 to 1 over the frames."""
    rho2 = ((u - 0.4 * width) ** 2 + (v - 0.5 * height) ** 2) / (0.25 * width * width)
    field = 1 - of(effects, "dew", "depth") * at * np.exp(-2 * rho2)
    field = field + of(effects, "Newton rings", "depth") * np.cos(
        2 * math.pi * of(effects, "Newton rings", "rings") * rho2)
    return field * (1 - of(effects, "fading lamp", "share") * at)
