"""Logs of servos with a motor, a load and friction (`motors`), by a solver of fourth order that stops at reversals."""
import math

import numpy as np

import outside
from draws import Draw
from servos import Swing, commands, joints_set, with_gross
from sets import Free, TRACE_SIZE, rows

STEP_S = 0.01
LENGTH = 160
INNER_S = 5e-4
GAINS = (4.0, 8.0, 16.0)
POSSIBLE = ("gravity_torque", "coulomb_friction", "load_friction", "torque_limit", "servo_latency")
STRANGE = ("torque_cogging", "warming motor")
KNOWN = ("torque_cogging",)  # Which the catalogue has by now.


class Joint:
    def __init__(self, effects):
        motor = effects["motor_servo"]
        self.stall, self.back_emf, self.gain = (motor[name] for name in ("stall_rad_per_s2", "back_emf_per_s", "gain"))
        gravity = effects.get("gravity_torque", {"rad_per_s2": 0, "level_rad": 0})
        self.gravity, self.level = gravity["rad_per_s2"], gravity["level_rad"]
        self.dry = effects.get("coulomb_friction", {}).get("rad_per_s2", 0)
        self.by_load = effects.get("load_friction", {}).get("fraction", 0)
        self.viscous = effects.get("viscous_friction", {}).get("per_s", 0)
        self.most = effects.get("torque_limit", {}).get("rad_per_s2", math.inf)
        self.cogging = effects.get("torque_cogging", {"rad_per_s2": 0, "per_turn": 0, "phase_rad": 0})
        self.warming = effects.get("warming motor", {}).get("per_s", 0)
        # By how much friction is more than its mean in motions to larger angles, and less in others.
        self.unlike = effects.get("friction_asymmetry", {}).get("rad_per_s2", 0)
        self.weaker = effects.get("motor_heating", {}).get("per_k", 0)
        self.time = self.warmer = 0.0
        self.effects = effects
        self.swing = None  # What hangs on the motor elastically.

    def pull(self, q, w, error, enabled):
        """Drive less load, and the dry friction that acts against the motion."""
        drive = 0.0
        if enabled:
            duty = max(-1.0, min(1.0, self.gain * error))
            drive = self.stall * (1 - self.warming * self.time) * duty - self.back_emf * w
            drive /= 1 + self.weaker * self.warmer  # The windings' resistance.
            drive = max(-self.most, min(self.most, drive))
        net = drive - self.gravity * math.cos(q - self.level)
        net += self.cogging["rad_per_s2"] * math.sin(self.cogging["per_turn"] * q + self.cogging["phase_rad"])
        net -= outside.load_of(self.effects, q, w)
        return net - self.viscous * w, self.dry + self.by_load * abs(net) + outside.friction_at(self.effects, q)

    def step(self, q, w, command, kp, enabled, h, sign):
        """Runge and Kutta's step of fourth order, the friction against this sign."""
        def slope(a, b):
            net, friction = self.pull(a, b, kp * (command - a), enabled)
            return net - sign * (friction + sign * self.unlike)
        a1 = slope(q, w)
        a2 = slope(q + 0.5 * h * w, w + 0.5 * h * a1)
        a3 = slope(q + 0.5 * h * (w + 0.5 * h * a1), w + 0.5 * h * a2)
        a4 = slope(q + h * (w + 0.5 * h * a2), w + h * a3)
        return q + h * w + h * h / 6 * (a1 + a2 + a3), w + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)

    def advance(self, q, w, command, kp, enabled, span):
        left = span
        while left > 1e-12:
            h = min(INNER_S, left)
            if w == 0:
                net, friction = self.pull(q, 0.0, kp * (command - q), enabled)
                if self.unlike - friction <= net <= self.unlike + friction:
                    if self.swing:
                        for _ in range(10):
                            self.swing.follow(q, q, left / 10)
                    return q, 0.0
                sign = math.copysign(1.0, net - self.unlike)
            else:
                sign = math.copysign(1.0, w)
            next_q, next_w = self.step(q, w, command, kp, enabled, h, sign)
            if w != 0 and next_w * sign < 0:
                low, high = 0.0, h  # The joint stops within this step: find when.
                for _ in range(30):
                    middle = 0.5 * (low + high)
                    moves_on = self.step(q, w, command, kp, enabled, middle, sign)[1] * sign > 0
                    low, high = (middle, high) if moves_on else (low, middle)
                h = max(high, 1e-12)
                next_q, next_w = self.step(q, w, command, kp, enabled, low, sign)[0], 0.0
            if self.swing:
                self.swing.follow(q, next_q, h)
            q, w = next_q, next_w
            left -= h
        return q, w


