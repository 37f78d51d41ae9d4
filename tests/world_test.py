#!/usr/bin/env python3
"""Worlds that a script drives step by step: the bits of `seam run`, and what happens when something goes wrong.

Usage: world_test.py BUILD_DIR SOURCE_DIR [unittest arguments], by the interpreter that has gRPC.
"""
import math
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import textwrap
import time
import unittest

import by_hand
import one_robot

BUILD, SOURCE = by_hand.arguments("build", "source")
sys.path.insert(0, str(BUILD / "python"))
import seam_sdk  # noqa: E402

SEAM = BUILD / "seam"
# Depends on frames, values and its own name.
BEHAVIOUR = f"""#!{sys.executable}
import sys
sys.path.insert(0, {str(BUILD / "python")!r})
import seam_sdk
from rules import decide
robot = seam_sdk.Robot()
for seen in robot.observations():
    decide(robot, seen)
"""
RULES = """
def decide(orders, seen):
    if seen.sequence == 1:
        orders.request_all_frames()
    orders.head(pan_rad=0.3 * seen.time_s, tilt_rad=0.001 * sum(sum(frame.rgb[:9]) for frame in seen.frames))
    orders.walk(vx_m_s=0.1)
    orders.log_value("paws", sum(seen.sensors.paw_contact))
"""


def scenario(*robots, limit_s=30):
    return one_robot.turns_of(SOURCE, "world", *robots, behaviour=f"command: [./bot.py], silence: abort, wall_limit_s: {limit_s}, ",
                              phases_s=[0, 0.016])


def servers(folder):
    """Processes of simulators whose scenario is below this folder."""
    found = []
    for entry in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            if str(folder).encode() in (entry / "cmdline").read_bytes() and (entry / "exe").resolve() == SEAM:
                found.append(int(entry.name))
        except OSError:
            pass
    return found


