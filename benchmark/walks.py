"""Bodies seen from above: walks by commanded velocities (`walks`) and drives by the ticks of two wheels (`wheels`)."""
import math

import numpy as np

import outside
from draws import Draw
from sets import MadeSet, TRACE_SIZE, noise_line, rows

FINE_S = 0.002
HEADERS = {"walks": "run,time_s,vx_cmd_mps,vy_cmd_mps,omega_cmd_radps,x_m,y_m,theta_rad",
           "wheels": "run,time_s,left_ticks,right_ticks,x_m,y_m,theta_rad"}
FORMATS = {"walks": ("d", ".3f", ".4f", ".4f", ".4f", ".6f", ".6f", ".7f"),
           "wheels": ("d", ".3f", "d", "d", ".6f", ".6f", ".7f")}
POSSIBLE = {"walks": ("odometry_scale", "heading_drift", "walk_lag", "turn_asymmetry", "tracker_offset", "walk_noise"),
            "wheels": ("wheel_scale", "base_scale", "wheel_slip", "frame_latency")}
STRANGE = {"walks": ("crab walk", "tiring"), "wheels": ("oval wheel", "oval wheel")}
TICK_M, WHEEL_M = 5e-5, 0.04


def draw_effect(draw, name):
    return {"odometry_scale": lambda: {"vx_scale": draw.signed(0.02, 0.1), "vy_scale": draw.signed(0.02, 0.1),
                                       "omega_scale": draw.signed(0.02, 0.1)},
            "heading_drift": lambda: {"rad_per_m": draw.signed(0.03, 0.2)},
            "walk_lag": lambda: {"tau_s": draw.uniform(0.08, 0.3)},
            "turn_asymmetry": lambda: {"left_excess": draw.signed(0.03, 0.12)},
            "tracker_offset": lambda: {"x_m": draw.signed(0.01, 0.05), "y_m": draw.signed(0.01, 0.05)},
            "walk_noise": lambda: {"xy_sigma": draw.uniform(0.01, 0.03), "theta_sigma": draw.uniform(0.02, 0.08)},
            "wheel_scale": lambda: {"left": draw.signed(0.005, 0.03), "right": draw.signed(0.005, 0.03)},
            "base_scale": lambda: {"scale": draw.signed(0.01, 0.08)},
            "wheel_slip": lambda: {"per_radps": draw.uniform(0.03, 0.12)},
            "frame_latency": lambda: {"latency_s": draw.signed(0.03, 0.12)},
            "wheel_growth": lambda: {"per_mps": draw.signed(0.005, 0.06)},
            "wheel_load": lambda: {"per_mps2": draw.signed(0.01, 0.09)},
            "encoder_skew": lambda: {"right_late_s": draw.signed(0.003, 0.02)},
            "tracker_turn": lambda: {"yaw_rad": draw.signed(0.003, 0.04)},
            # Sideways in proportion to the square of the speed; slower with each second; a wheel that is not round.
            "crab walk": lambda: {"s_per_m": draw.signed(0.2, 0.5)},
            "tiring": lambda: {"per_s": draw.uniform(0.008, 0.02)},
            "oval wheel": lambda: {"share": draw.uniform(0.1, 0.2), "phase_rad": draw.uniform(-3, 3)}}.get(
                name, lambda: outside.draw_of_body(draw, name))()


def body_of(effects, v, t):
    """The body's velocity of a velocity that is commanded (and lagged)."""
    scale = effects.get("odometry_scale", {})
    vx, vy, omega = (v[k] * (1 + scale.get(name, 0)) for k, name in enumerate(("vx_scale", "vy_scale", "omega_scale")))
    omega = omega + effects.get("turn_asymmetry", {}).get("left_excess", 0) * max(omega, 0)
    omega += effects.get("heading_drift", {}).get("rad_per_m", 0) * math.hypot(vx, vy)
    vy += effects.get("crab walk", {}).get("s_per_m", 0) * vx * abs(vx)
    less = 1 - effects.get("tiring", {}).get("per_s", 0) * t
    return vx * less, vy * less, omega * less


def arc(pose, v, dt):
    """Moved by a velocity of the body that holds."""
    x, y, theta = pose
    vx, vy, omega = v
    half = 0.5 * omega * dt
    chord = dt * (math.sin(half) / half if abs(half) > 1e-12 else 1.0)
    c, s = math.cos(theta + half), math.sin(theta + half)
    return x + chord * (c * vx - s * vy), y + chord * (s * vx + c * vy), theta + omega * dt


