"""What the tests of `seam import` share: the program, refusals, and files that several kinds read."""
import csv
import json
import pathlib
import struct
import subprocess
import sys
import tempfile
import zlib

import numpy as np

import by_hand

SEAM = by_hand.arguments("seam")
HERE = pathlib.Path(__file__).resolve().parent.parent
RNG = np.random.default_rng(18)
# A camera: fx, fy, cx, cy, and OpenCV's k1, k2, p1, p2, k3.
K = np.array([400.0, 405.0, 310.0, 236.0])
D = np.array([-0.2, 0.05, 0.001, -0.0015, 0.01])


def run(*arguments, code=0):
    done = subprocess.run([SEAM, *map(str, arguments)], capture_output=True, text=True, timeout=120)
    assert done.returncode == code, (arguments, done.returncode, done.stdout, done.stderr)
    return done.stdout + done.stderr


def imported(kind, *arguments, out):
    """Imports, checks the set; what was said and the set's folder."""
    said = run("import", kind, *arguments, "--out", out)
    assert "0 errors" in run("check", out)
    return said


def refused(kind, *arguments, out, words, code=1):
    said = run("import", kind, *arguments, "--out", out, code=code)
    for word in words:
        assert word in said, (word, said)
    assert not out.exists(), out
    assert not list(out.parent.glob(f".{out.name}*")), "left behind"


def error_of(folder):
    run("compare", "--model", folder / "nominal.yaml", "--data", folder, "--json", folder.parent / "c.json")
    return json.loads((folder.parent / "c.json").read_text())["error"]


def rows_of(path):
    return list(csv.DictReader(path.open()))


def servo_log(n=400):
    t = np.arange(n) * 0.01
    command = 0.5 * np.sin(2 * t) + 0.3 * np.sign(np.sin(3.1 * t))
    q, angles = 0.0, []
    for c in command:
        angles.append(q)
        q += (c - q) * (1 - np.exp(-0.01 / 0.05))
    return t, command, np.array(angles) + 1e-4 * RNG.standard_normal(n)


def matrix(name, array):
    """A matrix of a MAT-file of version 5."""
    array = np.atleast_2d(np.asarray(array, float))

    def element(kind, data):
        return struct.pack("<II", kind, len(data)) + data + b"\0" * (-len(data) % 8)

    inside = (element(6, struct.pack("<II", 6, 0)) + element(5, struct.pack("<ii", *array.shape)) +
              element(1, name.encode()) + element(9, array.T.tobytes()))
    return element(14, inside)


def mat_file(arrays, packed=True):
    data = b"MATLAB 5.0 MAT-file, made for a test".ljust(124) + b"\x00\x01IM"
    for name, array in arrays.items():
        one = matrix(name, array)
        if packed:
            one = zlib.compress(one)
            one = struct.pack("<II", 15, len(one)) + one
        data += one
    return data


def run_tests(tests):
    """Each function that begins with test_, or those named on the command line, in a folder of its own."""
    chosen = sys.argv[2:] or [name for name in tests if name.startswith("test_")]
    for name in chosen:
        with tempfile.TemporaryDirectory() as folder:
            tests[name](pathlib.Path(folder))
        print(name)