class World(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.here = pathlib.Path(folder.name)
        (self.here / "rules.py").write_text(RULES)
        (self.here / "bot.py").write_text(BEHAVIOUR)
        (self.here / "bot.py").chmod(0o755)
        (self.here / "one.yaml").write_text(scenario("r0"))
        (self.here / "three.yaml").write_text(scenario("r0", "r1", "r2"))
        before = os.getcwd()
        os.chdir(self.here)
        self.addCleanup(os.chdir, before)
        rules = {}
        exec(RULES, rules)
        self.decide = rules["decide"]

    def run_by_seam(self, name, *options):
        done = subprocess.run([SEAM, "run", f"{name}.yaml", "--log", f"{name}.mcap", "--force", *options], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return re.search(r"fingerprint\W+(\w{16})", done.stdout)[1]

    def equal(self, *logs):
        done = subprocess.run([SEAM, "diff", *logs], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def play(self, world):
        turns = []
        while not world.done:
            decisions = {}
            for name, seen in world.observations.items():
                self.assertEqual(seen.time_ns, world.time_ns)
                decisions[name] = seam_sdk.Decision()
                self.decide(decisions[name], seen)
            turns.append((world.time_ns, sorted(decisions)))
            world.step(decisions)
        return turns

    def test_a_script_that_decides_as_a_behaviour_makes_its_log(self):
        self.run_by_seam("one", "--seed", "7")
        with seam_sdk.World("one.yaml", seed=7, log="script.mcap") as world:
            self.assertGreater(len(self.play(world)), 10)
        self.equal("one.mcap", "script.mcap")

    def test_several_robots_are_asked_together_at_each_instant(self):
        self.run_by_seam("three")
        with seam_sdk.World("three.yaml", log="script.mcap") as world:
            self.assertEqual(sorted(world.robots), ["r0", "r1", "r2"])
            turns = self.play(world)
        self.assertEqual({tuple(names) for _, names in turns}, {("r0", "r2"), ("r1",)})
        self.equal("three.mcap", "script.mcap")

    def test_robots_that_are_not_driven_play_by_themselves(self):
        self.run_by_seam("three")
        with seam_sdk.World("three.yaml", robots=["r1"], log="script.mcap") as world:
            self.assertEqual({tuple(names) for _, names in self.play(world)}, {("r1",)})
        self.equal("three.mcap", "script.mcap")

    def test_reset_begins_anew_with_another_seed(self):
        with seam_sdk.World("one.yaml", seed=1) as world:
            first = world.observations["r0"]
            again = world.reset(seed=1)["r0"]
            self.assertEqual(first, again)
            world.step()
            other = world.reset(seed=2)["r0"]
            self.assertEqual((other.sequence, other.time_ns), (first.sequence, first.time_ns))
            self.play(world)
            self.assertTrue(world.done)
            self.assertEqual(world.observations, {})
            with self.assertRaisesRegex(seam_sdk.SeamError, "the run is over"):
                world.step()
            world.reset()
            self.assertFalse(world.done)

    def test_only_a_log_is_replaced(self):
        for file, content in (("notes.txt", "mine"), ("empty", "")):
            (self.here / file).write_text(content)
            with self.assertRaisesRegex(seam_sdk.SeamError, f"^{file}: exists and is no log$"):
                seam_sdk.World("one.yaml", log=file)
            self.assertEqual((self.here / file).read_text(), content)
        for _ in range(2):
            with seam_sdk.World("one.yaml", log="again.mcap") as world:
                world.step()

    def test_time_stands_still_for_as_long_as_a_person_thinks(self):
        (self.here / "one.yaml").write_text(scenario("r0", limit_s=4))
        self.run_by_seam("one")
        with seam_sdk.World("one.yaml", log="script.mcap") as world:
            time.sleep(5)  # Of 4 s that the scenario grants before it aborts.
            self.play(world)
        self.equal("one.mcap", "script.mcap")

    def test_truth_is_the_supervisors(self):
        with seam_sdk.World("one.yaml") as world:
            with self.assertRaisesRegex(seam_sdk.SeamError, "supervisor=True"):
                world.truth()
        with seam_sdk.World("one.yaml", supervisor=True) as world:
            truth = world.truth()
            self.assertAlmostEqual(truth.robots["r0"].x_m, -0.9, 3)
            world.step({"r0": seam_sdk.Decision().walk(vx_m_s=0.2)})
            self.assertEqual(world.truth().time_ns, world.time_ns)

    def test_expressions_are_watched_with_the_turns_of_each_robot(self):
        with self.assertRaisesRegex(seam_sdk.SeamError, "watch is the supervisor's"):
            seam_sdk.World("one.yaml", watch=["time_s"])
        with self.assertRaisesRegex(seam_sdk.SeamError, "watch.expressions: found 65, expected at most 64"):
            seam_sdk.World("one.yaml", supervisor=True, watch=["time_s"] * 65)
        self.run_by_seam("three")
        watch = ["truth.{robot}.x_m - truth.r1.x_m", "time_s", "{robot}.paws"]
        with seam_sdk.World("three.yaml", log="script.mcap", supervisor=True, watch=watch) as world:
            while not world.done:
                truth = world.truth().robots
                self.assertEqual(list(world.watched), list(world.observations))
                for name, seen in world.observations.items():
                    apart_m, time_s, paws = world.watched[name]
                    self.assertAlmostEqual(apart_m, truth[name].x_m - truth["r1"].x_m, 12)
                    self.assertEqual(time_s, seen.time_ns * 1e-9)
                    self.assertTrue(math.isnan(paws) if seen.sequence == 1 else paws == before[name])
                before = {**(before if world.time_ns else {}), **{name: sum(seen.sensors.paw_contact) for name, seen in world.observations.items()}}
                decisions = {name: seam_sdk.Decision() for name in world.observations}
                for name, decision in decisions.items():
                    self.decide(decision, world.observations[name])
                world.step(decisions)
            self.assertEqual([sorted(world.watched), world.watched["r0"][1]], [["r0", "r1", "r2"], 0.5])
        self.equal("three.mcap", "script.mcap")

    def test_mistakes_are_exceptions_with_the_servers_words(self):
        with self.assertRaisesRegex(seam_sdk.SeamError, "nothing.yaml"):
            seam_sdk.World("nothing.yaml")
        with self.assertRaisesRegex(seam_sdk.SeamError, "--drive r7: no robot of the scenario"):
            seam_sdk.World("one.yaml", robots=["r7"])
        with seam_sdk.World("one.yaml") as world:
            with self.assertRaisesRegex(seam_sdk.SeamError, "no robot 'red1' is driven here, expected one of: r0"):
                world.step({"red1": seam_sdk.Decision()})
            with self.assertRaisesRegex(ValueError, "no joint 'nose'"):
                world.step({"r0": seam_sdk.Decision().joints([seam_sdk.JointTarget("nose", 1)])})
            before = world.time_ns
            with self.assertRaisesRegex(seam_sdk.RefusedDecision, "r0: the decision was refused: walk.vx_m_s"):
                world.step({"r0": seam_sdk.Decision().walk(vx_m_s=float("nan"))})
            self.assertGreater(world.time_ns, before)
            world.step({"r0": seam_sdk.Decision().joints([seam_sdk.JointTarget("head_pan", 0.1)]) if "head_pan" in world.robots["r0"].joint_names
                        else seam_sdk.Decision()})
            os.kill(world.process, signal.SIGKILL)
            with self.assertRaises(seam_sdk.SeamError):
                for _ in range(3):
                    world.step()

    def test_the_server_ends_with_whoever_drives_it(self):
        script = textwrap.dedent(f"""\
            import sys
            sys.path.insert(0, {str(BUILD / "python")!r})
            import seam_sdk, time
            with seam_sdk.World({str(self.here / "one.yaml")!r}) as world:
                world.step()
                print("ready", flush=True)
                ACTION
            """)
        for action, end in (("raise RuntimeError", None), ("time.sleep(60)", signal.SIGINT), ("time.sleep(60)", signal.SIGKILL),
                            ("import os; os._exit(3)", None)):
            with self.subTest(action=action, end=end):
                with subprocess.Popen([sys.executable, "-c", script.replace("ACTION", action)], stdout=subprocess.PIPE,
                                      stderr=subprocess.DEVNULL, text=True) as process:
                    self.assertEqual(process.stdout.readline(), "ready\n")
                    if end:
                        self.assertEqual(len(servers(self.here)), 1)
                        time.sleep(0.5)  # It sleeps by then: Python loses an interrupt that meets a destructor.
                        process.send_signal(end)
                    process.wait(20)
                deadline = time.monotonic() + 10
                while servers(self.here) and time.monotonic() < deadline:
                    time.sleep(0.05)
                self.assertEqual(servers(self.here), [])

    def test_the_example_of_the_page_runs(self):
        page = (SOURCE / "docs/reference/sdk.md").read_text()
        example = re.search(r"```python\n(import seam_sdk\n.*?World.*?)```", page, re.S)[1]
        example = example.replace('"scenario.yaml"', '"one.yaml"')
        done = subprocess.run([sys.executable, "-c", example], capture_output=True, text=True, timeout=120,
                              env={**os.environ, "PYTHONPATH": str(BUILD / "python")})
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertRegex(done.stdout, r"went \d\.\d+ m")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
