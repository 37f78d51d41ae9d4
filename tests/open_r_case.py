"""What tests of OPEN-R programs share: the program `seam`, and a folder of its own for each test."""
import pathlib
import subprocess
import tempfile
import unittest

import by_hand

SEAM, SOURCE = by_hand.arguments("seam", "source")
LIMIT_S = 240  # A hang is a failure.


def seam(*words, code=0):
    done = subprocess.run([SEAM, *map(str, words)], capture_output=True, text=True, timeout=LIMIT_S)
    said = done.stdout + done.stderr
    assert done.returncode == code, f"seam {' '.join(map(str, words))}: exit code {done.returncode}\n{said}"
    return said


class Case(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.here = pathlib.Path(folder.name)
