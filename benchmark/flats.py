"""Flat fields and dark frames of a camera of 12 bits (`flats`)."""
import math

import numpy as np

import outside
from draws import Draw
from sets import Free, MadeSet, TRACE_SIZE

WIDTH, HEIGHT, BITS = 64, 48, 12
TOP = 2 ** BITS - 1
POSSIBLE = ("vignetting", "uneven_lighting", "pixel_gain_spread", "pixel_offset_spread", "column_offsets", "row_noise",
            "response_cubic", "dark_current", "lamp_fluctuation", "shot_noise")
# The two of a line are hard to separate in few frames: at most one of them.
ALIKE = (("vignetting", "uneven_lighting"), ("row_noise", "column_offsets"))
STRANGE = ("dust ring", "image lag")
FRAMES_A_LEVEL = 5


def draw_effect(draw, name, seen):
    """`seen`: the noise of a value in the middle of the range, in DN."""
    middle = 0.5 * TOP
    return {"vignetting": lambda: {"a2": draw.uniform(0.05, 0.25), "a4": draw.uniform(0.0, 0.1)},
            "uneven_lighting": lambda: {"gx": draw.signed(0.02, 0.1), "gy": draw.signed(0.02, 0.1)},
            "pixel_gain_spread": lambda: {"sigma": draw.uniform(0.4, 1.5) * seen / middle},
            "pixel_offset_spread": lambda: {"sigma_dn": draw.uniform(0.4, 1.5) * seen},
            # DN a second: at the longest exposure, 0.2 s, of the noise's size.
            "dark_current_spread": lambda: {"sigma_dn_per_s": draw.uniform(0.4, 1.5) * seen / 0.2},
            "column_offsets": lambda: {"sigma_dn": draw.uniform(0.4, 1.2) * seen},
            "row_noise": lambda: {"sigma_dn": draw.uniform(0.4, 1.2) * seen},
            "response_cubic": lambda: {"k2": draw.signed(0.03, 0.1), "k3": 0.0},
            "response_gamma": lambda: {"gamma": 1 + draw.signed(0.04, 0.12)},
            "dark_current": lambda: {"electrons_per_s": draw.uniform(500, 4000)},
            "lamp_fluctuation": lambda: {"sigma": draw.uniform(0.5, 1.5) * seen / middle},
            "shot_noise": lambda: {"electrons_per_dn": draw.log_uniform(0.8, 6)},
            "tap_gain": lambda: taps(draw, seen / middle),
            "periodic_pattern": lambda: {"amplitude_dn": draw.uniform(0.2, 1) * seen,
                                         "period_px": draw.log_uniform(2.5, 16),
                                         "angle_rad": draw.choice((0, math.pi / 2, draw.uniform(-1.5, 1.5))),
                                         "phase_rad": draw.uniform(-3, 3)},
            # From a corner or the middle of an edge; 0.5 to 5 times that noise in the longest of dark frames.
            "amplifier_glow": lambda: {"light": 0.1 * draw.uniform(0.5, 5) * seen / (0.85 * TOP),
                                       **dict(zip(("u0", "v0"), draw.choice(((0.5, 0.5), (-0.5, 0.5), (0.5, 0), (0, -0.5))))),
                                       "fall_u_per_px": draw.log_uniform(0.03, 0.1),
                                       "fall_v_per_px": draw.log_uniform(0.03, 0.1), "shape": draw.choice((1, 2))},
            "dust ring": lambda: {"depth": draw.uniform(2, 5) * seen / middle, "u_px": draw.uniform(15, 48),
                                  "v_px": draw.uniform(12, 36), "radius_px": draw.uniform(6, 12)},
            "noise_filter": lambda: draw_filter(draw),
            "image lag": lambda: {"share": draw.uniform(0.005, 0.02)}}.get(
                name, lambda: outside.draw_of_sensor(draw, name, seen / middle))()


def taps(draw, share):
    """Two halves, or stripes; now and then both."""
    sizes = {"right_half": draw.signed(1, 5), "lower_half": draw.signed(1, 5), "odd_columns": draw.signed(0.3, 3),
             "odd_rows": draw.signed(0.3, 3)}
    act = draw.sample(sizes, draw.choice((1, 1, 2)))
    return {name: share * size if name in act else 0.0 for name, size in sizes.items()}


