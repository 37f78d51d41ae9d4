#!/usr/bin/env python3
"""Ranges to radio beacons (docs/real-plaza.md) and a robot on two wheels (docs/real-wheels.md).
`real_robots_test.py path/to/seam [folder of real sets]`
"""
import sys

from real_sets import SETS, SKIP, discover, has, parameters


def plaza():
    found, _, _ = discover(SETS / "real-plaza", SETS / "real-plaza" / "nominal.yaml")
    scale, sigma = parameters(found)["range_scale.scale"]
    assert abs(scale - 0.07) < 0.005 and 0 < sigma < 0.002, (scale, sigma)
    assert found["steps"][0]["effect"] == "range_scale", found["steps"]
    assert found["error"] < 1.1, found["error"]


def wheels():
    found, _, _ = discover(SETS / "real-wheels", SETS / "real-wheels" / "nominal.yaml")
    before = found["steps"][0]["error_before"]
    assert found["error"] < 0.6 * before, (before, found["error"])
    values = parameters(found)
    assert any(name.startswith(("wheel_scale", "base_scale")) for name in values), values


def main():
    if not (has("real-plaza") and has("real-wheels")):
        return SKIP
    plaza()
    wheels()
    return 0


if __name__ == "__main__":
    sys.exit(main())
