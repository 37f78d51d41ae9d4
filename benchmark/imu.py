"""Readings of a gyroscope and an accelerometer: at rest, in attitudes, on a turntable (`imus`, always with an effect: none
is natural in all of these). Noise is made sample by sample in the time domain, by formulas of its own and no code of SEAM.

  benchmark/imu.py OUT EFFECT NUMBER    makes OUT with this effect hidden ('nothing': none), nominal.yaml inside
"""
import math
import pathlib
import sys

import numpy as np

import imu_camera
from draws import Draw
from sets import MadeSet, Plan, model_text, rows

GRAVITY = 9.80665
DT = 0.02  # s
AXES = ("x", "y", "z")
WHITE = {"gyro": 1.5e-3, "accel": 2e-2}  # Densities, unit / sqrt(Hz).
UNIT = {"gyro": "radps", "accel": "mps2"}
LETTER = {"gyro": "w", "accel": "a"}
# Units of the parameters of what both sensors have: gyroscope, accelerometer.
OF_NOISE = {"white_noise": ("radps_rthz", "mps2_rthz"), "bias_instability": ("radps", "mps2"),
            "random_walk": ("radps2_rthz", "mps3_rthz"), "quantisation": ("rad", "mps"), "vibration": ("radps", "mps2")}
OF_MEANS = {"temperature": ("radps_k", "mps2_k"), "bias": ("radps", "mps2"), "scale": ("scale", "scale"),
            "misalignment": ("rad", "rad"), "saturation": ("radps", "mps2")}
CLOCK = ("imu_clock", "imu_jitter")
EFFECTS = [*(f"{sensor}_{kind}" for sensor in WHITE for kind in OF_NOISE | OF_MEANS), "gyro_g_sensitivity", *CLOCK]
RUNS, SAMPLES_A_RUN, SAMPLES_AT_REST = 24, 1000, 90000


def split(effect):
    """The sensor of an effect, and what it is of any sensor."""
    sensor, _, kind = effect.partition("_")
    return sensor, kind


def flicker(draw, size, count):
    """1/f noise with the density size^2 / (2 pi f), by its moving average (Kasdin 1995)."""
    k = np.arange(1, count)
    weights = np.concatenate([[1.0], np.cumprod((k - 0.5) / k)])
    long = 4 * count
    drawn = np.fft.rfft(draw.normal(size=count), long)
    # Half of the length is let go: at its beginning the average is not long enough.
    return size * np.fft.irfft(drawn * np.fft.rfft(weights, long), long)[:count]


def vibration(draw, line, count):
    """A line of unit variance: an oscillator that noise drives, its deflection (skew 1) or its rate (-1), by its response
    over frequency; or a motor whose turn is a sine of even amplitude and wandering phase (0)."""
    frequency, skew = line["frequency_hz"], line["skew"]
    width = frequency / line["quality"]
    if skew == 0:
        steps = np.cumsum(math.sqrt(2 * math.pi * width * DT) * draw.normal(size=count))
        phase = draw.uniform(0, 2 * math.pi)
        return math.sqrt(2) * np.sin(phase + 2 * math.pi * frequency * DT * np.arange(count) + steps)
    # Made far longer and finer than it is read, so that it neither repeats nor ends at half of the rate.
    fine, long = 4, 2 * count
    f = np.fft.rfftfreq(fine * long, DT / fine)
    response = (1.0 if skew > 0 else 1j * f) / (frequency ** 2 + width ** 2 / 4 - f ** 2 + 1j * f * width)
    swung = np.fft.irfft(np.fft.rfft(draw.normal(size=fine * long)) * response, fine * long)
    # In units of its spread in the mean over all that may happen.
    return swung[:fine * count:fine] / math.sqrt(np.sum(np.abs(response[1:]) ** 2) * 2 / (fine * long))


def noise(draw, sizes, count):
    """Sizes: N, B, K, Q; a line."""
    out = sizes.get("white", 0) / math.sqrt(DT) * draw.normal(size=count)
    if "flicker" in sizes:
        out += flicker(draw, sizes["flicker"], 2 * count)[count:]
    if "walk" in sizes:
        out += sizes["walk"] * math.sqrt(DT) * np.cumsum(draw.normal(size=count))
    if "line" in sizes:
        out += sizes["rms"] * vibration(draw, sizes["line"], count)
    if "step" in sizes:  # What is added up is rounded, and its differences are reported.
        added = np.concatenate([[0], np.cumsum(out * DT)]) + sizes["step"] * draw.uniform()
        out = np.diff(np.round(added / sizes["step"])) * sizes["step"] / DT
    return out


