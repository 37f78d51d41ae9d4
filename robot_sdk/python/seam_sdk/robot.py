"""A robot's connection to the server: observations come, decisions go."""
from __future__ import annotations

import argparse
import contextlib
import dataclasses
import functools
import io
import os
import pathlib
import queue
import sys
import time
from typing import Callable, Iterable, Iterator, Sequence

import grpc
from seam.v1 import simulation_pb2 as wire
from seam.v1 import simulation_pb2_grpc as service

from .line import DirectLine, LineError
from .observation import Observation, from_wire
from .orders import Orders
from .standby import stand_by

MOST_SERVER_MESSAGE_BYTES = 64 << 20
_CHANNEL_OPTIONS = (
    ("grpc.max_receive_message_length", MOST_SERVER_MESSAGE_BYTES),
    ("grpc.http2.bdp_probe", 0),  # Small messages in lockstep: no probing.
    ("grpc.keepalive_time_ms", 10_000),
    ("grpc.keepalive_timeout_ms", 5_000),
    ("grpc.http2.max_pings_without_data", 0),
    ("grpc.initial_reconnect_backoff_ms", 50),
    ("grpc.max_reconnect_backoff_ms", 500),
)
# Worth another try: the server is not up yet, or the connection broke.
_PASSING = (grpc.StatusCode.UNAVAILABLE, grpc.StatusCode.CANCELLED, grpc.StatusCode.DEADLINE_EXCEEDED,
            grpc.StatusCode.INTERNAL)
_REPORTED_AFTER_S = 2.0  # Without a connection.


class SeamError(Exception):
    """The server cannot be reached, or refuses the client; the text says what was found."""


@dataclasses.dataclass(frozen=True)
class Refusal:
    """A decision that the server refused as a whole: the field, what was found and what was expected."""
    field: str
    message: str


@dataclasses.dataclass(frozen=True)
class Connection:
    address: str  # "unix:/path", "host:port".
    robot: str
    token: str
    # A directory with ca.pem, client.pem and client.key (as `seam certs` makes it): TLS. Empty: plain, which the
    # server accepts on a Unix socket or loopback only.
    certificates: str = ""
    give_up_s: float = 60.0  # Wall time for connecting, and for reconnecting after a lost connection.
    # A Unix socket of the same server for direct lines, which make quicker turns than gRPC does; empty: none.
    line: str = ""

    @staticmethod
    def from_arguments(arguments: Sequence[str] | None = None) -> Connection:
        """From --address, --robot, --token, --certs, or else SEAM_ADDRESS, SEAM_ROBOT, SEAM_TOKEN, SEAM_CERTS.

        `seam run` sets the environment. SEAM_LINE counts where no --address is given. Other arguments are left alone.
        """
        stand_by()
        # `seam run` reads what is printed through a pipe, and gives each line the time at which it came.
        if isinstance(sys.stdout, io.TextIOWrapper):
            sys.stdout.reconfigure(line_buffering=True)
        parser = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
        for option in ("address", "robot", "token", "certs"):
            parser.add_argument("--" + option)
        given, _ = parser.parse_known_args(arguments)
        found = [value or os.environ.get("SEAM_" + name.upper(), "") for name, value in vars(given).items()]
        return Connection(*found, line="" if given.address else os.environ.get("SEAM_LINE", ""))


def _open_channel(connection: Connection) -> grpc.Channel:
    if not connection.certificates:
        return grpc.insecure_channel(connection.address, options=_CHANNEL_OPTIONS)
    folder = pathlib.Path(connection.certificates)
    try:
        authority, chain, key = ((folder / name).read_bytes() for name in ("ca.pem", "client.pem", "client.key"))
    except OSError as error:
        raise SeamError(f"cannot read {error.filename}: {error.strerror}") from error
    return grpc.secure_channel(connection.address, grpc.ssl_channel_credentials(authority, key, chain), _CHANNEL_OPTIONS)


