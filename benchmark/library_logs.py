"""Libraries of linear terms for robots, servos and flat fields (see library.py)."""
import math
import struct
import zlib

import numpy as np

from landmarks import wrapped
from library import nominal_values, problem_of, stated_noise, table


def by_run(run, values, function):
    """A function of each run's rows, joined."""
    return np.concatenate([function(values[run == r]) for r in np.unique(run)])


# -- landmarks --------------------------------------------------------------------------------------------------------

def of_landmarks(folder):
    seen, poses, where = (table(folder / name) for name in ("observations.csv", "poses.csv", "map.csv"))
    place = np.stack([where["x_m"], where["y_m"]], -1)[seen["landmark"].astype(int)]

    def at(shift):
        out = np.empty((len(seen["run"]), 3))
        for run in np.unique(seen["run"]):
            mine, some = poses["run"] == run, seen["run"] == run
            heading = np.unwrap(poses["theta_rad"][mine])
            for k, column in enumerate((poses["x_m"][mine], poses["y_m"][mine], heading)):
                out[some, k] = np.interp(seen["time_s"][some] + shift, poses["time_s"][mine], column)
        return out

    def predicted(x_m=0.0, y_m=0.0, late=0.0):
        x, y, theta = at(late).T
        dx = place[:, 0] - x - x_m * np.cos(theta) + y_m * np.sin(theta)
        dy = place[:, 1] - y - x_m * np.sin(theta) - y_m * np.cos(theta)
        return np.concatenate([np.hypot(dx, dy), wrapped(np.arctan2(dy, dx) - theta)])
    base = predicted()
    half = len(base) // 2
    ranges, bearings = base[:half], base[half:]
    none, one = np.zeros(half), np.ones(half)

    def small(step, **given):
        change = predicted(**given) - base
        change[half:] = wrapped(change[half:])
        return change / step

    def column(*parts):
        return np.concatenate(parts)[:, None]
    terms = [("range_scale", [], ("scale",), column(ranges, none)),
             ("range_offset", [], ("offset_m",), column(one, none)),
             ("bearing_scale", [], ("scale",), column(none, bearings)),
             ("mount_misalignment", [], ("yaw_rad",), column(none, -one)),
             ("bearing_offset_per_range", [], ("rad_per_m",), column(none, ranges)),
             ("mount_offset", [], ("x_m", "y_m"), np.stack([small(1e-5, x_m=1e-5), small(1e-5, y_m=1e-5)], -1)),
             ("frame_latency", [], ("latency_s",), small(2e-2, late=2e-2)[:, None])]
    off = seen["range_m"] - ranges, wrapped(seen["bearing_rad"] - bearings)
    fields = {"range": np.tile(ranges, 2), "bearing": np.tile(bearings, 2), "time": np.tile(seen["time_s"], 2),
              "channel": np.repeat((0.0, 1.0), half)}
    return problem_of([("range_m", off[0]), ("bearing_rad", off[1])], np.zeros((2 * half, 1)), terms, fields,
                      stated_noise(folder))


# -- bodies seen from above -------------------------------------------------------------------------------------------

def of_walks(folder):
    """Steps from row to row in the body's frame. Each has the errors of two poses: neighbours are not independent."""
    data = table(folder / "odometry.csv")
    run, ticks = data["run"], "left_ticks" in data
    same = run[1:] == run[:-1]
    dt = np.diff(data["time_s"])[same]
    theta = data["theta_rad"]
    turn = wrapped(np.diff(theta))[same]
    dx, dy = np.diff(data["x_m"])[same], np.diff(data["y_m"])[same]
    if ticks:
        drive = nominal_values(folder, "differential_drive")
        left, right = (data[name][1:][same] * drive["metres_per_tick"] / dt for name in ("left_ticks", "right_ticks"))
        vx, vy, omega = 0.5 * (left + right), np.zeros(len(dt)), (right - left) / drive["base_m"]
    else:
        vx, vy, omega = (data[name][:-1][same] for name in ("vx_cmd_mps", "vy_cmd_mps", "omega_cmd_radps"))
    middle = theta[:-1][same] + 0.5 * omega * dt
    ahead, aside = np.cos(middle) * dx + np.sin(middle) * dy, np.cos(middle) * dy - np.sin(middle) * dx
    zero, runs = np.zeros(len(dt)), run[:-1][same]

    def column(*parts):
        return np.concatenate([part * dt for part in parts])

    def before(v):
        return by_run(runs, v, lambda some: np.concatenate([[0.0], some[:-1]]) if not ticks else some)
    if ticks:
        base = drive["base_m"]
        slope = [by_run(runs, v, np.gradient) / dt for v in (vx, vy, omega)]
        terms = [("wheel_scale", [], ("left", "right"), np.stack([column(0.5 * left, zero, -left / base),
                                                                   column(0.5 * right, zero, right / base)], -1)),
                 ("base_scale", [], ("scale",), column(zero, zero, -omega)[:, None]),
                 ("wheel_slip", [], ("per_radps",), column(-vx * np.abs(omega), zero, zero)[:, None]),
                 ("frame_latency", [], ("latency_s",), column(*slope)[:, None])]
    else:
        speed = np.hypot(vx, vy)
        lag = [before(v) - v for v in (vx, vy, omega)]
        terms = [("odometry_scale", [], ("vx_scale", "vy_scale", "omega_scale"), np.stack(
                     [column(vx, zero, zero), column(zero, vy, zero), column(zero, zero, omega)], -1)),
                 ("heading_drift", [], ("rad_per_m",), column(zero, zero, speed)[:, None]),
                 ("turn_asymmetry", [], ("left_excess",), column(zero, zero, np.maximum(omega, 0))[:, None]),
                 ("tracker_offset", [], ("x_m", "y_m"), np.stack([column(zero, omega, zero),
                                                                  column(-omega, zero, zero)], -1)),
                 # A share of the step, not a time.
                 ("walk_lag", [], (), column(*lag)[:, None])]
    noise = stated_noise(folder)
    sources = (("ahead", "x_m"), ("aside", "y_m"), ("turn", "theta_rad"))
    steps = {name: math.sqrt(2) * noise[source] for name, source in sources if noise}
    fields = {"vx": np.tile(vx, 3), "omega": np.tile(omega, 3), "time": np.tile(data["time_s"][:-1][same], 3),
              "channel": np.repeat((0.0, 1.0, 2.0), len(dt))}
    return problem_of([("ahead", ahead - vx * dt), ("aside", aside - vy * dt), ("turn", turn - omega * dt)],
                      np.zeros((3 * len(dt), 1)), terms, fields, steps)


