#!/usr/bin/env python3
"""Labels of tests name tests that there are, and `./test.sh` runs a journey through each program: labels_test.py BUILD_DIR

A test that was renamed would leave its label behind and be run by `./test.sh`, however slow.
"""
import json
import pathlib
import re
import subprocess
import sys

import by_hand

BUILD = by_hand.arguments("build")
SOURCE = pathlib.Path(__file__).resolve().parent.parent
# At least one test of each that `./test.sh` does not leave out.
JOURNEYS = ("help_examples.journey", "end_to_end.journey", "import.images.journey", "python_sdk.journey", "docs.simulate",
            "docs.sweeps", "docs.replay")


def slow_names():
    """Names in SLOW of the rooms' CMakeLists.txt, and the GoogleTests that there are."""
    named, known = {}, set()
    for path in SOURCE.glob("*/CMakeLists.txt"):
        for block in re.findall(r"\bSLOW\s+([^)]+)\)", path.read_text(encoding="utf-8")):
            named.update({name: path.relative_to(SOURCE) for name in block.split()})
    for path in SOURCE.glob("*/**/*.test.cc"):
        known |= {f"{suite}.{name}" for suite, name in re.findall(r"^TEST(?:_F|_P)?\((\w+),\s*(\w+)\)", path.read_text(encoding="utf-8"), re.M)}
    return named, known


def main():
    named, known = slow_names()
    wrong = [f"{path}: SLOW names {name}, which is no test" for name, path in named.items() if name not in known]
    listed = json.loads(subprocess.run(["ctest", "--test-dir", BUILD, "--show-only=json-v1"], capture_output=True, text=True,
                                       check=True).stdout)
    labels = {test["name"]: next((entry["value"] for entry in test["properties"] if entry["name"] == "LABELS"), [])
              for test in listed["tests"]}
    wrong += [f"{name}: has none of the labels unit, e2e, slow (tests/CMakeLists.txt)" for name, given in labels.items()
              if not {"unit", "e2e", "slow"} & set(given) and not name.endswith("_NOT_BUILT")]
    wrong += [f"{name}: ./test.sh must run it, and its labels are {labels.get(name, 'none: there is no such test')}"
              for name in JOURNEYS if "slow" in labels.get(name, ["slow"])]
    print("\n".join(wrong) or f"{len(named)} names of slow tests, labels of {len(labels)} tests")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
