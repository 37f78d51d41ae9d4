"""Boards with unknown poses before one camera: still views (`boards`) and a video by hand (`videos`)."""
import math

import numpy as np

import outside
from draws import Draw
from sets import Free, MadeSet, TIE_SIZE, TRACE_SIZE, noise_line, rows

SIZES = ((640, 480), (752, 480), (1280, 720), (1280, 960), (1920, 1080))
PINHOLE = ("fx_px", "fy_px", "cx_px", "cy_px")
HEADER = "frame,time_s,point,x_m,y_m,z_m,u_px,v_px"
FORMATS = ("d", ".6f", "d", ".6f", ".6f", ".6f", ".4f", ".4f")
STRANGE = {"boards": ("glass", "twisted board", "glass", "pixel phase"),
           "videos": ("focal_drift", "twisted board", "glass", "focal_drift")}
# Which the catalogue has by now.
KNOWN = ("focal_drift",)
# Between two still views, with which a focal length drifts.
VIEW_S = 15.0
AT_C = 20.0  # At which a camera's focal length is its own.


def turned(axis, angle):
    """Rotation matrices by Rodrigues' formula, one for each angle."""
    x, y, z = np.moveaxis(np.broadcast_to(np.asarray(axis, float), np.shape(angle) + (3,)), -1, 0)
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([np.stack([c + x * x * (1 - c), x * y * (1 - c) - z * s, x * z * (1 - c) + y * s], -1),
                     np.stack([y * x * (1 - c) + z * s, c + y * y * (1 - c), y * z * (1 - c) - x * s], -1),
                     np.stack([z * x * (1 - c) - y * s, z * y * (1 - c) + x * s, c + z * z * (1 - c)], -1)], -2)


# -- the camera -------------------------------------------------------------------------------------------------------

def warmths(plan, draw, count):
    """Degrees Celsius of views in a chamber that warms up and whose door is opened at random; nothing in other sorts."""
    if plan.cause != "focal_temperature":
        return None
    span = draw.uniform(60, 90)
    part = 0.4 * np.linspace(0, 1, count) + 0.6 * draw.uniform(size=count)
    return np.round(draw.uniform(-20, 0) + span * part, 1)


def bent(effects, x, y):
    """Image coordinates with the lens's distortion, of those without."""
    r2 = x * x + y * y
    k = effects.get("radial_polynomial", {})
    t = effects.get("tangential_distortion", {})
    s = effects.get("thin_prism", {})
    grown = 1 + r2 * (k.get("k1", 0) + r2 * (k.get("k2", 0) + r2 * k.get("k3", 0)))
    p1, p2 = t.get("p1", 0), t.get("p2", 0)
    x_bent = x + outside.of(effects, "windscreen", "a") * x ** 3
    return (x_bent - x + x * grown + 2 * p1 * x * y + p2 * (r2 + 2 * x * x) + s.get("s1", 0) * r2,
            y * grown + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y + s.get("s3", 0) * r2)


def through_glass(points, glass):
    """Directions in which points are seen through a flat pane, by Snell's law; Newton's method for the angle."""
    normal = np.array([math.sin(glass["tilt_rad"]) * math.cos(glass["way_rad"]),
                       math.sin(glass["tilt_rad"]) * math.sin(glass["way_rad"]), math.cos(glass["tilt_rad"])])
    depth = points @ normal
    across = points - depth[..., None] * normal
    aside = np.linalg.norm(across, axis=-1)
    slope = aside / depth
    for _ in range(20):
        sine = slope / np.sqrt(1 + slope ** 2)
        inside = sine / glass["index"]
        root = np.sqrt(1 - inside ** 2)
        missed = (depth - glass["thick_m"]) * slope + glass["thick_m"] * inside / root - aside
        change = depth - glass["thick_m"] + glass["thick_m"] / root ** 3 / glass["index"] * (1 + slope ** 2) ** -1.5
        slope = slope - missed / change
    return normal + across * (slope / np.maximum(aside, 1e-12))[..., None]


