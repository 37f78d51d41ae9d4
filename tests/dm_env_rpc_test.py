#!/usr/bin/env python3
"""`seam serve --dm-env-rpc`: what the documentation of dm_env_rpc says of worlds, agents, sequences, tensors and properties.

Usage: dm_env_rpc_test.py BUILD_DIR SOURCE_DIR [unittest arguments], by the interpreter that has gRPC.
"""
import sys
import time
import unittest

from dm_client import PAYLOADS, Case, Refused, number, properties, rpc, scenario, seed, tensor


class Worlds(Case):
    options = ("--worlds", "3")

    def test_worlds_are_made_joined_left_and_destroyed(self):
        stream = self.stream()
        first, second = stream.create(), stream.create(seed(3))
        self.assertNotEqual(first, second)
        stream.ask(leave_world=rpc.LeaveWorldRequest())  # Joined to none: nothing happens.
        stream.join(first)
        self.refused("FAILED_PRECONDITION", ["has joined", first, "leave_world first"], stream.join, second)
        self.refused("FAILED_PRECONDITION", "joined as r0", stream.ask, destroy_world=rpc.DestroyWorldRequest(world_name=first))
        other = self.stream()
        self.refused("ALREADY_EXISTS", "another agent", other.join, first)
        stream.ask(leave_world=rpc.LeaveWorldRequest())
        other.join(first)
        other.ask(leave_world=rpc.LeaveWorldRequest())
        stream.join(first)  # Again, after leaving.
        stream.ask(leave_world=rpc.LeaveWorldRequest())
        # Not only by whoever made it.
        other.ask(destroy_world=rpc.DestroyWorldRequest(world_name=first))
        self.refused("NOT_FOUND", first, stream.join, first)
        stream.ask(destroy_world=rpc.DestroyWorldRequest(world_name=second))

    def test_what_is_not_there_is_refused(self):
        stream = self.stream()
        self.refused("NOT_FOUND", "no world 'foo'", stream.join, "foo")
        self.refused("NOT_FOUND", "no world 'foo'", stream.ask, destroy_world=rpc.DestroyWorldRequest(world_name="foo"))
        self.refused("NOT_FOUND", "no world 'foo'", stream.ask, reset_world=rpc.ResetWorldRequest(world_name="foo"))
        self.refused("FAILED_PRECONDITION", "has not joined", stream.ask, step=rpc.StepRequest())
        self.refused("FAILED_PRECONDITION", "has not joined", stream.ask, reset=rpc.ResetRequest())
        self.refused("INVALID_ARGUMENT", "no setting 'map', expected seed", stream.create, {"map": number(1)})
        self.refused("INVALID_ARGUMENT", "found type DOUBLE, expected an integer", stream.create, {"seed": number(1)})
        self.refused("OUT_OF_RANGE", "2^62", stream.create, seed(2**63 - 1))
        self.refused("INVALID_ARGUMENT", "found 2 elements", stream.create, {"seed": tensor("int64s", [1, 2], [2])})
        world = stream.create()
        self.refused("NOT_FOUND", ["'r7'", "expected one of: r0"], stream.join, world, "r7")
        self.refused("INVALID_ARGUMENT", "expected type STRING", stream.join, world, robot=None, token=number(1))
        self.refused("INVALID_ARGUMENT", "no setting 'colour', expected robot, token", stream.join, world, colour=number(1))

    def test_there_are_no_more_worlds_than_allowed(self):
        stream = self.stream()
        names = [stream.create() for _ in range(3)]
        self.refused("RESOURCE_EXHAUSTED", "destroy one", stream.create)
        stream.ask(destroy_world=rpc.DestroyWorldRequest(world_name=names[0]))
        self.assertNotIn(stream.create(), names)

    def test_a_stream_that_breaks_leaves_its_world(self):
        agent = self.agent()
        agent.step()
        agent.close()
        other = self.stream()
        for _ in range(100):
            try:
                other.join(agent.world)
                break
            except Refused:
                time.sleep(0.1)
        self.assertEqual(other.step()[0], rpc.RUNNING)

    def test_properties(self):
        stream = self.stream()
        listed = {value.spec.name: value for value in stream.property(list_property=properties.ListPropertyRequest()).values}
        self.assertEqual(sorted(listed), ["duration_s", "robots", "scenario", "version"])
        self.assertTrue(all(value.is_readable and not value.is_writable and value.description for value in listed.values()))

        def read(key):
            return stream.property(read_property=properties.ReadPropertyRequest(key=key)).value

        def write(key, value):
            return stream.property(write_property=properties.WritePropertyRequest(key=key, value=value))

        self.assertEqual(read("duration_s").doubles.array, [0.5])
        self.assertEqual(list(read("robots").strings.array), ["r0"])
        self.refused("NOT_FOUND", "once it is joined", read, "world.seed")
        stream.join(stream.create(seed(11)))
        below = {value.spec.name: value
                 for value in stream.property(list_property=properties.ListPropertyRequest(key="world")).values}
        self.assertTrue(below["world.seed"].is_writable and below["world.seed"].spec.dtype == rpc.INT64)
        self.assertEqual(read("world.seed").int64s.array, [11])
        write("world.seed", tensor("int32s", [40]))
        stream.step()
        self.assertEqual([read("world.seed").int64s.array[0], read("world.sequence").int64s.array[0]], [41, 1])
        self.assertEqual(read("world.robot").strings.array, ["r0"])
        self.assertTrue((self.here / "logs" / read("world.log").strings.array[0]).is_file())
        self.refused("PERMISSION_DENIED", "cannot be written", write, "world.robot", tensor("strings", ["r1"]))
        self.refused("INVALID_ARGUMENT", "expected an integer", write, "world.seed", number(1))
        self.refused("PERMISSION_DENIED", "no value", read, "world")
        self.refused("NOT_FOUND", "no property 'truth'", read, "truth")
        self.refused("INVALID_ARGUMENT", "none below", stream.property, list_property=properties.ListPropertyRequest(key="robots"))
        self.refused("INVALID_ARGUMENT", "empty PropertyRequest", stream.property)
        request = rpc.EnvironmentRequest()
        request.extension.Pack(rpc.StepRequest())
        stream.send_bytes(request.SerializeToString())
        self.refused("UNIMPLEMENTED", "StepRequest", stream.next)


