"""Views of a board by a camera that shakes, with a gyroscope on its body (`rig: imu`): how well the read-out time is estimated.

  benchmark/shaken_views.py SEAM [--sets 20] [--first 0] [--keep FOLDER]

Views stand apart, so that no path joins them. The place of each corner is found row by row, by formulas of this file alone.
"""
import argparse
import json
import pathlib
import subprocess
import tempfile

import numpy as np

FOCAL, NOISE = 520.0, 0.2  # px
WIDTH, HEIGHT = 640, 480
GYRO_STEP, GYRO_NOISE = 0.005, 2e-3  # s; rad/s of a sample.
VIEWS, APART = 24, 0.5  # s


def rotations(vectors):
    """Rodrigues' formula, for many turn vectors."""
    angle = np.linalg.norm(vectors, axis=-1)[..., None, None]
    x, y, z = np.moveaxis(vectors, -1, 0)
    zero = np.zeros_like(x)
    cross = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1).reshape(*x.shape, 3, 3)
    return np.eye(3) + np.sinc(angle / np.pi) * cross + 0.5 * np.sinc(angle / (2 * np.pi)) ** 2 * cross @ cross


class Hand:
    """Slow turns to new poses, and shaking at 1 to 6 Hz."""

    def __init__(self, draw):
        def waves(count, low, high, rate):
            hz = draw.uniform(low, high, size=(3, count))
            return hz, rate * draw.normal(size=(3, count)) / (2 * np.pi * hz * np.sqrt(count)), draw.uniform(0, 2 * np.pi, size=(3, count))
        self.turns = [waves(2, 0.05, 0.15, 0.08), waves(4, 1, 6, 1.5)]  # rad/s
        self.shifts = [waves(2, 0.05, 0.2, 0.03), waves(3, 1, 4, 0.1)]  # m/s

    @staticmethod
    def at(waves, t):
        return sum((size * np.sin(2 * np.pi * hz * t[..., None, None] + phase)).sum(axis=-1) for hz, size, phase in waves)

    def attitude(self, t):
        return rotations(self.at(self.turns, t))

    def seen(self, t, points):
        """Points before the camera at times of their own."""
        return np.einsum("...ij,...j->...i", self.attitude(t), points + np.array([0, 0, 0.5])) + self.at(self.shifts, t)

    def rate(self, t):
        """Of the camera in its own axes."""
        h = 1e-5
        step = self.attitude(t + h) @ np.swapaxes(self.attitude(t - h), -1, -2)
        return -np.stack([step[..., 2, 1] - step[..., 1, 2], step[..., 0, 2] - step[..., 2, 0], step[..., 1, 0] - step[..., 0, 1]],
                         axis=-1) / (4 * h)


