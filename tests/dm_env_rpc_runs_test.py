#!/usr/bin/env python3
"""Runs of `seam serve --dm-env-rpc`: the bits and logs of any other client's run, and two agents in one world.

Usage: dm_env_rpc_runs_test.py BUILD_DIR SOURCE_DIR [unittest arguments], by the interpreter that has gRPC.
"""
import subprocess
import sys
import threading
import time
import unittest

# Before the SDK, whose place it knows.
from dm_client import BUILD, SEAM, SOURCE, Case, number, properties, rpc, scenario, seed, tensor
import seam_sdk


class Runs(Case):
    """The same simulation as by any other client, with the same logs."""
    text = scenario("r0").replace("ers210.yaml,", f"ers210.yaml, colour_table: {SOURCE}/models/colour_table_2002.yaml,")
    orders = [{"walk.vx_m_s": 0.1, "joints.pan_rad": 0.3}, {}, {"joints.tilt_rad": -0.4}, {"walk.omega_rad_s": 0.5}] + 20 * [{}]

    def play(self, agent, observations=()):
        agent.step(observations=observations)
        seen = []
        for order in self.orders:
            state, values = agent.step({name: number(value) for name, value in order.items()}, observations)
            seen.append(values)
            if state != rpc.RUNNING:
                break
        return seen

    def seam(self, *words):
        done = subprocess.run([SEAM, *words], cwd=self.here, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def test_its_log_is_that_of_a_script_which_decides_the_same(self):
        agent = self.agent(seed(21))
        seen = self.play(agent, ["camera.rgb", "camera.colours", "camera.frame_index"])
        log = self.here / "logs" / f"{agent.world}-1.mcap"
        walk, frames = {}, []
        with seam_sdk.World(self.here / "scenario.yaml", seed=21, log=self.here / "script.mcap") as world:
            for number_of_turn, order in enumerate(self.orders):
                decision = seam_sdk.Decision()
                if number_of_turn == 0:
                    decision.request_all_frames()
                joints = {name[7:-4]: value for name, value in order.items() if name.startswith("joints.")}
                if joints:
                    decision.joints(joints)
                if any(name.startswith("walk.") for name in order):
                    walk |= {name[5:]: value for name, value in order.items() if name.startswith("walk.")}
                    decision.walk(**walk)
                for robot in world.step({"r0": decision}).values():
                    frames += robot.frames
                if world.done:
                    break
        self.seam("diff", log, "script.mcap")
        self.assertGreater(len(frames), 2)
        self.assertEqual(seen[-1]["camera.rgb"].uint8s.array, frames[-1].rgb)
        colours = seen[-1]["camera.colours"]
        self.assertEqual((colours.uint8s.array, list(colours.shape)), (frames[-1].colours, [18, 16]))
        self.assertGreater(len(set().union(*(values["camera.colours"].uint8s.array for values in seen))), 2)
        self.assertEqual(seen[-1]["camera.frame_index"].int64s.array[0], frames[-1].index)
        self.assertEqual(set(seen[0]["camera.rgb"].uint8s.array), {0})  # Before the first frame.
        # What is done with a log.
        self.seam("replay", "verify", log)
        (self.here / "still.py").write_text(f"#!{sys.executable}\nimport sys\nsys.path.insert(0, {str(BUILD / 'python')!r})\n"
                                            "import seam_sdk\nfor seen in seam_sdk.Robot().observations():\n    pass\n")
        (self.here / "still.py").chmod(0o755)
        said = self.seam("replay", "whatif", log, "--robot", "r0", "--client", "./still.py", "--log", "whatif.mcap")
        self.assertNotEqual(said, "")
        self.seam("replay", "verify", "whatif.mcap")

    def test_the_same_seed_gives_the_same_and_each_sequence_has_the_next(self):
        agent = self.agent(seed(30))
        names = ["acceleration_m_s2", "angular_velocity_rad_s", "odometry.x_m", "joint_log.time_ns", "joint_log.pan_rad"]
        first, second = self.play(agent, names), self.play(agent, names)
        self.assertNotEqual(first, second)
        agent.ask(reset=rpc.ResetRequest(settings=seed(30)))
        self.assertEqual(self.play(agent, names), first)
        agent.ask(reset_world=rpc.ResetWorldRequest(world_name=agent.world, settings=seed(31)))
        self.assertEqual(self.play(agent, names), second)
        logs = [self.here / "logs" / f"{agent.world}-{number}.mcap" for number in (1, 2, 3, 4)]
        self.seam("diff", logs[0], logs[2])
        self.seam("diff", logs[1], logs[3])


class TwoAgents(Case):
    text = scenario("r0", "r1", more="    token: secret-of-ID\n")

    def both(self):
        first, second = self.stream(), self.stream()
        first.world = first.create()
        first.join(first.world, "r0", token=tensor("strings", ["secret-of-r0"]))
        second.join(first.world, "r1", token=tensor("strings", ["secret-of-r1"]))
        return first, second

    def together(self, *asks):
        """Asks on threads of their own; the answers."""
        found = [None] * len(asks)

        def one(place):
            try:
                found[place] = asks[place]()
            except Exception as error:  # For whoever looks at the answers.
                found[place] = error
        threads = [threading.Thread(target=one, args=[place]) for place in range(len(asks))]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(60)
        self.assertNotIn(None, found)
        return found

    def test_a_token_that_the_scenario_gives_is_asked_for(self):
        stream = self.stream()
        world = stream.create()
        self.refused("UNAUTHENTICATED", "'token'", stream.join, world, "r1")
        self.refused("UNAUTHENTICATED", "'token'", stream.join, world, "r1", token=tensor("strings", ["secret-of-r0"]))
        stream.join(world, "r1", token=tensor("strings", ["secret-of-r1"]))

    def test_agents_step_in_lockstep_and_one_may_leave(self):
        first, second = self.both()
        for time_ns in (0, 32_000_000, 64_000_000):
            self.assertEqual(self.together(first.time_ns, second.time_ns), [time_ns] * 2)
        # A message from one to the other, which arrives after 20 ms, within the step.
        _, (_, seen) = self.together(lambda: first.step({"radio": tensor("uint8s", b"hello", [-1])}),
                                     lambda: second.step(observations=["radio.from", "radio.bytes", "radio.lengths"]))
        self.assertEqual((list(seen["radio.from"].strings.array), seen["radio.bytes"].uint8s.array, list(seen["radio.lengths"].int64s.array)),
                         (["r0"], b"hello", [5]))
        self.refused("OUT_OF_RANGE", "'radio'", first.step, {"radio": tensor("uint8s", bytes(5000), [5000])})
        first.ask(leave_world=rpc.LeaveWorldRequest())
        states = []
        while not states or states[-1] == rpc.RUNNING:
            states.append(second.step()[0])
        self.assertEqual(states[-1], rpc.TERMINATED)
        self.assertGreater(len(states), 3)

    @staticmethod
    def until(state, agent):
        """Steps of an agent while others do something; how many there were."""
        steps = 1
        while agent.step()[0] != state:
            steps += 1
        return steps

    def test_a_reset_of_the_world_interrupts_the_others(self):
        first, second = self.both()
        self.together(first.step, second.step)
        self.together(first.step, second.step)
        reset, steps = self.together(lambda: first.ask(reset_world=rpc.ResetWorldRequest(world_name=first.world)),
                                     lambda: self.until(rpc.INTERRUPTED, second))
        self.assertIsInstance(reset, rpc.ResetWorldResponse)
        self.assertEqual(steps, 1)  # It waited for the other agent.
        self.assertEqual(self.together(first.time_ns, second.time_ns), [0, 0])
        # By a stream that has joined nothing.
        self.together(first.step, second.step)
        found = self.together(lambda: self.stream().ask(reset_world=rpc.ResetWorldRequest(world_name=first.world)),
                              lambda: self.until(rpc.INTERRUPTED, first), lambda: self.until(rpc.INTERRUPTED, second))
        self.assertEqual([type(answer) for answer in found], [rpc.ResetWorldResponse, int, int])

    def test_an_agent_that_resets_waits_for_the_others(self):
        first, second = self.both()
        self.together(first.step, second.step)
        first.ask(reset=rpc.ResetRequest())
        restarted, again = self.together(first.time_ns, lambda: self.until(rpc.TERMINATED, second) and second.time_ns())
        self.assertEqual((restarted, again), (0, 0))

    def test_a_sequence_does_not_wait_for_ever_for_agents_that_do_not_come(self):
        stream = self.stream()
        stream.join(stream.create(), "r0", token=tensor("strings", ["secret-of-r0"]))
        began = time.monotonic()
        self.refused("DEADLINE_EXCEEDED", ["waits for agents that join as r1", "--drive"], stream.step)
        self.assertGreater(time.monotonic() - began, 15)


class OneDriven(Case):
    """Of two robots one: the other one's behaviour is started."""
    text = scenario("r0", "r1", behaviour="command: [head_swing], ")
    options = ("--drive", "r1")

    def test_the_others_have_their_behaviours(self):
        agent = self.agent()
        self.assertEqual(list(agent.property(read_property=properties.ReadPropertyRequest(key="robots")).value.strings.array), ["r1"])
        for time_ns in (0, 32_000_000, 64_000_000):
            self.assertEqual(agent.time_ns(), time_ns)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
