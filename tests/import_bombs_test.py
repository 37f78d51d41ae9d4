#!/usr/bin/env python3
"""Small files that unpack to more than a machine has: each import ends within 20 s of processor time and little more than
1 GB of memory, and says which file it was. `import_bombs_test.py path/to/seam`"""
import base64
import bz2
import io
import os
import resource
import struct
import subprocess
import zipfile
import zlib


from importing import SEAM, run_tests
from ros_bags import mcap_file, ros1_chunks

LIMIT_S, LIMIT_BYTES = 20, 1300 << 20
MB = 1 << 20


def refused(kind, *sources, words):
    """Measured by the kernel; an address space of 4 GB ends what would fill the machine."""
    def limit():
        resource.setrlimit(resource.RLIMIT_AS, (4 << 30, 4 << 30))

    out = sources[0].parent / "none"
    process = subprocess.Popen([SEAM, "import", kind, *map(str, sources), "--out", out], stdout=subprocess.PIPE,
                               stderr=subprocess.STDOUT, text=True, preexec_fn=limit)
    said = process.stdout.read()
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    assert process.returncode == 1, (process.returncode, said)
    for word in words:
        assert word in said, (word, said)
    assert used.ru_utime + used.ru_stime < LIMIT_S, used.ru_utime
    assert used.ru_maxrss * 1024 < LIMIT_BYTES, used.ru_maxrss
    assert not out.exists()




def mat_bomb(path, arrays):
    """arrays: names with counts of bytes, each an array of int8, which becomes eight bytes a value."""
    data = b"MATLAB 5.0 MAT-file, made for a test".ljust(124) + b"\x00\x01IM"
    for name, count in arrays:
        name = name.encode().ljust(8, b"\0")
        head = (struct.pack("<IIII", 6, 8, 9, 0) + struct.pack("<IIii", 5, 8, 1, count) +
                struct.pack("<II", 1, len(name.rstrip(b"\0"))) + name + struct.pack("<II", 1, count))
        packer = zlib.compressobj(6)
        packed = packer.compress(struct.pack("<II", 14, len(head) + count) + head)
        packed += b"".join(packer.compress(bytes(MB)) for _ in range(count // MB)) + packer.flush()
        data += struct.pack("<II", 15, len(packed)) + packed
    path.write_bytes(data)
    assert len(data) < 20 * MB
    return path


def cameramodel(path, sizes):
    """An mrcal file whose inputs hold arrays of uint8 of these sizes."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for i, size in enumerate(sizes):
            head = f"{{'descr': '|u1', 'fortran_order': False, 'shape': ({size},), }}".ljust(117) + "\n"
            with archive.open(f"a{i}.npy", "w", force_zip64=True) as entry:
                entry.write(b"\x93NUMPY\x01\x00" + struct.pack("<H", len(head)) + head.encode())
                for _ in range(size // MB):
                    entry.write(bytes(MB))
    inputs = base64.b85encode(packed.getvalue())
    path.write_text("{'lensmodel': 'LENSMODEL_PINHOLE', 'intrinsics': [400, 400, 320, 240], 'imagersize': [640, 480],\n"
                    "'extrinsics': [0, 0, 0, 0, 0, 0], 'icam_intrinsics': 0,\n"
                    f"'optimization_inputs': {inputs!r},}}\n")
    return path


def test_mat(folder):
    refused("ranges", mat_bomb(folder / "one.mat", [("GT", 900 * MB)]), words=["one.mat", "1024 MB"])
    refused("bouguet", mat_bomb(folder / "many.mat", [(f"a{i}", 60 * MB) for i in range(20)]), words=["many.mat", "1024 MB"])
    # What fits is read, and refused for what it says.
    refused("ranges", mat_bomb(folder / "fits.mat", [("GT", 40 * MB)]), words=["fits.mat"])


def test_npz(folder):
    refused("mrcal", cameramodel(folder / "one.cameramodel", [900 * MB]), words=["one.cameramodel", "1024 MB"])
    refused("mrcal", cameramodel(folder / "many.cameramodel", [60 * MB] * 20), words=["many.cameramodel", "1024 MB"])


def test_bags(folder):
    """Chunks that unpack to a little each, and to a lot together; over several parts of a recording, too."""
    record = struct.pack("<I", 4 + 4) + struct.pack("<I", 4) + b"op=\x08" + struct.pack("<I", 100 * MB) + bytes(100 * MB)
    packed = bz2.compress(record)
    (folder / "bz2.bag").write_bytes(ros1_chunks(packed, len(record), "bz2", 1000))
    refused("ros", folder / "bz2.bag", words=["bz2.bag", "1024 MB"])
    parts = folder / "parts"
    parts.mkdir()
    for k in range(40):
        (parts / f"run_{k}.bag").write_bytes(ros1_chunks(packed, len(record), "bz2", 1))
    refused("ros", parts, words=["parts", "1024 MB"])
    dark = [("/camera", "sensor_msgs/Image", 60.0, bytes(100 * MB))]
    (folder / "zstd.mcap").write_bytes(mcap_file(dark, "zstd", repeat=1000))
    refused("ros", folder / "zstd.mcap", words=["zstd.mcap", "1024 MB"])
    (folder / "cut.bag").write_bytes(ros1_chunks(packed[:-9] + bytes(9), len(record), "bz2", 3))
    refused("ros", folder / "cut.bag", words=["cut.bag: byte 151: a chunk's bz2 bytes are damaged"])
    (folder / "none.bag").write_bytes(ros1_chunks(bz2.compress(bytes(MB)), MB, "bz2", 1))
    refused("ros", folder / "none.bag", words=["does not say what it is"])


run_tests(globals())
