#!/usr/bin/env python3
"""The real programs, as a user runs them: `seam run`, `seam serve`, behaviours as processes.

Usage: end_to_end_test.py BUILD_DIR SOURCE_DIR [unittest arguments]
"""
import csv
import json
import os
import pathlib
import random
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import by_hand

BUILD, SOURCE = by_hand.arguments("build", "source")
SEAM = BUILD / "seam"
GOLDEN = SOURCE / "tests" / "golden" / "fingerprints.json"
LIMIT_S = 240  # A hang is a failure.


def scenario(robots=2, duration_s=1.0, frames=True, behaviour="head_swing, --rate, '200'", extra="", step_extra=""):
    text = (f"format: seam-scenario/1\nname: end-to-end\nduration_s: {duration_s}\nseed: 5\n{step_extra}"
            f"field: {SOURCE}/models/field_2002.yaml\nball: {{x_m: 0.4, y_m: 0.1, vx_mps: 0.3}}\nrobots:\n")
    for i in range(robots):
        text += (f"  - id: r{i}\n    team: {'red' if i % 2 == 0 else 'blue'}\n"
                 f"    pose: {{x_m: {-0.9 + 0.6 * i}, y_m: {0.4 - 0.5 * i}, theta_rad: {0.3 * i}}}\n"
                 f"    body: {SOURCE}/models/robot_ers210.yaml\n"
                 f"    camera: {{model: {SOURCE}/models/ers210.yaml, every_frame: {str(frames).lower()}, "
                 f"clock: {{phase_s: {0.01 * i}, jitter_sigma_s: 1.0e-4}}}}\n"
                 f"    behaviour: {{command: [{behaviour}{'' if frames else ', --no-frames'}]{extra}}}\n")
    return text


def behaviours_of(parent):
    """Process ids of the parent's children, by robot."""
    found = {}
    for task in pathlib.Path(f"/proc/{parent}/task").glob("*/children"):
        try:
            for pid in map(int, task.read_text().split()):
                environment = pathlib.Path(f"/proc/{pid}/environ").read_bytes().split(b"\0")
                for entry in environment:
                    if entry.startswith(b"SEAM_ROBOT="):
                        found[entry[11:].decode()] = pid
        except OSError:
            pass
    return found


def is_running(pid):
    try:
        return pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


def wait_until(condition, limit_s=30):
    end = time.monotonic() + limit_s
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        time.sleep(0.01)
    raise AssertionError("waited in vain")


