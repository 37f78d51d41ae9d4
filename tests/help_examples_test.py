#!/usr/bin/env python3
"""Every example in the help of every subcommand runs as it stands there.

Usage: help_examples_test.py SEAM SOURCE_DIR [--first] [COMMAND...]
  --first     only the first example of each command: a journey through the whole program in few seconds
  COMMAND...  only examples of these commands

Each runs in a shell in a scratch folder of its own that holds the files which examples name, made here.
What serves for ever is started, looked at and stopped.
"""
import argparse
import math
import os
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

import by_hand

SEAM, SOURCE = by_hand.arguments("seam", "source")
LIMIT_S = 200  # For builds without optimisation; the longest takes seconds.
SERVES = {"serve": "listening", "view": "http://", "workbench": "http://"}  # What they print when they are there.
WITHOUT_EXAMPLE = {"experiment", "open-r", "replay"}  # Their subcommands have some.
EXIT_CODES = {"seam replay recover": 3}  # Something was lost, as the help says.
# The paper's experiments take minutes; tests/experiments_test.py runs them in this very form.
RUN_ELSEWHERE = {"seam experiment ball-distance --quick", "seam experiment localization --quick",
                 "seam experiment head-swing-bias --quick"}
FITTED = """format: seam-model/1
name: better
effects:
  pinhole: {fx_px: 161.9, fy_px: 162.5, cx_px: 88.5, cy_px: 71.5}
  rolling_shutter: {line_delay_s: {value: 2.0e-4, sigma: 1.0e-5}}
history:
  - {effect: rolling_shutter, parameters: {line_delay_s: {value: 2.0e-4, sigma: 1.0e-5}}, data: A room,
     data_fingerprint: "0", error_before: 9.5, error_after: 1.0}
"""


def examples_of(text):
    """The example lines of a help text: after `Example:` in a line, or below `Examples:`."""
    lines = re.sub(r"\\\n\s*", "", text).splitlines()
    found = []
    for i, line in enumerate(lines):
        start = re.search(r"\bExamples?:\s*(.*)$", line)
        if not start:
            continue
        if start[1]:
            found.append(start[1].strip())
        for below in lines[i + 1:]:
            if not below.startswith(" "):
                break
            found.append(below.strip())
    return found


def all_examples(page):
    """Lists of example lines by command, from `seam help --markdown`."""
    by_command = {}
    for title, text in re.findall(r"^## `seam (.*?)`\n\n```text\n(.*?)^```", page, re.M | re.S):
        by_command[title] = examples_of(text)
    return by_command