class Robot(Orders):
    """Drives one robot.

    `observations()` yields what the robot senses; what is ordered until the next is asked for is the decision that
    answers it. What is not ordered stays as it was: a walk goes on, a head target is held. Orders before the first
    observation are part of the first decision.
    """

    def __init__(self, connection: Connection | None = None) -> None:
        super().__init__()
        self.connection = connection or Connection.from_arguments()
        # Something that this client sent was refused; by default the first of each field is printed.
        self.on_refusal: Callable[[Refusal], None] = self._print_refusal
        self._refused_fields: set[str] = set()
        self._time_s = 0.0  # Of the newest observation.
        self._welcome = wire.Welcome()
        self._answered = 0  # Number of the last observation that was yielded.

    # ---- Known once the first observation has come ----

    @property
    def name(self) -> str:
        return self.connection.robot

    @property
    def team(self) -> str:
        return self._welcome.team

    @property
    def number(self) -> int:
        """Its place in the scenario, from 0."""
        return self._welcome.robot_number

    @property
    def image_size_px(self) -> tuple[int, int]:
        """Width and height of its frames."""
        return self._welcome.image_width_px, self._welcome.image_height_px

    @property
    def decision_latency_s(self) -> float:
        return self._welcome.decision_latency_ns * 1e-9

    @property
    def joint_names(self) -> tuple[str, ...]:
        """By number, as JointTarget and JointAngles.angles_rad count."""
        return tuple(self._welcome.joint_names)

    def joint(self, name: str) -> int:
        """The number of the joint of this name; ValueError that lists the known ones."""
        if name not in self.joint_names:
            raise ValueError(f"no joint {name!r}, expected one of: {' '.join(self.joint_names)}")
        return self.joint_names.index(name)

    _joint_number = joint

    def observations(self) -> Iterator[Observation]:
        """One for each turn of the robot, until the run is over.

        A lost connection is made again with the token, and goes on at the pending observation. SeamError where that
        fails for longer than the connection's `give_up_s`, or the server refuses this client.
        """
        if not self.connection.address:
            raise SeamError("no server address: give --address, or set SEAM_ADDRESS")
        with contextlib.ExitStack() as kept:
            if self.connection.line:
                drive = self._drive_line
            else:
                drive = functools.partial(self._drive_grpc, kept.enter_context(_open_channel(self.connection)))
            last_connected, reported = time.monotonic(), False
            while True:
                self._welcome.Clear()
                try:
                    yield from drive()
                    return
                except (grpc.RpcError, LineError) as error:
                    now = time.monotonic()
                    if self._welcome.robot:
                        last_connected = now
                    if error.code() not in _PASSING or now - last_connected > self.connection.give_up_s:
                        raise SeamError(f"{self.name}: {error.details()}") from error
                    if not reported and now - last_connected > _REPORTED_AFTER_S:
                        reported = True
                        print(f"{self.name}: no server at {self.connection.line or self.connection.address} (is its run over?); "
                              f"tries for {self.connection.give_up_s:g} s", file=sys.stderr)
                time.sleep(0.02)

    def _drive_grpc(self, channel: grpc.Channel) -> Iterator[Observation]:
        to_server: queue.SimpleQueue[wire.ClientMessage | None] = queue.SimpleQueue()
        to_server.put(self._hello())
        call = service.SimulationStub(channel).Drive(iter(to_server.get, None))
        try:
            yield from self._drive(call, to_server.put)
        finally:
            to_server.put(None)  # Ends the thread that sends.
            call.cancel()  # Where the caller has left in the midst of it.

    def _drive_line(self) -> Iterator[Observation]:
        with contextlib.closing(DirectLine(self.connection.line, MOST_SERVER_MESSAGE_BYTES)) as line:
            line.send(self._hello())
            yield from self._drive(line.messages(), line.send)

    def _hello(self) -> wire.ClientMessage:
        hello = wire.Hello(robot=self.connection.robot, token=self.connection.token, client="seam Python SDK 1")
        return wire.ClientMessage(hello=hello)

    def _drive(self, messages: Iterable[wire.ServerMessage],
               send: Callable[[wire.ClientMessage], None]) -> Iterator[Observation]:
        """One stream; returns at the server's Goodbye."""
        for message in messages:
            kind = message.WhichOneof("kind")
            if kind == "observation":
                sequence = message.observation.sequence
                # After a reconnection the pending observation comes again. Where the answer was made but lost on the
                # way, it is sent again, not made twice.
                if sequence != self._answered:
                    if self._answered > 0:
                        self._answer = wire.ClientMessage()
                    self._answered = self._answer.decision.sequence = sequence
                    self._time_s = message.observation.time_ns * 1e-9
                    yield from_wire(message.observation)
                send(self._answer)
            elif kind == "goodbye":
                return
            else:
                self._hear(message)

    def _hear(self, message: wire.ServerMessage) -> None:
        """What is neither a turn nor the end."""
        kind = message.WhichOneof("kind")
        if kind == "welcome":
            self._welcome = message.welcome
        elif kind == "refusal":
            self.on_refusal(Refusal(message.refusal.field, message.refusal.message))

    def _print_refusal(self, refusal: Refusal) -> None:
        if refusal.field in self._refused_fields:
            return  # A mistake is mostly made at each turn.
        self._refused_fields.add(refusal.field)
        print(f"{self.name}: the decision at {self._time_s:.3f} s was refused: {refusal.field}: {refusal.message} "
              "(more of this field are counted by the server alone)", file=sys.stderr)