def through_port(points, port):
    """Points in air that are seen where those beyond a port square to the axis are: by halving, from Snell's law."""
    aside = np.hypot(points[..., 0], points[..., 1])
    pane = port.get("thickness_m", 0)
    ways = ((1.0, port["distance_m"]), (1.49, pane), (port["index"], points[..., 2] - port["distance_m"] - pane))
    low, high = np.zeros(aside.shape), np.full(aside.shape, 1.0)
    for _ in range(60):
        sine = 0.5 * (low + high)
        short = sum(way * (sine / index) / np.sqrt(1 - (sine / index) ** 2) for index, way in ways) < aside
        low, high = np.where(short, sine, low), np.where(short, high, sine)
    there = points.copy()
    there[..., 2] = aside * np.sqrt(1 - low ** 2) / np.maximum(low, 1e-15)
    return there


def as_in_air(effects, points):
    return through_port(points, effects["flat_port"]) if "flat_port" in effects else points


def seen(camera, effects, points):
    """Pixels of points in the camera's frame."""
    points = as_in_air(effects, points)
    if "glass" in effects:
        points = through_glass(points, effects["glass"])
    x, y = bent(effects, points[..., 0] / points[..., 2], points[..., 1] / points[..., 2])
    u, v = camera["fx_px"] * x + camera["cx_px"], camera["fy_px"] * y + camera["cy_px"]
    if "pixel phase" in effects:
        size = effects["pixel phase"]["px"]
        u, v = u + size * np.sin(2 * math.pi * u), v + size * np.sin(2 * math.pi * v)
    return outside.in_image(effects, camera, u, v)


def seen_in_motion(camera, effects, points, turns):
    """Pixels of points while the camera turns, each read with its row; a turn a view, from the first row to the last."""
    u, v = seen(camera, effects, points)
    for _ in range(5 if np.any(turns) else 0):
        part = v / camera["size"][1] - 0.5
        u, v = seen(camera, effects, points + part[..., None] * np.cross(turns[:, None], points))
    return u, v


def drifted(camera, effects, t, warmth=AT_C):
    """The camera at these times and temperatures."""
    factor = 1 + effects.get("focal_drift", {}).get("per_s", 0) * t
    factor = factor * (1 + outside.of(effects, "focal_temperature", "per_k") * (warmth - AT_C))
    hunt = effects.get("hunting focus", {"share": 0, "hz": 1})
    factor = factor * (1 + hunt["share"] * np.sin(2 * math.pi * hunt["hz"] * t))
    return camera | {name: camera[name] * factor for name in ("fx_px", "fy_px")} | {"t": t}


def draw_camera(draw):
    w, h = draw.choice(SIZES)
    half_angle = draw.uniform(0.4, 0.7)
    f = 0.5 * math.hypot(w, h) / math.tan(half_angle)
    return {"size": (w, h), "corner": math.tan(half_angle), "fx_px": f, "fy_px": f * draw.uniform(0.99, 1.01),
            "cx_px": (w - 1) / 2 + w * draw.uniform(-0.03, 0.03), "cy_px": (h - 1) / 2 + h * draw.uniform(-0.03, 0.03)}


def draw_radial(draw, camera):
    first = draw.signed(0.02, 0.15)  # Of the radius, at the image's corner.
    r2 = camera["corner"] ** 2
    return {"k1": first / r2, "k2": -first * draw.uniform(0.05, 0.4) / r2 ** 2, "k3": 0.0}


