#!/usr/bin/env python3
"""`seam serve --dm-env-rpc` and clients that send nonsense or vanish, runs that are killed, options that do not go together.

Usage: dm_env_rpc_hostile_test.py BUILD_DIR SOURCE_DIR [unittest arguments], by the interpreter that has gRPC.
"""
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import grpc
from dm_client import SEAM, Case, children_of, number, properties, rpc, scenario, tensor


class Hostile(Case):
    def test_nonsense_is_answered_by_errors(self):
        agent = self.agent()
        for nonsense in (b"\xff" * 100, b"\x08\x96\x01", b"\x1a\xff\xff\xff\xff\x0f"):
            agent.send_bytes(nonsense)
            self.refused("INVALID_ARGUMENT", "", agent.next)
        self.refused("INVALID_ARGUMENT", "found a request of no kind", agent.ask)
        request = rpc.EnvironmentRequest()
        request.extension.type_url, request.extension.value = "x/dm_env_rpc.v1.extensions.properties.PropertyRequest", b"\xff"
        agent.send_bytes(request.SerializeToString())
        self.refused("INVALID_ARGUMENT", "no PropertyRequest", agent.next)
        many = rpc.StepRequest(actions={uid: number(0) for uid in range(1000, 9000)}, requested_observations=[])
        self.assertEqual(agent.ask(step=many).state, rpc.RUNNING)
        self.refused("NOT_FOUND", "action 1000", agent.ask, step=many)
        self.refused("NOT_FOUND", "observation 77", agent.ask, step=rpc.StepRequest(requested_observations=[77] * 100_000))
        self.refused("INVALID_ARGUMENT", "found 100000 elements", agent.step, {"joints.pan_rad": tensor("doubles", [0.0] * 100_000)})
        self.assertEqual(agent.time_ns(), 32_000_000)

    def test_a_message_that_is_too_long_ends_its_stream_alone(self):
        agent, other = self.agent(), self.agent()
        agent.send(step=rpc.StepRequest(actions={1: tensor("doubles", [0.0] * 200_000)}))
        with self.assertRaises(grpc.RpcError) as caught:
            agent.next()
        self.assertEqual(caught.exception.code(), grpc.StatusCode.RESOURCE_EXHAUSTED)
        self.assertIn("1048576", caught.exception.details())
        self.assertEqual(other.step()[0], rpc.RUNNING)

    def test_streams_are_counted(self):
        quiet = [self.stream() for _ in range(48)]
        for stream in quiet:
            stream.ask(leave_world=rpc.LeaveWorldRequest())
        with self.assertRaises(grpc.RpcError) as caught:
            self.stream().ask(leave_world=rpc.LeaveWorldRequest())
        self.assertEqual(caught.exception.code(), grpc.StatusCode.RESOURCE_EXHAUSTED)
        for stream in quiet:
            stream.close()
        for _ in range(50):
            try:
                self.assertEqual(self.agent().step()[0], rpc.RUNNING)
                return
            except grpc.RpcError:
                time.sleep(0.1)
        self.fail("no stream is taken any more")

    def test_a_run_that_is_killed_is_an_error_and_the_next_sequence_works(self):
        agent = self.agent()
        agent.step()
        runs = [pid for pid in children_of(self.here) if int(pid) != self.server.pid]
        self.assertEqual(len(runs), 1)
        os.kill(int(runs[0]), signal.SIGKILL)
        self.refused("UNAVAILABLE", "the run ended", agent.step)
        self.assertEqual(agent.time_ns(), 0)


class CommandLine(unittest.TestCase):
    def refused(self, code, words, *options):
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / "scenario.yaml").write_text(scenario("r0"))
            done = subprocess.run([SEAM, "serve", "scenario.yaml", "--listen", f"unix:{folder}/socket", *options], cwd=folder,
                                  capture_output=True, text=True, timeout=60)
        self.assertEqual((done.returncode, done.stdout), (code, ""), done.stderr)
        self.assertRegex(done.stderr, words)

    def test_options_that_do_not_go_together(self):
        for option in ("--log", "--frames", "--json", "--tokens", "--lines"):
            self.refused(2, f"{option}: expected without --dm-env-rpc", "--dm-env-rpc", option, "x")
        self.refused(2, "--logs: expected --dm-env-rpc with it", "--logs", "x")
        self.refused(2, "--drive r9: no robot", "--dm-env-rpc", "--drive", "r9")
        self.refused(2, "0.0.0.0:7211: plain connections", "--dm-env-rpc", "--listen", "0.0.0.0:7211")
        self.refused(1, "logs: cannot be made", "--dm-env-rpc", "--logs", "scenario.yaml/logs")

    def test_it_ends_with_the_program_that_started_it(self):
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / "scenario.yaml").write_text(scenario("r0"))
            server = subprocess.Popen([SEAM, "serve", "scenario.yaml", "--dm-env-rpc", "--listen", f"unix:{folder}/socket", "--until-eof"],
                                      cwd=folder, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
            server.stdout.readline()
            server.stdin.close()
            self.assertEqual(server.wait(30), 0)
            server.stdout.close()


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
