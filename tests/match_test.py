#!/usr/bin/env python3
"""The match of scenarios/match.yaml as a user runs it: from one command, over TLS with the teams on network
namespaces of their own, for long, and as recorded in replays/.

Usage: match_test.py BUILD_DIR SOURCE_DIR [unittest arguments]
"""
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import by_hand

BUILD, SOURCE = by_hand.arguments("build", "source")
SEAM = BUILD / "seam"
LIMIT_S = 500  # A hang is a failure.
ROBOTS = [f"{team}{number}" for team in ("red", "blue") for number in (1, 2, 3, 4)]


def scenario(duration_s, half_s, frames=True, **changes):
    """The match, shorter; without frames its players know nothing and stand still, so head swings take their place."""
    text = (SOURCE / "scenarios" / "match.yaml").read_text().replace("../models", f"{SOURCE}/models")
    replaced = {"duration_s: 90": f"duration_s: {duration_s}", "half_s: 40": f"half_s: {half_s}",
                "ready_s: 2, set_s: 1": "ready_s: 0.2, set_s: 0.1", **changes}
    for old, new in replaced.items():
        assert old in text, old
        text = text.replace(old, new)
    if not frames:
        lines = []
        for line in text.splitlines():
            start = line.find("behaviour: {command")
            lines.append(line if start < 0 else line[:start] + "behaviour: {command: [head_swing, --no-frames]}")
        text = "\n".join(lines) + "\n"
    return text


def ip(*arguments):
    return subprocess.run(["ip", *arguments], capture_output=True, text=True).returncode == 0


class Match(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.here = pathlib.Path(folder.name)

    def write(self, text):
        path = self.here / "match.yaml"
        path.write_text(text)
        return path

    def seam(self, *arguments, code=0):
        done = subprocess.run([SEAM, *map(str, arguments)], capture_output=True, text=True, timeout=LIMIT_S)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done.stdout

    def run_match(self, path, log):
        out = self.here / "run.json"
        self.seam("run", path, "--log", log, "--json", out)
        return json.loads(out.read_text())

    def verify(self, log, *arguments):
        out = self.here / "verify.json"
        self.seam("replay", "verify", log, "--json", out, *arguments)
        self.assertTrue(json.loads(out.read_text())["ok"])

    def test_from_one_command_and_over_tls_from_two_other_namespaces(self):
        """Eight players with frames: a whole match with its score, and the same to the bit when the server, the red
        and the blue clients are on three network namespaces."""
        path = self.write(scenario(duration_s=2.7, half_s=1))
        here_log, log = self.here / "here.mcap", self.here / "served.mcap"
        reference = self.run_match(path, here_log)
        self.assertEqual(reference["end"], "finished")
        self.assertEqual(set(reference["score"]), {"red", "blue"})
        self.assertGreater(reference["frames"], 400)
        self.verify(here_log)
        self.assertIn("half_time", self.seam("replay", "show", here_log))

        names = {who: f"seam-{who}-{os.getpid()}" for who in ("server", "red", "blue")}
        self.addCleanup(lambda: [ip("netns", "del", name) for name in names.values()])
        if not all(ip("netns", "add", name) and ip("netns", "exec", name, "true") for name in names.values()):
            self.skipTest("network namespaces need rights that this user has not")
        addresses = {"red": "10.78.1.1", "blue": "10.78.2.1"}
        for i, (team, address) in enumerate(addresses.items()):
            link = f"m{os.getpid() % 100000}{i}"
            if not ip("link", "add", link + "s", "netns", names["server"], "type", "veth",
                      "peer", "name", link + "c", "netns", names[team]):
                self.skipTest("no virtual network links here")
            for name, end, host in ((names["server"], "s", address), (names[team], "c", address[:-1] + "2")):
                ip("-n", name, "addr", "add", host + "/24", "dev", link + end)
                ip("-n", name, "link", "set", link + end, "up")
        certificates, tokens, out = self.here / "certs", self.here / "tokens.yaml", self.here / "served.json"
        self.seam("certs", certificates, *[word for host in addresses.values() for word in ("--host", host)])
        server = subprocess.Popen(["ip", "netns", "exec", names["server"], SEAM, "serve", path, "--certs", certificates,
                                   "--listen", addresses["red"] + ":7210", "--listen", addresses["blue"] + ":7210",
                                   "--tokens", tokens, "--json", out, "--log", log], stdout=subprocess.PIPE, text=True)
        self.addCleanup(lambda: (server.poll() is None and server.kill(), server.wait(), server.stdout.close()))
        for _ in addresses:
            self.assertIn("listening on", server.stdout.readline())
        secret = dict(line.strip().split(": ") for line in tokens.read_text().splitlines() if line.startswith("  "))
        clients = []
        for robot in ROBOTS:
            team, number = robot[:-1], int(robot[-1])
            command = ["ip", "netns", "exec", names[team], BUILD / "behaviours" / "player", "--number", str(number - 1),
                       "--attacks", "skyblue" if team == "red" else "yellow", "--seed", "1" if team == "red" else "2",
                       "--address", addresses[team] + ":7210", "--robot", robot, "--token", secret[robot]]
            clients.append(subprocess.Popen(command, env=dict(os.environ, SEAM_CERTS=str(certificates))))
        self.assertEqual([client.wait(LIMIT_S) for client in clients], [0] * len(clients))
        self.assertEqual(server.wait(LIMIT_S), 0)
        served = json.loads(out.read_text())
        for key in ("fingerprint", "score", "frames", "decisions"):
            self.assertEqual(served[key], reference[key], key)
        self.verify(log)

    def test_ten_minutes_without_frames_take_no_more_memory_than_one(self):
        if b"__asan_init" in SEAM.read_bytes():
            self.skipTest("a sanitizer keeps freed memory")
        path = self.write(scenario(duration_s=600, half_s=299, frames=False))
        summary = self.run_match(path, self.here / "long.mcap")
        self.assertEqual(summary["sim_s"], 600)
        memory = {round(sample["sim_s"]): sample["rss_bytes"] for sample in summary["memory"]}
        self.assertEqual(sorted(memory), list(range(0, 601, 10)))
        after_a_minute = max(memory[second] for second in (60, 70, 80))
        for second, rss_bytes in memory.items():
            self.assertLess(rss_bytes, after_a_minute + (2 << 20), f"at {second} s: {memory}")
        self.assertEqual(summary["log_bytes"], (self.here / "long.mcap").stat().st_size)
        print(f"resident: {after_a_minute >> 10} kB after a minute, {memory[600] >> 10} kB at the end; log "
              f"{summary['log_bytes']} bytes", file=sys.stderr)

    def test_the_recorded_match_verifies(self):
        """Its frames are made anew and compared in `./test.sh --all`."""
        recorded = SOURCE / "replays" / "match.mcap"
        self.verify(recorded, "--no-frames")
        shown = self.here / "show.json"
        self.seam("replay", "show", recorded, "--json", shown)
        content = json.loads(shown.read_text())
        self.assertEqual(content["robots"], ROBOTS)
        self.assertEqual(content["end"], "finished")
        self.assertEqual(content["messages"]["/seam/frame"], 8789)
        out = self.here / "accuracy.json"
        self.seam("replay", "accuracy", recorded, "--from", "5", "--json", out)
        accuracy = json.loads(out.read_text())["all"]
        self.assertLess(accuracy["position_m"]["p90_abs"], 0.4)
        self.assertLess(accuracy["ball_distance_m"]["p90_abs"], 0.3)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=2)
