#!/usr/bin/env python3
"""`seam serve --dm-env-rpc`: what the documentation of dm_env_rpc says of worlds, agents, sequences, tensors, properties and
errors; the bits and logs of any other client's run; clients that send nonsense.

Usage: dm_env_rpc_test.py BUILD_DIR SOURCE_DIR [unittest arguments], by the interpreter that has gRPC.
"""
import os
import pathlib
import queue
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import grpc
import by_hand

BUILD, SOURCE = by_hand.arguments("build", "source")
sys.path.insert(0, str(BUILD / "python"))
import seam_sdk  # noqa: E402

SEAM = BUILD / "seam"
STUBS = tempfile.TemporaryDirectory()
PROTOS = ["google/rpc/status", "dm_env_rpc/v1/dm_env_rpc", "dm_env_rpc/v1/extensions/properties"]
subprocess.run(["protoc", f"--python_out={STUBS.name}", "-I", SOURCE / "proto", *(f"{name}.proto" for name in PROTOS)], check=True)
sys.path.insert(0, STUBS.name)
import google  # noqa: E402

google.__path__ = [*google.__path__, f"{STUBS.name}/google"]
from dm_env_rpc.v1 import dm_env_rpc_pb2 as rpc  # noqa: E402
from dm_env_rpc.v1.extensions import properties_pb2 as properties  # noqa: E402

CODES = {code.value[0]: code.name for code in grpc.StatusCode}
PAYLOADS = {rpc.DOUBLE: "doubles", rpc.INT32: "int32s", rpc.INT64: "int64s", rpc.UINT8: "uint8s", rpc.BOOL: "bools",
            rpc.STRING: "strings"}
ROBOT = """  - id: ID
    team: red
    pose: {x_m: X, y_m: 0.4, theta_rad: 0.3}
    body: SOURCE/models/robot_ers210.yaml
    camera: {model: SOURCE/models/ers210.yaml, width_px: 44, height_px: 36, clock: {period_s: 0.1}}
    behaviour: {clock: {period_s: 0.032}}
    sensors: {accelerometer: {sigma: 0.01}}
"""


def scenario(*robots, duration_s=0.5, more=""):
    text = f"format: seam-scenario/1\nname: learning\nduration_s: {duration_s}\nseed: 5\nfield: SOURCE/models/field_2002.yaml\nrobots:\n"
    for number, name in enumerate(robots):
        text += (ROBOT + more).replace("ID", name).replace("X", str(number - 0.9))
    return text.replace("SOURCE", str(SOURCE))


class Refused(Exception):
    def __init__(self, error):
        super().__init__(f"{CODES[error.code]}: {error.message}")
        self.code, self.text = CODES[error.code], error.message


def tensor(kind, value, shape=()):
    made = rpc.Tensor(shape=shape)
    array = getattr(made, kind)
    if kind in ("uint8s", "int8s"):
        array.array = bytes(value)
    else:
        array.array.extend(value)
    array.SetInParent()
    return made


def number(value):
    return tensor("doubles", [value])


def seed(value):
    return {"seed": tensor("int64s", [value])}


