"""A client of `seam serve --dm-env-rpc` for tests: streams, tensors, and a server of a test's own.

Its messages are made by protoc, so that it needs no package but gRPC's.
"""
import pathlib
import queue
import subprocess
import sys
import tempfile
import unittest

import grpc
import by_hand
import one_robot

BUILD, SOURCE = by_hand.arguments("build", "source")
sys.path.insert(0, str(BUILD / "python"))
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


def scenario(*robots, behaviour="", more=""):
    return one_robot.turns_of(SOURCE, "learning", *robots, behaviour=behaviour,
                              more="    sensors: {accelerometer: {sigma: 0.01}, gyroscope: {sigma: 0.01}}\n" + more)


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
