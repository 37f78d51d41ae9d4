"""A world that a script drives step by step: a simulator of its own, in lockstep with the script.

    with seam_sdk.World("scenario.yaml", seed=1) as world:
        while not world.done:
            world.step({"r0": seam_sdk.Decision().head(pan_rad=0.5)})

Wire, log and bits are those of `seam run` with behaviours that decide the same.
"""
from __future__ import annotations

import dataclasses
import os
import pathlib
import re
import select
import shutil
import subprocess
import tempfile
from types import TracebackType
from typing import Mapping, Sequence

import grpc
from seam.v1 import simulation_pb2 as wire
from seam.v1 import simulation_pb2_grpc as service

from .line import DirectLine, LineError
from .observation import Observation, from_wire
from .orders import Decision
from .robot import MOST_SERVER_MESSAGE_BYTES, Connection, Refusal, Robot, SeamError

_MAGIC = b"\x89MCAP0\r\n"  # The first bytes of each log.
_END_S = 10  # For the server to end by itself.
_ENDED = "the run is over: reset() begins another one"


@dataclasses.dataclass(frozen=True)
class RobotTruth:
    x_m: float
    y_m: float
    heading_rad: float
    joints_rad: tuple[float, ...]  # Of an ERS-210 tilt, pan and roll of the head.


@dataclasses.dataclass(frozen=True)
class Truth:
    """Where everything is. A behaviour never learns it: for rewards, tests and plots."""
    time_ns: int
    robots: dict[str, RobotTruth]
    ball_m: tuple[float, float, float]
    ball_m_s: tuple[float, float, float]


class RefusedDecision(SeamError):
    """The server refused a decision as a whole, and it counted as an empty one; the world can go on."""

    def __init__(self, robot: str, refusal: Refusal) -> None:
        super().__init__(f"{robot}: the decision was refused: {refusal.field}: {refusal.message}")
        self.robot, self.refusal = robot, refusal


class _Seat(Robot):
    """A robot whose turns the script takes: what is asked, and answered, as two calls."""

    def __init__(self, connection: Connection, watch: wire.Watch | None) -> None:
        super().__init__(connection)
        self.watched: wire.Watched | None = None  # Of the turn that is there, or of the next one once that was heard.
        self.line = DirectLine(connection.line, MOST_SERVER_MESSAGE_BYTES)
        hello = self._hello()
        if watch is not None:
            hello.hello.watch.CopyFrom(watch)
        self.line.send(hello)

    def greet(self) -> None:
        """Hears what the robot is like, which comes before its first turn."""
        self._hear(self.line.receive())

    def answer(self) -> None:
        self.line.send(self._answer)
        self._answer = wire.ClientMessage()
        self.watched = None

    def asked(self) -> list[str] | None:
        """Takes one message; the robots that are asked next, where it says so."""
        message = self.line.receive()
        if message.WhichOneof("kind") != "watched":
            self._hear(message)
            return None
        self.watched = message.watched
        return list(message.watched.robots)

    def next(self) -> Observation | None:
        """The robot's next turn; none at the end of the run."""
        for message in self.line.messages():
            kind = message.WhichOneof("kind")
            if kind == "goodbye":
                break
            if kind == "observation":
                self._answer.decision.sequence = message.observation.sequence
                return from_wire(message.observation)
            if kind == "watched":
                self.watched = message.watched
            else:
                self._hear(message)
        return None


