#!/usr/bin/env python3
"""What `./run.sh` builds is all that a user needs, and nothing of the tests: program_test.py BUILD_DIR

The target `program` must make the messages of the Python SDK, without which no behaviour in Python starts.
"""
import subprocess
import sys

import by_hand

BUILD = by_hand.arguments("build")
# A part of a command that the build runs for a target, and what it makes there.
MADE = {"--python_out=": "messages of the Python SDK", "-o seam ": "seam", "-o seam-render ": "seam-render",
        "-o behaviours/head_swing ": "example behaviours", "tools/manual.py": "manual pages"}
NOT_MADE = {"/test_": "tests", "/bench_": "benchmarks", "/fuzz_": "fuzzers"}


def main():
    listed = subprocess.run(["ninja", "-C", BUILD, "-t", "commands", "program"], capture_output=True, text=True, check=True).stdout
    wrong = [f"'program' does not make the {what}: no command has '{part}'" for part, what in MADE.items() if part not in listed]
    wrong += [f"'program' builds {what}: {next(line for line in listed.splitlines() if part in line)[:200]}"
              for part, what in NOT_MADE.items() if part in listed]
    print("\n".join(wrong))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
