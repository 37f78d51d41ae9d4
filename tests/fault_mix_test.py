#!/usr/bin/env python3
"""Ten simulated minutes under a mix of all faults, again and again: the run ends by its policy, and what it left verifies.

Each run draws from its seed: clients that die, hang, go on and lie; connections that are silent, speak nonsense or are too
many; signals; a disk that fills up; few descriptors; little memory. Allowed ends: the scenario's end (0), a stop that a
signal asked for (0), an abort that the policy for silent clients asked for (1), an error that names the resource that ran
out (1), and, where memory is limited, the death of the process by its own abort, since libraries below us end it so.
Whatever the end, `seam replay verify` must say of the log that it is the same as its re-run, as far as it goes.

SEAM_FAULT_MIXES=100 makes a hundred runs of ten simulated minutes; without it there are a few short ones.
SEAM_FAULT_SEED starts elsewhere.

Usage: fault_mix_test.py BUILD_DIR SOURCE_DIR PYTHON (PYTHON has gRPC, or is empty: then nobody lies)
"""
import collections
import os
import pathlib
import random
import re
import resource
import signal
import socket
import subprocess
import sys
import tempfile
import time

import by_hand

BUILD, SOURCE, PYTHON = by_hand.arguments("build", "source", "python")
PYTHON = PYTHON if PYTHON and (BUILD / "python").exists() else ""
SEAM = BUILD / "seam"
MIXES = int(os.environ.get("SEAM_FAULT_MIXES", "0"))
SEED = int(os.environ.get("SEAM_FAULT_SEED", "1"))
SHORT_RUNS, SHORT_S, LONG_S = 5, 15, 600
HANG_S = 900  # Of wall time: a run that takes longer hangs.
SMALLEST_LOG = 30_000  # Bytes: a log cut before its header is whole is none.

# A client that has its robot's token and says what it should not.
LIAR = """#!{python}
import os, queue, random, sys, time
sys.path.insert(0, {stubs!r})
import grpc
from seam.v1 import simulation_pb2 as wire
from seam.v1 import simulation_pb2_grpc as service
draw = random.Random({seed})
for attempt in range(1000):
    out = queue.SimpleQueue()
    out.put(wire.ClientMessage(hello=wire.Hello(robot=os.environ["SEAM_ROBOT"], token=os.environ["SEAM_TOKEN"],
                                                client="liar \\x1b[2J")))
    try:
        with grpc.insecure_channel(os.environ["SEAM_ADDRESS"]) as channel:
            for message in service.SimulationStub(channel).Drive(iter(out.get, None)):
                if message.HasField("goodbye"):
                    sys.exit(0)
                if not message.HasField("observation"):
                    continue
                right = message.observation.sequence
                lie = draw.randrange(10)
                if lie == 0:
                    out.put(wire.ClientMessage())
                elif lie == 1:
                    out.put(wire.ClientMessage(hello=wire.Hello(robot="r0", token="x")))
                elif lie == 2:
                    for wrong in (right + 1, max(right, 1) - 1, 2**64 - 1, 0):
                        out.put(wire.ClientMessage(decision=wire.Decision(sequence=wrong)))
                elif lie == 3 and draw.random() < 0.3:
                    break  # It hangs up and comes again.
                answer = wire.Decision(sequence=right)
                if lie == 4:
                    answer.walk.vx_m_s = draw.choice([float("nan"), float("inf"), 1e300])
                elif lie == 5:
                    answer.debug.add(name="x" * 1000, value=1.0)
                    answer.debug.add(name="\\x1b[2J", value=float("nan"))
                elif lie == 6:
                    answer.kick = 99
                elif lie == 7:
                    answer.frame_requests.add(which=1)
                elif lie == 8 and draw.random() < 0.2:
                    time.sleep(0.3)
                for copy in range(1 + (lie == 9)):
                    out.put(wire.ClientMessage(decision=answer))
    except grpc.RpcError:
        time.sleep(0.05)
"""

SCENARIO = f"""format: seam-scenario/1
name: faults
duration_s: DURATION
seed: 5
step_s: 0.01
field: {SOURCE}/models/field_2002.yaml
ball: {{x_m: 0.3, y_m: 0.2, vx_mps: 0.4}}
robot_defaults:
  body: {SOURCE}/models/robot_ers210.yaml
  camera: {{model: {SOURCE}/models/ers210.yaml, width_px: 32, height_px: 24, clock: {{period_s: 1}}}}
robots:
"""
ROBOT = """  - id: r{number}
    team: red
    pose: {{x_m: {x_m}, y_m: 0.4, theta_rad: 0.3}}
    behaviour: {{command: [{command}], clock: {{period_s: {period_s}}}, silence: {silence}, wall_limit_s: {limit_s}}}
"""


