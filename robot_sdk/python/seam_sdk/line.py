"""A direct line: the messages of a robot's stream on a Unix socket without gRPC.

Each message stands behind its length, 4 bytes little-endian. A length with its highest bit set is the end: gRPC's
status code in a byte, and its text.
"""
from __future__ import annotations

import socket
import struct
from typing import Iterator

import grpc
from seam.v1 import simulation_pb2 as wire

_HEAD = struct.Struct("<I")
_END = 1 << 31
_CODES = {code.value[0]: code for code in grpc.StatusCode}


class LineError(Exception):
    """Why a line ended; code and details are those of a gRPC error."""

    def __init__(self, code: grpc.StatusCode, details: str) -> None:
        super().__init__(details)
        self._code = code

    def code(self) -> grpc.StatusCode:
        return self._code

    def details(self) -> str:
        return str(self)


class DirectLine:
    def __init__(self, path: str, most_bytes: int) -> None:
        """Connects to the Unix socket at `path`; messages from the server have at most `most_bytes`."""
        self._most_bytes = most_bytes
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            self._socket.connect(path)
        except OSError as error:
            self._socket.close()
            raise LineError(grpc.StatusCode.UNAVAILABLE, str(error)) from error

    def send(self, message: wire.ClientMessage) -> None:
        data = message.SerializeToString()
        try:
            self._socket.sendall(_HEAD.pack(len(data)) + data)
        except OSError:
            pass  # Whoever hung up may have said why before: reading finds it.

    def messages(self) -> Iterator[wire.ServerMessage]:
        with self._socket.makefile("rb") as stream:
            while True:
                head, = _HEAD.unpack(self._read(stream, _HEAD.size))
                size = head & ~_END
                if size > self._most_bytes:
                    raise LineError(grpc.StatusCode.RESOURCE_EXHAUSTED,
                                    f"found a message of {size} bytes, expected at most {self._most_bytes}")
                data = self._read(stream, size)
                if head & _END:
                    code = _CODES.get(data[0], grpc.StatusCode.UNKNOWN)
                    raise LineError(code, data[1:].decode(errors="replace"))
                yield wire.ServerMessage.FromString(data)

    @property
    def descriptor(self) -> int:
        return self._socket.fileno()

    def close(self) -> None:
        self._socket.close()

    @staticmethod
    def _read(stream, size: int) -> bytes:
        try:
            data = stream.read(size)
        except OSError as error:
            raise LineError(grpc.StatusCode.UNAVAILABLE, str(error)) from error
        if len(data) < size:
            raise LineError(grpc.StatusCode.UNAVAILABLE, "the connection broke")
        return data
