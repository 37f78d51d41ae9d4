#!/usr/bin/env python3
"""All C++ stands as clang-format lays it out by .clang-format: format_test.py [--mend]

Prints the files that do not, and how to mend them; exit code 77 (skipped) where clang-format is missing. --mend formats
them instead."""
import pathlib
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent


def main():
    if not shutil.which("clang-format"):
        print("clang-format is missing: scripts/dependencies.sh installs it")
        return 77
    names = subprocess.run(["git", "-C", str(ROOT), "ls-files", "--cached", "--others", "--exclude-standard",
                            "*.h", "*.cc", "*.inc"], capture_output=True, text=True, check=True).stdout.split()
    names = [name for name in names if (ROOT / name).exists()]

    def well(some):
        return subprocess.run(["clang-format", "--dry-run", "-Werror", *some], cwd=ROOT, capture_output=True).returncode == 0

    # Many at a time: a start costs as much as ten files.
    bad = []
    for first in range(0, len(names), 100):
        some = names[first:first + 100]
        if not well(some):
            bad += [name for name in some if not well([name])]
    if bad and "--mend" in sys.argv:
        subprocess.run(["clang-format", "-i", *bad], cwd=ROOT, check=True)
        print(f"formatted: {' '.join(bad)}")
        return 0
    for name in bad:
        print(f"{name}: not as .clang-format says: clang-format -i {name}")
    print(f"{len(bad)} of {len(names)} files")
    return 1 if bad or not names else 0


if __name__ == "__main__":
    sys.exit(main())
