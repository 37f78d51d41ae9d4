"""Readings of a gyroscope and an accelerometer: at rest, in attitudes, on a turntable. Noise is made sample by sample in
the time domain, by formulas of its own and no code of SEAM.

  benchmark/imu.py OUT EFFECT NUMBER    makes OUT with this effect hidden ('nothing': none), nominal.yaml inside
"""
import pathlib
import sys

import numpy as np

GRAVITY = 9.80665
AXES = ("x", "y", "z")
WHITE = {"gyro": 1.5e-3, "accel": 2e-2}  # Densities, unit / sqrt(Hz).
UNIT = {"gyro": "radps", "accel": "mps2"}


def flicker(rng, size, count):
    """1/f noise with the density size^2 / (2 pi f), by its moving average (Kasdin 1995)."""
    weights = np.empty(count)
    weights[0] = 1
    for k in range(1, count):
        weights[k] = weights[k - 1] * (k - 0.5) / k
    long = 4 * count
    drawn = np.fft.rfft(rng.normal(size=count), long)
    # Half of the length is let go: at its beginning the average is not long enough.
    return size * np.fft.irfft(drawn * np.fft.rfft(weights, long), long)[:count]


def noise(rng, sizes, count, dt):
    """Sizes: N, B, K, Q."""
    out = sizes.get("white", 0) / np.sqrt(dt) * rng.normal(size=count)
    if "flicker" in sizes:
        out += flicker(rng, sizes["flicker"], 2 * count)[count:]
    if "walk" in sizes:
        out += sizes["walk"] * np.sqrt(dt) * np.cumsum(rng.normal(size=count))
    if "step" in sizes:  # What is added up is rounded, and its differences are reported.
        added = np.concatenate([[0], np.cumsum(out * dt)]) + sizes["step"] * rng.uniform()
        out = np.diff(np.round(added / sizes["step"])) * sizes["step"] / dt
    return out


def draw(rng, effect):
    """Values of an effect's parameters by axis, and of what makes them."""
    sensor = effect.split("_")[0]
    big = 1 if sensor == "gyro" else 10
    spread = lambda low, high: {axis: float(np.exp(rng.uniform(np.log(low), np.log(high)))) for axis in AXES}
    signed = lambda low, high: {axis: v * rng.choice((-1, 1)) for axis, v in spread(low, high).items()}
    kind = effect[len(sensor) + 1:]
    return {"white_noise": lambda: spread(1.5 * WHITE[sensor], 4 * WHITE[sensor]),
            "bias_instability": lambda: spread(4e-4 * big, 2e-3 * big),
            "random_walk": lambda: spread(6e-5 * big, 3e-4 * big),
            "quantisation": lambda: spread(6e-5 * big, 3e-4 * big),
            "temperature": lambda: signed(2e-4 * big, 1e-3 * big),
            "bias": lambda: signed(5e-3 * big, 2e-2 * big),
            "scale": lambda: signed(0.004, 0.02),
            "misalignment": lambda: signed(0.004, 0.02),
            "g_sensitivity": lambda: signed(2e-4, 1e-3),
            "saturation": lambda: {"x": float(rng.uniform(2.2, 2.8)) if sensor == "gyro" else 9.0}}[kind]()


def attitudes(rng, count):
    """Directions of gravity, all over the sphere."""
    v = rng.normal(size=(count, 3))
    v[:6] = np.concatenate([np.eye(3), -np.eye(3)]) + 0.05 * v[:6]
    return GRAVITY * v / np.linalg.norm(v, axis=1)[:, None]


def readings(rng, effect, values, truth, sensor, temperature, dt):
    """Readings of one sensor in a run whose true rates or forces stay the same."""
    count = len(temperature)
    out = np.empty((count, 3))
    kind = effect[len(sensor) + 1:] if effect.startswith(sensor) else ""
    for i, axis in enumerate(AXES):
        sizes = {"white": WHITE[sensor]}
        value = values.get(axis, 0)
        if kind == "white_noise":
            sizes["white"] = np.hypot(WHITE[sensor], value)
        for name, key in (("bias_instability", "flicker"), ("random_walk", "walk")):
            if kind == name:
                sizes[key] = value
        if kind == "quantisation":
            sizes["step"] = value * np.sqrt(12)
        mean = truth[sensor][i]
        if kind == "scale":
            mean = mean * (1 + value)
        if kind == "misalignment" and i > 0:  # yx, zx, zy are the values of x, y, z.
            mean = mean + (values["x"] * truth[sensor][0] if i == 1 else
                           values["y"] * truth[sensor][0] + values["z"] * truth[sensor][1])
        if kind == "bias":
            mean = mean + value
        if kind == "g_sensitivity":
            mean = mean + value * truth["accel"][i]
        mean = np.full(count, mean)
        if kind == "temperature":
            mean = mean + value * (temperature - 25)
        if kind == "saturation":
            mean = np.clip(mean, -values["x"], values["x"])
        out[:, i] = mean + noise(rng, sizes, count, dt)
    return out


