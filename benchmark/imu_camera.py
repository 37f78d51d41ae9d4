"""A gyroscope and a camera on one body that is turned by hand (`imus+camera_imu_offset`, `imus+camera_imu_rotation`). The body's
attitude is added up in steps of half a millisecond by quaternions, by no code of SEAM."""
import numpy as np

from draws import Draw
from sets import Free, MadeSet, rows

FINE = 0.0005  # s
GYRO_STEP, GYRO_SIGMA = 0.005, 1e-3  # s; rad/s of a sample.
VIEW_STEP, VIEW_SIGMA = 0.045, 1e-3  # s; rad about each axis.
LASTS = 25.0
EFFECTS = ("camera_imu_offset", "camera_imu_rotation")


def product(a, b):
    w, x, y, z = np.moveaxis(np.asarray(a), -1, 0)
    p, i, j, k = np.moveaxis(np.asarray(b), -1, 0)
    return np.stack([w * p - x * i - y * j - z * k, w * i + x * p + y * k - z * j, w * j - x * k + y * p + z * i,
                     w * k + x * j - y * i + z * p], axis=-1)


def turn(vector):
    """The quaternion of a turn by a vector."""
    angle = np.linalg.norm(vector, axis=-1, keepdims=True)
    return np.concatenate([np.cos(angle / 2), 0.5 * np.sinc(angle / 2 / np.pi) * vector], axis=-1)


def swing(draw):
    """The rate of a hand that turns a body to and fro, in the axes of the sensor."""
    waves = [(draw.uniform(0.15, 1.6), draw.uniform(0, 2 * np.pi), draw.uniform(0.1, 0.7, size=3), draw.uniform(0, 2 * np.pi, size=3))
             for _ in range(5)]

    def rate(t):
        return sum(size * np.sin(2 * np.pi * hz * t[:, None] + phase + phases) for hz, phase, size, phases in waves)
    return rate


def imus(plan):
    draw = Draw(plan.sort, plan.number)
    hidden, values = plan.course == "one", {}
    offset_s = of_exposure = 0.0
    # The sensor sits as it was drawn, a quarter of a turn about one axis, but for a few degrees.
    mount = np.zeros(3)
    if plan.cause == "camera_imu_offset":
        mount[draw.choice((0, 1, 2))] = np.pi / 2
        mount += draw.uniform(-0.05, 0.05, size=3)
        if hidden:
            offset_s = draw.signed(0.5e-3, 0.12)
            of_exposure = 0.5 * (plan.number // 2 % 2)
            values = {"offset_s": offset_s} | ({"of_exposure": of_exposure} if of_exposure else {})
    elif hidden:
        axis = draw.normal(size=3)
        mount = draw.signed(0.005, 2.8) * axis / np.linalg.norm(axis)
        values = dict(zip(("x_rad", "y_rad", "z_rad"), mount))
    rate = swing(draw)
    fine = np.arange(0, LASTS, FINE)
    steps = turn(FINE * rate(fine + FINE / 2))
    attitude = np.empty((len(fine) + 1, 4))
    attitude[0] = 1, 0, 0, 0
    for i, step in enumerate(steps):
        attitude[i + 1] = product(attitude[i], step)
    sampled = np.arange(0, LASTS - GYRO_STEP, GYRO_STEP)
    bias = draw.normal(size=3) * 0.01
    read = rate(sampled) + bias + GYRO_SIGMA * draw.normal(size=(len(sampled), 3))
    # Views in the sensor's time, of which the camera says another; now and then one is lost.
    seen = np.arange(0.8, LASTS - 0.8, VIEW_STEP)
    seen = seen + draw.uniform(-1e-3, 1e-3, size=len(seen))
    seen = seen[draw.uniform(size=len(seen)) > 0.03]
    exposure = 0.006 + 0.004 * np.sin(0.7 * seen + draw.uniform(0, 6)) + draw.uniform(0, 0.001, size=len(seen))
    at = np.floor(seen / FINE).astype(int)
    there = product(attitude[at], turn((seen - at * FINE)[:, None] * rate(0.5 * (seen + at * FINE))))
    there = product(product(there, turn(mount)), turn(VIEW_SIGMA * draw.normal(size=(len(seen), 3))))
    stamps = seen - offset_s - of_exposure * exposure
    tables = {
        "imu.csv": rows("time_s,wx_radps,wy_radps,wz_radps", [".6f"] + [".9g"] * 3, sampled, *read.T),
        "attitudes.csv": rows("time_s,qw,qx,qy,qz,sigma_rad,exposure_s", [".9f"] + [".9g"] * 6, stamps, *there.T,
                              np.full(len(seen), VIEW_SIGMA), exposure)}
    nominal = {"gyro_bias": {f"{axis}_radps": Free(0.0) for axis in "xyz"}}
    if plan.cause == "camera_imu_offset":
        drawn = np.abs(np.round(mount / (np.pi / 2)) * np.pi / 2)
        nominal["camera_imu_rotation"] = {f"{axis}_rad": Free(value) for axis, value in zip("xyz", drawn)}
    return MadeSet(kind="imu", settings="files: {imu: imu.csv, attitudes: attitudes.csv}\n", tables=tables, nominal=nominal,
                   hidden={plan.cause: values} if hidden else {}, noise_stated=True)
