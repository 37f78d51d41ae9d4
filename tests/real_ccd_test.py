#!/usr/bin/env python3
"""An industrial CCD's flat fields (docs/evidence/real-ccd.md): what is found in them, and the figures of EMVA 1288 beside a
calculation of its own. `real_ccd_test.py path/to/seam [folder of real sets]`

The set is not part of the source; without it the test is skipped and says so.
"""
import csv
import pathlib
import shutil
import sys
import tempfile

from real_sets import SETS, SKIP, discover, has, parameters

SET = SETS / "real-ccd"
GAIN = 0.28  # DN an electron, as the recording's makers state it.


def figures(found):
    return {f["name"]: (f["value"], f["sigma"]) for f in found["figures"]["figures"]}


def in_another_unit(folder, factor):
    """The same frames, their light stated in another unit."""
    folder.mkdir()
    shutil.copytree(SET / "images", folder / "images")
    (folder / "measurement.yaml").write_text((SET / "measurement.yaml").read_text())
    rows = list(csv.DictReader((SET / "frames.csv").open()))
    with (folder / "frames.csv").open("w") as out:
        writer = csv.DictWriter(out, rows[0].keys())
        writer.writeheader()
        for row in rows:
            row["illumination"] = repr(float(row["illumination"]) * factor)
            writer.writerow(row)


def main():
    if not has("real-ccd"):
        return SKIP
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        found, text, _ = discover(SET, SET / "nominal.yaml")
        values, emva = parameters(found), figures(found)
        gain, sigma = emva["system gain K"]
        assert abs(gain - GAIN) < 0.02 * GAIN, gain
        # By plain sums over the files.
        assert abs(gain - 0.28086) < 1e-4 and 0 < sigma < 0.01, (gain, sigma)
        assert abs(emva["dark noise"][0] - 3.0600) < 1e-3, emva
        assert abs(emva["PRNU1288"][0] - 0.43179) < 1e-3, emva
        assert abs(emva["linearity error LE"][0] - 0.09161) < 1e-3, emva
        # The model's own gain by the same formula, and what makes it right: a pattern that is a trace.
        own, own_sigma = emva["K of the model"]
        assert abs(own - GAIN) < min(0.02 * GAIN, 3 * own_sigma) and own_sigma < 0.001, (own, own_sigma)
        assert abs(own - gain) < 3 * (own_sigma ** 2 + sigma ** 2) ** 0.5, (own, gain)
        kept = {k["effect"]: k for k in found["kept"]}
        assert kept["pixel_gain_spread"]["moves"] == "shot_noise.electrons_per_dn", kept
        assert 0.003 < kept["pixel_gain_spread"]["parameters"]["sigma"]["value"] < 0.0037, kept
        assert not set(kept) & {s["effect"] for s in found["steps"]}, kept
        assert "frames.csv:2: illumination 0.998159" in text, text
        in_another_unit(folder / "set", 1e-5)
        other, _, _ = discover(folder / "set", SET / "nominal.yaml")
        assert [s["effect"] for s in other["steps"]] == [s["effect"] for s in found["steps"]]
        for name, (value, sigma) in parameters(other).items():
            assert abs(value - values[name][0]) < 0.1 * sigma + 1e-4 * abs(value), (name, value, values[name])
    return 0


if __name__ == "__main__":
    sys.exit(main())