class EndToEnd(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.here = pathlib.Path(self.folder.name)

    def tearDown(self):
        self.folder.cleanup()

    def write(self, text, name="s.yaml"):
        path = self.here / name
        path.write_text(text)
        return path

    def seam(self, *arguments):
        return subprocess.run([SEAM, *map(str, arguments)], capture_output=True, text=True, timeout=LIMIT_S)

    def start(self, *arguments):
        process = subprocess.Popen([SEAM, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(lambda: process.poll() is None and process.kill())
        return process

    def run_json(self, *arguments):
        out = self.here / "summary.json"
        done = self.seam("run", *arguments, "--json", out)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(out.read_text())

    def verify(self, log):
        if " replay " not in self.seam("--help").stdout:
            self.skipTest("this build has no `seam replay`")
        done = self.seam("replay", "verify", log)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def check_golden(self, name, fingerprint):
        """After a change of results that was meant: look at the .new file, then move it over the golden one."""
        known = json.loads(GOLDEN.read_text()) if GOLDEN.exists() else {}
        if known.get(name) == fingerprint:
            return
        new = GOLDEN.with_suffix(".json.new")
        changed = json.loads(new.read_text()) if new.exists() else dict(known)
        changed[name] = fingerprint
        new.write_text(json.dumps(changed, indent=2, sort_keys=True) + "\n")
        self.fail(f"{name}: fingerprint {fingerprint}, expected {known.get(name)}; compare {GOLDEN} with {new}")

    def test_the_same_bits_again_on_any_number_of_threads(self):
        path = self.write(scenario())
        first = self.run_json(path)
        for key in ("sim_s", "wall_s", "real_time_factor", "frames", "fingerprint"):
            self.assertIn(key, first)
        self.assertEqual(first["sim_s"], 1.0)
        self.assertGreater(first["frames"], 40)
        for threads in (1, 2, 3):
            self.assertEqual(self.run_json(path, "--render-threads", threads)["fingerprint"], first["fingerprint"])
        self.assertNotEqual(self.run_json(path, "--seed", 6)["fingerprint"], first["fingerprint"])

    @unittest.skipUnless(GOLDEN.exists(), f"no {GOLDEN.name}")
    def test_the_golden_fingerprints(self):
        for name, path in (("end-to-end", self.write(scenario())), ("head_swing", SOURCE / "scenarios" / "head_swing.yaml")):
            with self.subTest(name):
                self.check_golden(name, self.run_json(path)["fingerprint"])

    def test_stopped_and_continued_clients_change_nothing(self):
        path = self.write(scenario(frames=False, duration_s=4))
        reference = self.run_json(path)["fingerprint"]
        out = self.here / "slow.json"
        process = self.start("run", path, "--json", out)
        pids = wait_until(lambda: behaviours_of(process.pid))
        dice = random.Random(3)
        for _ in range(6):
            if process.poll() is not None:
                break
            victim = dice.choice(list(pids.values()))
            try:
                os.kill(victim, signal.SIGSTOP)
                time.sleep(dice.random() * 0.2)
                os.kill(victim, signal.SIGCONT)
            except ProcessLookupError:
                break
        self.assertEqual(process.wait(LIMIT_S), 0, process.stderr.read())
        self.assertEqual(json.loads(out.read_text())["fingerprint"], reference)

    def test_frames_and_their_table(self):
        frames = self.here / "frames"
        summary = self.run_json(self.write(scenario(robots=1, duration_s=0.3)), "--frames", frames)
        pictures = sorted(p.name for p in frames.glob("*.png"))
        self.assertEqual(len(pictures), summary["frames"])
        self.assertEqual(pictures[0], "r0_000000.png")
        with open(frames / "frames.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(len(rows), 144 * len(pictures))
        self.assertEqual({row["file"] for row in rows}, set(pictures))
        first, second = rows[0], rows[1]
        self.assertEqual(int(second["row_start_ns"]) - int(first["row_start_ns"]), 278000)
        self.assertEqual(int(first["row_end_ns"]) - int(first["row_start_ns"]), 5000000)
        quaternion = [float(first[k]) for k in ("qw", "qx", "qy", "qz")]
        self.assertAlmostEqual(sum(q * q for q in quaternion), 1, 12)

    def test_bad_scenarios_are_refused_with_file_and_key(self):
        good = scenario(robots=1)
        cases = [
            (good.replace("seed:", "sede:"), "sede"),
            (good.replace("field_2002.yaml", "nowhere.yaml"), "nowhere.yaml"),
            (good.replace("duration_s: 1.0", "duration_s: -3"), "duration_s"),
            (scenario(robots=2).replace("id: r1", "id: r0"), "r0"),
            (good.replace("head_swing", "no_such_behaviour"), "no_such_behaviour"),
            (good.replace("ers210.yaml, every", "unknown.yaml, every"), "unknown.yaml"),
            ("format: seam-scenario/1\n: [", "bad.yaml"),
        ]
        for text, word in cases:
            done = self.seam("run", self.write(text, "bad.yaml"))
            self.assertEqual(done.returncode, 1, word)
            self.assertIn(word, done.stderr)
            self.assertLessEqual(len(done.stderr.strip().splitlines()), 2, done.stderr)
        self.assertEqual(self.seam("run", self.here / "missing.yaml").returncode, 1)

    def test_bad_camera_models_are_refused_with_file_and_key(self):
        path = self.write(scenario(robots=1))
        pinhole = "  pinhole: {fx_px: 161.9, fy_px: 162.5, cx_px: 88.5, cy_px: 71.5}\n"
        cases = [
            ("  vigneting: {a2: 0.1}\n", ["unknown effect 'vigneting'", "did you mean 'vignetting'"]),
            ("  vignetting: {a3: 0.1}\n", ["effects.vignetting", "a3", "did you mean 'a2'"]),
            ("  lens_blur: {sigma_px: -1}\n", ["effects.lens_blur.sigma_px", "found -1"]),
            ("  radial_polynomial: {k1: -2, k2: 0, k3: 0}\n",
             ["effects.radial_polynomial {k1: -2", "no ray leads to pixel", "178x144"]),
            ("  spline_lens: {fov_x_deg: 5, x_0_1: 0.01}\n", ["effects.spline_lens {fov_x_deg: 5, x_0_1: 0.01}: no ray leads to pixel"]),
        ]
        for effect, words in cases:
            model = self.write(f"format: seam-model/1\nname: bad\neffects:\n{pinhole}{effect}", "bad_model.yaml")
            done = self.seam("run", path, "--model", model)
            self.assertEqual(done.returncode, 1, effect)
            for word in ["bad_model.yaml", *words]:
                self.assertIn(word, done.stderr)

    def test_wrong_use_is_exit_code_2(self):
        path = self.write(scenario(robots=1))
        for arguments in (["run"], ["run", path, "--no-such-option"], ["run", path, "--model", f"nobody={path}"],
                          ["serve", path, "--listen", "0.0.0.0:0"], ["no-such-command"]):
            self.assertEqual(self.seam(*arguments).returncode, 2, arguments)

    def test_a_killed_client_under_each_policy(self):
        for policy, code in (("wait", 1), ("abort", 1), ("freeze", 0)):
            log = self.here / f"{policy}.mcap"
            # Long enough that a fast machine is still running when the kill comes.
            path = self.write(scenario(robots=3, duration_s=100000 if policy != "freeze" else 60, frames=False,
                                       extra=f", silence: {policy}, wall_limit_s: 1"))
            process = self.start("run", path, "--log", log)
            pids = wait_until(lambda: len(behaviours_of(process.pid)) == 3 and behaviours_of(process.pid))
            os.kill(pids["r1"], signal.SIGSTOP)  # Time stands still now: the kill finds the run in its middle.
            time.sleep(0.2)
            os.kill(pids["r1"], signal.SIGKILL)
            self.assertEqual(process.wait(LIMIT_S), code, policy)
            errors = process.stderr.read()
            self.assertIn("r1", errors)
            self.assertIn("signal 9", errors)
            self.assertFalse(any(is_running(pid) for pid in pids.values()), policy)
            self.verify(log)

    def test_interrupt_ends_cleanly_with_a_whole_log(self):
        log = self.here / "stopped.mcap"
        process = self.start("run", self.write(scenario(duration_s=1000)), "--log", log, "--frames", self.here / "f")
        pids = wait_until(lambda: len(behaviours_of(process.pid)) == 2 and behaviours_of(process.pid))
        time.sleep(0.5)
        process.send_signal(signal.SIGINT)
        process.send_signal(signal.SIGINT)  # As `timeout -s INT` does.
        self.assertEqual(process.wait(20), 0)
        self.assertIn("stopped", process.stdout.read())
        self.assertFalse(any(is_running(pid) for pid in pids.values()))
        self.verify(log)

    def test_behaviours_die_with_a_killed_server(self):
        process = self.start("run", self.write(scenario(duration_s=1000, frames=False)))
        pids = wait_until(lambda: len(behaviours_of(process.pid)) == 2 and behaviours_of(process.pid))
        process.kill()
        process.wait()
        wait_until(lambda: not any(is_running(pid) for pid in pids.values()))

    def test_clients_over_tls_with_tokens(self):
        path = self.write(scenario(robots=1))
        reference = self.run_json(path)["fingerprint"]
        certificates, tokens, out = self.here / "certs", self.here / "tokens.yaml", self.here / "served.json"
        self.assertEqual(self.seam("certs", certificates).returncode, 0)
        server = self.start("serve", path, "--listen", "127.0.0.1:0", "--certs", certificates, "--tokens", tokens,
                            "--json", out)
        address = server.stdout.readline().split()[-1]
        token = next(line.split()[1] for line in tokens.read_text().splitlines() if "r0:" in line)
        self.assertEqual(tokens.stat().st_mode & 0o077, 0)
        client = [BUILD / "behaviours" / "head_swing", "--rate", "200", "--address", address, "--robot", "r0"]
        secure = dict(os.environ, SEAM_CERTS=str(certificates))
        wrong = subprocess.run([*client, "--token", "guess"], env=secure, capture_output=True, text=True, timeout=60)
        self.assertEqual(wrong.returncode, 1)
        self.assertIn("token", wrong.stderr)
        right = subprocess.run([*client, "--token", token], env=secure, timeout=LIMIT_S)
        self.assertEqual(right.returncode, 0)
        self.assertEqual(server.wait(LIMIT_S), 0)
        self.assertEqual(json.loads(out.read_text())["fingerprint"], reference)

    def test_renderers_of_their_own_give_the_same_bits(self):
        path = self.write(scenario(duration_s=0.6))
        reference = self.run_json(path)
        self.assertEqual(reference["rendered_remotely"], 0)
        for renderers in (1, 2):
            remote = self.run_json(path, "--renderers", renderers)
            self.assertEqual(remote["fingerprint"], reference["fingerprint"])
            self.assertEqual(remote["rendered_remotely"], reference["frames"])

    def serve_with_renderers(self, path, *arguments):
        """A server, its address, its tokens and where its summary will be."""
        tokens, out = self.here / "tokens.yaml", self.here / "served.json"
        server = self.start("serve", path, "--listen", f"unix:{self.here}/s", "--tokens", tokens, "--json", out, *arguments)
        address = server.stdout.readline().split()[-1]
        found = dict(line.strip().split(": ") for line in tokens.read_text().splitlines() if ": " in line)
        return server, address, found, out

    def start_renderer(self, address, token, *arguments):
        process = subprocess.Popen([BUILD / "seam-render", "--address", address, *arguments],
                                   env=dict(os.environ, SEAM_RENDER_TOKEN=token), stderr=subprocess.PIPE, text=True)
        self.addCleanup(lambda: (process.poll() is None and process.kill(), process.wait(), process.stderr.close()))
        return process

    def start_client(self, address, robot, token):
        return subprocess.Popen([BUILD / "behaviours" / "head_swing", "--rate", "200", "--address", address,
                                 "--robot", robot, "--token", token])

    def test_a_robot_token_is_refused_the_scene_and_lost_renderers_change_nothing(self):
        path = self.write(scenario(duration_s=3))
        reference = self.run_json(path)["fingerprint"]
        server, address, tokens, out = self.serve_with_renderers(path, "--renderers", 3, "--renderer-limit", 2)
        spy = self.start_renderer(address, tokens["r0"])
        self.assertEqual(spy.wait(60), 1)
        self.assertIn("token: not the render token", spy.stderr.read())
        stranger = self.start_renderer(address, tokens["render"], "--robot", "r7")
        self.assertEqual(stranger.wait(60), 1)
        self.assertIn("r7", stranger.stderr.read())
        for arguments in (["--threads", "-3"], ["--no-such-option"]):
            self.assertEqual(subprocess.run([BUILD / "seam-render", "--address", address, "--token", "x", *arguments],
                                            capture_output=True, timeout=60).returncode, 2)
        killed, stopped, good = [self.start_renderer(address, tokens["render"], "--name", name, "--threads", "1")
                                 for name in ("killed", "stopped", "good")]
        clients = [self.start_client(address, robot, tokens[robot]) for robot in ("r0", "r1")]
        time.sleep(0.3)
        killed.kill()
        stopped.send_signal(signal.SIGSTOP)
        self.assertEqual([client.wait(LIMIT_S) for client in clients], [0, 0])
        self.assertEqual(server.wait(LIMIT_S), 0)
        self.assertEqual(good.wait(30), 0)
        self.assertEqual(json.loads(out.read_text())["fingerprint"], reference)

    def test_without_its_last_renderer_a_run_ends_by_its_policy(self):
        path = self.write(scenario(robots=1, duration_s=100))
        server, address, tokens, out = self.serve_with_renderers(path, "--renderers", 1, "--renderer-policy", "abort")
        renderer = self.start_renderer(address, tokens["render"], "--name", "only")
        client = self.start_client(address, "r0", tokens["r0"])
        self.addCleanup(lambda: (client.poll() is None and client.kill(), client.wait()))
        time.sleep(1)
        renderer.kill()
        self.assertEqual(server.wait(60), 1)
        errors = server.stderr.read()
        self.assertIn("renderer 'only' is lost", errors)
        self.assertIn("no renderer for frame", errors)

    def test_clients_on_another_network_namespace(self):
        a, b = f"seam-a-{os.getpid()}", f"seam-b-{os.getpid()}"

        def ip(*arguments):
            return subprocess.run(["ip", *arguments], capture_output=True, text=True).returncode == 0

        if not (ip("netns", "add", a) and ip("netns", "add", b)):
            self.skipTest("network namespaces need rights that this user has not")
        self.addCleanup(lambda: [ip("netns", "del", name) for name in (a, b)])
        if not (ip("netns", "exec", a, "true") and ip("netns", "exec", b, "true")):
            self.skipTest("no program can be started in a network namespace here (a change of root without /sys)")
        link = f"v{os.getpid() % 100000}"
        if not ip("link", "add", link + "a", "netns", a, "type", "veth", "peer", "name", link + "b", "netns", b):
            self.skipTest("no virtual network links here")
        for name, end, address in ((a, "a", "10.77.0.1/24"), (b, "b", "10.77.0.2/24")):
            ip("-n", name, "addr", "add", address, "dev", link + end)
            ip("-n", name, "link", "set", link + end, "up")
        path = self.write(scenario(robots=2, frames=False))
        reference = self.run_json(path)["fingerprint"]
        certificates, tokens, out = self.here / "certs", self.here / "tokens.yaml", self.here / "served.json"
        self.assertEqual(self.seam("certs", certificates, "--host", "10.77.0.1").returncode, 0)
        server = subprocess.Popen(["ip", "netns", "exec", a, SEAM, "serve", path, "--listen", "10.77.0.1:7210",
                                   "--certs", certificates, "--tokens", tokens, "--json", out],
                                  stdout=subprocess.PIPE, text=True)
        self.addCleanup(lambda: server.poll() is None and server.kill())
        server.stdout.readline()
        secret = dict(line.strip().split(": ") for line in tokens.read_text().splitlines() if line.startswith("  "))
        clients = [subprocess.Popen(["ip", "netns", "exec", b, BUILD / "behaviours" / "head_swing", "--no-frames",
                                     "--rate", "200", "--address", "10.77.0.1:7210", "--robot", robot, "--token", secret[robot]],
                                    env=dict(os.environ, SEAM_CERTS=str(certificates))) for robot in ("r0", "r1")]
        for client in clients:
            self.assertEqual(client.wait(LIMIT_S), 0)
        self.assertEqual(server.wait(LIMIT_S), 0)
        self.assertEqual(json.loads(out.read_text())["fingerprint"], reference)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=2)
