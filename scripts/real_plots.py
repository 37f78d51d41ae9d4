#!/usr/bin/env python3
"""The plots of docs/evidence/real-plaza.md and docs/evidence/real-wheels.md, from a recording and the model found.

  scripts/real_plots.py plaza real-plaza found.json docs/images
  scripts/real_plots.py wheels real-wheels found.json docs/images

Predictions are worked out here from the formulas, apart from the program, with the parameters of
the result of `seam discover --json`."""
import bisect
import csv
import json
import math
import pathlib
import sys

WIDTH, HEIGHT, LEFT, BOTTOM = 640, 300, 64, 44
COLOURS = ["#b0413e", "#2a6f97", "#5b8c5a", "#8e6c8a"]


def ticks(low, high):
    step = 10 ** math.floor(math.log10((high - low) / 3))
    step *= next(m for m in (1, 2, 5, 10) if (high - low) / (step * m) <= 6)
    return [step * i for i in range(math.ceil(low / step), math.floor(high / step) + 1)]


class Plot:
    def __init__(self, title, x_label, y_label, x_range, y_range):
        self.x_range, self.y_range = x_range, y_range
        self.parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif" '
                      f'font-size="12"><rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>'
                      f'<text x="{LEFT}" y="16" font-weight="bold">{title}</text>']
        for value in ticks(*x_range):
            x = self.x(value)
            self.parts.append(f'<path d="M{x:.1f} 26V{HEIGHT - BOTTOM}" stroke="#ddd"/>'
                              f'<text x="{x:.1f}" y="{HEIGHT - BOTTOM + 16}" text-anchor="middle">{value:g}</text>')
        for value in ticks(*y_range):
            y = self.y(value)
            self.parts.append(f'<path d="M{LEFT} {y:.1f}H{WIDTH - 10}" stroke="#ddd"/>'
                              f'<text x="{LEFT - 6}" y="{y + 4:.1f}" text-anchor="end">{value:g}</text>')
        self.parts.append(f'<text x="{WIDTH / 2}" y="{HEIGHT - 8}" text-anchor="middle">{x_label}</text>'
                          f'<text transform="translate(14 {HEIGHT / 2}) rotate(-90)" text-anchor="middle">{y_label}</text>')
        self.labels = 0

    def x(self, value):
        low, high = self.x_range
        return LEFT + (value - low) / (high - low) * (WIDTH - 10 - LEFT)

    def y(self, value):
        low, high = self.y_range
        return HEIGHT - BOTTOM - (min(max(value, low), high) - low) / (high - low) * (HEIGHT - BOTTOM - 26)

    def label(self, text, colour):
        x = LEFT + 10 + 190 * self.labels
        self.labels += 1
        self.parts.append(f'<rect x="{x}" y="30" width="12" height="4" fill="{colour}"/><text x="{x + 17}" y="36">{text}</text>')

    def points(self, xs, ys, colour, label):
        dots = "".join(f"M{self.x(x):.1f} {self.y(y):.1f}h.01" for x, y in zip(xs, ys))
        self.parts.append(f'<path d="{dots}" stroke="{colour}" stroke-width="2.4" stroke-linecap="round" opacity="0.6"/>')
        self.label(label, colour)

    def line(self, xs, ys, colour, label=None):
        way = "L".join(f"{self.x(x):.1f} {self.y(y):.1f}" for x, y in zip(xs, ys))
        self.parts.append(f'<path d="M{way}" fill="none" stroke="{colour}" stroke-width="1.3"/>')
        if label:
            self.label(label, colour)

    def write(self, path):
        path.write_text("\n".join([*self.parts, "</svg>"]) + "\n", encoding="utf-8")
        print(path)


def rows_of(path):
    with open(path, encoding="utf-8") as file:
        return list(csv.DictReader(file))


def found_values(found):
    values = {}
    for step in found["steps"]:
        for name, value in step["parameters"].items():
            values[f"{step['effect']}.{name}"] = value["value"]
    return values


def wrap(angle):
    return math.remainder(angle, 2 * math.pi)


