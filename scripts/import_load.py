#!/usr/bin/env python3
"""Much to import, for measuring time and memory: scripts/import_load.py pictures FOLDER COUNT, or bag FILE.mcap MEGABYTES.

`pictures`: a chessboard of 9 x 6 corners, 30 mm apart, before a camera of 1280 x 800 pixels, with noise of 2 grey levels.
`bag`: the same pictures as Image messages, a chunk each, beside JointState and commands at 100 Hz.
Needs Debian's python3-opencv."""
import math
import pathlib
import struct
import sys
import zlib

import cv2
import numpy as np

WIDTH, HEIGHT, FOCAL = 1280, 800, 1000.0
COLUMNS, LINES, SPACING = 9, 6, 0.03


def texture():
    """The board with a white border of a square, 80 pixels a square."""
    size = 80
    squares = np.add.outer(np.arange(LINES + 1), np.arange(COLUMNS + 1)) % 2 * 180 + 40
    squares = np.pad(squares, 1, constant_values=220)
    return np.kron(squares, np.ones((size, size))).astype(np.uint8), size


def picture(number, board, size):
    random = np.random.default_rng(number)
    tilt = random.uniform(-0.5, 0.5, 3)
    rotation, _ = cv2.Rodrigues(tilt)
    place = np.array([*random.uniform(-0.06, 0.06, 2), random.uniform(0.35, 0.6)])
    # From the texture's pixels to metres about the board's middle, to the image; twice as fine, then averaged.
    metres = SPACING / size
    middle = np.array([(COLUMNS + 3) / 2, (LINES + 3) / 2]) * SPACING
    to_board = np.array([[metres, 0, metres / 2 - middle[0]], [0, metres, metres / 2 - middle[1]], [0, 0, 1]])
    camera = np.array([[2 * FOCAL, 0, WIDTH - 0.5], [0, 2 * FOCAL, HEIGHT - 0.5], [0, 0, 1]])
    map_ = camera @ np.stack([rotation[:, 0], rotation[:, 1], place], 1) @ to_board
    fine = cv2.warpPerspective(board, map_, (2 * WIDTH, 2 * HEIGHT), flags=cv2.INTER_LINEAR, borderValue=120)
    seen = cv2.resize(fine, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA)
    return np.clip(seen + random.normal(0, 2, seen.shape), 0, 255).astype(np.uint8)


def pictures(folder, count):
    folder.mkdir()
    board, size = texture()
    for number in range(count):
        cv2.imwrite(str(folder / f"{number:05d}.png"), picture(number, board, size), [cv2.IMWRITE_PNG_COMPRESSION, 1])


class Message:
    """CDR, little-endian."""

    def __init__(self, t):
        self.data = b"\0\1\0\0"
        self.put("I", int(t), round(t % 1 * 1e9)).text("map")

    def put(self, form, *values):
        for value in values:
            size = struct.calcsize("<" + form)
            self.data += b"\0" * (-(len(self.data) - 4) % size) + struct.pack("<" + form, value)
        return self

    def text(self, text):
        self.put("I", len(text) + 1).data += text.encode() + b"\0"
        return self

    def reals(self, *values):
        return self.put("I", len(values)).put("d", *values)


def record(op, data):
    return bytes([op]) + struct.pack("<Q", len(data)) + data


def text(value):
    return struct.pack("<I", len(value)) + value.encode()


def bag(path, megabytes):
    board, size = texture()
    shown = [picture(number, board, size).tobytes() for number in range(16)]
    topics = [("/camera/image_raw", "sensor_msgs/msg/Image"), ("/joint_states", "sensor_msgs/msg/JointState"),
              ("/commands", "sensor_msgs/msg/JointState")]
    with open(path, "wb") as file:
        file.write(b"\x89MCAP0\r\n" + record(1, text("ros2") + text("test")))
        for i, (topic, kind) in enumerate(topics):
            file.write(record(3, struct.pack("<H", i + 1) + text(kind) + text("ros2msg") + text("")))
            file.write(record(4, struct.pack("<HH", i, i + 1) + text(topic) + text("cdr") + struct.pack("<I", 0)))
        number = 0
        while file.tell() < megabytes * 1e6:
            t = 100 + 0.04 * number
            inside = b""

            def message(channel, t, data):
                ns = round(t * 1e9)
                return record(5, struct.pack("<HIQQ", channel, 0, ns, ns) + data)
            frame = Message(t).put("I", HEIGHT, WIDTH).text("mono8").put("B", 0).put("I", WIDTH, WIDTH * HEIGHT).data
            inside += message(0, t, frame + shown[number % len(shown)])
            for k in range(4):
                at = t + 0.01 * k
                command = math.sin(3 * at)
                for channel, angle in ((2, command), (1, math.sin(3 * (at - 0.05)))):
                    state = Message(at).put("I", 1).text("arm").reals(angle).put("I", 0, 0).data
                    inside += message(channel, at + 0.001 * (channel == 1), state)
            span = struct.pack("<QQQI", round(t * 1e9), round((t + 0.04) * 1e9), len(inside), zlib.crc32(inside))
            file.write(record(6, span + text("") + struct.pack("<Q", len(inside)) + inside))
            number += 1
        file.write(record(15, struct.pack("<I", 0)) + record(2, struct.pack("<QQI", 0, 0, 0)) + b"\x89MCAP0\r\n")
    print(f"{number} pictures")


def main():
    if len(sys.argv) != 4 or sys.argv[1] not in ("pictures", "bag"):
        print(__doc__)
        return 2
    {"pictures": pictures, "bag": bag}[sys.argv[1]](pathlib.Path(sys.argv[2]), int(sys.argv[3]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
