#!/usr/bin/env python3
"""The same corners given to SEAM, to OpenCV's calibrateCamera and to mrcal-calibrate-cameras, with the same lens model:
what each says of the camera, with its error, as a Markdown table; below it what SEAM says beyond the lens.

  scripts/camera_peers.py make FOLDER [--warp-mm X Y] [--views 16] [--seed 1]
  scripts/camera_peers.py compare SET [--lens opencv5] [--seam build/seam] [--within-px R] [--warp] [--discover]

`make` writes a points set of a board of 10 x 7 corners with the truth beside it (truth.json), by numpy alone. `compare`
takes any points set of a flat, regular board with unknown poses. --within-px leaves out corners further than this from
the image's middle; --warp lets mrcal and SEAM estimate the board's bend (OpenCV cannot). Needs Debian's python3-opencv
and mrcal; a program that is not there is left out. Root mean squares are over coordinates, by one ruler: the lens as
each program gave it, each view's pose fitted anew."""
import argparse
import csv
import json
import math
import pathlib
import shutil
import subprocess
import sys
import tempfile

import numpy as np

CAMERA = ["fx_px", "fy_px", "cx_px", "cy_px"]
# In OpenCV's order, which mrcal has as well.
LENSES = {"opencv4": ["k1", "k2", "p1", "p2"], "opencv5": ["k1", "k2", "p1", "p2", "k3"],
          "opencv8": ["k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"]}
WARP = ["x_m", "y_m"]
TRUTH = dict(fx_px=610.0, fy_px=613.0, cx_px=648.0, cy_px=392.0, k1=-0.21, k2=0.07, p1=0.0008, p2=-0.0005, k3=-0.012)
NOISE_PX = 0.2
FEWEST_CORNERS = 30  # Of a view: fewer, in a part of the image, hold no pose.


class Corners:
    """A points set: per view the corners' places on the board (column, row), their metres and their pixels."""

    def __init__(self, folder, within_px=math.inf):
        self.folder = pathlib.Path(folder)
        text = (self.folder / "measurement.yaml").read_text(encoding="utf-8")
        import yaml
        facts = yaml.safe_load(text)
        self.size = facts["camera"]["width_px"], facts["camera"]["height_px"]
        with open(self.folder / facts["files"]["points"], encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        at = {c: np.array([float(r[c]) for r in rows]) for c in ("x_m", "y_m", "z_m", "u_px", "v_px")}
        if np.ptp(at["z_m"]) > 0:
            raise SystemExit(f"{folder}: expected a flat board")
        gaps = [np.diff(np.unique(np.round(at[c], 9))) for c in ("x_m", "y_m")]
        self.spacing = min(g.min() for g in gaps)
        self.origin = at["x_m"].min(), at["y_m"].min(), at["z_m"].min()
        columns = np.rint((at["x_m"] - self.origin[0]) / self.spacing).astype(int)
        lines = np.rint((at["y_m"] - self.origin[1]) / self.spacing).astype(int)
        if max(np.abs(columns * self.spacing + self.origin[0] - at["x_m"]).max(),
               np.abs(lines * self.spacing + self.origin[1] - at["y_m"]).max()) > 1e-6:
            raise SystemExit(f"{folder}: expected a regular board")
        self.columns, self.lines = columns.max() + 1, lines.max() + 1
        middle = (self.size[0] - 1) / 2, (self.size[1] - 1) / 2
        near = np.hypot(at["u_px"] - middle[0], at["v_px"] - middle[1]) <= within_px
        frames = np.array([r["frame"] for r in rows])
        names = list(dict.fromkeys(frames))
        self.rows = [r for r, keep in zip(rows, near) if keep]
        self.views = []
        for name in names:
            here = np.flatnonzero((frames == name) & near)
            if len(here) < FEWEST_CORNERS:
                continue
            self.views.append({"name": name, "place": np.stack([columns[here], lines[here]], 1),
                               "object": np.stack([at[c][here] for c in ("x_m", "y_m", "z_m")], 1),
                               "image": np.stack([at[c][here] for c in ("u_px", "v_px")], 1)})
        kept = {view["name"] for view in self.views}
        self.rows = [r for r in self.rows if r["frame"] in kept]
        self.count = sum(len(view["image"]) for view in self.views)
        truth = self.folder / "truth.json"
        self.truth = json.loads(truth.read_text(encoding="utf-8")) if truth.exists() else {}

    def start(self):
        """What each begins with: the nominal model's camera."""
        import yaml
        nominal = yaml.safe_load((self.folder / "nominal.yaml").read_text(encoding="utf-8"))["effects"]["pinhole"]
        return [value["value"] if isinstance(value, dict) else value for value in (nominal[name] for name in CAMERA)]


def coefficients(names, values):
    return np.array([values[name] for name in names])


def ruler(corners, names, values):
    """Root mean square over coordinates, each view's pose fitted to all of its corners."""
    import cv2
    matrix = np.array([[values["fx_px"], 0, values["cx_px"]], [0, values["fy_px"], values["cy_px"]], [0, 0, 1.0]])
    lens = coefficients(names, values)
    squares = 0.0
    for view in corners.views:
        object_points = bent(corners, view["object"], values)
        _, rotation, translation = cv2.solvePnP(view["object"], view["image"], matrix, lens)
        rotation, translation = cv2.solvePnPRefineLM(object_points, view["image"], matrix, lens, rotation, translation,
                                                     (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 200, 1e-12))
        seen, _ = cv2.projectPoints(object_points, rotation, translation, matrix, lens)
        squares += ((seen[:, 0] - view["image"])**2).sum()
    return math.sqrt(squares / (2 * corners.count))


def bent(corners, points, values):
    """The board's points with its warp, as docs/reference/effects.md has it: zero at the outermost corners' frame."""
    if "x_m" not in values:
        return points
    a = 2 * (points[:, 0] - corners.origin[0]) / ((corners.columns - 1) * corners.spacing) - 1
    b = 2 * (points[:, 1] - corners.origin[1]) / ((corners.lines - 1) * corners.spacing) - 1
    return points + np.stack([0 * a, 0 * a, values["x_m"] * (1 - a * a) + values["y_m"] * (1 - b * b)], 1)


def by_opencv(corners, names):
    import cv2
    f = corners.start()
    matrix = np.array([[f[0], 0, f[2]], [0, f[1], f[3]], [0, 0, 1.0]])
    flags = cv2.CALIB_USE_INTRINSIC_GUESS | (cv2.CALIB_RATIONAL_MODEL if len(names) == 8 else 0)
    flags |= cv2.CALIB_FIX_K3 if "k3" not in names else 0
    _, matrix, lens, _, _, spreads, _, _ = cv2.calibrateCameraExtended(
        [view["object"].astype(np.float32) for view in corners.views],
        [view["image"].astype(np.float32) for view in corners.views], corners.size, matrix, np.zeros(8), flags=flags,
        criteria=(cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 300, 1e-12))
    values = dict(zip(CAMERA + names, [matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2], *lens.ravel()]))
    return values, dict(zip(CAMERA + names, spreads.ravel())), 0