def make(folder, number):
    draw = np.random.default_rng([715, number])
    hand = Hand(draw)
    delay, offset = draw.uniform(2e-5, 7e-5) * draw.choice((-1, 1)), draw.uniform(-0.1, 0.1)  # s
    mount, bias = draw.normal(size=3), 0.02 * draw.normal(size=3)
    mount *= draw.uniform(0, 3) / np.linalg.norm(mount)
    x, y = np.meshgrid(0.035 * (np.arange(9) - 4), 0.035 * (np.arange(7) - 3))
    board = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=-1)
    rows = ["frame,time_s,point,x_m,y_m,z_m,u_px,v_px"]
    for view in range(VIEWS):
        leaning = board @ rotations(draw.uniform(-0.5, 0.5, size=3)).T  # Laid down otherwise before each view.
        v = np.full(len(board), HEIGHT / 2.0)
        for _ in range(60):
            p = hand.seen(APART * view + delay * v, leaning)
            u, v = FOCAL * p[:, 0] / p[:, 2] + (WIDTH - 1) / 2, FOCAL * p[:, 1] / p[:, 2] + (HEIGHT - 1) / 2
        u, v = u + NOISE * draw.normal(size=len(u)), v + NOISE * draw.normal(size=len(v))
        for i in np.flatnonzero((u >= 0) & (u <= WIDTH - 1) & (v >= 0) & (v <= HEIGHT - 1)):
            rows.append(f"{view},{APART * view:.3f},{i},{board[i, 0]:.6f},{board[i, 1]:.6f},0,{u[i]:.5f},{v[i]:.5f}")
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "points.csv").write_text("\n".join(rows) + "\n")
    t = np.arange(-1, VIEWS * APART + 1, GYRO_STEP)  # By the camera's clock.
    rates = hand.rate(t) @ rotations(mount).T + bias + GYRO_NOISE * draw.normal(size=(len(t), 3))
    (folder / "imu.csv").write_text("time_s,wx_radps,wy_radps,wz_radps\n" + "".join(
        f"{at:.6f},{r[0]:.7f},{r[1]:.7f},{r[2]:.7f}\n" for at, r in zip(t + offset, rates)))
    (folder / "measurement.yaml").write_text(
        f"format: seam-measurement/1\nkind: points\ncamera: {{width_px: {WIDTH}, height_px: {HEIGHT}, frame_period_s: 0.04}}\n"
        f"noise: {{u_px: {NOISE}, v_px: {NOISE}}}\ngroup: frame\nfiles: {{points: points.csv, imu: imu.csv}}\nrig: imu\n")
    free = "{{value: {}, free: true}}".format
    for name, of, away in (("known", str, 0), ("free", free, 1)):
        begun = mount + 0.03 * away * draw.uniform(-1, 1, size=3)
        (folder / f"{name}.yaml").write_text(
            "format: seam-model/1\neffects:\n"
            f"  pinhole: {{fx_px: {free(500)}, fy_px: {free(500)}, cx_px: {free(319.5)}, cy_px: {free(239.5)}}}\n"
            f"  camera_imu_offset: {{offset_s: {of(offset + 0.003 * away)}}}\n"
            f"  camera_imu_rotation: {{x_rad: {of(begun[0])}, y_rad: {of(begun[1])}, z_rad: {of(begun[2])}}}\n"
            f"  gyro_bias: {{x_radps: {bias[0]}, y_radps: {bias[1]}, z_radps: {bias[2]}}}\n")
    return delay


def read_out(seam, folder, model):
    """Value and standard error of the read-out time, and the error on held-out views."""
    out = folder / "found.json"
    run = subprocess.run([seam, "add", "rolling_shutter", "--model", folder / f"{model}.yaml", "--data", folder,
                          "--out", folder / "out.yaml", "--json", out], capture_output=True, text=True)
    if run.returncode:
        raise SystemExit(f"{folder}: {model}: {run.stdout}{run.stderr}")
    found = json.loads(out.read_text())
    delay = found["parameters"]["line_delay_s"]
    return delay["value"], delay["sigma"], found["error_after"]


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("seam")
    options.add_argument("--sets", type=int, default=20)
    options.add_argument("--first", type=int, default=0)
    options.add_argument("--keep", help="the sets are made here, and stay")
    given = options.parse_args()
    base = pathlib.Path(given.keep or tempfile.mkdtemp())
    scores = {"known": [], "free": []}
    print("set  true us/row   sensor's place known       free    (us/row, in standard errors, error on held-out views)")
    for number in range(given.first, given.first + given.sets):
        folder = base / f"shaken-{number}"
        delay = make(folder, number)
        cells = []
        for model, of in scores.items():
            value, sigma, error = read_out(given.seam, folder, model)
            of.append(((value - delay) / sigma, sigma, value - delay))
            cells.append(f"{1e6 * value:8.2f} +- {1e6 * sigma:5.2f} ({(value - delay) / sigma:4.1f}) {error:.3f}")
        print(f"{number:3}  {1e6 * delay:11.2f}  " + "  ".join(cells), flush=True)
    for model, of in scores.items():
        z, sigma, off = np.array(of).T
        print(f"{model}: rms of error over standard error {np.sqrt(np.mean(z ** 2)):.2f}, within two in {np.sum(np.abs(z) < 2)} of {len(z)}, "
              f"median standard error {1e6 * np.median(sigma):.2f} us, rms error {1e6 * np.sqrt(np.mean(off ** 2)):.2f} us")


if __name__ == "__main__":
    main()