def like_one_number(radial, camera, noise):
    """Whether one number of a division model bends all radii of the image as these do, to a share of the noise."""
    r = np.linspace(0.02, 1, 60) * camera["corner"]
    wanted = r * (1 + radial["k1"] * r ** 2 + radial["k2"] * r ** 4)
    least = math.inf
    for kappa in np.linspace(-0.6, 0.24, 337) / camera["corner"] ** 2:
        curve = 2 * r / (1 + np.sqrt(1 - 4 * kappa * r ** 2))
        scale = (curve * r) @ wanted / ((curve * r) @ curve)  # Weights: the image has more of large radii.
        least = min(least, float(np.sqrt(np.average((scale * curve - wanted) ** 2, weights=r))))
    return least * camera["fx_px"] < TIE_SIZE * noise


# -- the board --------------------------------------------------------------------------------------------------------

def draw_plan(draw):
    nx, ny = draw.choice(((8, 6), (9, 7), (11, 8)))
    pitch = draw.choice((0.02, 0.03, 0.05))
    x, y = np.meshgrid((np.arange(nx) - (nx - 1) / 2) * pitch, (np.arange(ny) - (ny - 1) / 2) * pitch)
    return np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], -1)


def displaced(plan, effects, draw):
    """Where the points of a board truly are."""
    extent = np.abs(plan[:, :2]).max(0)
    a, b = plan[:, 0] / extent[0], plan[:, 1] / extent[1]
    warp, scale = effects.get("board_warp", {}), effects.get("board_scale", {})
    there = plan.copy()
    there[:, 0] = plan[:, 0] * (1 + scale.get("x_scale", 0)) + scale.get("shear", 0) * plan[:, 1]
    there[:, 1] = plan[:, 1] * (1 + scale.get("y_scale", 0))
    there[:, 2] += warp.get("x_m", 0) * (1 - a * a) + warp.get("y_m", 0) * (1 - b * b)
    there[:, 2] += effects.get("twisted board", {}).get("m", 0) * a * b
    there[:, 2] += outside.out_of_plane(effects, plan[:, 0], plan[:, 1])
    if "target_scatter" in effects:
        there += effects["target_scatter"]["sigma_m"] * draw.of("scatter").normal(size=there.shape)
    return there


def draw_effect(draw, name, camera, extent, px_m, video):
    """px_m: metres on the board that a pixel sees."""
    if name == "radial_polynomial":
        return draw_radial(draw, camera)
    far = 1 / camera["corner"] ** 2
    return {"tangential_distortion": lambda: {"p1": far * draw.signed(5e-4, 3e-3), "p2": far * draw.signed(5e-4, 3e-3)},
            "thin_prism": lambda: {"s1": far * draw.signed(1e-3, 4e-3), "s2": 0.0, "s3": far * draw.signed(1e-3, 4e-3),
                                   "s4": 0.0},
            "board_warp": lambda: {name: draw.signed(0.004, 0.012) * extent for name in ("x_m", "y_m")},
            "board_scale": lambda: {"x_scale": draw.signed(0.001, 0.005), "y_scale": 0.0,
                                    "shear": draw.signed(0.001, 0.005)},
            "target_scatter": lambda: {"sigma_m": draw.uniform(0.15, 0.5) * px_m},
            "rolling_shutter": lambda: {"line_delay_s": draw.signed(5e-6, 2.5e-5)},
            "glass": lambda: {"thick_m": draw.uniform(0.03, 0.08) * extent * 2, "index": 1.52,
                              "tilt_rad": draw.uniform(0.3, 0.6), "way_rad": draw.uniform(-math.pi, math.pi)},
            "twisted board": lambda: {"m": draw.signed(0.006, 0.02) * extent},
            "flat_port": lambda: {"index": draw.uniform(1.333, 1.343), "distance_m": draw.uniform(0.01, 0.08)},
            # Between the first row and the last, 0.4 to 2.5 px about each axis.
            "view_motion": lambda: {"turn_sigma_rad": draw.uniform(0.4, 2.5) / camera["fx_px"]},
            "focus_variation": lambda: {"sigma": draw.uniform(0.01, 0.04)},
            "focal_temperature": lambda: {"per_k": draw.signed(1.5e-4, 3.5e-4)},
            "pixel phase": lambda: {"px": draw.uniform(0.5, 1) * 0.2},
            # A zoom that creeps while a video is taken; in still views, a camera that warms up.
            "focal_drift": lambda: {"per_s": draw.signed(*((0.05, 0.15) if video else (6e-5, 1.5e-4)))}}.get(
                name, lambda: outside.draw_of_camera(draw, name, extent, camera["corner"]))()