class Scratch:
    """Files that examples name, made once and copied for each command."""

    def __init__(self, folder):
        self.folder = folder
        folder.mkdir()
        self.environment = dict(os.environ, PATH=f"{SEAM.parent}:{os.environ['PATH']}")
        (folder / "scenarios").symlink_to(SOURCE / "scenarios")
        (folder / "models").symlink_to(SOURCE / "models")
        (folder / "open_r").symlink_to(SOURCE / "open_r")
        shutil.copy(SOURCE / "docs/tutorial/nominal.yaml", folder)
        shutil.copy(SOURCE / "docs/tutorial/robot.yaml", folder / "truth.yaml")
        for name in ("better.yaml", "found.yaml"):
            (folder / name).write_text(FITTED)
        self.run(["seam", "measure", "--model", "truth.yaml", "--protocol", self.small_room(), "--seed", "1", "--out", "sets/points-a"])
        shutil.copy(SOURCE / "docs/tutorial/nominal.yaml", folder / "sets/points-a")
        shutil.copy(SOURCE / "replays/match.mcap", folder / "match.mcap")
        shutil.copy(SOURCE / "replays/corpus/corrupted.mcap", folder / "damaged.mcap")
        swing = ["seam", "run", "scenarios/head_swing.yaml"]
        self.run([*swing, "--log", "swing.mcap", "--frames", "rolling"])
        shutil.copytree(folder / "rolling", folder / "instantaneous")
        for name in ("monday.mcap", "today.mcap"):
            shutil.copy(folder / "swing.mcap", folder / name)
        sweep = ["seam", "sweep", "scenarios/sweep.yaml", "--out"]
        for part in ("1", "2", "3"):
            self.run([*sweep, f"part{part}.sqlite", "--shard", f"{part}/3"])
        self.run(["seam", "sweep", "merge", "part1.sqlite", "part2.sqlite", "part3.sqlite", "--out", "results.sqlite"])
        angles = [20 * math.sin(0.1 * k) for k in range(50)]
        (folder / "log.csv").write_text("time_s,goal,angle\n" + "".join(
            f"{0.01 * k:.2f},{angles[k]:.3f},{angles[max(0, k - 3)]:.3f}\n" for k in range(50)))
        log = (folder / "swing.mcap").read_bytes()
        (folder / "killed.mcap").write_bytes(log[:len(log) * 2 // 3])

    def small_room(self):
        """The tutorial's room with a third of its frames."""
        room = self.folder / "sets" / "room"
        shutil.copytree(SOURCE / "docs/tutorial/room", room)
        lines = (room / "points.csv").read_text().splitlines(keepends=True)
        (room / "points.csv").write_text("".join(lines[:1 + len(lines) // 3]))
        return "sets/room"

    def run(self, command):
        done = subprocess.run(command, cwd=self.folder, env=self.environment, capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"to prepare: {' '.join(command)}: exit code {done.returncode}\n{done.stdout}{done.stderr}")

    def copy_to(self, folder):
        shutil.copytree(self.folder, folder, symlinks=True)


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def serve_a_while(line, word, folder, environment):
    """Starts what serves for ever, waits for its word, and stops it as a user does. None, or what went wrong."""
    output = folder / "served.txt"
    with output.open("w") as file:
        server = subprocess.Popen(["bash", "-c", "exec " + line if "&&" not in line else line.replace("&& seam", "&& exec seam")],
                                  cwd=folder, env=environment, stdout=file, stderr=subprocess.STDOUT)
    end = time.monotonic() + 30
    while word not in output.read_text() and server.poll() is None and time.monotonic() < end:
        time.sleep(0.05)
    text = output.read_text()
    if server.poll() is None:
        server.send_signal(signal.SIGINT)
        try:
            server.wait(30)
        except subprocess.TimeoutExpired:
            server.kill()
            return f"does not stop:\n{text}"
    return None if word in text else f"exit code {server.returncode}, expected '{word}' in\n{text}"


def run_example(command, line, folder, environment):
    """None, or what went wrong."""
    # Ports and sockets that other tests may use, and folders outside the scratch.
    line = line.replace("7210", str(free_port())).replace("unix:/tmp/", f"unix:{folder}/")
    if command in SERVES:
        if command == "view":
            line += f" --port {free_port()}"
        return serve_a_while(line, SERVES[command], folder, environment)
    done = subprocess.run(["bash", "-c", line], cwd=folder, env=environment, capture_output=True, text=True, timeout=LIMIT_S)
    expected = next((code for start, code in EXIT_CODES.items() if line.startswith(start)), 0)
    if done.returncode != expected:
        return f"exit code {done.returncode}, expected {expected}\n{done.stdout}{done.stderr}"
    return None


def main():
    page = subprocess.run([SEAM, "help", "--markdown"], capture_output=True, text=True, check=True).stdout
    examples = all_examples(page)
    failures = [f"seam {command}: its help has no example" for command, lines in examples.items()
                if not lines and command not in WITHOUT_EXAMPLE]
    given = argparse.ArgumentParser()
    given.add_argument("--first", action="store_true")
    given.add_argument("commands", nargs="*")
    given = given.parse_args(sys.argv[3:])
    chosen = {command: examples[command] for command in given.commands or examples}
    count = 0
    with tempfile.TemporaryDirectory(prefix="seam-help-") as name:
        material = Scratch(pathlib.Path(name) / "material")
        for command, lines in chosen.items():
            folder = pathlib.Path(name) / command.replace(" ", "-")
            material.copy_to(folder)
            lines = [line for line in lines if line not in RUN_ELSEWHERE]
            # One after the other: the later ones may use what the earlier made.
            for line in lines[:1] if given.first else lines:
                count += 1
                started = time.monotonic()
                wrong = run_example(command, line, folder, material.environment)
                print(f"{time.monotonic() - started:6.2f} s  {line}", flush=True)
                if wrong:
                    failures.append(f"seam {command}: {line}\n{wrong}")
            shutil.rmtree(folder)
    used = os.times()
    print(f"{count} examples run, {used.children_user + used.children_system:.0f} s of processor time")
    return "\n".join(failures) if failures else 0


if __name__ == "__main__":
    sys.exit(main())
