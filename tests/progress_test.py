#!/usr/bin/env python3
"""At a terminal a line shows what is done, of how many; elsewhere there is none: progress_test.py SEAM."""
import os
import pathlib
import pty
import re
import select
import subprocess
import sys
import tempfile
import time

import by_hand

by_hand.arguments("seam")

ROOM = pathlib.Path(__file__).resolve().parent.parent / "docs" / "tutorial"
MOST_SILENCE_S = 5


def watched(command):
    """What the command writes to a terminal as its standard error, and the longest silence before its end, s."""
    ours, theirs = pty.openpty()
    run = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=theirs)
    os.close(theirs)
    told, longest, last = b"", 0, time.monotonic()
    while True:
        ready, _, _ = select.select([ours, run.stdout], [], [], 0.2)
        for source in ready:
            try:
                part = os.read(ours if source == ours else run.stdout.fileno(), 65536)
            except OSError:  # The other end of the terminal is closed.
                part = b""
            if source == ours and part:
                told, last = told + part, time.monotonic()
        longest = max(longest, time.monotonic() - last)
        if run.poll() is not None:
            break
    run.stdout.close()
    os.close(ours)
    assert run.returncode == 0, (command, run.returncode, told)
    return told.decode(), longest


def main():
    seam = sys.argv[1]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        subprocess.run([seam, "measure", "--model", ROOM / "slipping_robot.yaml", "--protocol", ROOM / "room", "--seed", "2",
                        "--out", folder / "slips"], check=True, capture_output=True)
        files = ["--model", ROOM / "nominal.yaml", "--data", folder / "slips"]
        commands = {
            "discover": [seam, "discover", *files, "--out", folder / "found.yaml"],
            "diagnose": [seam, "diagnose", *files, "--suggest", folder / "formula.yaml"],
        }
        for which, command in commands.items():
            told, longest = watched(command)
            assert longest < MOST_SILENCE_S, f"{which}: silent for {longest:.1f} s"
            # A line is shown each second. What is counted then, and whether time left can be estimated, depends on the
            # machine: progress_text has tests of its own.
            for line in filter(None, told.replace("\r\x1b[K", "\n").splitlines()):
                assert re.fullmatch(r"(\d+ min )?\d+ s .+ \(\d+ steps of fits\)", line), f"{which}: {line!r}"
            assert told.endswith("\r\x1b[K"), f"{which}: the last line stays: {told[-80:]!r}"
        # Each command that fits has the line, long or short as it may be.
        for which in ("compare", "add", "fit"):
            rest = {"compare": [], "add": ["--out", folder / "a.yaml"], "fit": ["--out", folder / "b.yaml"]}[which]
            told, longest = watched([seam, which, *(["rolling_shutter"] if which == "add" else []), *files, *rest])
            assert longest < MOST_SILENCE_S and told.endswith("\r\x1b[K"), (which, longest, told)
        silent = subprocess.run(commands["discover"], capture_output=True, text=True, check=True)
        assert silent.stderr == "", f"no terminal, and yet: {silent.stderr!r}"
    print("ok")


if __name__ == "__main__":
    main()