# -- sets -------------------------------------------------------------------------------------------------------------

class Scene:
    """Camera, board and effects of a set."""

    def __init__(self, plan, possible):
        self.draw = draw = Draw(plan.sort, plan.number)
        self.plan = plan
        self.camera = draw_camera(draw)
        self.board = draw_plan(draw)
        self.extent = float(np.abs(self.board[:, 0]).max())
        self.fill = draw.uniform(0.45, 0.75)  # Of the image's width.
        self.distance = 2 * self.extent * self.camera["fx_px"] / (self.fill * self.camera["size"][0])
        self.noise = draw.log_uniform(0.06, 0.25)
        self.stated = draw.chance(0.6)
        names = ["thin_prism"] if plan.course == "tie" else plan.names(draw, possible)
        px_m = self.distance / self.camera["fx_px"]
        self.video = plan.base == "videos"
        self.hidden = {name: draw_effect(draw, name, self.camera, self.extent, px_m, self.video) for name in names}
        self.effects = dict(self.hidden)
        self.known_lens = "radial_polynomial" not in self.hidden and draw.chance(0.5)
        # A port before a camera that was calibrated in air, in every second pair of sets; some ports are thick.
        self.calibrated = plan.cause == "flat_port" and plan.number % 4 < 2
        if self.known_lens:
            self.effects["radial_polynomial"] = draw_radial(draw, self.camera)
        if "flat_port" in self.hidden and plan.number % 6 == 1:
            self.effects["flat_port"] = self.hidden["flat_port"] | {"thickness_m": draw.uniform(0.002, 0.008)}
        self.outside = ""
        if plan.course == "outside":
            strange = plan.strange(STRANGE[plan.base])
            self.effects[strange] = draw_effect(draw, strange, self.camera, self.extent, px_m, self.video)
            if strange in KNOWN:
                self.hidden = {strange: self.effects[strange]}
            else:
                self.outside = strange
        self.traces = {}

    def add_trace(self, pixels_of):
        """A bend of the board that is far below the noise."""
        if self.plan.course != "trace":
            return
        name = next(n for n in ("board_warp", "board_scale") if n not in self.hidden)
        values = draw_effect(self.draw.of("trace"), name, self.camera, self.extent, 0, self.video)
        without, within_it = (np.concatenate(pixels_of(e)) for e in (self.effects, self.effects | {name: values}))
        size = math.sqrt(float(np.mean((within_it - without) ** 2))) / self.noise
        self.traces[name] = {key: value * TRACE_SIZE / size for key, value in values.items()}
        self.effects |= self.traces

    def made(self, kind_settings, table):
        camera, draw = self.camera, self.draw.of("nominal")
        w, h = camera["size"]
        f = camera["fx_px"] * math.exp(draw.uniform(-1, 1) * math.log(1.2))
        nominal = {"pinhole": dict(zip(PINHOLE, (Free(f), Free(f), Free((w - 1) / 2), Free((h - 1) / 2))))}
        nuisance = {"pinhole": {name: Free(camera[name]) for name in PINHOLE}}
        if self.known_lens:
            nominal["radial_polynomial"] = {"k1": Free(0.0), "k2": Free(0.0)}
            lens = self.effects["radial_polynomial"]
            nuisance["radial_polynomial"] = {"k1": Free(lens["k1"]), "k2": Free(lens["k2"])}
        if self.calibrated:
            nominal = {"pinhole": {name: camera[name] for name in PINHOLE}} | {
                name: self.effects[name] for name in ("radial_polynomial",) if self.known_lens}
            nuisance = {}
        ties = {"tangential_distortion": ["thin_prism"], "thin_prism": ["tangential_distortion"],
                "radial_polynomial": ["rational_lens"],
                "flat_port": [] if self.calibrated else ["radial_polynomial", "radial_distortion", "rational_lens", "fisheye"]}
        if "radial_polynomial" in self.hidden and like_one_number(self.hidden["radial_polynomial"], camera, self.noise):
            ties["radial_polynomial"].append("radial_distortion")
        settings = (f"camera: {{width_px: {w}, height_px: {h}, frame_period_s: {1 / 30:.9f}}}\ngroup: frame\n"
                    + noise_line(self.stated, u_px=self.noise, v_px=self.noise)
                    + f"files: {{points: points.csv}}\nrig: {kind_settings}\n")
        return MadeSet(kind="points", settings=settings, tables={"points.csv": table}, nominal=nominal,
                       hidden=self.hidden, nuisance=nuisance, traces=self.traces, outside=self.outside,
                       unscored=["flat_port.distance_m"] if "thickness_m" in self.effects.get("flat_port", {}) else [],
                       ties={name: ties[name] for name in self.hidden if name in ties},
                       allowed=["point_scatter"] if self.plan.gross else [], noise_stated=self.stated)

    def table(self, frames, times, points, pixels, inside, warmth=None):
        """Rows with noise and gross errors, and with the temperatures of the frames where there are some."""
        draw = self.draw.of("noise")
        u, v = (p + self.noise * draw.normal(size=len(p)) for p in pixels)
        wrong = draw.uniform(size=len(u)) < self.plan.gross
        far = draw.uniform(3, 25, size=len(u)) * wrong
        way = draw.uniform(-math.pi, math.pi, size=len(u))
        u, v = u + far * np.cos(way), v + far * np.sin(way)
        keep = np.flatnonzero(inside)
        x, y, z = self.board[points].T
        more, header, formats = (), HEADER, FORMATS
        if warmth is not None:
            more, header, formats = (warmth[frames],), HEADER + ",temperature_c", (*FORMATS, ".1f")
        return rows(header, formats, *(column[keep].tolist() for column in (frames, times, points, x, y, z, u, v, *more)))


