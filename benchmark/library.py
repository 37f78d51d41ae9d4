"""Sets as linear problems, for baselines: residuals of the nominal model, and columns of a library of known terms.

A column is the change of the predictions by one effect of the catalogue, linear in its size about the nominal model.
Effects that change a spread have no column, nor have motors: differences of angles are too noisy for accelerations.
"""
import csv
import dataclasses
import math
import pathlib
import re

import numpy as np

import boards

FAR = 6.0  # Residuals beyond so many robust deviations are left out.


@dataclasses.dataclass
class Problem:
    y: np.ndarray  # In units of the noise where it is stated, else of the scatter that is left with all columns.
    nuisance: np.ndarray
    terms: list  # (effect, alternatives, parameters, columns)
    fields: dict  # What residuals may depend on, for smooth functions.
    stated: bool


def table(path):
    with open(path, newline="") as file:
        lines = list(csv.DictReader(file))
    out = {}
    for name in lines[0]:
        try:
            out[name] = np.array([float(line[name]) for line in lines])
        except ValueError:
            out[name] = np.array([line[name] for line in lines])
    return out


def stated_noise(folder):
    line = re.search(r"^noise: \{(.*)\}$", (folder / "measurement.yaml").read_text(), re.M)
    return {k: float(v) for k, v in re.findall(r"(\w+): ([\d.e+-]+)", line[1])} if line else {}


def nominal_values(folder, effect):
    """Of a line such as `  pinhole: {fx_px: {value: 5, free: true}, cy_px: 3}`."""
    line = re.search(rf"^  {effect}: \{{(.*)\}}$", (folder / "nominal.yaml").read_text(), re.M)
    return {k: float(v) for k, v in re.findall(r"(\w+): (?:\{value: )?(-?[\d.e+-]+)", line[1])} if line else None


def problem_of(channels, nuisance, terms, fields, noise):
    """Channels (name, residuals) one after the other; columns have the residuals' unit and are scaled with them."""
    y = np.concatenate([values for _, values in channels])
    parts, at = [], 0
    whole = np.concatenate([nuisance] + [columns for *_, columns in terms], axis=1)
    left = y - whole @ np.linalg.lstsq(whole, y, rcond=None)[0]
    keep = np.ones(len(y), dtype=bool)
    scale = np.empty(len(y))
    for name, values in channels:
        part = slice(at, at + len(values))
        robust = 1.4826 * np.median(np.abs(left[part] - np.median(left[part]))) + 1e-15
        keep[part] = np.abs(left[part]) < FAR * robust
        scale[part] = noise.get(name, robust)
        parts.append(part)
        at += len(values)
    weighed = [(effect, others, names, (columns / scale[:, None])[keep]) for effect, others, names, columns in terms]
    return Problem((y / scale)[keep], (nuisance / scale[:, None])[keep], weighed,
                   {name: values[keep] for name, values in fields.items()}, bool(noise))


def differences(function, names, steps):
    """Columns by small steps from neutral."""
    base = function({})
    return np.stack([(function({name: step}) - base) / step for name, step in zip(names, steps)], -1)


# -- boards with unknown poses ----------------------------------------------------------------------------------------

def start_pose(points, x, y):
    """By the homography of a plane, of normalised image coordinates."""
    X, Y, one, zero = points[:, 0], points[:, 1], np.ones(len(x)), np.zeros((len(x), 3))
    p = np.stack([X, Y, one], -1)
    rows_of = np.concatenate([np.concatenate([p, zero, -x[:, None] * p], 1),
                              np.concatenate([zero, p, -y[:, None] * p], 1)])
    size = np.abs(p).max(0)
    h = np.linalg.svd(rows_of / np.tile(size, 3))[2][-1].reshape(3, 3) / size
    h = h / np.sqrt(np.linalg.norm(h[:, 0]) * np.linalg.norm(h[:, 1])) * np.sign(h[2, 2])
    u, _, vt = np.linalg.svd(np.stack([h[:, 0], h[:, 1], np.cross(h[:, 0], h[:, 1])], -1))
    return u @ np.diag([1, 1, np.linalg.det(u @ vt)]) @ vt, h[:, 2]