class Steps(Case):
    def test_specs(self):
        specs = self.agent().specs
        for group in (specs.actions, specs.observations):
            names = [spec.name for spec in group.values()]
            self.assertEqual(len(names), len(set(names)))
            self.assertTrue(all(spec.dtype in PAYLOADS and sum(size < 0 for size in spec.shape) <= 1 for spec in group.values()))
        actions = {spec.name: spec for spec in specs.actions.values()}
        self.assertEqual(len([name for name in actions if name.startswith("joints.")]), 15)
        pan = actions["joints.pan_rad"]
        self.assertTrue(-2 < pan.min.doubles.array[0] < 0 < pan.max.doubles.array[0] < 2)
        self.assertEqual([actions["kick"].min.int32s.array[0], actions["kick"].max.int32s.array[0]], [0, 7])
        observed = {spec.name: spec for spec in specs.observations.values()}
        self.assertEqual(list(observed["camera.rgb"].shape), [36, 44, 3])
        self.assertFalse([name for name in observed if "truth" in name or "ball" in name])

    def test_observations_are_those_that_were_asked_for_and_as_specified(self):
        agent = self.agent()
        everything = list(agent.observations)
        for observations in ([], everything, everything * 2, *([name] for name in everything), everything):
            state, seen = agent.step(observations=observations)
            self.assertEqual((state, set(seen)), (rpc.RUNNING, set(observations)))
            for name, value in seen.items():
                spec = agent.specs.observations[agent.observations[name]]
                self.assertEqual(value.WhichOneof("payload"), PAYLOADS[spec.dtype], name)
                self.assertEqual(len(value.shape), len(spec.shape), name)
                self.assertTrue(all(want in (-1, got) for want, got in zip(spec.shape, value.shape)), name)
                array = getattr(value, PAYLOADS[spec.dtype]).array
                elements = 1
                for size in value.shape:
                    elements *= size
                self.assertEqual(len(array), elements, name)
            agent.ask(reset=rpc.ResetRequest())
        self.refused("NOT_FOUND", "observation 4711", agent.step, observations=[4711])

    def test_a_sequence_has_a_beginning_and_an_end(self):
        agent = self.agent()
        # The first step brings the first observations; its actions are ignored, whatever they are.
        self.assertEqual(agent.step({4711: number(9), "joints.pan_rad": number(1e9)})[0], rpc.RUNNING)
        times, states = [], []
        while not states or states[-1] == rpc.RUNNING:
            state, seen = agent.step({"joints.pan_rad": number(0.5)}, ["time_ns", "joints.pan_rad"])
            states.append(state)
            times.append(seen["time_ns"].int64s.array[0])
        self.assertEqual(states[-1], rpc.TERMINATED)
        self.assertEqual(times[-1], times[-2])  # The last ones again.
        self.assertTrue(all(b - a == 32_000_000 for a, b in zip(times[:-1], times[1:-1])), times)
        self.assertGreater(seen["joints.pan_rad"].doubles.array[0], 0.4)
        # The next step begins another one, by itself.
        state, seen = agent.step(observations=["time_ns", "joints.pan_rad"])
        self.assertEqual((state, seen["time_ns"].int64s.array[0]), (rpc.RUNNING, 0))
        self.assertLess(abs(seen["joints.pan_rad"].doubles.array[0]), 0.01)

    def test_reset_ends_a_sequence_and_sends_the_specs_again(self):
        agent = self.agent()
        for _ in range(2):  # Also where none goes on.
            self.assertEqual(agent.ask(reset=rpc.ResetRequest()).specs, agent.specs)
        self.assertEqual([agent.time_ns() for _ in range(3)], [0, 32_000_000, 64_000_000])
        self.assertEqual(agent.ask(reset=rpc.ResetRequest()).specs, agent.specs)
        self.assertEqual(agent.time_ns(), 0)
        agent.ask(reset_world=rpc.ResetWorldRequest(world_name=agent.world))
        self.assertEqual(agent.time_ns(), 0)
        self.refused("INVALID_ARGUMENT", "no setting 'x'", agent.ask, reset=rpc.ResetRequest(settings={"x": number(1)}))

    def test_bad_actions_are_refused_and_change_nothing(self):
        agent = self.agent()
        self.assertEqual(agent.time_ns(), 0)
        pan = agent.specs.actions[agent.actions["joints.pan_rad"]]
        bad = [
            ("NOT_FOUND", "action 4711", {4711: number(0)}),
            ("INVALID_ARGUMENT", "found type FLOAT, expected type DOUBLE", {"joints.pan_rad": tensor("floats", [0])}),
            ("INVALID_ARGUMENT", "found type STRING", {"joints.pan_rad": tensor("strings", ["left"])}),
            ("INVALID_ARGUMENT", "without values", {"joints.pan_rad": rpc.Tensor()}),
            ("INVALID_ARGUMENT", "found shape [1], expected []", {"joints.pan_rad": tensor("doubles", [0], [1])}),
            ("INVALID_ARGUMENT", "found shape [-1, -1]", {"joints.pan_rad": tensor("doubles", [0], [-1, -1])}),
            ("INVALID_ARGUMENT", "found 2 elements, expected 1", {"joints.pan_rad": tensor("doubles", [0, 0])}),
            ("INVALID_ARGUMENT", "found 0 elements", {"joints.pan_rad": tensor("doubles", [])}),
            ("INVALID_ARGUMENT", "found shape [2147483647,", {"kick": tensor("int32s", [0], [2**31 - 1] * 9)}),
            ("OUT_OF_RANGE", "found nan", {"joints.pan_rad": number(float("nan"))}),
            ("OUT_OF_RANGE", "joints.pan_rad", {"joints.pan_rad": number(pan.max.doubles.array[0] + 1e-6)}),
            ("OUT_OF_RANGE", "joints.pan_rad", {"joints.pan_rad": number(-float("inf"))}),
            ("OUT_OF_RANGE", "found 8, expected 0 to 7", {"kick": tensor("int32s", [8])}),
            # One bad one spoils all.
            ("OUT_OF_RANGE", "walk.vx_m_s", {"joints.pan_rad": number(1), "walk.vx_m_s": number(99)}),
        ]
        for code, words, actions in bad:
            with self.subTest(words=words):
                self.refused(code, words, agent.step, actions)
        _, seen = agent.step(observations=["time_ns", "joints.pan_rad"])
        self.assertEqual(seen["time_ns"].int64s.array[0], 32_000_000)
        self.assertLess(abs(seen["joints.pan_rad"].doubles.array[0]), 0.01)
        for name, uid in agent.actions.items():
            spec = agent.specs.actions[uid]
            least = getattr(spec.min, PAYLOADS[spec.dtype]).array
            agent.step({name: tensor(PAYLOADS[spec.dtype], least)})
            agent.ask(reset=rpc.ResetRequest())
            agent.step()

    def test_requests_may_be_sent_before_earlier_ones_are_answered(self):
        agent = self.agent()
        for _ in range(40):
            agent.send(step=agent.step_request(observations=["time_ns"]))
        times = [agent.next().observations[agent.observations["time_ns"]].int64s.array[0] for _ in range(40)]
        self.assertEqual(times[:3] + times[-1:], [0, 32_000_000, 64_000_000, times[39]])
        self.assertEqual(times.count(0), 3)  # A third sequence.


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
