#!/usr/bin/env python3
"""What the recipes begin with, made without SEAM: corners.npz of a lens with OpenCV's k1 = -0.21, k2 = 0.07, and servo.csv
of a servo that acts 24 ms late and follows with a lag of 60 ms."""
import csv
import math

import numpy as np


def rotation(rx, ry, rz):
    def turn(axis, angle):
        c, s = math.cos(angle), math.sin(angle)
        i, j = [(1, 2), (2, 0), (0, 1)][axis]
        m = np.eye(3)
        m[i, i], m[i, j], m[j, i], m[j, j] = c, -s, s, c
        return m
    return turn(2, rz) @ turn(1, ry) @ turn(0, rx)


def corners(random):
    pattern, square_m, size = (9, 6), 0.025, (640, 480)
    camera = np.array([[520, 0, 322], [0, 521, 238], [0, 0, 1]])
    board = np.array([(c * square_m, r * square_m, 0) for r in range(pattern[1]) for c in range(pattern[0])])
    found = []
    while len(found) < 20:
        angles = random.uniform((-0.5, -0.5, -0.3), (0.5, 0.5, 0.3))
        place = random.uniform((-0.16, -0.13, 0.22), (0.16, 0.13, 0.45))
        p = (board - board.mean(axis=0)) @ rotation(*angles).T + place
        xy = p[:, :2] / p[:, 2:]
        r2 = (xy ** 2).sum(axis=1, keepdims=True)
        uv = xy * (1 - 0.21 * r2 + 0.07 * r2 ** 2) * (520, 521) + (322, 238)
        if (uv > 0).all() and (uv < np.array(size) - 1).all():
            found.append(uv + random.normal(0, 0.1, uv.shape))
    found.append(np.full_like(found[0], np.nan))  # An image without the board.
    guess = camera * [[1.02, 1, 0.99], [1, 1.02, 1.01], [1, 1, 1]]
    np.savez("corners.npz", corners=np.array(found), pattern=pattern, square_m=square_m, image_size=size,
             camera_matrix=guess)


def servo(random):
    step_s, latency_s, tau_s, resolution_deg = 0.01, 0.024, 0.06, 0.088
    q, goal, commands, next_s = 0.0, 0.0, [(-1, 0.0)], 1.0
    with open("servo.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["time_s", "goal_deg", "present_deg", "volts"])
        for k in range(3000):
            t = k * step_s
            seen = round((q + random.normal(0, 0.05)) / resolution_deg) * resolution_deg
            if t >= next_s:  # A new goal, which acts later.
                goal = float(random.uniform(-60, 60))
                commands.append((t + latency_s, goal))
                next_s = t + float(random.uniform(0.2, 1.6))
            writer.writerow([f"{t:.3f}", f"{goal:.3f}", f"{seen:.3f}", f"{random.normal(11.9, 0.02):.2f}"])
            # Exactly over the step: the goal may change within it.
            at = t
            for begin, end in zip(commands, commands[1:] + [(math.inf, 0)]):
                until = min(end[0], t + step_s)
                if until > max(at, begin[0]):
                    q = begin[1] + (q - begin[1]) * math.exp(-(until - max(at, begin[0])) / tau_s)
                    at = until


if __name__ == "__main__":
    corners(np.random.default_rng(7))
    servo(np.random.default_rng(8))
