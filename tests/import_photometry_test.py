#!/usr/bin/env python3
"""`seam import` of flat fields and darks, made here with the truth known. `import_photometry_test.py path/to/seam`"""
import json
import re
import struct
import zlib

import numpy as np

from importing import RNG, imported, refused, rows_of, run, run_tests


def png(array, bits):
    height, width = array.shape
    raw = b"".join(b"\0" + (row.astype(">u2") if bits == 16 else row.astype("u1")).tobytes() for row in array)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, bits, 0, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(raw)) + chunk(b"IEND", b""))


def flat(exposure, light, gain=0.4, black=20, dark_dn=2.0, size=(48, 64)):
    electrons = RNG.poisson(light * exposure * np.ones(size)) + dark_dn / gain * RNG.standard_normal(size)
    return np.clip(np.rint(gain * electrons + black), 0, 4095).astype(int)


def test_photometry(folder):
    series = folder / "series"
    (series / "images").mkdir(parents=True)
    lines = ["# a series", "v 3.0", "n 12 64 48"]
    for i, exposure in enumerate([1e-3, 2e-3, 4e-3, 8e-3]):
        for what, light in (("b", 1e6), ("d", 0)):
            lines.append(f"b {exposure * 1e9:.1f} {2e6 * exposure}" if what == "b" else f"d {exposure * 1e9:.1f}")
            for k in range(2):
                name = f"{what}_{i}_{k}.png"
                (series / "images" / name).write_bytes(png(flat(exposure, light), 16))
                lines.append(f"i images\\{name}")
    (series / "data.txt").write_text("\r\n".join(lines) + "\r\n")
    out = folder / "emva"
    imported("emva1288", series / "data.txt", out=out)
    assert "bits: 12" in (out / "measurement.yaml").read_text()
    run("discover", "--model", out / "nominal.yaml", "--data", out, "--out", folder / "s.yaml", "--json", folder / "s.json")
    figures = {f["name"]: f["value"] for f in json.loads((folder / "s.json").read_text())["figures"]["figures"]}
    assert abs(figures["system gain K"] - 0.4) < 0.04 and abs(figures["quantum efficiency"] - 50) < 5, figures
    (series / "data.txt").write_text("\n".join(lines).replace("d_2_1", "d_2_9") + "\n")
    refused("emva1288", series / "data.txt", out=folder / "lost", words=["data.txt:", "d_2_9.png is missing"])
    (series / "data.txt").write_text("\n".join(lines).replace("images\\d_2_1", "..\\..\\d_2_1") + "\n")
    refused("emva1288", series / "data.txt", out=folder / "slip", words=["data.txt:"])

    names = folder / "names"
    names.mkdir()
    for exposure in ("1ms", "2.5ms", "0p004s"):
        seconds = {"1ms": 1e-3, "2.5ms": 2.5e-3, "0p004s": 4e-3}[exposure]
        for k in range(2):
            (names / f"flat_{exposure}_{k}.png").write_bytes(png(flat(seconds, 1e6), 16))
            (names / f"dark_{exposure}_{k}.png").write_bytes(png(flat(seconds, 0), 16))
    imported("flats", names, out=folder / "flats")
    rows = rows_of(folder / "flats" / "frames.csv")
    assert sorted({float(r["exposure_s"]) for r in rows}) == [0.001, 0.0025, 0.004], rows
    assert {r["illumination"] for r in rows if "dark" in r["file"]} == {"0"}

    heads = folder / "fits"
    heads.mkdir()
    for k, exposure in enumerate([0.001, 0.001, 0.003, 0.003, 0.001, 0.001]):
        kind = "Dark Frame" if k >= 4 else "Flat Field"
        cards = ["SIMPLE  =                    T", "BITPIX  =                   16", "NAXIS   =                    2",
                 "NAXIS1  =                   64", "NAXIS2  =                   48", "BZERO   =                32768",
                 f"EXPTIME = {exposure:20} / s", f"IMAGETYP= '{kind}'", "END"]
        data = "".join(card.ljust(80) for card in cards).ljust(2880).encode()
        pixels = (flat(exposure, 0 if k >= 4 else 1e6) - 32768).astype(">i2").tobytes()
        (heads / f"{k}.fits").write_bytes(data + pixels.ljust((len(pixels) + 2879) // 2880 * 2880, b"\0"))
    said = imported("flats", heads, out=folder / "from-fits")
    assert "6 frames from FITS headers" in said and "2 of them dark" in said, said
    listed = folder / "listed"
    listed.mkdir()
    for k in range(4):
        (listed / f"{k}.png").write_bytes(png(flat(0.001 * (1 + k // 2), 1e6), 16))
    refused("flats", listed, out=folder / "unknown", words=["0.png", "exposure is not known"])
    (listed / "list.csv").write_text("file,exposure_ms,illumination\n" + "".join(f"{k}.png,{1 + k // 2},1\n" for k in range(4)))
    imported("flats", listed, out=folder / "csv")
    (listed / "list.csv").write_text("image;exposure time [ms];lux\n" + "".join(f"{k}.png;{1 + k // 2},5;1\n" for k in range(4)))
    imported("flats", listed, out=folder / "named")
    assert [float(r["exposure_s"]) for r in rows_of(folder / "named" / "frames.csv")] == [0.0015, 0.0015, 0.0025, 0.0025]
    bias = folder / "bias"
    bias.mkdir()
    for k in range(2):
        (bias / f"a_bias_{k}.png").write_bytes(png(flat(0, 0), 16))
        (bias / f"flat_2ms_{k}.png").write_bytes(png(flat(0.002, 1e6), 16))
    imported("flats", bias, out=folder / "with-bias")
    assert [float(r["exposure_s"]) for r in rows_of(folder / "with-bias" / "frames.csv")] == [0.002, 0, 0, 0.002]
    bomb = bytearray(png(np.zeros((4, 4), int), 8))
    bomb[16:24] = struct.pack(">II", 60000, 60000)
    bomb[29:33] = struct.pack(">I", zlib.crc32(bytes(bomb[12:29])))
    (listed / "3.png").write_bytes(bytes(bomb))
    refused("flats", listed, out=folder / "bomb", words=["3.png"])


def filtered(image, share):
    """By weights share, 1 - 2 share, share along rows, as a camera that smooths, or sharpens."""
    wide = np.pad(image, ((0, 0), (1, 1)), "edge").astype(float)
    return np.rint(share * wide[:, :-2] + (1 - 2 * share) * wide[:, 1:-1] + share * wide[:, 2:]).astype(int)


def figures_behind(share, folder):
    """The figures of flat fields of K = 0.2 DN/e- behind this filter, what is said of shared noise, the text and the curve."""
    series, out = folder / "series", folder / "set"
    series.mkdir(parents=True)
    for exposure in (1, 2, 4, 8, 12, 16):
        for k in range(2):
            for what, light in (("flat", 1e6), ("dark", 0)):
                image = filtered(flat(1e-3 * exposure, light, gain=0.2, black=60, dark_dn=6), share)
                (series / f"{what}_{exposure}ms_{k}.png").write_bytes(png(image, 16))
    imported("flats", series, out=out)
    said = run("compare", "--model", out / "nominal.yaml", "--data", out, "--json", folder / "out.json")
    result = json.loads((folder / "out.json").read_text())
    notes = [note for note in result.get("notes", []) if "noise is alike in neighbouring pixels" in note]
    return {f["name"]: f["value"] for f in result["figures"]["figures"]}, notes, said, result["figures"]["snr_curve"]


def test_a_filter_in_the_camera(folder):
    figures, notes, _, _ = figures_behind(0, folder / "raw")
    assert abs(figures["system gain K"] / 0.2 - 1) < 0.1 and not notes, (figures, notes)
    # Of the variance 1.1^2 + 2 * 0.05^2 = 1.215 is left, and K with it: the correlation says 1.22.
    figures, notes, said, _ = figures_behind(-0.05, folder / "sharp")
    assert abs(figures["system gain K"] / 0.243 - 1) < 0.1 and notes[0] in said, (figures, notes)
    assert "correlates by -0." in notes[0] and " % too large, and what rests on it is off by as much" in notes[0], notes
    # Of the variance 3/8 is left: K is 2.7 times too small, of which 1 + 2 * 4/6 are seen in the next pixels.
    figures, notes, said, curve = figures_behind(0.25, folder / "smooth")
    times = re.search("K comes out some ([0-9.]+) times too small", notes[0])
    assert abs(float(times.group(1)) - 2.33) < 0.3 and "correlates by 0.6" in notes[0] and notes[0] in said, notes
    assert "EMVA 1288, without what rests on noise" in said, said
    assert set(figures) <= {"dark signal", "saturation signal", "linearity error LE"}, figures
    assert abs(figures["dark signal"] - 60) < 0.5, figures
    assert curve and all(point["expected"] is None for point in curve), curve


run_tests(globals())
