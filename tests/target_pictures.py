"""Calibration targets as scenes of rectangles and discs, drawn by `seam measure`: every corner's place is known."""
import ctypes
import math

import numpy as np

# Of DICT_4X4_50, the first seventeen: rows of bits, the dark ones 0.
ARUCO_4X4 = [0xB532, 0x0F9A, 0x332D, 0x9946, 0x549E, 0x79CD, 0x9E2E, 0xC4F2, 0xFEDA, 0xCF56, 0xF991]
DARK, LIGHT = 0.05, 0.8


def tag_bits(number):
    """Of tag36h11 with its dark border, a row a list, from the library's own picture."""
    library = ctypes.CDLL("libapriltag.so.3")

    class Picture(ctypes.Structure):
        _fields_ = [("width", ctypes.c_int32), ("height", ctypes.c_int32), ("stride", ctypes.c_int32),
                    ("bytes", ctypes.POINTER(ctypes.c_uint8))]
    library.tag36h11_create.restype = ctypes.c_void_p
    library.apriltag_to_image.restype = ctypes.POINTER(Picture)
    library.apriltag_to_image.argtypes = [ctypes.c_void_p, ctypes.c_uint32]
    p = library.apriltag_to_image(library.tag36h11_create(), number).contents
    return [[p.bytes[y * p.stride + x] for x in range(1, p.width - 1)] for y in range(1, p.height - 1)]


def rectangle(x0, y0, x1, y1, z, value):
    """In the target's frame, x right and y down, which is the world seen from above."""
    return (f"  - {{shape: rectangle, centre_m: [{(x0 + x1) / 2:.9f}, {-(y0 + y1) / 2:.9f}, {z}], "
            f"size_m: [{x1 - x0:.9f}, {y1 - y0:.9f}], normal: [0, 0, 1], rgb: [{value}, {value}, {value}]}}\n")


def cells(bits, left, top, cell, z):
    """The dark cells of a square of bits, runs in a row as one rectangle."""
    text = ""
    for r, row in enumerate(bits):
        c = 0
        while c < len(row):
            end = c
            while end < len(row) and not row[end]:
                end += 1
            if end > c:
                text += rectangle(left + c * cell, top + r * cell, left + end * cell, top + (r + 1) * cell, z, DARK)
            c = max(end, c + 1)
    return text


class Chessboard:
    def __init__(self, columns, rows, pitch):
        self.size = ((columns - 1) * pitch, (rows - 1) * pitch)
        self.points = {r * columns + c: (c * pitch, r * pitch) for r in range(rows) for c in range(columns)}
        self.scene = rectangle(-2 * pitch, -2 * pitch, (columns + 1) * pitch, (rows + 1) * pitch, 0, LIGHT)
        for r in range(rows + 1):
            for c in range(columns + 1):
                if (r + c) % 2 == 0:
                    self.scene += rectangle((c - 1) * pitch, (r - 1) * pitch, c * pitch, r * pitch, 1e-5, DARK)


class Circles:
    def __init__(self, columns, rows, pitch, radius, asymmetric=False):
        place = (lambda r, c: ((2 * c + r % 2) * pitch, r * pitch)) if asymmetric else (lambda r, c: (c * pitch, r * pitch))
        self.points = {r * columns + c: place(r, c) for r in range(rows) for c in range(columns)}
        far = [max(p[k] for p in self.points.values()) for k in (0, 1)]
        self.size = tuple(far)
        self.scene = rectangle(-2 * pitch, -2 * pitch, far[0] + 2 * pitch, far[1] + 2 * pitch, 0, LIGHT)
        for x, y in self.points.values():
            self.scene += (f"  - {{shape: cylinder, base_m: [{x:.9f}, {-y:.9f}, 0], radius_m: {radius}, height_m: 1.0e-5, "
                           f"rgb: [{DARK}, {DARK}, {DARK}]}}\n")


