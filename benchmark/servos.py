"""Logs of servos that follow commands by kinematic rules (`servos`): lag, limits, play, sag, encoders."""
import math

import numpy as np

import outside
from draws import Draw
from sets import MadeSet, TRACE_SIZE, noise_line, rows

NOISE_RAD = 0.0005
STEP_S = 0.01
LENGTH = 160
# At most one of each line: effects of one line answer alike to most commands.
FAMILIES = (("servo_lag", "servo_latency"), ("speed_limit",), ("stiction", "backlash"),
            ("gravity_sag", "encoder_scale"), ("encoder_quantisation",), ("joint_wander",))
STRANGE = ("gear_ripple", "slow drift")
KNOWN = ("gear_ripple",)  # Which the catalogue has by now.


def commands(draw, runs, kinds=4):
    """Angles of command, one row a run: steps, a swing that grows faster, slow ramps, small moves."""
    t = np.arange(LENGTH) * STEP_S
    table = np.empty((runs, LENGTH))
    for run in range(runs):
        ends = [draw.uniform(-1.1, 1.1) for _ in range(8)]
        block = np.minimum((6 * t / t[-1]).astype(int), 5)
        if run % kinds == 0:
            table[run] = np.take(ends, block)
        elif run % kinds == 1:
            table[run] = ends[0] * np.sin((2 + 3 * t) * t) + 0.4 * ends[1] * np.sin(11 * t)
        elif run % kinds == 2:
            table[run] = np.interp(t, np.linspace(0, t[-1], 5), ends[:5])
        else:
            table[run] = 0.6 * ends[0] + np.take([0.03 * end for end in ends], (30 * t / t[-1]).astype(int) % 7)
        table[run, :3] = table[run, 0]
    return np.round(table, 5)


def settled(q, command, dt, lag, limit, band):
    """The angle after a time under a command that holds, in closed form."""
    left = command - q
    if abs(left) <= band * (1 + 1e-9) + 1e-15:
        return q
    if lag == 0 and not math.isfinite(limit):
        return command  # An ideal servo jumps; only nearer commands leave it where it is.
    if math.isfinite(limit) and abs(left) > limit * lag:
        edge = max(limit * lag, band)
        span = (abs(left) - edge) / limit
        if span >= dt:
            return q + math.copysign(limit * dt, left)
        left, dt = math.copysign(edge, left), dt - span
    if lag == 0 or (band and lag * math.log(max(1.0, abs(left) / band)) <= dt):
        return command - math.copysign(band, left)
    return command - left * math.exp(-dt / lag)


class Swing:
    """A load that hangs on the drive by a spring and a damper, by Runge and Kutta's steps of fourth order."""

    def __init__(self, effect, at):
        self.rate, self.damping = 2 * math.pi / effect["period_s"], effect["damping"]
        self.q, self.w = at, 0.0

    def follow(self, start, end, h):
        """While the drive goes evenly."""
        speed = (end - start) / h

        def pull(t, q, w):
            return self.rate ** 2 * (start + speed * t - q) + 2 * self.damping * self.rate * (speed - w)
        q, w = self.q, self.w
        a1 = pull(0, q, w)
        a2 = pull(h / 2, q + h / 2 * w, w + h / 2 * a1)
        a3 = pull(h / 2, q + h / 2 * (w + h / 2 * a1), w + h / 2 * a2)
        a4 = pull(h, q + h * (w + h / 2 * a2), w + h * a3)
        self.q, self.w = q + h * w + h * h / 6 * (a1 + a2 + a3), w + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)

    def jump(self, by):
        """The drive is elsewhere at once; the damper passes that on."""
        self.w += 2 * self.damping * self.rate * by


def swung(effects, command, inner_s=2.5e-4):
    """Angles at the rows of a load that swings behind the drive."""
    lag = effects.get("servo_lag", {}).get("tau_s", 0)
    limit = effects.get("speed_limit", {}).get("rad_per_s", math.inf)
    q, load, angles = command[0], Swing(effects["elastic_joint"], command[0]), []
    for asked in command:
        angles.append(load.q)
        at_once = settled(q, asked, 0.0, lag, limit, 0)
        load.jump(at_once - q)
        q = at_once
        for _ in range(round(STEP_S / inner_s)):
            after = settled(q, asked, inner_s, lag, limit, 0)
            load.follow(q, after, inner_s)
            q = after
    return np.array(angles)


