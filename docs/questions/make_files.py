#!/usr/bin/env python3
"""Small files as other programs write them: a servo's log, a calibration, corners, a path and ranges."""
import math
import pathlib
import random

random.seed(3)


def servo_log(name, tau_s, phase, shift_s=0.0):
    """A joint that follows its command with a lag; degrees and milliseconds, as firmware likes them."""
    q, held, rows = 0.0, [], []
    for k in range(300):
        t = 0.01 * k
        command = 20 * math.sin(2 * math.pi * 0.7 * t + phase) + 10 * (1 if math.sin(4 * t + phase) > 0 else -1)
        held.append(command)
        rows.append(f"{10 * k},{command:.4f},{q + random.gauss(0, 0.01):.4f},7.4\n")
        late = held[max(0, len(held) - 1 - round(shift_s / 0.01))]
        q += (late - q) * (1 - math.exp(-0.01 / tau_s))
    pathlib.Path(name).write_text("time_ms,goal,angle,supply\n" + "".join(rows))


for run in range(5):
    servo_log(f"swing{run}.csv", 0.04, 0.9 * run)

pathlib.Path("camera_info.yaml").write_text("""image_width: 640
image_height: 480
camera_name: front
camera_matrix: {rows: 3, cols: 3, data: [420.0, 0, 322.0, 0, 421.0, 238.0, 0, 0, 1]}
distortion_model: plumb_bob
distortion_coefficients: {rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}
""")

path, ranges = ["time,x,y\n"], ["time,anchor,distance\n"]
anchors = {"a": (-8.0, 2.0), "b": (9.0, -7.0), "c": (5.0, 10.0)}
for k in range(600):
    t = 0.1 * k
    x, y = 5 * math.cos(t / 8), 4 * math.sin(t / 5)
    path.append(f"{t:.2f},{x:.4f},{y:.4f}\n")
    name = "abc"[k % 3]
    distance = math.dist((x, y), anchors[name]) * 1.03 + random.gauss(0, 0.05)
    ranges.append(f"{t:.2f},{name},{distance:.4f}\n")
pathlib.Path("path.csv").write_text("".join(path))
pathlib.Path("ranges.csv").write_text("".join(ranges))
pathlib.Path("anchors.csv").write_text("id,x,y\n" + "".join(f"{n},{x},{y}\n" for n, (x, y) in anchors.items()))
