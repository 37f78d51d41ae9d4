"""Bags of ROS as bytes, made for tests."""
import ctypes
import struct
import zlib


def lz4_frame(data):
    """By the library itself: Python's standard one has no LZ4."""
    lz4 = ctypes.CDLL("liblz4.so.1")
    lz4.LZ4F_compressFrameBound.restype = lz4.LZ4F_compressFrame.restype = ctypes.c_size_t
    most = lz4.LZ4F_compressFrameBound(ctypes.c_size_t(len(data)), None)
    out = ctypes.create_string_buffer(most)
    size = lz4.LZ4F_compressFrame(out, ctypes.c_size_t(most), data, ctypes.c_size_t(len(data)), None)
    return out.raw[:size]


def zstd_frame(data):
    zstd = ctypes.CDLL("libzstd.so.1")
    zstd.ZSTD_compressBound.restype = zstd.ZSTD_compress.restype = ctypes.c_size_t
    most = zstd.ZSTD_compressBound(ctypes.c_size_t(len(data)))
    out = ctypes.create_string_buffer(most)
    size = zstd.ZSTD_compress(out, ctypes.c_size_t(most), data, ctypes.c_size_t(len(data)), 3)
    return out.raw[:size]


class Cdr:
    """A message as bytes: little-endian CDR (ROS 2), or the plain form of ROS 1."""

    def __init__(self, ros1):
        self.ros1, self.data = ros1, b"" if ros1 else b"\0\1\0\0"

    def put(self, form, *values):
        for value in values:
            size = struct.calcsize("<" + form)
            if not self.ros1:
                self.data += b"\0" * (-(len(self.data) - 4) % size)
            self.data += struct.pack("<" + form, value)
        return self

    def text(self, text):
        raw = text.encode() + (b"" if self.ros1 else b"\0")
        self.put("I", len(raw))
        self.data += raw
        return self

    def header(self, t, frame="map"):
        if self.ros1:
            self.put("I", 7)
        return self.put("I", int(t), int(round(t % 1 * 1e9))).text(frame)

    def reals(self, values):
        return self.put("I", len(values)).put("d", *values)

    def texts(self, values):
        self.put("I", len(values))
        for value in values:
            self.text(value)
        return self


def ros1_record(head, data):
    fields = b"".join(struct.pack("<I", len(k) + 1 + len(v)) + k.encode() + b"=" + v for k, v in head.items())
    return struct.pack("<I", len(fields)) + fields + struct.pack("<I", len(data)) + data


def ros1_chunks(packed, size, compression, times):
    """A bag of one chunk, again and again."""
    head = {"op": b"\x05", "compression": compression.encode(), "size": struct.pack("<I", size)}
    return b"#ROSBAG V2.0\n" + ros1_record({"op": b"\x03", "index_pos": bytes(8)}, b" " * 100) + times * ros1_record(head, packed)


def ros1_bag(messages, compression="none", definitions={}):
    """messages: (topic, type, seconds, bytes). definitions: their texts by type."""
    import bz2
    record = ros1_record

    def connection(i, topic, kind):
        facts = {"topic": topic, "type": kind, "message_definition": definitions.get(kind, "")}
        inside = b"".join(struct.pack("<I", len(f)) + f for f in (f"{k}={v}".encode() for k, v in facts.items()))
        return record({"op": b"\x07", "conn": struct.pack("<I", i), "topic": topic.encode()}, inside)

    topics = list(dict.fromkeys((m[0], m[1]) for m in messages))
    chunk = b"".join(connection(i, *topic) for i, topic in enumerate(topics))
    for topic, kind, t, data in messages:
        stamp = struct.pack("<II", int(t), int(round(t % 1 * 1e9)))
        chunk += record({"op": b"\x02", "conn": struct.pack("<I", topics.index((topic, kind))), "time": stamp}, data)
    packed = {"none": bytes, "bz2": bz2.compress, "lz4": lz4_frame}[compression](chunk)
    return ros1_chunks(packed, len(chunk), compression, 1)


def mcap_file(messages, compression="", encoding="cdr", definitions={}, repeat=1):
    """`compression` of its one chunk, which stands `repeat` times: none, "lz4", "zstd"; "direct": messages outside of chunks."""
    def record(op, data):
        return bytes([op]) + struct.pack("<Q", len(data)) + data

    def text(value):
        return struct.pack("<I", len(value)) + value.encode()

    topics = list(dict.fromkeys((m[0], m[1]) for m in messages))
    out = b"\x89MCAP0\r\n" + record(1, text("ros2") + text("test"))
    inside = b""
    for i, (topic, kind) in enumerate(topics):
        package, name = kind.split("/")
        inside += record(3, struct.pack("<H", i + 1) + text(f"{package}/msg/{name}") + text("ros2msg") +
                         text(definitions.get(kind, "")))
        inside += record(4, struct.pack("<HH", i, i + 1) + text(topic) + text(encoding) + struct.pack("<I", 0))
    for number, (topic, kind, t, data) in enumerate(messages):
        ns = int(round(t * 1e9))
        inside += record(5, struct.pack("<HIQQ", topics.index((topic, kind)), number, ns, ns) + data)
    times = [int(round(m[2] * 1e9)) for m in messages]
    if compression == "direct":
        return out + inside + record(15, struct.pack("<I", 0)) + record(2, struct.pack("<QQI", 0, 0, 0)) + b"\x89MCAP0\r\n"
    packed = {"lz4": lz4_frame, "zstd": zstd_frame}.get(compression, bytes)(inside)
    chunk = struct.pack("<QQQI", min(times), max(times), len(inside), zlib.crc32(inside)) + text(compression)
    out += repeat * record(6, chunk + struct.pack("<Q", len(packed)) + packed) + record(15, struct.pack("<I", 0))
    return out + record(2, struct.pack("<QQI", 0, 0, 0)) + b"\x89MCAP0\r\n"