class Mix:
    """One run: what it draws from its seed, and what it came to."""

    def __init__(self, seed, duration_s, folder):
        self.draw = random.Random(seed)
        self.duration_s = duration_s
        self.folder = folder
        self.log = folder / "run.mcap"
        self.limits = {}
        self.did = collections.Counter()
        self.silence = self.draw.choice(["freeze", "freeze", "freeze", "abort"])
        self.make_scenario(seed)
        self.draw_limits()

    def make_scenario(self, seed):
        text = SCENARIO.replace("DURATION", str(self.duration_s))
        commands = ["head_swing, --rate, '2'"] * self.draw.randint(1, 2)
        if PYTHON:
            liar = self.folder / "liar"
            liar.write_text(LIAR.format(python=PYTHON, stubs=str(BUILD / "python"), seed=seed))
            liar.chmod(0o755)
            commands.append(str(liar))
        for number, command in enumerate(commands):
            lies = command.startswith("/")
            text += ROBOT.format(number=number, x_m=-0.9 + 0.7 * number, command=command, period_s=2 if lies else 0.5,
                                 silence="freeze" if lies else self.silence, limit_s=self.draw.choice([0.1, 0.3]))
        self.scenario = self.folder / "s.yaml"
        self.scenario.write_text(text)

    def draw_limits(self):
        """At most one resource runs out in a run; the rest have all."""
        kind = self.draw.choice(["none", "none", "disk", "descriptors", "memory"])
        if kind == "disk":
            self.limits[resource.RLIMIT_FSIZE] = self.draw.randrange(SMALLEST_LOG, 60_000 * max(1, self.duration_s // 10))
        elif kind == "descriptors":
            self.limits[resource.RLIMIT_NOFILE] = self.draw.randrange(16, 64)
        elif kind == "memory":
            self.limits[resource.RLIMIT_AS] = self.draw.randrange(150, 900) << 20
        self.did[f"little {kind}"] += kind != "none"

    def limit(self):
        for what, value in self.limits.items():
            resource.setrlimit(what, (value, value))
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)  # A write beyond the limit fails, as on a full disk.

    # ---- What is done to it ----

    def children(self):
        try:
            return list(map(int, pathlib.Path(f"/proc/{self.run.pid}/task/{self.run.pid}/children").read_text().split()))
        except OSError:
            return []

    def to_a_client(self, sent):
        children = self.children()
        if children:
            try:
                os.kill(self.draw.choice(children), sent)
            except ProcessLookupError:
                pass

    def addresses(self):
        return [str(path) for path in self.folder.glob("tmp/seam-run-*/socket")]

    def connection(self):
        one = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        one.settimeout(1)
        try:
            one.connect(next(iter(self.addresses()), ""))
        except OSError:
            pass  # It is not there yet, full, or at its end.
        self.connections.append(one)
        return one

    def connect_and_say(self, words):
        try:
            self.connection().sendall(words)
        except OSError:
            pass

    def act(self):
        kind = self.draw.choice(["kill", "stop", "go on", "silent", "flood", "nonsense", "preface", "hang up", "signal", "end"])
        if kind == "kill" and self.draw.random() < 0.15:
            self.to_a_client(signal.SIGKILL)
        elif kind == "stop":
            self.to_a_client(signal.SIGSTOP)
        elif kind == "go on":
            for child in self.children():
                os.kill(child, signal.SIGCONT)
        elif kind == "silent":
            self.connection()
        elif kind == "flood":
            for _ in range(self.draw.randrange(20, 80)):
                self.connection()
        elif kind == "nonsense":
            self.connect_and_say(self.draw.randbytes(self.draw.randrange(1, 5000)))
        elif kind == "preface":
            self.connect_and_say(b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + self.draw.randbytes(200))
        elif kind == "hang up":
            while self.connections:
                self.connections.pop().close()
        elif kind == "signal" and self.addresses():  # Before it serves, a SIGPIPE ends it as any program.
            self.run.send_signal(self.draw.choice([signal.SIGPIPE, signal.SIGWINCH, signal.SIGCHLD, signal.SIGURG]))
        elif kind == "end" and self.draw.random() < 0.05:
            self.ended_by_us = True
            self.run.send_signal(self.draw.choice([signal.SIGINT, signal.SIGTERM, signal.SIGHUP]))
        else:
            return
        self.did[kind] += 1

    def go(self):
        self.connections, self.ended_by_us = [], False
        (self.folder / "tmp").mkdir()
        environment = dict(os.environ, TMPDIR=str(self.folder / "tmp"), HOME=str(self.folder))
        said = (self.folder / "said.txt").open("w+")
        command = [SEAM, "run", self.scenario, "--log", self.log]
        self.run = subprocess.Popen(command, stdout=said, stderr=subprocess.STDOUT, env=environment, preexec_fn=self.limit,
                                    start_new_session=True)
        start = time.monotonic()
        try:
            while self.run.poll() is None:
                if time.monotonic() - start > HANG_S:
                    return "hangs"
                try:
                    self.act()
                except ProcessLookupError:
                    pass
                time.sleep(self.draw.expovariate(1 / 0.1))
        finally:
            if self.run.poll() is None:
                self.run.kill()
                self.run.wait()
            for one in self.connections:
                one.close()
        said.seek(0)
        self.said = said.read()
        said.close()
        return self.why_not_this_end()

    # ---- What it came to ----

    def why_not_this_end(self):
        code = self.run.returncode
        if code == 0:
            self.end = "stopped" if "stopped" in self.said else "finished"
            if self.end == "stopped" and not self.ended_by_us:
                return "stopped, and nobody asked for it"
            return ""
        if self.ended_by_us and code in (-signal.SIGINT, -signal.SIGTERM, -signal.SIGHUP) and self.log_bytes() == 0:
            self.end = "stopped before it began"
            return ""
        if code == 1 and "aborted" in self.said:
            self.end = "aborted"
            return "" if self.silence == "abort" else "aborted against its policy"
        reasons = {resource.RLIMIT_FSIZE: "File too large", resource.RLIMIT_NOFILE: "Too many open files|descriptor",
                   resource.RLIMIT_AS: "emory|bad_alloc|thread"}
        for what, words in reasons.items():
            if what in self.limits and code == 1 and re.search(words, self.said):
                self.end = f"error: {words.split('|')[0]}"
                return ""
        if resource.RLIMIT_AS in self.limits and code in (-signal.SIGABRT, -signal.SIGSEGV, -signal.SIGTRAP):
            self.end = "died without memory"
            return ""
        self.end = f"exit code {code}"
        return f"ended with {code}"

    def log_bytes(self):
        return self.log.stat().st_size if self.log.exists() else 0

    def why_not_verified(self):
        self.verified_s = 0
        if self.log_bytes() < SMALLEST_LOG and self.end not in ("finished", "stopped", "aborted"):
            return ""
        done = subprocess.run([SEAM, "replay", "verify", self.log, "--no-frames"], capture_output=True, text=True)
        if self.end not in ("finished", "aborted") and "nothing to compare: the run ended before its first step" in done.stdout:
            self.end += " before the first step"
            return ""
        found = re.search(r"the same: .* up to ([0-9.]+) s", done.stdout)
        if self.end not in ("finished", "stopped", "aborted"):  # A log whose run died has no end.
            found = found or re.search(r"verified up to ([0-9.]+) s: .* are the same; the log has no end", done.stdout)
        self.verified_s = float(found.group(1)) if found else 0
        if done.returncode != 0 or not found:
            return f"the log does not verify: {done.stdout}{done.stderr}"
        if self.end == "finished" and self.verified_s < self.duration_s:
            return f"finished, and verified up to {self.verified_s} s"
        return ""


def main():
    runs, duration_s = (MIXES, LONG_S) if MIXES else (SHORT_RUNS, SHORT_S)
    ends, did, failures, verified_s = collections.Counter(), collections.Counter(), [], 0
    for seed in range(SEED, SEED + runs):
        with tempfile.TemporaryDirectory(prefix="seam-mix-") as name:
            mix = Mix(seed, duration_s, pathlib.Path(name))
            why = mix.go() or mix.why_not_verified()
            if why:
                failures.append(f"seed {seed}: {why}\n{getattr(mix, 'said', '')[-2000:]}")
                print(failures[-1], flush=True)
                continue
            ends[mix.end] += 1
            did += mix.did
            verified_s += mix.verified_s
            if MIXES:
                print(f"seed {seed}: {mix.end}, verified up to {mix.verified_s} s", flush=True)
    print(f"{runs} runs of up to {duration_s} s, {verified_s:.0f} simulated seconds verified")
    print("ends:", dict(ends))
    print("faults:", dict(did))
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