class World:
    """Drives robots of a scenario. Simulated time stands still between two steps, as long as you like.

    scenario: a file of format seam-scenario/1.
    robots: those that the script drives; the behaviours of all others are started. Left out: all robots.
    supervisor: whether `truth()` may be asked, and `watch` be given.
    watch: expressions in the language of `seam replay find --when`, over truth, logged values and events, whose values
        `watched` has at each turn; `{robot}` is the robot whose turn it is.
    log: where the replay log goes; options: further ones of `seam serve`, such as ["--set", "duration_s=2"].
    seam: the program; left out: SEAM_PROGRAM, the one beside this package, or the one in PATH.
    """

    def __init__(self, scenario: str | os.PathLike[str], seed: int | None = None, *, robots: Sequence[str] | None = None,
                 supervisor: bool = False, watch: Sequence[str] = (), log: str | os.PathLike[str] | None = None,
                 options: Sequence[str] = (), seam: str | os.PathLike[str] | None = None) -> None:
        if watch and not supervisor:
            raise SeamError("watch is the supervisor's: make the world with supervisor=True")
        self._scenario, self._wanted, self._options, self._watch = scenario, robots, list(options), list(watch)
        self._log, self._supervisor, self._program = log, supervisor, _program(seam)
        self._server: subprocess.Popen[str] | None = None
        self._folder: tempfile.TemporaryDirectory[str] | None = None
        self._channel: grpc.Channel | None = None
        self.robots: dict[str, _Seat] = {}  # Those that are driven, by name.
        self.observations: dict[str, Observation] = {}  # Of the robots whose turn it is.
        # Values of `watch` by robot: of those whose turn it is, at the end of all that are driven. NaN where one reads what
        # has no value yet; events are those since the robot's last turn.
        self.watched: dict[str, tuple[float, ...]] = {}
        self.time_ns = 0  # Of the observations.
        self.done = False  # The run is over: there are no observations any more.
        self.reset(seed)

    # ---- What a script calls ----

    def reset(self, seed: int | None = None, *, log: str | os.PathLike[str] | None = None,
              options: Sequence[str] = ()) -> dict[str, Observation]:
        """Begins the run anew, with another seed or log where one is given; the first observations.

        `options` are added to those of the world, for this run alone."""
        self.close()
        self.time_ns, self.done = 0, False
        if log is not None:
            self._log = log
        try:
            self._start(seed, options)
            return self._next()
        except BaseException:
            self.close()
            raise

    def step(self, decisions: Mapping[str, Decision] | None = None) -> dict[str, Observation]:
        """Answers the observations and goes on to the next ones; empty at the end of the run.

        A robot without a decision goes on as it does. RefusedDecision where the server refused one of them: the world
        has gone on, and `observations` has what followed.
        """
        self.answer(decisions)
        return self.wait()

    def answer(self, decisions: Mapping[str, Decision] | None = None) -> None:
        """The first half of `step`: worlds that were all answered go on side by side."""
        if self.done or self._server is None:
            raise SeamError(_ENDED)
        for name, decision in (decisions or {}).items():
            if name not in self.observations:
                known = ", ".join(self.robots) if name not in self.robots else ""
                raise SeamError(f"no robot '{name}' is driven here, expected one of: {known}" if known else
                                f"{name}: it is not its turn, expected a decision for: {', '.join(self.observations)}")
            decision.give_to(self.robots[name])
        for name in self.observations:
            self.robots[name].answer()

    def wait(self) -> dict[str, Observation]:
        """The second half of `step`."""
        return self._next()

    def truth(self) -> Truth:
        """Where everything is now; only of a world that was made with supervisor=True."""
        if not self._supervisor:
            raise SeamError("truth() is the supervisor's: make the world with supervisor=True")
        if self.done or self._server is None:
            raise SeamError(_ENDED)
        try:
            return _truth(self._stub.GetGroundTruth(wire.SupervisorRequest(token=self._token)))
        except grpc.RpcError as error:
            raise self._failure(error.details()) from error

    @property
    def process(self) -> int:
        """The simulator's number, while it runs."""
        if self._server is None:
            raise SeamError(_ENDED)
        return self._server.pid

    def close(self) -> None:
        """Ends the server, and with it the run; its log is whole."""
        # The server first, or its log would tell of lost connections.
        server, self._server = self._server, None
        if server is not None:
            _end(server)
        for robot in self.robots.values():
            robot.line.close()
        self.robots, self.observations, self.watched = {}, {}, {}
        if self._channel is not None:
            self._channel.close()
            self._channel = None
        if self._folder is not None:
            self._folder.cleanup()
            self._folder = None

    def __enter__(self) -> World:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    def __del__(self) -> None:
        if getattr(self, "_server", None) is not None:
            self.close()

    # ---- The server ----

    def _start(self, seed: int | None, options: Sequence[str]) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="seam-world-")
        here = pathlib.Path(self._folder.name)
        driven = ["*"] if self._wanted is None else self._wanted
        line = [self._program, "serve", os.fspath(self._scenario), "--listen", f"unix:{here}/socket", "--lines", f"{here}/lines",
                "--tokens", f"{here}/tokens", "--until-eof", *(word for robot in driven for word in ("--drive", robot))]
        if seed is not None:
            line += ["--seed", str(seed)]
        if self._log is not None:
            _check_replaceable(self._log)
            line += ["--log", os.fspath(self._log), "--force"]
        # A session of its own: Ctrl-C comes to this process alone, which ends the server. If this process is killed, the
        # server's standard input ends, and the server with it.
        with open(here / "errors", "wb") as errors:
            self._server = subprocess.Popen([*line, *self._options, *options], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=errors,
                                            text=True, start_new_session=True)
        if not any(text.startswith("listening on") for text in iter(self._server.stdout.readline, "")):
            raise self._failure()
        self._connect(here)

    def _connect(self, here: pathlib.Path) -> None:
        tokens = dict(re.findall(r"^ *([^:\n]+): (\S+)$", (here / "tokens").read_text(), re.M))
        self._token, names = tokens.pop("supervisor"), list(tokens)[1:]
        self._refused: list[RefusedDecision] = []
        driven = names if self._wanted is None else self._wanted
        for name in driven:
            own = re.sub(r"[^A-Za-z0-9_.]", "_", name)
            watch = wire.Watch(token=self._token, expressions=[text.replace("{robot}", own) for text in self._watch])
            seat = _Seat(Connection(f"unix:{here}/socket", name, tokens[name], line=f"{here}/lines"),
                         watch if self._watch or len(driven) > 1 else None)
            seat.on_refusal = lambda refusal, name=name: self._refused.append(RefusedDecision(name, refusal))
            self.robots[name] = seat
        try:
            for robot in self.robots.values():
                robot.greet()
        except LineError as error:
            raise self._failure(str(error)) from error
        self._channel = grpc.insecure_channel(f"unix:{here}/socket")
        self._stub = service.SupervisorStub(self._channel)

    def _next(self) -> dict[str, Observation]:
        """Waits for the next turns."""
        try:
            found = {name: self.robots[name].next() for name in self._due()}
        except LineError as error:
            raise self._failure(str(error)) from error
        self.observations = {name: seen for name, seen in found.items() if seen is not None}
        self.watched = {name: tuple(self.robots[name].watched.values) for name in found} if self._watch else {}
        self.done = not self.observations
        if self.done:
            self._finish()
        else:
            self.time_ns = next(iter(self.observations.values())).time_ns
        if self._refused:
            refused, self._refused = self._refused[0], []
            raise refused
        return self.observations

    def _due(self) -> list[str]:
        """Robots of one instant are asked together: the first to hear of it hears who they are."""
        seats = {robot.line: robot for robot in self.robots.values()}
        while len(seats) > 1:
            ready = [line for line in seats if line.has_read] or select.select(list(seats), [], [])[0]
            asked = seats[ready[0]].asked()
            if asked is not None:
                # Nobody is asked at the end, of which all hear.
                return [name for name in asked if name in self.robots] or list(self.robots)
        return list(self.robots)

    def _finish(self) -> None:
        assert self._server is not None
        if self._server.wait() != 0:
            raise self._failure()

    def _failure(self, otherwise: str = "") -> SeamError:
        """What the server said, and how it ended."""
        if self._server is not None:
            try:
                self._server.wait(1 if otherwise else _END_S)
            except subprocess.TimeoutExpired:
                pass
        assert self._folder is not None
        text = (pathlib.Path(self._folder.name) / "errors").read_text(errors="replace").strip()
        self.close()
        self.done = True
        return SeamError(text or otherwise or "the simulator ended without a word")