def write_corners(corners, path):
    lines = ["# filename x y level"]
    for number, view in enumerate(corners.views):
        seen = {tuple(place): image for place, image in zip(view["place"], view["image"])}
        for line in range(corners.lines):
            for column in range(corners.columns):
                corner = seen.get((column, line))
                text = f"{corner[0]:.6f} {corner[1]:.6f} 0" if corner is not None else "- - -"
                lines.append(f"view{number:05d}.png {text}")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def by_mrcal(corners, names, warp):
    import mrcal
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        write_corners(corners, folder / "corners.vnl")
        focal = sum(corners.start()[:2]) / 2
        run = subprocess.run(
            ["mrcal-calibrate-cameras", "--corners-cache", str(folder / "corners.vnl"), "--lensmodel",
             f"LENSMODEL_OPENCV{len(names)}", "--focal", str(focal), "--imagersize", *map(str, corners.size),
             "--object-spacing", str(corners.spacing), "--object-width-n", str(corners.columns), "--object-height-n",
             str(corners.lines), "--outdir", name, *([] if warp else ["--skip-calobject-warp-solve"]), "view*.png"], capture_output=True, text=True)
        if run.returncode != 0:
            raise RuntimeError(f"mrcal-calibrate-cameras: {run.stderr[-300:]}")
        inputs = mrcal.cameramodel(str(folder / "camera-0.cameramodel")).optimization_inputs()
    # The covariance of all that was solved for, as mrcal's own uncertainties have it.
    solved, residuals, _, factors = mrcal.optimizer_callback(**inputs)
    measured = residuals[:mrcal.num_measurements_boards(**inputs)]
    kept = (inputs["observations_board"][..., 2] > 0).sum()
    variance = (measured**2).sum() / (2 * kept - len(solved))
    scales = np.ones(len(solved))
    mrcal.unpack_state(scales, **inputs)
    mrcal.unpack_state(solved, **inputs)
    first = mrcal.state_index_intrinsics(0, **inputs)
    wanted = list(range(first, first + 4 + len(names)))
    titles = CAMERA + names
    if warp:
        bend = mrcal.state_index_calobject_warp(**inputs)
        wanted, titles = wanted + [bend, bend + 1], titles + WARP
    units = np.eye(len(solved))[wanted]
    covariance = factors.solve_xt_JtJ_bt(units)[:, wanted] * np.outer(scales[wanted], scales[wanted]) * variance
    return (dict(zip(titles, solved[wanted])), dict(zip(titles, np.sqrt(np.maximum(0, np.diag(covariance))))),
            corners.count - kept)


