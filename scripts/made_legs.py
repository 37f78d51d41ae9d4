#!/usr/bin/env python3
"""Joints of legs whose physics is known: how often `seam discover` finds it.

    scripts/made_legs.py build/seam [--sort leg ...] [--sets 20] [--first 0] [--keep FOLDER]

A joint with a controller of its own (`kp`, `kd` of the robot, no column), a leg that hangs from it and swings without
contact, gears with friction. It is moved by a solver that shares nothing with SEAM's. Counts are those of
made_servos.py.
"""
import math
import random
import sys

from made_robots import write_set
from made_servos import deviations, search_all

# Seconds between rows, length of a run in seconds, runs.
SORTS = {
    "leg": {"dt": 0.005, "length": 4, "runs": 6},
    "fast": {"dt": 0.001, "length": 3, "runs": 6},
    # Its makers' numbers are given: gains, limit, an inertia without that of the rotor behind its gears.
    "given": {"dt": 0.005, "length": 4, "runs": 6, "given": True},
}


class Joint:
    """Newton metres over kg m^2."""

    def __init__(self, draw):
        self.inertia = math.exp(draw.uniform(math.log(0.03), math.log(0.3)))
        self.link_share = draw.uniform(0.6, 0.9)  # Of the inertia; the rotor has the rest.
        rate = math.exp(draw.uniform(math.log(10), math.log(30)))
        self.kp = self.inertia * rate ** 2
        self.kd = 2 * draw.uniform(0.15, 0.7) * rate * self.inertia
        self.most = self.kp * (draw.uniform(0.25, 0.6) if draw.random() < 0.4 else 4)  # Torque.
        typical = 0.3 * self.kp
        self.weight = typical * draw.uniform(0.1, 0.6)
        self.hangs_at = draw.uniform(-0.8, 0.8)
        self.viscous = self.kd * (draw.uniform(0.1, 0.4) if draw.random() < 0.6 else 0)
        kinds = draw.choice((("dry",), ("load",), ("dry", "load")))
        self.dry = typical * draw.uniform(0.05, 0.25) if "dry" in kinds else 0
        self.by_load = draw.uniform(0.06, 0.25) if "load" in kinds else 0

    def torques(self, q, w, command):
        drive = max(-self.most, min(self.most, self.kp * (command - q) - self.kd * w))
        net = drive - self.weight * math.sin(q - self.hangs_at)
        return net - self.viscous * w, self.dry + self.by_load * abs(net)

    def moved(self, q, w, command, h, sign):
        """Runge and Kutta's step with dry friction against this sign."""
        def slope(q, w):
            torque, friction = self.torques(q, w, command)
            return w, (torque - sign * friction) / self.inertia
        a = slope(q, w)
        b = slope(q + 0.5 * h * a[0], w + 0.5 * h * a[1])
        c = slope(q + 0.5 * h * b[0], w + 0.5 * h * b[1])
        d = slope(q + h * c[0], w + h * c[1])
        return (q + h / 6 * (a[0] + 2 * b[0] + 2 * c[0] + d[0]), w + h / 6 * (a[1] + 2 * b[1] + 2 * c[1] + d[1]))

    def advance(self, q, w, command, span):
        """Moves for a time in short steps; one that would turn back ends where the joint stops."""
        left, longest = span, 2.5e-4
        while left > 1e-12:
            h = min(longest, left)
            if w == 0:
                torque, friction = self.torques(q, 0, command)
                if abs(torque) <= friction:
                    return q, 0.0  # Held until the next command.
                sign = math.copysign(1, torque)
            else:
                sign = math.copysign(1, w)
            to = self.moved(q, w, command, h, sign)
            if w != 0 and to[1] * sign < 0:
                low, high = 0.0, h
                for _ in range(50):
                    middle = 0.5 * (low + high)
                    if self.moved(q, w, command, middle, sign)[1] * sign > 0:
                        low = middle
                    else:
                        high = middle
                q, w, h = self.moved(q, w, command, low, sign)[0], 0.0, low
            else:
                q, w = to
            left -= max(h, 1e-12)
        return q, w

    def effects(self, given):
        """Without releases viscous friction is back-EMF by another name, but that friction by load feels the one alone;
        and a controller's own damping that is given is no unknown. One that is not, of a motor without back-EMF whose
        torque is cut off, is back-EMF behind a limit of torque by another name: the search tells it so."""
        j = self.inertia
        effects = {"motor_servo": {"stall_rad_per_s2": self.most / j, "back_emf_per_s": 0,
                                   "gain": self.kp / self.most, "damping_s": self.kd / self.most},
                   "gravity_torque": {"rad_per_s2": self.weight / j, "level_rad": self.hangs_at + math.pi / 2}}
        cut_off = not given and self.most < self.kp and (self.by_load or not self.viscous)
        if cut_off:
            strong = 100 * self.kp / j  # Never reached.
            effects["motor_servo"] = {"stall_rad_per_s2": strong, "back_emf_per_s": self.kd / j, "gain": 0.01}
            effects["torque_limit"] = {"rad_per_s2": self.most / j}
        if self.viscous and (given or self.by_load):
            effects["viscous_friction"] = {"per_s": self.viscous / j}
        elif not cut_off:
            effects["motor_servo"]["back_emf_per_s"] = self.viscous / j
        if self.dry:
            effects["coulomb_friction"] = {"rad_per_s2": self.dry / j}
        if self.by_load:
            effects["load_friction"] = {"fraction": self.by_load}
        return effects