def plaza(folder, found, out):
    values = found_values(found)
    poses = rows_of(folder / "poses.csv")
    times = [float(p["time_s"]) for p in poses]
    places = {p["landmark"]: (float(p["x_m"]), float(p["y_m"])) for p in rows_of(folder / "landmarks.csv")}
    true, error = [], []
    for row in rows_of(folder / "observations.csv"):
        t = float(row["time_s"])
        i = min(max(bisect.bisect_right(times, t) - 1, 0), len(times) - 2)
        share = (t - times[i]) / (times[i + 1] - times[i])
        x, y = (float(poses[i][c]) * (1 - share) + float(poses[i + 1][c]) * share for c in ("x_m", "y_m"))
        distance = math.dist((x, y), places[row["landmark"]])
        true.append(distance)
        error.append(float(row["range_m"]) - distance)
    after = [e - values.get("range_scale.scale", 0) * d - values.get("range_offset.offset_m", 0)
             for e, d in zip(error, true)]
    plot = Plot("Range errors of four beacons", "distance by RTK GPS, m", "range less distance, m", (0, 80), (-3, 8))
    plot.points(true[::3], error[::3], COLOURS[0], "as reported")
    plot.points(true[::3], after[::3], COLOURS[1], "with the model found")
    plot.write(out / "real_plaza_ranges.svg")
    sigma = math.sqrt(sum(a * a for a in after) / len(after))
    plot = Plot("What the model leaves", "range less prediction, m", "ranges in 0.1 m", (-2.5, 2.5), (0, 320))
    edges = [-2.5 + 0.1 * i for i in range(51)]
    counts = [0] * 50
    for a in after:
        if -2.5 <= a < 2.5:
            counts[min(49, int((a + 2.5) / 0.1))] += 1
    plot.line([e for e in edges for _ in (0, 1)][1:-1], [c for c in counts for _ in (0, 1)], COLOURS[1], "ranges")
    density = [0.1 * len(after) * math.exp(-0.5 * (e / sigma) ** 2) / sigma / math.sqrt(2 * math.pi) for e in edges]
    plot.line(edges, density, COLOURS[0], f"normal, {sigma:.2f} m")
    plot.write(out / "real_plaza_rest.svg")


def way(rows, metres_per_tick, base_m, left, right, base):
    """Position and heading of each row from the ticks, from the origin."""
    x = y = theta = 0.0
    track = [(x, y, theta)]
    for row in rows[1:]:
        a = float(row["left_ticks"]) * metres_per_tick * (1 + left)
        b = float(row["right_ticks"]) * metres_per_tick * (1 + right)
        turn = (b - a) / (base_m * (1 + base))
        chord = (a + b) / 2 * (math.sin(turn / 2) / (turn / 2) if abs(turn) > 1e-9 else 1)
        x += chord * math.cos(theta + turn / 2)
        y += chord * math.sin(theta + turn / 2)
        theta += turn
        track.append((x, y, theta))
    return track


def misses(rows, track):
    """Errors of a drive that starts as the first second's mean pose says."""
    first = [i for i, row in enumerate(rows) if float(row["time_s"]) <= 1 and row["x_m"]]
    turned = [wrap(float(rows[i]["theta_rad"]) - track[i][2] - float(rows[0]["theta_rad"])) for i in first]
    heading = float(rows[0]["theta_rad"]) + sum(turned) / len(turned)
    c, s = math.cos(heading), math.sin(heading)
    placed = [(c * x - s * y, s * x + c * y, heading + theta) for x, y, theta in track]
    dx = sum(float(rows[i]["x_m"]) - placed[i][0] for i in first) / len(first)
    dy = sum(float(rows[i]["y_m"]) - placed[i][1] for i in first) / len(first)
    out = []
    for row, (x, y, theta) in zip(rows, placed):
        if row["x_m"] and row["theta_rad"]:
            out.append((float(row["time_s"]), 1e3 * math.hypot(float(row["x_m"]) - x - dx, float(row["y_m"]) - y - dy),
                        1e3 * wrap(float(row["theta_rad"]) - theta)))
    return out


def wheels(folder, found, out):
    values = found_values(found)
    runs = {}
    for row in rows_of(folder / "odometry.csv"):
        runs.setdefault(row["run"], []).append(row)
    nominal = (84e-3 * math.pi / (43.7 * 64), 0.2)
    scales = [values.get(name, 0) for name in ("wheel_scale.left", "wheel_scale.right", "base_scale.scale")]
    place = Plot("Where ticks alone lead, six drives", "time, s", "error of the position, mm", (0, 91), (0, 45))
    turn = Plot("How they turn", "time, s", "error of the heading, mrad", (0, 91), (-80, 80))
    for number, rows in enumerate(runs.values()):
        for colour, what, factors in ((COLOURS[0], "nominal", [0, 0, 0]), (COLOURS[1], "with the model found", scales)):
            t, position, heading = zip(*misses(rows, way(rows, *nominal, *factors)))
            label = None if number else what
            place.line(t[::4], position[::4], colour, label)
            turn.line(t[::4], heading[::4], colour, label)
    place.write(out / "real_wheels_position.svg")
    turn.write(out / "real_wheels_heading.svg")


def main():
    if len(sys.argv) != 5 or sys.argv[1] not in ("plaza", "wheels"):
        print(__doc__)
        return 2
    folder, found, out = (pathlib.Path(argument) for argument in sys.argv[2:])
    {"plaza": plaza, "wheels": wheels}[sys.argv[1]](folder, json.loads(found.read_text(encoding="utf-8")), out)
    return 0


if __name__ == "__main__":
    sys.exit(main())