def draw_effect(draw, effect):
    """Values by axis, and others by their parameters' names."""
    if effect in CLOCK:
        return {"drift_ppm": draw.signed(20, 5000)} if effect == "imu_clock" else {"sigma_s": draw.log_uniform(1e-4, 1.5e-3)}
    sensor, kind = split(effect)
    big = 1 if sensor == "gyro" else 10
    white = WHITE[sensor] / math.sqrt(DT)  # Of a sample.

    def spread(low, high):
        return {axis: draw.log_uniform(low, high) for axis in AXES}

    def signed(low, high):
        return {axis: value * draw.choice((-1, 1)) for axis, value in spread(low, high).items()}

    def line():
        frequency = draw.log_uniform(1.5, 22)
        return spread(0.2 * white, white) | {"frequency_hz": frequency, "quality": draw.log_uniform(10, 300),
                                             "skew": float(draw.choice((-1, 0, 0, 1)))}
    return {"white_noise": lambda: spread(1.2 * WHITE[sensor], 2.4 * WHITE[sensor]),
            "bias_instability": lambda: spread(4e-4 * big, 2e-3 * big),
            "random_walk": lambda: spread(6e-5 * big, 3e-4 * big),
            "quantisation": lambda: spread(4e-5 * big, 1.5e-4 * big),
            "vibration": line,
            "temperature": lambda: signed(2e-4 * big, 1e-3 * big),
            "bias": lambda: signed(5e-3 * big, 2e-2 * big),
            "scale": lambda: signed(0.004, 0.02),
            "misalignment": lambda: signed(0.004, 0.02),
            "g_sensitivity": lambda: signed(2e-4, 1e-3),
            "saturation": lambda: {"x": draw.uniform(2.2, 2.8) if sensor == "gyro" else 9.0}}[kind]()


def parameters(effect, values):
    """The values by the names that the catalogue's parameters have."""
    sensor, kind = split(effect)
    if effect in CLOCK:
        return values
    unit = "radps_mps2" if kind == "g_sensitivity" else (OF_NOISE | OF_MEANS)[kind][list(WHITE).index(sensor)]
    # yx, zx, zy are the values of x, y, z.
    names = {"misalignment": {"x": "yx", "y": "zx", "z": "zy"}, "saturation": {"x": "most"}}.get(kind, {})
    return {f"{names.get(key, key)}_{unit}" if key in AXES else key: value for key, value in values.items()}


def attitudes(draw, count):
    """Directions of gravity, all over the sphere."""
    v = draw.normal(size=(count, 3))
    v[:6] = np.concatenate([np.eye(3), -np.eye(3)]) + 0.05 * v[:6]
    return GRAVITY * v / np.linalg.norm(v, axis=1)[:, None]


def mean_of(kind, values, truth, sensor, i):
    """What an axis reports in the mean, but for warmth and the end of its range."""
    mean, value = truth[sensor][i], values.get(AXES[i], 0)
    if kind == "scale":
        return mean * (1 + value)
    if kind == "misalignment":
        x, y = truth[sensor][:2]
        return mean + (0, values["x"] * x, values["y"] * x + values["z"] * y)[i]
    if kind == "bias":
        return mean + value
    return mean + value * truth["accel"][i] if kind == "g_sensitivity" else mean


def readings(draw, effect, values, truth, sensor, temperature):
    """Readings of one sensor in a run whose true rates or forces stay the same."""
    kind = split(effect)[1] if effect.startswith(sensor) else ""
    out = np.empty((len(temperature), 3))
    for i, axis in enumerate(AXES):
        sizes, value = {"white": WHITE[sensor]}, values.get(axis, 0)
        if kind == "white_noise":
            sizes["white"] = math.hypot(WHITE[sensor], value)
        sizes |= {"bias_instability": {"flicker": value}, "random_walk": {"walk": value},
                  "quantisation": {"step": value * math.sqrt(12)}, "vibration": {"rms": value, "line": values}}.get(kind, {})
        mean = np.full(len(temperature), mean_of(kind, values, truth, sensor, i))
        if kind == "temperature":
            mean = mean + value * (temperature - 25)
        if kind == "saturation":
            mean = np.clip(mean, -values["x"], values["x"])
        out[:, i] = mean + noise(draw.of(f"{sensor} {axis}"), sizes, len(temperature))
    return out