def moved(effects, command, kp, enabled, warmer):
    """Angles at the rows, each just before the row's command acts."""
    joint, late = Joint(effects), effects.get("servo_latency", {}).get("latency_s", 0)
    q, w, active, angles, now = command[0], 0.0, None, [], 0.0
    events = sorted([(round(k * STEP_S, 9), 0, k) for k in range(len(command))]
                    + [(round(k * STEP_S + late, 9), 2, k) for k in range(len(command))])
    gain, on = kp, enabled[0]
    if "elastic_joint" in effects:
        joint.swing = Swing(effects["elastic_joint"], q)
    for time, what, k in events:
        if active is not None and time > now:
            joint.time, joint.warmer = now, warmer[row]
            q, w = joint.advance(q, w, active, gain, on, time - now)
        now = time
        if what == 0:
            row = k
            angles.append(joint.swing.q if joint.swing else q)
        elif what == 2:
            active, on = command[k], enabled[k]  # The switch is part of the command, and as late.
    return np.array(angles)


def draw_motor(draw):
    rate = draw.log_uniform(10, 30)
    kp = GAINS[1]
    ask = draw.uniform(1.3, 3) if draw.chance(0.5) else draw.uniform(0.3, 0.8)
    gain = ask / 1.5 / kp
    motor = {"stall_rad_per_s2": rate ** 2 / (gain * kp), "back_emf_per_s": 2 * rate * draw.uniform(0.3, 0.9),
             "gain": gain}
    return motor, rate, 0.3 * rate ** 2  # The last: acceleration at 0.3 rad from the command.


def draw_cogging(draw, typical, alone):
    if alone:
        return {"rad_per_s2": typical * draw.log_uniform(0.05, 0.3), "per_turn": draw.uniform(6, 40),
                "phase_rad": draw.uniform(-3, 3)}
    return {"rad_per_s2": typical * draw.uniform(0.15, 0.3), "per_turn": draw.choice((12, 16, 20)), "phase_rad": math.pi}


def draw_effect(draw, name, motor, typical, alone=False):
    most = min(motor["stall_rad_per_s2"], 4 * typical)
    return {"gravity_torque": lambda: {"rad_per_s2": typical * draw.uniform(0.3, 0.8),
                                       "level_rad": draw.uniform(-1.5, 1.5)},
            "coulomb_friction": lambda: {"rad_per_s2": typical * draw.uniform(0.1, 0.4)},
            "load_friction": lambda: {"fraction": draw.log_uniform(0.015, 0.3) if alone else draw.uniform(0.1, 0.3)},
            "torque_limit": lambda: {"rad_per_s2": draw.uniform(0.45, 0.7) * most},
            "servo_latency": lambda: {"latency_s": draw.uniform(0.003, 0.02)},
            "torque_cogging": lambda: draw_cogging(draw, typical, alone),
            "friction_asymmetry": lambda: {"rad_per_s2": typical * draw.signed(0.03, 0.1)},
            "motor_heating": lambda: {"per_k": draw.uniform(0.003, 0.006)},
            "elastic_joint": lambda: {"period_s": draw.log_uniform(0.03, 0.25), "damping": draw.uniform(0.02, 0.25)},
            "warming motor": lambda: {"per_s": draw.uniform(0.1, 0.2)}}.get(
                name, lambda: outside.draw_of_motor(draw, name, typical))()


