#!/usr/bin/env python3
"""Makes the corpus of logs that every reader must pass, and expected.json beside it.

make_corpus.py SEAM [FOLDER]: runs a short scenario and damages its log in every way that FORMAT.md names.
The numbers of expected.json come from this program; look at the differences before you check them in."""
import json
import pathlib
import struct
import subprocess
import sys
import tempfile
import zlib

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent
MAGIC = b"\x89MCAP0\r\n"
SCENARIO = f"""format: seam-scenario/1
name: corpus
duration_s: 2
seed: 3
robots:
  - id: red1
    team: red
    pose: {{x_m: -0.5, y_m: 0.1}}
    body: {ROOT}/models/robot_ers210.yaml
    behaviour: {{command: [head_swing, --rate, "2", --amplitude, "0.5"], clock: {{period_s: 0.064}}}}
"""


def records(data):
    """Offset, opcode and length (with its head of 9 bytes) of each record of a whole file."""
    at = len(MAGIC)
    while at < len(data) - len(MAGIC):
        length = struct.unpack_from("<Q", data, at + 1)[0]
        yield at, data[at], 9 + length
        at += 9 + length


def record(opcode, content):
    return bytes([opcode]) + struct.pack("<Q", len(content)) + content


def text(value):
    return struct.pack("<I", len(value)) + value


def with_summary(data, summary):
    """A file whose index is `summary`, with the CRC right: only its content can be absurd."""
    body = data + record(0x0F, struct.pack("<I", 0))
    footer = struct.pack("<QQ", len(body), 0)
    head = bytes([2]) + struct.pack("<Q", 20)
    crc = zlib.crc32(head + footer, zlib.crc32(summary))
    return body + summary + head + footer + struct.pack("<I", crc) + MAGIC


def make(seam, folder):
    folder.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as temporary:
        scenario = pathlib.Path(temporary) / "corpus.yaml"
        scenario.write_text(SCENARIO)
        subprocess.run([seam, "run", scenario, "--log", folder / "whole.mcap"], check=True, stdout=subprocess.DEVNULL)
    whole = (folder / "whole.mcap").read_bytes()
    chunks = [(at, length) for at, opcode, length in records(whole) if opcode == 6]
    data_end = next(at for at, opcode, _ in records(whole) if opcode == 0x0F)
    summary = next(at for at, opcode, _ in records(whole) if at > data_end)
    last, last_length = chunks[-1]
    middle, middle_length = chunks[len(chunks) // 2]

    def flipped(at, mask=0x5A):
        return whole[:at] + bytes([whole[at] ^ mask]) + whole[at + 1:]

    header = MAGIC + record(1, text(b"seam-log/1") + text(b"corpus"))
    chunk = struct.pack("<QQQI", 0, 0, 1 << 40, 1) + text(b"zstd") + struct.pack("<Q", 4) + b"tiny"
    index = struct.pack("<QQQQ", 0, 0, 8, 1 << 60) + text(b"") + struct.pack("<Q", 0) + text(b"zstd")
    files = {
        "unfinished": whole[:data_end],
        "truncated": whole[:last + last_length // 2],
        "corrupted": flipped(middle + middle_length // 2),
        "headless": b"\xEE" * 200 + whole[200:],
        "bad_index": flipped(summary + 20),
        "bomb": header + record(6, chunk),
        "hostile_lengths": header + bytes([6]) + struct.pack("<Q", (1 << 63) - 1) + b"some bytes",
        "absurd_index": with_summary(header, record(8, index + struct.pack("<QQ", 1 << 62, 1 << 62)) * 3),
        "empty": b"",
        "text": b"This is a text file that somebody took for a log.\n" * 4,
    }
    for name, data in files.items():
        (folder / f"{name}.mcap").write_bytes(data)
    for name, mode in (("broken_command", "break-command"), ("older", "older")):
        subprocess.run(["node", ROOT / "tests/mcap_node/edit_log.mjs", mode, folder / "whole.mcap",
                        folder / f"{name}.mcap"], check=True, stdout=subprocess.DEVNULL)


def look(seam, path):
    """What `recover` says of a file."""
    with tempfile.TemporaryDirectory() as temporary:
        out, report = pathlib.Path(temporary) / "out.mcap", pathlib.Path(temporary) / "report.json"
        done = subprocess.run([seam, "replay", "recover", path, "--out", out, "--json", report],
                              capture_output=True, timeout=60)
        found = json.loads(report.read_text()) if report.exists() else {}
    return {"recover": done.returncode, "messages": found.get("messages", 0), "losses": len(found.get("losses", []))}


def main():
    seam = pathlib.Path(sys.argv[1]).resolve()
    folder = pathlib.Path(sys.argv[2]) if len(sys.argv) > 2 else HERE / "corpus"
    make(seam, folder)
    expected = {path.name: look(seam, path) for path in sorted(folder.glob("*.mcap"))}
    (folder / "expected.json").write_text(json.dumps(expected, indent=1) + "\n")
    for name, entry in expected.items():
        print(f"{name:24} {entry}")


if __name__ == "__main__":
    main()
