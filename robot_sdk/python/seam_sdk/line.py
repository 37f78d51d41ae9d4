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
_PART_BYTES = 1 << 16
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
        self._read = bytearray()  # What came and was not taken yet.
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
        while True:
            yield self.receive()

    def receive(self) -> wire.ServerMessage:
        """The next message, once it is whole."""
        self._wait_for(_HEAD.size)
        head, = _HEAD.unpack_from(self._read)
        size = head & ~_END
        if size > self._most_bytes:
            raise LineError(grpc.StatusCode.RESOURCE_EXHAUSTED,
                            f"found a message of {size} bytes, expected at most {self._most_bytes}")
        self._wait_for(_HEAD.size + size)
        data = bytes(self._read[_HEAD.size:_HEAD.size + size])
        del self._read[:_HEAD.size + size]
        if head & _END:
            code = _CODES.get(data[0], grpc.StatusCode.UNKNOWN)
            raise LineError(code, data[1:].decode(errors="replace"))
        return wire.ServerMessage.FromString(data)

    @property
    def has_read(self) -> bool:
        """Whether something came that was not taken yet, which the descriptor does not show."""
        return bool(self._read)

    def fileno(self) -> int:
        return self._socket.fileno()

    def close(self) -> None:
        self._socket.close()

    def _wait_for(self, size: int) -> None:
        while len(self._read) < size:
            try:
                data = self._socket.recv(max(_PART_BYTES, size - len(self._read)))
            except OSError as error:
                raise LineError(grpc.StatusCode.UNAVAILABLE, str(error)) from error
            if not data:
                raise LineError(grpc.StatusCode.UNAVAILABLE, "the connection broke")
            self._read += data