def runs_of(rng, effect):
    """True rates and forces of each run, and how many samples it has."""
    kind = effect.split("_", 1)[1] if "_" in effect else effect
    if kind in ("scale", "misalignment", "bias", "g_sensitivity", "saturation"):
        forces = attitudes(rng, 24)
        rates = np.zeros((24, 3))
        if effect in ("gyro_scale", "gyro_misalignment", "gyro_saturation"):
            rates = rng.uniform(-3, 3, size=(24, 3))
        return [({"gyro": r, "accel": f}, 1000) for r, f in zip(rates, forces)]
    return [({"gyro": np.zeros(3), "accel": np.array([0.3, -0.2, GRAVITY])}, 90000)]


def make(out, effect, number):
    """A set with its nominal model, whose white noise is known: what is hidden is beside it. Returns the true values."""
    rng = np.random.default_rng([48, number, sum(map(ord, effect))])
    dt = 0.02
    values = {} if effect == "nothing" else draw(rng, effect)
    runs = runs_of(rng, effect)
    knows_forces = effect == "accel_saturation"
    out = pathlib.Path(out)
    out.mkdir(parents=True)
    names = ["wx_radps", "wy_radps", "wz_radps", "ax_mps2", "ay_mps2", "az_mps2", "temperature_c"]
    turns = any(truth["gyro"].any() for truth, _ in runs)
    names += [f"w{a}_true_radps" for a in AXES] if turns else []
    names += [f"a{a}_true_mps2" for a in AXES] if knows_forces else []
    with (out / "imu.csv").open("w") as file:
        file.write("run,time_s," + ",".join(names) + "\n")
        start = 0.0
        for run, (truth, count) in enumerate(runs):
            t = start + dt * np.arange(count)
            warmth = 25 + 6 * (1 - np.exp(-(t - t[0]) / 600)) + 1.5 * np.sin(t / 500)
            if len(runs) > 1:
                warmth = np.full(count, rng.uniform(20, 32))
            columns = [readings(rng, effect, values, truth, sensor, warmth, dt) for sensor in ("gyro", "accel")]
            columns.append(warmth[:, None])
            if turns:
                columns.append(np.tile(truth["gyro"], (count, 1)))
            if knows_forces:
                columns.append(np.tile(truth["accel"], (count, 1)))
            for at, row in zip(t, np.hstack(columns)):
                file.write(f"{run},{at:.3f}," + ",".join(f"{v:.9g}" for v in row) + "\n")
            start = t[-1] + 5
    # Known white noise stands in the model, or with the set where there is more of it.
    more = effect.endswith("white_noise")
    columns = [(sensor, f"{'w' if sensor == 'gyro' else 'a'}{a}_{UNIT[sensor]}") for sensor in WHITE for a in AXES]
    stated = ", ".join(f"{name}: {WHITE[sensor] / dt ** 0.5:.9g}" for sensor, name in columns)
    (out / "measurement.yaml").write_text("format: seam-measurement/1\nkind: imu\nfiles: {imu: imu.csv}\n"
                                          + (f"noise: {{{stated}}}\n" if more else ""))
    lines = ["format: seam-model/1", "name: nominal", "effects:" + (" {}" if more else "")]
    for sensor, density in WHITE.items():
        white = ", ".join(f"{a}_{UNIT[sensor]}_rthz: {density:g}" for a in AXES)
        lines += [] if more else [f"  {sensor}_white_noise: {{{white}}}"]
    (out / "nominal.yaml").write_text("\n".join(lines) + "\n")
    return values


if __name__ == "__main__":
    print(make(sys.argv[1], sys.argv[2], int(sys.argv[3])))
