#!/usr/bin/env python3
"""Stages the pages of the site: pages.py FOLDER

Copies docs/ and the pages outside it that readers want (contributing, security, changes, the log's format). Links to
these lead to the copies; links to other files of the tree become plain text, since the site does not hold them.
A comment `<!-- site: TEXT -->` becomes TEXT: what only the site has.
"""
import pathlib
import re
import shutil
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
OUTSIDE = {"CONTRIBUTING.md": "project/contributing.md", "SECURITY.md": "project/security.md", "CHANGELOG.md": "project/changes.md",
           "CODE_OF_CONDUCT.md": "project/conduct.md", "replays/FORMAT.md": "reference/log-format.md"}
LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)\s]+)\)")


def up(page, there):
    """The link from one page of the site to another, by their paths there."""
    return "/".join([".."] * (len(pathlib.PurePath(page).parts) - 1) + [there])


def staged(text, source, page):
    """The text of `source` as the site's `page`."""
    def link(match):
        mark, label, target = match.groups()
        path, _, anchor = target.partition("#")
        if "://" in target or not path:
            return match.group()
        there = (source.parent / path).resolve().relative_to(ROOT).as_posix()
        if there in OUTSIDE:
            there = OUTSIDE[there]
        elif there.startswith("docs/"):
            there = there.removeprefix("docs/")
            if not there.endswith((".md", ".png", ".json")):
                return label
        else:
            return label
        return f"{mark}[{label}]({up(page, there)}{'#' + anchor if anchor else ''})"

    text = re.sub(r"<!-- site: (.*?) -->", r"\1", text)
    # Blocks of code stay as they are.
    parts = re.split(r"(^```.*?^```$)", text, flags=re.M | re.S)
    return "".join(part if part.startswith("```") else LINK.sub(link, part) for part in parts)


def main():
    folder = pathlib.Path(sys.argv[1])
    sources = {page: page.relative_to(ROOT / "docs").as_posix() for page in (ROOT / "docs").rglob("*.md")}
    sources |= {ROOT / name: page for name, page in OUTSIDE.items() if (ROOT / name).exists()}
    for source, page in sources.items():
        there = folder / page
        there.parent.mkdir(parents=True, exist_ok=True)
        there.write_text(staged(source.read_text(encoding="utf-8"), source, page), encoding="utf-8")
    for name in ("images", "reference/schemas"):
        shutil.copytree(ROOT / "docs" / name, folder / name, ignore=shutil.ignore_patterns("*.new"))


if __name__ == "__main__":
    main()
