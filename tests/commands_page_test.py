#!/usr/bin/env python3
"""A page says what the program says: commands_page_test.py SEAM docs/reference/commands.md [COMMAND...]

COMMAND makes the page, run in the source folder; left out: help --markdown.
Where they differ, the page as it should be is written beside it, to be looked at and moved into its place.
"""
import pathlib
import subprocess
import sys

import by_hand

by_hand.arguments("seam", "commands")


def main():
    seam, page = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    command = sys.argv[3:] or ["help", "--markdown"]
    wanted = subprocess.run([seam.resolve(), *command], cwd=pathlib.Path(__file__).resolve().parent.parent, capture_output=True, text=True,
                            check=True).stdout
    beside = page.with_name(page.name + ".new")
    if page.exists() and page.read_text(encoding="utf-8") == wanted:
        beside.unlink(missing_ok=True)
        return 0
    beside.write_text(wanted, encoding="utf-8")
    return f"{page} differs from the program; compare with {beside} (or: seam {' '.join(command)} > {page})"


if __name__ == "__main__":
    sys.exit(main())