def commands(draw, kind):
    """A trajectory of one run: steps, a swing that grows faster, slow ramps, or several swings."""
    ends = [draw.uniform(-0.8, 0.8) for _ in range(8)]
    if kind == 0:
        return lambda t: ends[int(1.6 * t) % 8]
    if kind == 1:
        return lambda t: ends[0] * math.sin((2 + 2 * t) * t) + 0.4 * ends[1] * math.sin(9 * t)
    if kind == 2:
        return lambda t: ends[int(t)] + (ends[int(t) + 1] - ends[int(t)]) * (t % 1)
    return lambda t: sum(0.5 * end * math.sin((1.5 + 2.3 * k) * t) for k, end in enumerate(ends[:4]))


def rows_of(joint, name, form, draw, noise, first_run=0):
    rows, count = [], round(form["length"] / form["dt"])
    for run in range(form["runs"]):
        way = commands(draw, run % 4)
        q, w = way(0), 0.0
        for k in range(count):
            t = k * form["dt"]
            # A policy speaks 50 times a second.
            command = round(way(math.floor(t * 50 + 1e-9) / 50), 5)
            rows.append(f"{first_run + run},{t:.3f},{name},{command},{q + draw.gauss(0, noise):.6f}")
            q, w = joint.advance(q, w, command, form["dt"])
    return rows


def make(_, sort, number, folder):
    draw, form = random.Random(f"{sort} {number}"), SORTS[sort]
    joint = Joint(draw)
    noise = draw.choice((1e-4, 3e-4))
    rows = rows_of(joint, "knee", form, draw, noise)
    truth = joint.effects("given" in form)
    motor = truth["motor_servo"]
    nominal = "ideal_servo: {}"
    if "given" in form:
        stall = motor["stall_rad_per_s2"] / joint.link_share
        nominal = (f"motor_servo: {{stall_rad_per_s2: {{value: {stall:.6g}, free: true}}, back_emf_per_s: "
                   f"{{value: 0, free: true}}, gain: {motor['gain']:.9g}, damping_s: {motor['damping_s']:.9g}}}")
        del truth["motor_servo"]
    stated = f"noise: {{measured_rad: {noise}}}\n" if draw.random() < 0.5 else ""
    write_set(folder, {"joints.csv": ["run,time_s,joint,command_rad,measured_rad", *rows]},
              f"kind: joints\ntitle: made\ngroup: run\n{stated}files: {{joints: joints.csv}}\n", [nominal])
    return truth


def deviations_of_leg(truth, values):
    if "motor_servo" in truth:
        return deviations(truth, values)
    named = [(name, *name.split(".")) for name in values]
    return [(name, (values[name][0] - truth[effect][parameter]) / values[name][1]) for name, effect, parameter in named
            if values[name][1] and parameter in truth.get(effect, {})]


if __name__ == "__main__":
    sys.exit(search_all(__doc__.splitlines()[0], SORTS, make, deviations_of_leg))
