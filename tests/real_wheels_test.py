#!/usr/bin/env python3
"""A robot on two wheels, its ticks against motion capture (docs/evidence/real-wheels.md): what wheels and base are off by, with
errors, and how far ticks alone lead. `real_wheels_test.py path/to/seam [folder of real sets]`
"""
import sys

from real_sets import SETS, SKIP, discover, has, parameters


def main():
    if not has("real-wheels"):
        return SKIP
    found, _, _ = discover(SETS / "real-wheels", SETS / "real-wheels" / "nominal.yaml")
    values = parameters(found)
    # By least squares over whole runs, written apart (docs/evidence/real-wheels.md).
    for name, expected in (("wheel_scale.left", -0.0033), ("wheel_scale.right", -0.0044), ("base_scale.scale", 0.0035)):
        value, sigma = values[name]
        assert abs(value - expected) < 0.0005 and 0 < sigma < 0.001, (name, value, sigma)
    # Nothing that only widens what is predicted may lead the wheels astray.
    free = {(error["over"], error["residual"]): error for error in found["free_prediction"]}
    position, heading = free["run", "position_m"], free["run", "theta_rad"]
    assert position["rms"] < 0.010 and position["at_end"] < 0.008, position
    assert heading["rms"] < 0.012 and heading["at_end"] < 0.010, heading
    assert found["error"] < 7, found["error"]
    return 0


if __name__ == "__main__":
    sys.exit(main())