class AprilGrid:
    """Kalibr's: numbered from the lower left, y up; here y is down and negative."""

    def __init__(self, columns, rows, tag, spacing, bits_of):
        gap, step = spacing * tag, (1 + spacing) * tag
        self.points, self.size = {}, ((columns - 1) * step + tag, (rows - 1) * step + tag)
        self.scene = rectangle(-3 * gap, -self.size[1] - 3 * gap, self.size[0] + 3 * gap, 3 * gap, 0, LIGHT)
        for r in range(2 * rows):
            for c in range(2 * columns):
                self.points[r * 2 * columns + c] = (c // 2 * step + c % 2 * tag, -(r // 2 * step + r % 2 * tag))
        for r in range(rows):
            for c in range(columns):
                self.scene += cells(bits_of(r * columns + c), c * step, -(r * step) - tag, tag / 8, 1e-5)
        for r in range(rows + 1):
            for c in range(columns + 1):
                self.scene += rectangle(c * step - gap, -(r * step), c * step, -(r * step) + gap, 1e-5, DARK)


class Charuco:
    def __init__(self, columns, rows, square, marker, first_is_dark=True):
        self.points = {r * (columns - 1) + c: ((c + 1) * square, (r + 1) * square)
                       for r in range(rows - 1) for c in range(columns - 1)}
        self.size = (columns * square, rows * square)
        self.scene = rectangle(-square, -square, self.size[0] + square, self.size[1] + square, 0, LIGHT)
        number = 0
        for r in range(rows):
            for c in range(columns):
                left, top = c * square, r * square
                if (r + c + (0 if first_is_dark else 1)) % 2 == 0:
                    self.scene += rectangle(left, top, left + square, top + square, 1e-5, DARK)
                else:
                    code = ARUCO_4X4[number]
                    bits = [[0] * 6] + [[0] + [code >> (15 - 4 * y - x) & 1 for x in range(4)] + [0] for y in range(4)] + [[0] * 6]
                    edge = (square - marker) / 2
                    self.scene += cells(bits, left + edge, top + edge, marker / 6, 1e-5)
                    number += 1


def rotation(tilt, azimuth, roll):
    """Of a camera that looks down on the world, tilted towards an azimuth: columns are its axes in the world."""
    down = np.array([[1, 0, 0], [0, -1, 0], [0, 0, -1.0]])

    def about(axis, angle):
        x, y, z = axis
        k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        return np.eye(3) + math.sin(angle) * k + (1 - math.cos(angle)) * k @ k
    return about((math.cos(azimuth), math.sin(azimuth), 0), tilt) @ down @ about((0, 0, 1), roll)


def quaternion(m):
    w = math.sqrt(max(0, 1 + m[0, 0] + m[1, 1] + m[2, 2])) / 2
    x = math.copysign(math.sqrt(max(0, 1 + m[0, 0] - m[1, 1] - m[2, 2])) / 2, m[2, 1] - m[1, 2])
    y = math.copysign(math.sqrt(max(0, 1 - m[0, 0] + m[1, 1] - m[2, 2])) / 2, m[0, 2] - m[2, 0])
    z = math.copysign(math.sqrt(max(0, 1 - m[0, 0] - m[1, 1] + m[2, 2])) / 2, m[1, 0] - m[0, 1])
    return w, x, y, z


def views(target, count, focal, width, height, fill=0.6, roll=0.3):
    """Poses that look at the target's middle from all sides, at distances where it fills the image."""
    w, h = target.size
    xs, ys = ([p[k] for p in target.points.values()] for k in (0, 1))
    middle = np.array([(min(xs) + max(xs)) / 2, -(min(ys) + max(ys)) / 2, 0])
    far = focal / fill * max(w / width, h / height)
    poses = []
    for i in range(count):
        m = rotation(0.1 + 0.45 * ((i * 0.618) % 1), 2.4 * i, roll * math.sin(1.7 * i))
        shift = np.array([0.06 * math.sin(2.1 * i) * far * width / focal, 0.06 * math.cos(1.3 * i) * far * height / focal, 0])
        poses.append((m, middle + shift - (1 + 0.15 * math.sin(i)) * far * m[:, 2]))
    return poses


def projected(target, pose, focal, width, height):
    """{point: (u, v)} of the target's points."""
    m, p = pose
    seen = {}
    for point, (x, y) in target.points.items():
        c = m.T @ (np.array([x, -y, 0]) - p)
        seen[point] = (focal * c[0] / c[2] + (width - 1) / 2, focal * c[1] / c[2] + (height - 1) / 2)
    return seen


def draw(run, target, poses, focal, width, height, folder, effects="", noise=False, seed=1):
    """Pictures folder/frames/0000.png... by `seam measure`."""
    protocol = folder.parent / f"{folder.name}-protocol"
    protocol.mkdir()
    (protocol / "measurement.yaml").write_text(
        f"format: seam-measurement/1\nkind: frames\ncamera: {{width_px: {width}, height_px: {height}, frame_period_s: 1}}\n"
        "group: frame\nscene: scene.yaml\nfiles: {frames: frames.csv}\nrig: {poses: poses.csv}\n")
    (protocol / "scene.yaml").write_text("format: seam-scene/1\nbackground_rgb: [0.3, 0.3, 0.3]\nshading: flat\nobjects:\n" +
                                         target.scene)
    (protocol / "frames.csv").write_text("frame,file,time_s\n" + "".join(
        f"{i},frames/{i:04d}.png,{i}\n" for i in range(len(poses))))
    (protocol / "poses.csv").write_text("time_s,x_m,y_m,z_m,qw,qx,qy,qz\n" + "".join(
        ",".join(f"{v:.12g}" for v in (i, *p, *quaternion(m))) + "\n" for i, (m, p) in enumerate(poses)))
    model = folder.parent / f"{folder.name}-camera.yaml"
    model.write_text(
        "format: seam-model/1\nname: truth\neffects:\n"
        f"  pinhole: {{fx_px: {focal}, fy_px: {focal}, cx_px: {(width - 1) / 2}, cy_px: {(height - 1) / 2}}}\n" + effects)
    run("measure", "--model", model, "--protocol", protocol, "--seed", seed, "--out", folder,
        *([] if noise else ["--noise", "off"]))
    return sorted((folder / "frames").glob("*.png"))
