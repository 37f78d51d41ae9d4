#!/usr/bin/env python3
"""Runs the commands of a page and checks its promises: doc_test.py FILE.md [SEAM [PYTHON]] [--set FOLDER] [--material FOLDER]
[--tree].

Every fenced block marked `sh` is run in order, in a copy of the material: the folder beside the page (docs/x.md:
docs/x/), or another one. With --tree the commands also find scenarios/, models/ and replays/ of the source there.
After a block, comments such as
    <!-- check: diagnose.json verdict == missing_effect -->
    <!-- check: fitted.json error_after < 1.05 -->
    <!-- check: exists report.html -->
look at the files it wrote. The document's words are for people; these are for this test. PYTHON is the python3 of
the blocks: one that has numpy. FOLDER is a measurement set that is not part of the source, by whose name the commands
know it; without it nothing is run (exit code 77).
"""
import argparse
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

import by_hand

ROOT = pathlib.Path(__file__).resolve().parent.parent
PIECE = re.compile(r"^```sh\n(?P<sh>.*?)^```$|^<!-- check: (?P<check>.*?) -->$", re.M | re.S)


def look_up(document, path):
    """candidates.0.effect, parameters.k.value"""
    for name in path.split("."):
        document = document[int(name)] if isinstance(document, list) else document[name]
    return document


def holds(folder, check):
    words = check.split()
    if words[0] == "exists":
        return (folder / words[1]).is_file(), "a file"
    file, path, relation, *rest = words
    found = look_up(json.loads((folder / file).read_text(encoding="utf-8")), path)
    expected = " ".join(rest)
    if relation == "==":
        return str(found) == expected, found
    if relation == "contains":
        return expected in json.dumps(found), found
    if relation == "within":  # value within TOLERANCE of EXPECTED
        tolerance, wanted = float(rest[0]), float(rest[2])
        return abs(found - wanted) <= tolerance, found
    number = float(expected)
    return {"<": found < number, ">": found > number}[relation], found


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("document", type=pathlib.Path)
    arguments.add_argument("seam", type=pathlib.Path, nargs="?", default=by_hand.DEFAULTS["seam"])
    arguments.add_argument("python", type=pathlib.Path, nargs="?", default=by_hand.DEFAULTS["python"])
    arguments.add_argument("--set", type=pathlib.Path)
    arguments.add_argument("--material", type=pathlib.Path)
    arguments.add_argument("--tree", action="store_true")
    given = arguments.parse_args()
    if given.set and not given.set.is_dir():
        print(f"skipped: {given.set} is not there")
        return 77
    document, seam = given.document.resolve(), given.seam.resolve()
    first = [str(seam.parent), *([str(given.python.parent)] if given.python else [])]
    environment = dict(os.environ, PATH=":".join([*first, os.environ["PATH"]]))
    with tempfile.TemporaryDirectory() as name:
        # As deep as the pages' folders are in the source, so that files name models by the same path.
        folder = pathlib.Path(name) / "docs" / "work"
        material = given.material or document.with_suffix("")
        if material.is_dir():
            shutil.copytree(material, folder)
        else:
            folder.mkdir(parents=True)
        for part in ("scenarios", "models", "replays") if given.tree else ():
            for place in (folder, pathlib.Path(name)):
                (place / part).symlink_to(ROOT / part)
        if given.set:
            (folder / given.set.name).symlink_to(given.set.resolve())
        done = checks = 0
        for piece in PIECE.finditer(document.read_text(encoding="utf-8")):
            if piece["sh"]:
                done += 1
                script = "set -euo pipefail\n" + piece["sh"]
                run = subprocess.run(["bash", "-c", script], cwd=folder, env=environment, capture_output=True, text=True)
                print(f"$ {piece['sh']}{run.stdout}{run.stderr}")
                if run.returncode != 0:
                    return f"{document.name}: the block above ended with exit code {run.returncode}"
            else:
                checks += 1
                true, found = holds(folder, piece["check"])
                if not true:
                    return f"{document.name}: promised {piece['check']}, found {found}"
        if not done or not checks:
            return f"{document.name}: nothing was run or nothing was checked"
        print(f"{document.name}: {done} blocks run, {checks} promises kept")
    return 0


if __name__ == "__main__":
    sys.exit(main())
