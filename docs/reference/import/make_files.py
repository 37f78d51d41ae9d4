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

# A body on two wheels, 0.3 m apart; the left one is 1 % larger than its 0.1 mm a tick. The motion capture is in millimetres.
wheels, mocap = ["time,enc_l,enc_r\n"], ["time,x,y,theta\n"]
x, y, theta, turned = 0.0, 0.0, 0.0, [0.0, 0.0]
for k in range(12000):
    t = 0.005 * k
    v, omega = 0.3 + 0.2 * math.sin(0.7 * t), 0.9 * math.sin(0.37 * t) + 0.4 * math.sin(1.3 * t)
    if k % 10 == 0:
        wheels.append(f"{t:.3f},{math.floor(turned[0])},{math.floor(turned[1])}\n")
    if k % 4 == 1:
        seen = [1000 * x + random.gauss(0, 1), 1000 * y + random.gauss(0, 1), theta + random.gauss(0, 0.002)]
        mocap.append(f"{t:.3f},{seen[0]:.3f},{seen[1]:.3f},{seen[2]:.5f}\n")
    x += 0.005 * v * math.cos(theta + 0.0025 * omega)
    y += 0.005 * v * math.sin(theta + 0.0025 * omega)
    theta += 0.005 * omega
    turned[0] += 0.005 * (v - 0.15 * omega) / 1.01e-4
    turned[1] += 0.005 * (v + 0.15 * omega) / 1e-4
pathlib.Path("wheels.csv").write_text("".join(wheels))
pathlib.Path("mocap.csv").write_text("".join(mocap))