class Views:
    """A board before a camera: poses by small turns about the current ones, and the camera's numbers."""

    def __init__(self, folder):
        data = table(folder / "points.csv")
        self.points = np.stack([data[name] for name in ("x_m", "y_m", "z_m")], -1)
        self.seen = np.stack([data["u_px"], data["v_px"]], -1)
        _, self.view = np.unique(data["frame"], return_inverse=True)
        self.camera = nominal_values(folder, "pinhole")
        self.lens = nominal_values(folder, "radial_polynomial")
        self.rotations, self.places = [], []
        for view in range(self.view.max() + 1):
            some = self.view == view
            x, y = ((self.seen[some] - (self.camera["cx_px"], self.camera["cy_px"]))
                    / (self.camera["fx_px"], self.camera["fy_px"])).T
            rotation, place = start_pose(self.points[some], x, y)
            self.rotations.append(rotation)
            self.places.append(place)
        self.rotations, self.places = np.stack(self.rotations), np.stack(self.places)

    def pixels(self, camera={}, effects={}, board=None, turn=None, shift=None):
        board = self.points if board is None else board
        p = np.einsum("nij,nj->ni", self.rotations[self.view], board)
        if turn is not None:
            p = p + np.cross(turn, p)
        p = p + self.places[self.view] + (0 if shift is None else shift)
        lens = {"radial_polynomial": self.lens} if self.lens else {}
        full = {name: self.camera[name] + camera.get(name, 0) for name in self.camera}
        merged = {name: {key: lens.get(name, {}).get(key, 0) + effects.get(name, {}).get(key, 0)
                         for key in {**lens.get(name, {}), **effects.get(name, {})}} for name in {**lens, **effects}}
        return np.concatenate(boards.seen(full, merged, p))

    def columns(self):
        """Of the poses, one block a view, and of the camera with the lens that is free."""
        base = self.pixels()
        poses = np.zeros((len(base), 6 * len(self.places)))
        for k in range(6):
            step = np.zeros(3)
            step[k % 3] = 1e-6
            column = (self.pixels(turn=step) if k < 3 else self.pixels(shift=step)) - base
            poses[np.arange(len(base)), 6 * np.tile(self.view, 2) + k] = column / 1e-6
        camera = [(self.pixels(camera={name: 1e-3}) - base) / 1e-3 for name in self.camera]
        if self.lens:
            camera += [(self.pixels(effects={"radial_polynomial": {name: 1e-6}}) - base) / 1e-6 for name in self.lens]
        return np.concatenate([poses, np.stack(camera, -1)], 1)

    def fit(self, rounds=12):
        """Gauss's and Newton's steps, rows that are far off left out."""
        for _ in range(rounds):
            columns, left = self.columns(), np.concatenate(self.seen.T) - self.pixels()
            robust = 1.4826 * np.median(np.abs(left)) + 1e-9
            keep = (np.abs(left) < FAR * robust).astype(float)
            a = columns * keep[:, None]
            h = a.T @ a
            h[np.diag_indices_from(h)] *= 1 + 1e-9
            step = np.linalg.solve(h, a.T @ (left * keep))
            count = 6 * len(self.places)
            for view in range(len(self.places)):
                w = step[6 * view:6 * view + 3]
                angle = np.linalg.norm(w)
                self.rotations[view] = boards.turned(w / max(angle, 1e-15), angle) @ self.rotations[view]
                self.places[view] += step[6 * view + 3:6 * view + 6]
            for name, change in zip(self.camera, step[count:]):
                self.camera[name] += change
            for name, change in zip(self.lens or (), step[count + 4:]):
                self.lens[name] += change
            if np.max(np.abs(step[count:count + 4])) < 1e-4:
                break
        return np.concatenate(self.seen.T) - self.pixels()


def of_boards(folder):
    views = Views(folder)
    left = views.fit()
    half = len(views.seen)
    terms = []
    for effect, names in (("radial_polynomial", ("k1", "k2", "k3")), ("tangential_distortion", ("p1", "p2"))):
        if effect != "radial_polynomial" or not views.lens:
            terms.append((effect, [], names, differences(lambda given: views.pixels(effects={effect: given}), names,
                                                         [1e-6] * len(names))))
    extent = np.abs(views.points[:, :2]).max(0)

    def warped(given):
        a, b = views.points[:, 0] / extent[0], views.points[:, 1] / extent[1]
        board = views.points.copy()
        board[:, 2] += given.get("x_m", 0) * (1 - a * a) + given.get("y_m", 0) * (1 - b * b)
        return views.pixels(board=board)

    def scaled(given):
        board = views.points.copy()
        board[:, 0] += given.get("x_scale", 0) * views.points[:, 0] + given.get("shear", 0) * views.points[:, 1]
        return views.pixels(board=board)
    terms.append(("board_warp", [], ("x_m", "y_m"), differences(warped, ("x_m", "y_m"), [1e-6] * 2)))
    terms.append(("board_scale", [], ("x_scale", "shear"), differences(scaled, ("x_scale", "shear"), [1e-6] * 2)))
    # A read-out time: how each point moves from view to view, by its row.
    if "spline" in (folder / "measurement.yaml").read_text():
        terms.append(("rolling_shutter", [], ("line_delay_s",), by_row(views)[:, None]))
    fields = {"u": np.tile(views.seen[:, 0], 2), "v": np.tile(views.seen[:, 1], 2),
              "x": np.tile(views.points[:, 0], 2), "y": np.tile(views.points[:, 1], 2),
              "channel": np.repeat((0.0, 1.0), half)}
    return problem_of([("u_px", left[:half]), ("v_px", left[half:])], views.columns(), terms, fields,
                      stated_noise(folder))


def by_row(views):
    """Pixels by which each row's image moves for a second of read-out a row."""
    count, period = len(views.places), 1 / 30
    later, before = (np.clip(np.arange(count) + k, 0, count - 1) for k in (1, -1))
    span = (later - before)[:, None] * period
    between = views.rotations[later] @ np.swapaxes(views.rotations[before], 1, 2)
    rate = 0.5 * np.stack([between[:, 2, 1] - between[:, 1, 2], between[:, 0, 2] - between[:, 2, 0],
                           between[:, 1, 0] - between[:, 0, 1]], -1) / span
    speed = (views.places[later] - views.places[before]) / span
    moved = views.pixels(turn=1e-5 * rate[views.view], shift=1e-5 * speed[views.view]) - views.pixels()
    return moved / 1e-5 * np.tile(views.seen[:, 1], 2)