def _program(seam: str | os.PathLike[str] | None) -> str:
    if seam is not None:
        return os.fspath(seam)
    if named := os.environ.get("SEAM_PROGRAM"):
        return named
    package = pathlib.Path(__file__).absolute().parent  # Of a build folder a link, which is not followed.
    for beside in (package.parents[1] / "seam", package.parents[3] / "bin" / "seam"):  # A build folder, an installed tree.
        if beside.is_file() and os.access(beside, os.X_OK):
            return str(beside)
    found = shutil.which("seam")
    if found is None:
        raise SeamError("the program `seam` is not beside this package nor in PATH: give World(..., seam=FILE), or set SEAM_PROGRAM")
    return found


def _check_replaceable(log: str | os.PathLike[str]) -> None:
    """An earlier log is replaced; what else a user has there is not."""
    if not os.path.exists(log):
        return
    if os.path.isfile(log):
        with open(log, "rb") as file:
            if file.read(len(_MAGIC)) == _MAGIC:
                return
    raise SeamError(f"{os.fspath(log)}: exists and is no log")


def _end(server: subprocess.Popen[str]) -> None:
    assert server.stdin is not None and server.stdout is not None
    if server.poll() is None:
        server.terminate()
    try:
        server.wait(_END_S)
    except subprocess.TimeoutExpired:
        server.kill()
        server.wait()
    finally:
        server.stdin.close()
        server.stdout.close()


def _truth(message: wire.GroundTruth) -> Truth:
    def joints(robot: wire.RobotTruth) -> tuple[float, ...]:
        return tuple(robot.joints_rad) or (robot.tilt_rad, robot.pan_rad, robot.roll_rad)

    def vector(value: wire.Vector3) -> tuple[float, float, float]:
        return (value.x, value.y, value.z)

    robots = {robot.robot: RobotTruth(robot.body.x_m, robot.body.y_m, robot.body.heading_rad, joints(robot)) for robot in message.robots}
    return Truth(message.time_ns, robots, vector(message.ball_position_m), vector(message.ball_velocity_m_s))
