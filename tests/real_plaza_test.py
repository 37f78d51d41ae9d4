#!/usr/bin/env python3
"""Ranges from a mower to radio beacons (docs/evidence/real-plaza.md): their scale with its error, and nothing beside it.
`real_plaza_test.py path/to/seam [folder of real sets]`
"""
import sys

from real_sets import SETS, SKIP, discover, has, parameters


def main():
    if not has("real-plaza"):
        return SKIP
    found, _, _ = discover(SETS / "real-plaza", SETS / "real-plaza" / "nominal.yaml")
    assert [step["effect"] for step in found["steps"]] == ["range_scale"], found["steps"]
    scale, sigma = parameters(found)["range_scale.scale"]
    assert abs(scale - 0.07) < 0.005 and 0 < sigma < 0.002, (scale, sigma)
    assert found["verdict"] == "adequate" and found["error"] < 1.1, found["error"]
    return 0


if __name__ == "__main__":
    sys.exit(main())