def walk_commands(draw, rows_a_run, course):
    """Each command holds for a second or so."""
    table = np.empty((rows_a_run, 3))
    at = 0
    while at < rows_a_run:
        length = draw.integer(6, 16)
        turn = draw.uniform(0.1, 1.0) if course == "tie" else draw.uniform(-0.9, 0.9)
        ahead, aside = draw.uniform(-0.1, 0.35), draw.choice((0, 0, 1)) * draw.uniform(-0.12, 0.12)
        table[at:at + length] = (ahead, aside, turn)
        at += length
    return np.round(table, 4)


def walked(effects, commands, dt, draw):
    """Poses at the rows, of the tracked point, from the origin on."""
    lag = effects.get("walk_lag", {}).get("tau_s", 0)
    noise = effects.get("walk_noise")
    point = effects.get("tracker_offset", {"x_m": 0, "y_m": 0})
    pose, follows = (0.0, 0.0, draw.uniform(-3, 3)), np.zeros(3)
    poses = []
    inner = 20
    h = dt / inner
    for k, command in enumerate(commands):
        c, s = math.cos(pose[2]), math.sin(pose[2])
        poses.append((pose[0] + c * point["x_m"] - s * point["y_m"],
                      pose[1] + s * point["x_m"] + c * point["y_m"], pose[2]))
        path = 0.0
        for step in range(inner):
            if lag:
                middle = command + (follows - command) * math.exp(-(step + 0.5) * h / lag)
            else:
                middle = command
            v = body_of(effects, middle, k * dt + (step + 0.5) * h)
            v = (*outside.walks_beside(effects, v[0], v[1], pose[2], k * dt + (step + 0.5) * h), v[2])
            pose = arc(pose, v, h)
            path += h * math.hypot(v[0], v[1])
        if lag:
            follows = command + (follows - command) * math.exp(-dt / lag)
        if noise:
            c, s, root = math.cos(pose[2]), math.sin(pose[2]), math.sqrt(path)
            a, b, turn = (root * draw.normal(noise[name]) for name in ("xy_sigma", "xy_sigma", "theta_sigma"))
            pose = (pose[0] + c * a - s * b, pose[1] + s * a + c * b, pose[2] + turn)
    return np.array(poses)


def wheel_speeds(draw, steps):
    """Forward speed and turning of a drive in fine steps, with bounded accelerations."""
    v = omega = 0.0
    goal, out = (0.0, 0.0), np.empty((steps, 2))
    until = 0
    for k in range(steps):
        if k >= until:
            goal = draw.choice(((0.3, 0.0), (0.2, 0.6), (0.25, -0.5), (0.0, 1.0), (0.0, -1.0), (0.3, 0.3), (0.35, 0.1)))
            until = k + round(draw.uniform(1.0, 2.0) / FINE_S)
        v += max(-FINE_S, min(FINE_S, goal[0] - v))
        omega += max(-4 * FINE_S, min(4 * FINE_S, goal[1] - omega))
        out[k] = v, omega
    return out


def driven(effects, base, speeds, start):
    """Counts of both encoders' paths and the true way at each fine step."""
    v, omega = speeds.T
    turned = np.stack([v - 0.5 * omega * base, v + 0.5 * omega * base], -1)  # As the encoders say.
    rolled = np.concatenate([np.zeros((1, 2)), np.cumsum(turned * FINE_S, 0)])
    scale = effects.get("wheel_scale", {})
    ground = turned * (1 + np.array([scale.get("left", 0), scale.get("right", 0)]))
    # A tyre is larger the faster it turns, and smaller the more a turn presses it to the floor.
    ground = ground * (1 + outside.of(effects, "wheel_growth", "per_mps") * np.abs(turned))
    ground = ground * (1 + outside.of(effects, "wheel_load", "per_mps2") * np.outer(v * omega, (1, -1)))
    oval = effects.get("oval wheel")
    at = np.linspace(0, 1, len(ground))[:, None]
    ground = ground * (1 + outside.of(effects, "warm tyres", "share") * (1 - np.exp(-3 * at)))
    if oval:
        ground[:, 0] *= 1 + oval["share"] * np.sin(rolled[:-1, 0] / WHEEL_M + oval["phase_rad"])
    rate = (ground[:, 1] - ground[:, 0]) / (base * (1 + effects.get("base_scale", {}).get("scale", 0)))
    ahead = 0.5 * ground.sum(1) * np.maximum(0, 1 - effects.get("wheel_slip", {}).get("per_radps", 0) * np.abs(rate))
    theta = start + np.concatenate([[0], np.cumsum(rate * FINE_S)])
    middle = theta[:-1] + 0.5 * FINE_S * rate
    if "carpet" in effects:  # Behind a line across the floor, the same for all runs.
        x = np.cumsum(ahead * np.cos(middle) * FINE_S)
        ahead = ahead * (1 + effects["carpet"]["share"] * (x > effects["carpet"]["edge_m"]))
    down = outside.of(effects, "slope", "share") * np.abs(ahead)
    way = np.stack([np.concatenate([[0], np.cumsum(
        (ahead * np.cos(middle) + down * math.cos(outside.of(effects, "slope", "way_rad"))) * FINE_S)]),
                    np.concatenate([[0], np.cumsum(
        (ahead * np.sin(middle) + down * math.sin(outside.of(effects, "slope", "way_rad"))) * FINE_S)]), theta], -1)
    return rolled, way