def temperatures(draw, runs):
    """Of a motor that warms up from run to run, as its sensor says, degrees Celsius."""
    at = np.arange(runs)[:, None] + np.arange(LENGTH) / LENGTH
    return np.round(25 + draw.uniform(20, 45) * (1 - np.exp(-2 * at / runs)), 1)


def freed(motor, draw):
    return {name: Free(value * math.exp(draw.uniform(-0.1, 0.1))) for name, value in motor.items()}


def motors(plan):
    draw = Draw(plan.sort, plan.number)
    motor, rate, typical = draw_motor(draw)
    noise = draw.uniform(0.0003, 0.001)
    runs = 6
    names = ["gravity_torque", "coulomb_friction"] if plan.course == "tie" else plan.names(draw, POSSIBLE)
    known = {} if plan.course == "tie" else {name: draw_effect(draw, name, motor, typical)
                                            for name in ("gravity_torque", "coulomb_friction") if name not in names}
    hidden = {name: draw_effect(draw, name, motor, typical, bool(plan.cause)) for name in names}
    strange = plan.strange(STRANGE)
    effects = {"motor_servo": motor} | known | hidden
    traces = {}
    if plan.course == "trace":
        traces = {"encoder_offset": {"pan_rad": draw.of("trace").signed(1, 1) * TRACE_SIZE * noise}}
    if strange:
        effects[strange] = draw_effect(draw, strange, motor, typical)
    if strange in KNOWN:
        hidden, strange = hidden | {strange: effects[strange]}, ""
    command = commands(draw.of("commands"), runs, kinds=3)
    gains = [GAINS[run % 3] for run in range(runs)]
    enabled = np.ones((runs, LENGTH), dtype=int)
    enabled[4, LENGTH // 3:LENGTH // 2] = 0  # Released: it swings freely.
    warms = plan.cause == "motor_heating"
    celsius = temperatures(draw.of("temperature"), runs) if warms else np.full((runs, LENGTH), 25.0)
    warmer = celsius - np.median(celsius)
    angles = np.stack([moved(effects, command[run], gains[run], enabled[run], warmer[run]) for run in range(runs)])
    angles = angles - traces.get("encoder_offset", {}).get("pan_rad", 0)
    measured = with_gross(draw.of("gross"), plan, angles + draw.of("noise").normal(noise, size=angles.shape))
    table = rows("run,time_s,joint,command_rad,torque_enable,kp,measured_rad" + ",temperature_c" * warms,
                 ("d", ".3f", "s", ".5f", "d", "g", ".9f") + (".1f",) * warms,
                 np.repeat(np.arange(runs), LENGTH).tolist(), np.tile(np.arange(LENGTH) * STEP_S, runs).tolist(),
                 ["joint"] * command.size, command.ravel().tolist(), enabled.ravel().tolist(),
                 np.repeat(gains, LENGTH).tolist(), measured.ravel().tolist(), *[celsius.ravel().tolist()] * warms)
    start = draw.of("nominal")
    if plan.course == "tie":
        # Not a tie but the long way: from an ideal servo, with all of the physics hidden.
        hidden = {"motor_servo": motor} | hidden
        nominal, nuisance = {"ideal_servo": {}}, {}
    else:
        nominal = {"motor_servo": freed(motor, start)} | {name: freed(values, start) for name, values in known.items()}
        nuisance = {name: {key: Free(value) for key, value in values.items()}
                    for name, values in ({"motor_servo": motor} | known).items()}
    return joints_set(table, nominal, True, noise, hidden=hidden, nuisance=nuisance, traces=traces,
                      outside=strange, unscored=[f"motor_servo.{name}" for name in motor])
