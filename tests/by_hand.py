"""Tests start by hand, without what CTest gives them: `python3 tests/sweep_test.py [UNITTEST NAMES]`.

A test names what it takes: `BUILD, SOURCE, PYTHON = by_hand.arguments("build", "source", "python")`. Where the first
argument is no path of a file or folder, those of the folder build/ beside the sources are put into sys.argv before the
rest.
"""
import pathlib
import shutil
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
DEFAULTS = {"seam": ROOT / "build/seam", "build": ROOT / "build", "source": ROOT, "python": "/usr/bin/python3",
            "cxx": shutil.which("c++") or "c++", "node": ROOT / "tests/mcap_node", "commands": ROOT / "docs/reference/commands.md",
            "models": ROOT / "docs/reference/models.md", "fewest": "5"}


def arguments(*takes):
    """What the test takes: files and folders as absolute paths, a compiler and Python as they are called."""
    # A name of a unittest may be that of a folder here.
    if len(sys.argv) < 2 or "/" not in sys.argv[1]:
        put_defaults(takes)
    given = [text if name in ("python", "cxx") else pathlib.Path(text).resolve() for name, text in zip(takes, sys.argv[1:])]
    given += [None] * (len(takes) - len(given))
    return given if len(takes) > 1 else given[0]


def put_defaults(takes):
    for name in takes:
        if not pathlib.Path(DEFAULTS[name]).exists() and name in ("seam", "build"):
            sys.exit(f"{sys.argv[0]}: {DEFAULTS[name]} is missing: build it (scripts/build.sh program), or name it: "
                     f"{' '.join(takes).upper()}")
    sys.argv[1:1] = [str(DEFAULTS[name]) for name in takes]