def free(values):
    return "{" + ", ".join(f"{name}: {{value: {value}, free: true}}" for name, value in values.items()) + "}"


def seam_set(corners, folder):
    """The set without the corners that are left out."""
    shutil.copy(corners.folder / "measurement.yaml", folder)
    with open(folder / "points.csv", "w", encoding="utf-8", newline="") as file:
        table = csv.DictWriter(file, list(corners.rows[0]))
        table.writeheader()
        table.writerows(corners.rows)


def seam(program, *arguments):
    run = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True)
    if run.returncode != 0:
        raise RuntimeError(f"seam {arguments[0]}: {run.stderr[-300:]}")


def by_seam(corners, names, warp, program):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        seam_set(corners, folder)
        radial = [name for name in names if name[0] == "k"]
        start = dict(zip(CAMERA, corners.start()))
        effects = [f"pinhole: {free(start)}",
                   f"{'rational_lens' if 'k4' in names else 'radial_polynomial'}: {free(dict.fromkeys(radial, 0))}",
                   f"tangential_distortion: {free({'p1': 0, 'p2': 0})}"]
        effects += [f"board_warp: {free(dict.fromkeys(WARP, 0))}"] if warp else []
        (folder / "start.yaml").write_text("format: seam-model/1\nname: start\neffects:\n  " + "\n  ".join(effects) + "\n",
                                           encoding="utf-8")
        seam(program, "fit", "--model", folder / "start.yaml", "--data", folder, "--out", folder / "out.yaml", "--json",
             folder / "out.json")
        found = json.loads((folder / "out.json").read_text(encoding="utf-8"))["parameters"]
    plain = {name.split(".")[1]: value for name, value in found.items()}
    return {n: v["value"] for n, v in plain.items()}, {n: v.get("sigma", math.nan) for n, v in plain.items()}, 0