def within(camera, u, v, margin=2.0):
    w, h = camera["size"]
    return (u > margin) & (u < w - 1 - margin) & (v > margin) & (v < h - 1 - margin)


def draw_poses(scene, count):
    """Rotations and places of a board: tilted, all over the image."""
    draw, camera = scene.draw.of("poses"), scene.camera
    poses = []
    while len(poses) < count:
        distance = scene.distance * draw.uniform(0.85, 1.5)
        w, h = camera["size"]
        ray = np.array([*(draw.uniform(-0.32, 0.32) * side / camera[f] for side, f in ((w, "fx_px"), (h, "fy_px"))), 1])
        way, tilt = draw.uniform(-math.pi, math.pi), 0.7 * math.sqrt(draw.uniform())
        rotation = turned((math.cos(way), math.sin(way), 0), tilt) @ turned((0, 0, 1), draw.choice((0, 0, 1)) * way
                                                                           + 0.1 * draw.normal())
        there = scene.board @ rotation.T + distance * ray
        u, v = seen(camera, scene.effects, there)
        bare = as_in_air(scene.effects, there)
        radius = np.hypot(bare[:, 0], bare[:, 1]) / bare[:, 2]
        if np.sum(within(camera, u, v) & (radius < 1.1 * camera["corner"])) >= max(16, 0.4 * len(scene.board)):
            poses.append((rotation, distance * ray))
    return poses


