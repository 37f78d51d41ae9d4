#!/usr/bin/env python3
"""What the pages say of the tree is there: tour_test.py

- docs/design/tour.md: each `name` in `file` is a function or type that this file holds;
- files and folders of the tree that any page names exist (NAME in a path stands for anything), and links lead somewhere;
- so does every page that a comment in the code cites.
"""
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
TOUR = ROOT / "docs/design/tour.md"
PAGES = sorted([*ROOT.glob("docs/**/*.md"), ROOT / "CONTRIBUTING.md", ROOT / "README.md", ROOT / "replays/FORMAT.md"])
FEWEST_HOPS = 50


def tracked():
    names = subprocess.run(["git", "-C", ROOT, "ls-files", "--cached", "--others", "--exclude-standard"], capture_output=True,
                           text=True, check=True).stdout.split("\n")
    return {name for name in names if name and (ROOT / name).exists()}


def holds(code, name, is_header):
    """Whether the code declares this type, or (in a source: defines, where a line begins) this function."""
    last = re.escape(name.split("::")[-1])
    if re.search(rf"\b(?:class|struct|enum class|using)\s+{last}\b(?!;)", code):
        return True
    if is_header:
        return re.search(rf"\b{last}\s*\(", code) is not None
    qualified = re.escape("::".join(name.split("::")[-2:]))
    return re.search(rf"^[\w:][^\n]*\b{qualified}\(", code, re.M) is not None


def missing_hops(files):
    text = TOUR.read_text(encoding="utf-8")
    # Two names of one file may stand together: `a` and `b` in `file`.
    hops = []
    for names, path in re.findall(r"((?:`[\w:]+`,?\s+(?:and\s+)?)+)in\s+`([\w/.]+)`", text):
        hops += [(name, path) for name in re.findall(r"`([\w:]+)`", names)]
    if len(hops) < FEWEST_HOPS:
        yield f"docs/design/tour.md: {len(hops)} hops found, expected {FEWEST_HOPS} or more"
    for name, path in hops:
        if path not in files:
            yield f"docs/design/tour.md: `{name}` in `{path}`: no such file"
            continue
        if not holds((ROOT / path).read_text(encoding="utf-8"), name, path.endswith(".h")):
            yield f"docs/design/tour.md: `{name}` in `{path}`: the file has no such function or type"


def missing_files(files):
    folders = {str(parent) for name in files for parent in pathlib.PurePath(name).parents}
    tops = {name.split("/")[0] for name in files if "/" in name}
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        text = re.sub(r"^```.*?^```$", "", text, flags=re.M | re.S)
        for path in re.findall(r"`([\w.-]+/[\w./-]*)`", text):
            if path.split("/")[0] in tops and "NAME" not in path and path.rstrip("/") not in files | folders:
                yield f"{page.relative_to(ROOT)}: `{path}`: no such file or folder"
        for link in re.findall(r"\]\(([\w./-]+)\)", text):
            there = (page.parent / link).resolve()
            if not there.exists():
                yield f"{page.relative_to(ROOT)}: link to {link}, which is not there"


def missing_citations(files):
    for name in sorted(files):
        if not re.search(r"\.(h|cc|inc)$", name) or ".test." in name or name == "app/camera_renderer.cc":
            continue
        for number, line in enumerate((ROOT / name).read_text(encoding="utf-8").splitlines(), 1):
            comment = line.split("//", 1)[1] if "//" in line else ""
            for page in re.findall(r"[\w./-]+\.md\b", comment):
                if page not in files:
                    yield f"{name}:{number}: cites {page}, which is not in the tree (docs/...?)"


def main():
    files = tracked()
    found = [*missing_hops(files), *missing_files(files), *missing_citations(files)]
    for finding in found:
        print(finding)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