def drive_rows(effects, base, draw, dt, count):
    """Ticks since the row before, and poses, of one run."""
    late = effects.get("frame_latency", {}).get("latency_s", 0)
    speeds = wheel_speeds(draw, round(count * dt / FINE_S) + round(0.4 / FINE_S))
    speeds[:round(0.3 / FINE_S)] = 0.0
    rolled, way = driven(effects, base, speeds, draw.uniform(-3, 3))
    times = np.arange(count) * dt
    fine = np.arange(len(way)) * FINE_S
    read = [times, times + outside.of(effects, "encoder_skew", "right_late_s")]  # When each wheel's counter is.
    paths = [np.interp(at, fine, path) for at, path in zip(read, rolled.T)]
    counts = np.rint(np.stack(paths, -1) / TICK_M).astype(int)
    at = np.maximum(times + late, 0) / FINE_S
    poses = np.stack([np.interp(at, np.arange(len(way)), column) for column in way.T], -1)
    return np.diff(counts, axis=0, prepend=counts[:1]), poses


def walks(plan):
    draw = Draw(plan.sort, plan.number)
    wheels = plan.base == "wheels"
    names = ["base_scale" if wheels else "turn_asymmetry"] if plan.course == "tie" else plan.names(
        draw, POSSIBLE[plan.base])
    hidden = {name: draw_effect(draw, name) for name in names}
    strange = plan.strange(STRANGE[plan.base])
    sigma, turn_sigma = draw.uniform(0.0005, 0.003), draw.uniform(0.001, 0.006)
    effects = hidden | ({strange: draw_effect(draw, strange)} if strange else {})
    traces = {}
    if plan.course == "trace":
        traces = {"base_scale": {"scale": 4e-5}} if wheels else {"turn_asymmetry": {"left_excess": 4e-5}}
        traces = {name: values for name, values in traces.items() if name not in hidden}
    dt, count, runs = (0.05, 300, 6) if wheels else (0.1, 120, 8)
    base = round(draw.uniform(0.2, 0.4), 4)
    stated = draw.chance(0.6) or "walk_noise" in hidden
    columns = [[] for _ in FORMATS[plan.base]]
    for run in range(runs):
        one = draw.of(f"run {run}")
        if wheels:
            given, poses = drive_rows(effects | traces, base, one, dt, count)
        else:
            given = walk_commands(one, count, plan.course)
            poses = walked(effects | traces, given, dt, one)
        poses[:, 2] = outside.said_heading(effects, poses[:, 2]) + outside.of(effects, "tracker_turn", "yaw_rad")
        poses = poses + one.normal(size=poses.shape) * (sigma, sigma, turn_sigma)
        wrong = one.uniform(size=len(poses)) < plan.gross
        poses = poses + wrong[:, None] * one.normal(size=poses.shape) * (0.3, 0.3, 0.5)
        poses[:, 2] = (poses[:, 2] + math.pi) % (2 * math.pi) - math.pi
        for column, values in zip(columns, (np.full(count, run), np.arange(count) * dt, *given.T, *poses.T)):
            column.extend(values.tolist())
    settings = ("group: run\n" + noise_line(stated, x_m=sigma, y_m=sigma, theta_rad=turn_sigma)
                + "files: {odometry: odometry.csv}\n")
    nominal = {"ideal_odometry": {}}
    if wheels:
        nominal = {"differential_drive": {"metres_per_tick": TICK_M, "base_m": base}}
    # Turns to one side alone. Wheels have no tie: a wrong base is two wrong wheels only in turns on the spot.
    ties = {"turn_asymmetry": ["odometry_scale"]} if plan.course == "tie" and not wheels else {}
    return MadeSet(kind="odometry", settings=settings, tables={"odometry.csv": rows(
        HEADERS[plan.base], FORMATS[plan.base], *columns)}, nominal=nominal, hidden=hidden, traces=traces, ties=ties,
        outside=strange, noise_stated=stated)