def boards(plan):
    scene = Scene(plan, ("radial_polynomial", "tangential_distortion", "board_warp", "board_scale", "target_scatter"))
    few = (24, 32) if plan.cause == "focal_temperature" else (12, 16, 24)
    poses = draw_poses(scene, scene.draw.of("views").choice(few))
    rotations, places = (np.stack(part) for part in zip(*poses))
    times = np.arange(len(poses)) * (VIEW_S if plan.cause in ("focal_drift", "focal_temperature") else 1.0)
    warmth = warmths(plan, scene.draw.of("warmth"), len(poses))

    def pixels_of(effects):
        there = displaced(scene.board, effects, scene.draw)
        in_camera = there @ np.swapaxes(rotations, 1, 2) + places[:, None]
        turns = scene.draw.of("turns").normal(outside.of(effects, "view_motion", "turn_sigma_rad"), size=(len(poses), 3))
        focus = 1 + scene.draw.of("focus").normal(outside.of(effects, "focus_variation", "sigma"), size=(len(poses), 1))
        camera = drifted(scene.camera, effects, times[:, None], AT_C if warmth is None else warmth[:, None])
        camera |= {name: camera[name] * focus for name in ("fx_px", "fy_px")}
        return [p.ravel() for p in seen_in_motion(camera, effects, in_camera, turns)]
    scene.add_trace(pixels_of)
    pixels = pixels_of(scene.effects)
    points = np.tile(np.arange(len(scene.board)), len(poses))
    frames = np.repeat(np.arange(len(poses)), len(scene.board))
    there = displaced(scene.board, scene.effects, scene.draw) @ np.swapaxes(rotations, 1, 2) + places[:, None]
    there = as_in_air(scene.effects, there)
    radius = (np.hypot(there[..., 0], there[..., 1]) / there[..., 2]).ravel()
    inside = within(scene.camera, *pixels) & (radius < 1.1 * scene.camera["corner"])
    return scene.made("{pose: unknown}", scene.table(frames, times[frames], points, pixels, inside, warmth))


# -- a video ----------------------------------------------------------------------------------------------------------

def wave(draw, size, slow, fast):
    parts = [(size * draw.uniform(0.3, 1), draw.uniform(slow, fast), draw.uniform(0, 6)) for _ in range(3)]
    return lambda t: sum(a * np.sin(w * t + p) for a, w, p in parts)


def videos(plan):
    scene = Scene(plan, ("rolling_shutter", "tangential_distortion", "board_warp", "board_scale", "radial_polynomial"))
    draw, period = scene.draw.of("path"), 1 / 30
    angles = [wave(draw, a, 2, 5) for a in (0.2, 0.2, 0.15)]
    places = [wave(draw, 0.08 * scene.distance, 1.5, 4) for _ in range(3)]
    stamps = np.arange(draw.choice((40, 60))) * period

    def pixels_of(effects):
        there = displaced(scene.board, effects, scene.draw)
        delay = effects.get("rolling_shutter", {}).get("line_delay_s", 0)
        v = np.full((len(stamps), len(there)), 0.5 * scene.camera["size"][1])
        for _ in range(10 if delay else 1):
            t = stamps[:, None] + delay * v
            a, b, c = (turned(axis, angle(t)) for axis, angle in zip(np.eye(3), angles))
            place = np.stack([places[0](t), places[1](t), 1.2 * scene.distance + places[2](t)], -1)
            u, v = seen(drifted(scene.camera, effects, t), effects, np.einsum("tpij,pj->tpi", a @ b @ c, there) + place)
        return [u.ravel(), v.ravel()]
    scene.add_trace(pixels_of)
    pixels = pixels_of(scene.effects)
    frames = np.repeat(np.arange(len(stamps)), len(scene.board))
    points = np.tile(np.arange(len(scene.board)), len(stamps))
    inside = within(scene.camera, *pixels)
    counts = np.bincount(frames[inside], minlength=len(stamps))
    inside &= counts[frames] >= 16
    return scene.made("{pose: unknown, motion: spline}",
                      scene.table(frames, stamps[frames], points, pixels, inside))