def moved(effects, command):
    """Angles at the rows, of the joint itself, each just before its row's command acts."""
    if "elastic_joint" in effects:
        return swung(effects, command)
    lag = effects.get("servo_lag", {}).get("tau_s", 0)
    limit = effects.get("speed_limit", {}).get("rad_per_s", math.inf)
    band = effects.get("stiction", {}).get("dead_band_rad", 0)
    late = effects.get("servo_latency", {}).get("latency_s", 0)
    play = 0.5 * effects.get("backlash", {}).get("width_rad", 0)
    angles = []
    q = load = active = command[0]
    # What happens: rows are read, then commands act that were given `late` ago; of one instant the reading is first.
    events = sorted([(round(k * STEP_S, 9), 0, k) for k in range(len(command))]
                    + [(round(k * STEP_S + late, 9), 1, k) for k in range(len(command))])
    now = 0.0
    for time, acts, k in events:
        q = settled(q, active, time - now, lag, limit, band)
        load = min(max(load, q - play), q + play)
        now = time
        if acts:
            active = command[k]
        else:
            angles.append(load)
    return np.array(angles)


def logged(effects, q, t, celsius=0.0):
    """What the encoder says of angles, a row a run, without noise."""
    beside = outside.said_beside(effects, q, t, celsius)
    sag = effects.get("gravity_sag", {})
    q = q - sag.get("rad", 0) * np.cos(q - sag.get("level_rad", 0))
    q = q - effects.get("encoder_offset", {}).get("pan_rad", 0)
    q = q / (1 + effects.get("encoder_scale", {}).get("pan_scale", 0))
    wave, drift = effects.get("gear_ripple", {}), effects.get("slow drift", {})
    repeats = wave.get("amplitude_rad", 0) * np.sin(wave.get("per_turn", 0) * q + wave.get("phase_rad", 0))
    return q + beside + repeats + drift.get("rad_per_s", 0) * t


def draw_effect(draw, name, noise, wide=False):
    return {"servo_lag": lambda: {"tau_s": draw.log_uniform(0.01, 0.08)},
            "servo_latency": lambda: {"latency_s": draw.uniform(0.004, 0.04)},
            "speed_limit": lambda: {"rad_per_s": draw.uniform(1.5, 5)},
            "stiction": lambda: {"dead_band_rad": draw.uniform(4, 15) * noise},
            "backlash": lambda: {"width_rad": draw.uniform(6, 25) * noise},
            "gravity_sag": lambda: {"rad": draw.uniform(8, 40) * noise, "level_rad": 0.0},
            "encoder_scale": lambda: {"pan_scale": draw.signed(0.004, 0.03)},
            "encoder_offset": lambda: {"pan_rad": draw.signed(4, 20) * noise},
            "encoder_quantisation": lambda: {"step_rad": draw.choice((2 * math.pi / 4096, math.radians(300) / 1024))},
            "joint_wander": lambda: {"sigma_rad": draw.uniform(2, 6) * noise, "tau_s": draw.uniform(0.1, 0.5)},
            "gear_ripple": lambda: {"amplitude_rad": draw.uniform(*((1, 10) if wide else (4, 10))) * noise,
                                    "per_turn": draw.log_uniform(4, 100) if wide else draw.choice((6, 8, 10)),
                                    "phase_rad": draw.uniform(-3, 3)},
            "elastic_joint": lambda: {"period_s": draw.log_uniform(0.03, 0.25), "damping": draw.uniform(0.02, 0.25)},
            "slow drift": lambda: {"rad_per_s": draw.signed(6, 15) * noise / (LENGTH * STEP_S)}}.get(
                name, lambda: outside.draw_of_servo(draw, name, noise))()


