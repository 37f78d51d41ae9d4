"""Logs that somebody made to do harm, from a log that is well: MCAP records taken apart and put together again, with all
sums right, so that nothing but what they say is wrong with them."""
import struct
import zlib

MAGIC = b"\x89MCAP0\r\n"
SCHEMA, CHANNEL, CHUNK, ATTACHMENT, DATA_END = 3, 4, 6, 9, 15
KEPT = {1, SCHEMA, CHANNEL, CHUNK, ATTACHMENT}


def records(data):
    """(opcode, content) up to the end of the data; the index is left out, so that readers walk over the file."""
    at = len(MAGIC)
    while at < len(data) and data[at] != DATA_END:
        opcode, length = struct.unpack_from("<BQ", data, at)
        if opcode in KEPT:
            yield opcode, data[at + 9:at + 9 + length]
        at += 9 + length


def record(opcode, content):
    return struct.pack("<BQ", opcode, len(content)) + content


def text(value):
    return struct.pack("<I", len(value)) + value


def varint(value):
    out = b""
    while value >= 0x80:
        out, value = out + bytes([value & 0x7F | 0x80]), value >> 7
    return out + bytes([value])


def field(number, value):
    """A field of bytes of a protobuf message."""
    return varint(number << 3 | 2) + varint(len(value)) + value


def log_header(scenario, name, robots, sections, seed):
    """seam.v1.LogHeader."""
    message = field(1, b"seam-log/1") + field(2, name) + field(3, scenario) + varint(4 << 3 | 1) + struct.pack("<Q", seed)
    for program, version in ((b"seam", b"\x1b[2J"), (b"state", b"1")):
        message += field(6, field(1, program) + field(2, version))
    return message + b"".join(field(7, robot) for robot in robots) + b"".join(field(8, section) for section in sections)


def attachment(name, data):
    content = struct.pack("<QQ", 0, 0) + text(name) + text(b"text/plain") + struct.pack("<Q", len(data)) + data
    return record(ATTACHMENT, content + struct.pack("<I", zlib.crc32(content)))


def chunk(channel, message):
    """A chunk of one message at time 0, not compressed."""
    content = record(5, struct.pack("<HIQQ", channel, 0, 0, 0) + message)
    return record(CHUNK, struct.pack("<QQQI", 0, 0, len(content), zlib.crc32(content)) + text(b"") +
                  struct.pack("<Q", len(content)) + content)


def topics(data):
    """Channels' numbers by topic."""
    found = {}
    for opcode, content in records(data):
        if opcode == CHANNEL:
            number, _, length = struct.unpack_from("<HHI", content)
            found[content[8:8 + length].decode()] = number
    return found


def scenario_of(data):
    """The scenario's text, which stands in the attachment, too."""
    for opcode, content in records(data):
        if opcode == ATTACHMENT:
            _, _, length = struct.unpack_from("<QQI", content)
            at = 20 + length
            at += 4 + struct.unpack_from("<I", content, at)[0]
            size = struct.unpack_from("<Q", content, at)[0]
            return content[at + 8:at + 8 + size]
    raise ValueError("the log has no scenario")


def forged(data, *, scenario, name, robots, sections, attachments, seed=5):
    """The log with another header and other attachments; its steps, decisions and pictures stay."""
    header = chunk(topics(data)["/seam/header"], log_header(scenario, name, robots, sections, seed))
    out = MAGIC
    replaced = False
    for opcode, content in records(data):
        if opcode == ATTACHMENT:
            out += b"".join(attachment(*one) for one in attachments)
        elif opcode == CHUNK and not replaced:  # The first holds the header alone.
            out, replaced = out + header, True
        else:
            out += record(opcode, content)
    return out