def gain_field(effects):
    """Light on a pixel beside that of the middle."""
    v, u = np.mgrid[0:HEIGHT, 0:WIDTH].astype(float)
    rho2 = ((u - (WIDTH - 1) / 2) ** 2 + (v - (HEIGHT - 1) / 2) ** 2) / ((WIDTH / 2) ** 2 + (HEIGHT / 2) ** 2)
    dim, plane = effects.get("vignetting", {}), effects.get("uneven_lighting", {})
    field = 1 - dim.get("a2", 0) * rho2 - dim.get("a4", 0) * rho2 ** 2
    field = field * (1 + plane.get("gx", 0) * (u / (WIDTH - 1) - 0.5) + plane.get("gy", 0) * (v / (HEIGHT - 1) - 0.5))
    tap = effects.get("tap_gain", {})
    for name, there in (("right_half", u >= WIDTH // 2), ("lower_half", v >= HEIGHT // 2), ("odd_columns", u % 2),
                        ("odd_rows", v % 2)):
        field = field * (1 + tap.get(name, 0) * there)
    if "dust ring" in effects:
        ring = effects["dust ring"]
        distance = np.hypot(u - ring["u_px"], v - ring["v_px"])
        field = field * (1 - ring["depth"] * np.exp(-((distance - ring["radius_px"]) / 2.0) ** 2))
    return field


def wave_of(amplitude_dn, period_px, angle_rad, phase_rad):
    v, u = np.mgrid[0:HEIGHT, 0:WIDTH].astype(float)
    return amplitude_dn * np.sin(2 * math.pi * (u * math.cos(angle_rad) + v * math.sin(angle_rad)) / period_px + phase_rad)


def glow_of(light, u0, v0, fall_u_per_px, fall_v_per_px, shape):
    v, u = np.mgrid[0:HEIGHT, 0:WIDTH].astype(float)
    away = np.hypot(fall_u_per_px * (u - (u0 + 0.5) * (WIDTH - 1)), fall_v_per_px * (v - (v0 + 0.5) * (HEIGHT - 1)))
    return light * np.exp(-away ** shape)


def draw_filter(draw):
    """Half of them alike in both directions; others along rows alone, or sharpening."""
    weight = draw.uniform(0.02, 0.16)
    return draw.choice(({"along_rows": weight, "along_columns": weight}, {"along_rows": weight, "along_columns": weight},
                        {"along_rows": weight, "along_columns": 0.0}, {"along_rows": -0.6 * weight, "along_columns": -0.6 * weight}))


def smoothed(dn, along_rows, along_columns):
    """Three by three pixels mixed into each; beyond the edges the last pixel once more."""
    once = np.pad(dn, 1, mode="edge")
    across, along = ((w, 1 - 2 * w, w) for w in (along_columns, along_rows))
    return sum(across[i] * along[j] * once[i:i + HEIGHT, j:j + WIDTH] for i in range(3) for j in range(3))


class Sensor:
    """What stays the same over all frames."""

    def __init__(self, effects, camera, draw):
        self.effects, self.camera, self.draw = effects, camera, draw
        shape = (HEIGHT, WIDTH)
        self.field = gain_field(effects)
        spread = effects.get("pixel_gain_spread", {}).get("sigma", 0)
        self.field = self.field * (1 + spread * draw.of("gains").normal(size=shape))
        self.fixed = effects.get("pixel_offset_spread", {}).get("sigma_dn", 0) * draw.of("offsets").normal(size=shape)
        self.dark = effects.get("dark_current_spread", {}).get("sigma_dn_per_s", 0) * draw.of("darks").normal(size=shape)
        self.fixed += effects.get("column_offsets", {}).get("sigma_dn", 0) * draw.of("columns").normal(size=(1, WIDTH))
        if "periodic_pattern" in effects:
            self.fixed += wave_of(**effects["periodic_pattern"])
        self.before = np.zeros(shape)

    def frame(self, number, light, exposure_ratio, exposure_s):
        effects, draw, shape = self.effects, self.draw.of(f"frame {number}"), (HEIGHT, WIDTH)
        lamp = 1 + effects.get("lamp_fluctuation", {}).get("sigma", 0) * draw.normal()
        v, u = np.mgrid[0:HEIGHT, 0:WIDTH]
        # Frames number 40 or so.
        beside = outside.gain_beside(effects, u, v, WIDTH, HEIGHT, min(1.0, number / 40))
        signal = self.camera["gain_dn"] * light * lamp * exposure_ratio * self.field * beside
        signal = signal + outside.of(effects, "light leak", "dn") * exposure_ratio * u / WIDTH
        if "amplifier_glow" in effects:  # Behind the lens.
            signal = signal + self.camera["gain_dn"] * exposure_ratio * glow_of(**effects["amplifier_glow"])
        electrons = effects.get("shot_noise", {}).get("electrons_per_dn", 0)
        if electrons:
            charge = signal * electrons + effects.get("dark_current", {}).get("electrons_per_s", 0) * exposure_s
            signal = draw.poisson(charge) / electrons
        if "response_cubic" in effects:
            signal = signal * (1 + effects["response_cubic"]["k2"] * signal / TOP)
        if "response_gamma" in effects:
            gain = self.camera["gain_dn"]
            signal = gain * np.power(np.maximum(signal, 0) / gain, effects["response_gamma"]["gamma"])
        lag = effects.get("image lag", {}).get("share", 0)
        signal, self.before = signal + lag * (self.before - signal), signal
        dn = signal + self.camera["black_dn"] + self.fixed + exposure_s * self.dark
        dn = dn + effects.get("row_noise", {}).get("sigma_dn", 0) * draw.normal(size=(HEIGHT, 1))
        dn = dn + draw.normal(self.camera["read_dn"], size=shape)
        return smoothed(dn, **effects["noise_filter"]) if "noise_filter" in effects else dn


def frames_of(plan, draw):
    """(illumination, exposure in seconds) of each frame: a lamp at even levels, dark frames at two exposures."""
    if plan.course == "tie":
        return [(level, 0.02) for level in (0.0, 0.45, 0.9) for _ in range(8)]
    levels = draw.choice((6, 8))
    lit = [((k + 1) / levels * 0.9, 0.02) for k in range(levels) for _ in range(FRAMES_A_LEVEL)]
    return [(0.0, 0.02)] * FRAMES_A_LEVEL + lit + [(0.0, 0.2)] * FRAMES_A_LEVEL


def draw_names(plan, draw):
    if plan.course == "tie":
        return ["response_gamma"]
    if plan.count == 0:
        return []
    if plan.cause:
        return [plan.cause]
    names = draw.sample(POSSIBLE, plan.count)
    for first, second in ALIKE:
        if first in names and second in names:
            names.remove(second)
            names += draw.sample([name for name in POSSIBLE[:9] if name not in names and name != second and not any(
                name in pair for pair in ALIKE)], 1)
    return names


def flats(plan):
    draw = Draw(plan.sort, plan.number)
    camera = {"gain_dn": draw.uniform(3300, 3700), "black_dn": draw.uniform(60, 160), "read_dn": draw.uniform(1.2, 5)}
    electrons = draw.log_uniform(0.8, 6)
    seen = math.hypot(camera["read_dn"], math.sqrt(0.5 * TOP / electrons))
    hidden = {name: draw_effect(draw, name, seen) for name in draw_names(plan, draw)}
    photons = hidden.get("shot_noise", {"electrons_per_dn": electrons})
    strange = plan.strange(STRANGE)
    traces = {}
    if plan.course == "trace":
        name = "row_noise" if not {"row_noise", "column_offsets"} & set(hidden) else "pixel_offset_spread"
        traces = {name: {"sigma_dn": TRACE_SIZE * seen}} if name not in hidden else {}
    effects = {"shot_noise": photons} | hidden | traces
    if strange:
        effects[strange] = draw_effect(draw, strange, seen)
    sensor = Sensor(effects, camera, draw)
    images, lines = {}, ["frame,file,time_s,exposure_s,illumination"]
    for number, (light, exposure_s) in enumerate(frames_of(plan, draw.of("frames"))):
        dn = sensor.frame(number, light, exposure_s / 0.02, exposure_s)
        # Particles: a tenth of the share, for a value is the mean over five frames and more.
        hits = draw.of(f"hits {number}")
        dn = dn + (hits.uniform(size=dn.shape) < 0.1 * plan.gross) * hits.uniform(50, 1500, size=dn.shape)
        images[f"frames/{number:03}.png"] = np.clip(np.rint(dn), 0, TOP)
        lines.append(f"{number},frames/{number:03}.png,{0.5 * number},{exposure_s},{light:.6g}")
    start = draw.of("nominal")
    about = {"linear_response": {"gain_dn": camera["gain_dn"], "black_dn": camera["black_dn"]},
             "read_noise": {"sigma_dn": camera["read_dn"]}}
    if "shot_noise" not in hidden:
        about["shot_noise"] = dict(photons)
    nominal = {name: {key: Free(value * math.exp(start.uniform(-0.1, 0.1))) for key, value in values.items()}
               for name, values in about.items()}
    nuisance = {name: {key: Free(value) for key, value in values.items()} for name, values in about.items()}
    settings = (f"camera: {{width_px: {WIDTH}, height_px: {HEIGHT}, channels: grey, bits: {BITS}}}\ngroup: frame\n"
                "files: {frames: frames.csv}\n")
    return MadeSet(kind="photometry", settings=settings, tables={"frames.csv": lines}, images=images, nominal=nominal,
                   hidden=hidden, nuisance=nuisance, traces=traces, outside=strange, noise_stated=False,
                   ties={"response_gamma": ["response_cubic"]} if plan.course == "tie" else {})