def beyond(corners, program):
    """What `seam discover` says of the set, from the nominal model."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        seam_set(corners, folder)
        seam(program, "discover", "--model", corners.folder / "nominal.yaml", "--data", folder, "--out",
             folder / "out.yaml", "--json", folder / "out.json")
        return json.loads((folder / "out.json").read_text(encoding="utf-8"))


def figure(value, sigma=None):
    if value is None:
        return "-"
    if sigma is None or not 0 < sigma < math.inf:
        return f"{value:.6g}"
    digits = max(0, 1 - math.floor(math.log10(sigma)))
    return f"{value:.{digits}f} ± {sigma:.{digits}f}"


def compare(corners, lens, program, warp=False):
    """Of each program that is there: its values, its sigmas and its error, by name."""
    names = LENSES[lens]
    answers = {}
    for title, run in (("SEAM", lambda: by_seam(corners, names, warp, program)),
                       ("OpenCV", lambda: by_opencv(corners, names)),
                       ("mrcal", lambda: by_mrcal(corners, names, warp))):
        try:
            values, sigmas, left_out = run()
            answers[title] = {"values": values, "sigmas": sigmas, "rms_px": ruler(corners, names, values),
                              "left_out": left_out}
        except (ImportError, RuntimeError) as error:
            print(f"{title} is left out: {error}", file=sys.stderr)
    return answers


def print_table(corners, lens, answers):
    truth = ["truth"] if corners.truth else []
    print(f"{corners.count} corners in {len(corners.views)} views, lens {lens}:\n")
    print("| | " + " | ".join([*truth, *answers]) + " |")
    print("|---|" + "---|" * (len(truth) + len(answers)))
    titles = CAMERA + LENSES[lens] + [n for n in WARP if any(n in a["values"] for a in answers.values())]
    for name in titles:
        cells = [figure(corners.truth.get(name, 0.0))] if truth else []
        cells += [figure(a["values"].get(name), a["sigmas"].get(name)) for a in answers.values()]
        print(f"| `{name}` | " + " | ".join(cells) + " |")
    cells = [figure(NOISE_PX)] if truth else []
    print("| RMS, px | " + " | ".join(cells + [f"{a['rms_px']:.4f}" for a in answers.values()]) + " |")
    print("| corners left out | " + " | ".join(["-"] * len(truth) + [str(a["left_out"]) for a in answers.values()]) + " |")


def print_beyond(found):
    noise = "; ".join(f"{name} {value:.3f}" for name, value in found["noise"].items())
    print(f"\n`seam discover`: {found['verdict']}, error {found['error']:.3f} (noise {noise})")
    for step in found["steps"]:
        parameters = ", ".join(f"{name} {figure(v['value'], v.get('sigma'))}" for name, v in step["parameters"].items())
        print(f"- `{step['effect']}`: {parameters}; error {step['error_before']:.3f} to {step['error_after']:.3f}")


def turned(vector):
    angle = np.linalg.norm(vector)
    axis = vector / angle
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross


def make(folder, warp_mm=(0, 0), views=16, seed=1):
    """A board of 10 x 7 corners, 30 mm apart, tilted by half a radian and more, before a lens of OpenCV's five numbers."""
    folder = pathlib.Path(folder)
    folder.mkdir()
    random = np.random.default_rng(seed)
    columns, lines, spacing = 10, 7, 0.03
    x, y = np.meshgrid(spacing * np.arange(columns), spacing * np.arange(lines))
    board = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], 1)
    a, b = 2 * board[:, 0] / board[:, 0].max() - 1, 2 * board[:, 1] / board[:, 1].max() - 1
    warp = dict(zip(WARP, (1e-3 * w for w in warp_mm)))
    shape = board + np.stack([0 * a, 0 * a, warp["x_m"] * (1 - a * a) + warp["y_m"] * (1 - b * b)], 1)
    truth, rows, view = TRUTH | warp, ["frame,time_s,point,x_m,y_m,z_m,u_px,v_px"], 0
    while view < views:
        tilt = random.uniform(-0.6, 0.6, 3)
        place = np.array([*random.uniform(-0.12, 0.12, 2), random.uniform(0.25, 0.4)])
        p = (shape - board.mean(0)) @ turned(tilt).T + place
        x, y = p[:, 0] / p[:, 2], p[:, 1] / p[:, 2]
        r2 = x * x + y * y
        radial = 1 + truth["k1"] * r2 + truth["k2"] * r2**2 + truth["k3"] * r2**3
        xd = x * radial + 2 * truth["p1"] * x * y + truth["p2"] * (r2 + 2 * x * x)
        yd = y * radial + truth["p1"] * (r2 + 2 * y * y) + 2 * truth["p2"] * x * y
        u = truth["fx_px"] * xd + truth["cx_px"] + random.normal(0, NOISE_PX, len(x))
        v = truth["fy_px"] * yd + truth["cy_px"] + random.normal(0, NOISE_PX, len(x))
        seen = (u > 0) & (u < 1279) & (v > 0) & (v < 799) & (r2 < 1.2)
        if seen.sum() < 50:
            continue
        rows += [f"{view},{view},{i},{board[i, 0]:.6f},{board[i, 1]:.6f},0,{u[i]:.4f},{v[i]:.4f}" for i in np.flatnonzero(seen)]
        view += 1
    (folder / "points.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    (folder / "measurement.yaml").write_text(
        "format: seam-measurement/1\nkind: points\ntitle: A board before a lens of known numbers\n"
        "camera: {width_px: 1280, height_px: 800}\ngroup: frame\nfiles: {points: points.csv}\nrig: {pose: unknown}\n",
        encoding="utf-8")
    (folder / "nominal.yaml").write_text(
        f"format: seam-model/1\nname: nominal\neffects:\n  pinhole: "
        f"{free({'fx_px': 600, 'fy_px': 600, 'cx_px': 639.5, 'cy_px': 399.5})}\n", encoding="utf-8")
    (folder / "truth.json").write_text(json.dumps(truth), encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    maker = commands.add_parser("make")
    maker.add_argument("folder", type=pathlib.Path)
    maker.add_argument("--warp-mm", type=float, nargs=2, default=[0, 0])
    maker.add_argument("--views", type=int, default=16)
    maker.add_argument("--seed", type=int, default=1)
    comparer = commands.add_parser("compare")
    comparer.add_argument("set", type=pathlib.Path)
    comparer.add_argument("--lens", choices=LENSES, default="opencv5")
    comparer.add_argument("--seam", default="build/seam")
    comparer.add_argument("--within-px", type=float, default=math.inf)
    comparer.add_argument("--warp", action="store_true")
    comparer.add_argument("--discover", action="store_true")
    given = parser.parse_args()
    if given.command == "make":
        make(given.folder, given.warp_mm, given.views, given.seed)
        return 0
    corners = Corners(given.set, given.within_px)
    print_table(corners, given.lens, compare(corners, given.lens, given.seam, given.warp))
    if given.discover:
        print_beyond(beyond(corners, given.seam))
    return 0


if __name__ == "__main__":
    sys.exit(main())