# -- servos -----------------------------------------------------------------------------------------------------------

def of_servos(folder):
    data = table(folder / "joints.csv")
    if "kp" in data:
        return None  # A motor.
    run, command = data["run"], data["command_rad"]
    last = by_run(run, command, lambda c: np.concatenate([c[:1], c[:-1]]))
    change = by_run(run, last, lambda c: np.concatenate([[0.0], np.diff(c)]))
    sign = by_run(run, np.sign(change), held_sign)
    terms = [("encoder_offset", [], ("pan_rad",), -np.ones((len(last), 1))),
             ("encoder_scale", [], ("pan_scale",), -last[:, None]),
             ("gravity_sag", [], ("rad",), -np.cos(last)[:, None]),
             # Half a width behind the last motion: a dead band ends like this, too.
             ("backlash", ["stiction"], ("width_rad",), -0.5 * sign[:, None])]
    for tau in (0.01, 0.02, 0.04, 0.08):
        terms.append(("servo_lag", ["servo_latency"], (), by_run(run, last, lambda c: behind(c, tau) - c)[:, None]))
    for limit in (1.5, 2.5, 4.0):
        terms.append(("speed_limit", [], (), by_run(run, last, lambda c: limited(c, limit) - c)[:, None]))
    fields = {"angle": last, "rate": change, "time": data["time_s"]}
    return problem_of([("measured_rad", data["measured_rad"] - last)], np.zeros((len(last), 1)), terms, fields,
                      stated_noise(folder))


def held_sign(signs):
    out, now = np.zeros(len(signs)), 0.0
    for k, sign in enumerate(signs):
        now = sign or now
        out[k] = now
    return out


def behind(command, tau, step=0.01):
    q, out, keep = command[0], np.empty(len(command)), math.exp(-step / tau)
    for k, c in enumerate(command):
        q = c + (q - c) * keep
        out[k] = q
    return out


def limited(command, limit, step=0.01):
    q, out = command[0], np.empty(len(command))
    for k, c in enumerate(command):
        q += max(-limit * step, min(limit * step, c - q))
        out[k] = q
    return out


# -- flat fields ------------------------------------------------------------------------------------------------------

def grey16(path):
    """Only the images that sets.py writes."""
    data = path.read_bytes()
    width, height = struct.unpack(">II", data[16:24])
    at, body = 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        body += data[at + 8:at + 8 + length] if kind == b"IDAT" else b""
        at += 12 + length
    lines = np.frombuffer(zlib.decompress(body), np.uint8).reshape(height, 1 + 2 * width)
    return lines[:, 1:].copy().view(">u2").astype(float)


def of_flats(folder):
    """Means of a level's frames over blocks of four by four pixels."""
    data = table(folder / "frames.csv")
    images = np.stack([grey16(folder / name) for name in data["file"]])
    count, height, width = images.shape
    blocks = images.reshape(count, height // 4, 4, width // 4, 4).mean((2, 4))
    values, light, exposure = [], [], []
    for lit, time in sorted(set(zip(data["illumination"], data["exposure_s"]))):
        some = (data["illumination"] == lit) & (data["exposure_s"] == time)
        values.append(blocks[some].mean(0))
        light.append(lit * time / 0.02)
        exposure.append(time)
    y = np.stack(values)
    v, u = np.meshgrid(np.arange(height // 4) * 4 + 1.5, np.arange(width // 4) * 4 + 1.5, indexing="ij")
    rho2 = ((u - (width - 1) / 2) ** 2 + (v - (height - 1) / 2) ** 2) / ((width / 2) ** 2 + (height / 2) ** 2)
    level = np.array(light)[:, None, None] * np.ones_like(y)
    gain = np.polyfit(level.ravel(), y.ravel(), 1)[0]

    def column(values):
        return (values * np.ones_like(y)).ravel()
    signal = gain * level
    terms = [("vignetting", [], ("a2", "a4"), np.stack([column(-signal * rho2), column(-signal * rho2 ** 2)], -1)),
             ("uneven_lighting", [], ("gx", "gy"), np.stack([column(signal * (u / (width - 1) - 0.5)),
                                                              column(signal * (v / (height - 1) - 0.5))], -1)),
             ("response_cubic", [], (), np.stack([column(signal ** 2 / 4095), column(signal ** 3 / 4095 ** 2)], -1)),
             # In electrons a second only with the gain, which means do not show.
             ("dark_current", [], (), column(np.array(exposure)[:, None, None])[:, None])]
    fields = {"u": column(u), "v": column(v), "light": level.ravel()}
    return problem_of([("dn", y.ravel())], np.stack([column(1.0), level.ravel()], -1), terms, fields, {})