def runs_of(draw, effect):
    """True rates and forces of each run, and how many samples it has."""
    if split(effect)[1] in (*OF_MEANS, "g_sensitivity") and not effect.endswith("temperature"):
        forces, rates = attitudes(draw, RUNS), np.zeros((RUNS, 3))
        if effect in ("gyro_scale", "gyro_misalignment", "gyro_saturation"):
            rates = draw.uniform(-3, 3, size=(RUNS, 3))
        return [({"gyro": r, "accel": f}, SAMPLES_A_RUN) for r, f in zip(rates, forces)]
    return [({"gyro": np.zeros(3), "accel": np.array([0.3, -0.2, GRAVITY])}, SAMPLES_AT_REST)]


def stamps(draw, effect, values, start, count):
    """When the host says that samples were taken, whose distance the sensor's own clock keeps."""
    t = start + DT / (1 + 1e-6 * values.get("drift_ppm", 0)) * np.arange(count)
    # A stamp may be early or late, but never so much that the next one comes before it.
    late = np.clip(values.get("sigma_s", 0) * draw.normal(size=count), -0.49 * DT, 0.49 * DT)
    return t + late if effect == "imu_jitter" else t


def imus(plan, effect=None):
    """A set with its nominal model, whose white noise is known. `effect`: what the runs are made for, hidden or not."""
    effect = effect or plan.cause
    draw = Draw(plan.sort, plan.number)
    hidden = plan.course == "one"
    values = draw_effect(draw, effect) if hidden else {}
    acting = effect if hidden else "nothing"
    columns, start = [], 0.0
    runs = runs_of(draw, effect)
    turns, knows_forces = any(truth["gyro"].any() for truth, _ in runs), effect == "accel_saturation"
    for run, (truth, count) in enumerate(runs):
        one = draw.of(f"run {run}")
        t = stamps(one, acting, values, start, count)
        warmth = 25 + 6 * (1 - np.exp(-(t - t[0]) / 600)) + 1.5 * np.sin(t / 500)
        if len(runs) > 1:
            warmth = np.full(count, one.uniform(20, 32))
        parts = [np.full((count, 1), run), t[:, None],
                 *(readings(one, acting, values, truth, sensor, warmth) for sensor in WHITE), warmth[:, None]]
        parts += [np.tile(truth["gyro"], (count, 1))] if turns else []
        parts += [np.tile(truth["accel"], (count, 1))] if knows_forces else []
        columns.append(np.hstack(parts))
        start = t[-1] + 5
    names = ["wx_radps", "wy_radps", "wz_radps", "ax_mps2", "ay_mps2", "az_mps2", "temperature_c"]
    names += [f"w{a}_true_radps" for a in AXES] if turns else []
    names += [f"a{a}_true_mps2" for a in AXES] if knows_forces else []
    table = rows("run,time_s," + ",".join(names), [".0f", ".6f"] + [".9g"] * len(names), *np.vstack(columns).T.tolist())
    # Known white noise stands in the model, or with the set where there is more of it.
    more = effect.endswith("white_noise")
    stated = ", ".join(f"{LETTER[sensor]}{a}_{UNIT[sensor]}: {WHITE[sensor] / DT ** 0.5:.9g}" for sensor in WHITE for a in AXES)
    settings = "files: {imu: imu.csv}\n" + (f"noise: {{{stated}}}\n" if more else "")
    settings += f"rate_hz: {1 / DT:g}\n" if effect in CLOCK else ""
    nominal = {} if more else {f"{sensor}_white_noise": parameters(f"{sensor}_white_noise", dict.fromkeys(AXES, density))
                               for sensor, density in WHITE.items()}
    return MadeSet(kind="imu", settings=settings, tables={"imu.csv": table}, nominal=nominal,
                   hidden={effect: parameters(effect, values)} if hidden else {}, noise_stated=True)


def write(made, out):
    """A set in a folder of its own, with its nominal model."""
    out = pathlib.Path(out)
    out.mkdir(parents=True)
    (out / "measurement.yaml").write_text(f"format: seam-measurement/1\nkind: imu\n{made.settings}")
    for name, lines in made.tables.items():
        (out / name).write_text("\n".join(lines) + "\n")
    (out / "nominal.yaml").write_text(model_text("nominal", made.nominal))


def make(out, effect, number):
    """Writes a set, and returns the true values."""
    plan = Plan(f"imus+{effect}", 2 * number + (effect != "nothing"))
    made = imu_camera.imus(plan) if effect in imu_camera.EFFECTS else imus(plan)
    write(made, out)
    return made.hidden.get(effect, {})


if __name__ == "__main__":
    print(make(sys.argv[1], sys.argv[2], int(sys.argv[3])))