class Stream:
    """One stream of a client."""

    def __init__(self, address):
        self.channel = grpc.insecure_channel(address)
        self.requests = queue.Queue()
        process = self.channel.stream_stream("/dm_env_rpc.v1.Environment/Process", request_serializer=bytes,
                                             response_deserializer=rpc.EnvironmentResponse.FromString)
        self.responses = process(iter(self.requests.get, None))

    def send_bytes(self, data):
        self.requests.put(data)

    def send(self, **payload):
        self.send_bytes(rpc.EnvironmentRequest(**payload).SerializeToString())

    def next(self):
        response = next(self.responses)
        kind = response.WhichOneof("payload")
        if kind == "error":
            raise Refused(response.error)
        return getattr(response, kind)

    def ask(self, **payload):
        self.send(**payload)
        return self.next()

    def create(self, settings=None):
        return self.ask(create_world=rpc.CreateWorldRequest(settings=settings)).world_name

    def join(self, world, robot=None, **settings):
        if robot:
            settings["robot"] = tensor("strings", [robot])
        self.specs = self.ask(join_world=rpc.JoinWorldRequest(world_name=world, settings=settings)).specs
        self.actions = {spec.name: uid for uid, spec in self.specs.actions.items()}
        self.observations = {spec.name: uid for uid, spec in self.specs.observations.items()}
        return self.specs

    def step_request(self, actions=None, observations=()):
        return rpc.StepRequest(actions={self.actions.get(name, name): value for name, value in (actions or {}).items()},
                               requested_observations=[self.observations.get(name, name) for name in observations])

    def step(self, actions=None, observations=()):
        """The state, and what was asked for by name."""
        response = self.ask(step=self.step_request(actions, observations))
        names = {uid: name for name, uid in self.observations.items()}
        return response.state, {names[uid]: value for uid, value in response.observations.items()}

    def time_ns(self, actions=None):
        return self.step(actions, ["time_ns"])[1]["time_ns"].int64s.array[0]

    def property(self, **payload):
        request = rpc.EnvironmentRequest()
        request.extension.Pack(properties.PropertyRequest(**payload))
        self.send_bytes(request.SerializeToString())
        response = properties.PropertyResponse()
        self.next().Unpack(response)
        return getattr(response, response.WhichOneof("payload"))

    def close(self):
        self.requests.put(None)
        self.responses.cancel()
        self.channel.close()


class Case(unittest.TestCase):
    text = scenario("r0")
    options = ()

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.here = pathlib.Path(folder.name)
        (self.here / "scenario.yaml").write_text(self.text)
        self.address = f"unix:{self.here}/socket"
        self.server = subprocess.Popen([SEAM, "serve", "scenario.yaml", "--dm-env-rpc", "--listen", self.address, "--logs", "logs",
                                        *self.options], cwd=self.here, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(self.end)
        self.assertRegex(self.server.stdout.readline(), "^listening on unix:")

    def end(self):
        """The server ends cleanly, and its runs with it."""
        if self.server.poll() is None:
            self.server.terminate()
        out, errors = self.server.communicate(timeout=30)
        self.assertEqual((self.server.returncode, out, errors), (0, "", ""))
        self.assertEqual(children_of(self.here), [])

    def stream(self):
        made = Stream(self.address)
        self.addCleanup(made.close)
        return made

    def agent(self, settings=None, robot=None):
        """A stream that has joined a new world."""
        made = self.stream()
        made.world = made.create(settings)
        made.join(made.world, robot)
        return made

    def refused(self, code, words, ask, *arguments, **named):
        with self.assertRaises(Refused) as caught:
            ask(*arguments, **named)
        self.assertEqual(caught.exception.code, code, str(caught.exception))
        for word in [words] if isinstance(words, str) else words:
            self.assertIn(word, caught.exception.text)


def children_of(folder):
    """Simulators that still run below this folder."""
    found = []
    for entry in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            if (entry / "cwd").resolve() == folder and (entry / "exe").resolve() == SEAM.resolve():
                found.append(entry.name)
        except OSError:
            pass
    return found


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


class Runs(Case):
    """The same simulation as by any other client, with the same logs."""
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
        seen = self.play(agent, ["camera.rgb", "camera.frame_index"])
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
        names = ["acceleration_m_s2", "odometry.x_m", "joint_log.time_ns", "joint_log.pan_rad"]
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
    text = scenario("r0", "r1").replace("behaviour: {clock", "behaviour: {command: [head_swing], clock")
    options = ("--drive", "r1")

    def test_the_others_have_their_behaviours(self):
        agent = self.agent()
        self.assertEqual(list(agent.property(read_property=properties.ReadPropertyRequest(key="robots")).value.strings.array), ["r1"])
        for time_ns in (0, 32_000_000, 64_000_000):
            self.assertEqual(agent.time_ns(), time_ns)


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