def joints_set(table, nominal, stated, noise, **more):
    settings = "group: run\n" + noise_line(stated, measured_rad=noise) + "files: {joints: joints.csv}\n"
    return MadeSet(kind="joints", settings=settings, tables={"joints.csv": table}, nominal=nominal,
                   noise_stated=stated, **more)


def with_gross(draw, plan, angles):
    """Samples of another time, as bits lost on a bus make them."""
    wrong = draw.uniform(size=angles.shape) < plan.gross
    return angles + wrong * np.sign(draw.normal(size=angles.shape)) * draw.uniform(0.05, 1.0, size=angles.shape)


def tied_commands(draw, runs):
    """Large steps to and fro: a dead band and play end them alike."""
    table = np.empty((runs, LENGTH))
    for run in range(runs):
        size = [draw.uniform(0.3, 1.0) * (1 if k % 2 else -1) for k in range(8)]
        table[run] = np.take(size, np.arange(LENGTH) // 20)
    return np.round(table, 5)


def servos(plan):
    draw = Draw(plan.sort, plan.number)
    runs, noise = draw.choice((5, 6)), NOISE_RAD * draw.uniform(0.5, 2)
    command = (tied_commands if plan.course == "tie" else commands)(draw.of("commands"), runs)
    nominal = {"ideal_servo": {}}
    if plan.cause == "elastic_joint":
        drive = draw.of("drive")
        rule = drive.choice(("", "servo_lag", "speed_limit"))
        nominal |= {rule: draw_effect(drive, rule, noise)} if rule else {}
    if plan.course == "tie":
        # A servo of known speed ends a dead band before its command, as play does.
        names, nominal = ["stiction"], nominal | {"speed_limit": {"rad_per_s": 25.0}}
    else:
        families = draw.sample(FAMILIES[:4] if plan.course in ("trace", "gross") else FAMILIES, plan.count)
        names = [draw.choice(family) for family in families]
        if plan.cause:
            names = plan.names(draw, ())
    stated = draw.chance(0.6) or bool({"encoder_quantisation", "joint_wander"} & set(names))
    hidden = {name: draw_effect(draw, name, noise, bool(plan.cause)) for name in names}
    strange = plan.strange(STRANGE)
    outside = {strange: draw_effect(draw, strange, noise)} if strange else {}
    effects = nominal | hidden | outside
    if strange in KNOWN:
        hidden, strange = hidden | outside, ""
    times = np.arange(LENGTH) * STEP_S
    angles = np.stack([moved(effects, row) for row in command])
    traces = {}
    if plan.course == "trace":
        traces = {"encoder_offset": {"pan_rad": draw.of("trace").signed(1, 1) * TRACE_SIZE * noise}}
    warms = strange == "warm mount"
    # Up by 20 K in all runs together, as a sensor says.
    celsius = np.round(20 * (1 - np.exp(-2 * np.linspace(0, 1, angles.size))), 1).reshape(angles.shape)
    clean = logged(effects | traces, angles, times, celsius)
    if "joint_wander" in effects:
        wander = effects["joint_wander"]
        clean = clean + np.stack([draw.of(f"wander {run}").wander(times, wander["sigma_rad"], wander["tau_s"])
                                  for run in range(runs)])
    measured = clean + draw.of("noise").normal(noise, size=clean.shape)
    step = effects.get("encoder_quantisation", {}).get("step_rad", 0)
    measured = with_gross(draw.of("gross"), plan, np.rint(measured / step) * step if step else measured)
    table = rows("run,time_s,joint,command_rad,measured_rad" + ",temperature_c" * warms,
                 ("d", ".3f", "s", ".5f", ".9f") + (".1f",) * warms,
                 np.repeat(np.arange(runs), LENGTH).tolist(), np.tile(times, runs).tolist(), ["joint"] * command.size,
                 command.ravel().tolist(), measured.ravel().tolist(), *[(25 + celsius).ravel().tolist()] * warms)
    ties = {"stiction": ["backlash"]} if plan.course == "tie" else {}
    return joints_set(table, nominal, stated, noise, hidden=hidden, traces=traces, outside=strange,
                      ties=ties, unscored=["gravity_sag.level_rad"])
