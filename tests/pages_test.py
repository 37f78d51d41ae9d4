#!/usr/bin/env python3
"""The pages of docs/ hold together: pages_test.py

- each link between pages, and to files of the tree, leads somewhere, its anchor included; each picture is there;
- each page is reached from docs/index.md by links, and stands in the site's contents (scripts/site/mkdocs.yml);
- outside docs/reference and docs/evidence no page is longer than 200 lines, and all of them have at most 25,000 words.
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
DOCS = ROOT / "docs"
OTHERS = [ROOT / name for name in ("README.md", "CONTRIBUTING.md", "SECURITY.md", "CHANGELOG.md", "CODE_OF_CONDUCT.md", "replays/FORMAT.md")]
MOST_LINES, MOST_WORDS = 200, 25_000
LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)\)")


def prose(text):
    """Without blocks of code, in which brackets mean other things."""
    return re.sub(r"^(```|~~~).*?^\1[^\n]*$", "", text, flags=re.M | re.S)


def anchors(text):
    """As GitHub and mkdocs make them from headings: lower case, words joined by hyphens."""
    found = set()
    for heading in re.findall(r"^#+ (.*)$", prose(text), flags=re.M):
        plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading)
        found.add(re.sub(r"\s", "-", re.sub(r"[^\w\s-]", "", plain).strip().lower()))
    return found


def links_of(page):
    return LINK.findall(re.sub(r"`[^`\n]*`", "", prose(page.read_text(encoding="utf-8"))))


def broken_links(page):
    for link in links_of(page):
        path, _, anchor = link.partition("#")
        if "://" in link or link.startswith("mailto:"):
            continue
        there = (page.parent / path).resolve() if path else page
        if not there.exists():
            yield f"{page.relative_to(ROOT)}: link to {link}: no such file"
        elif anchor and there.suffix == ".md" and anchor not in anchors(there.read_text(encoding="utf-8")):
            yield f"{page.relative_to(ROOT)}: link to {link}: no such heading"


def reached(start):
    """All pages of docs/ to which links lead from `start`."""
    seen, todo = set(), [start]
    while todo:
        page = todo.pop()
        if page in seen:
            continue
        seen.add(page)
        there = [(page.parent / link.partition("#")[0]).resolve() for link in links_of(page) if "://" not in link]
        todo += [page for page in there if page.suffix == ".md" and DOCS in page.parents and page.exists()]
    return seen


def sizes(pages):
    words = 0
    for page in pages:
        if page.relative_to(DOCS).parts[0] in ("reference", "evidence"):
            continue
        text = page.read_text(encoding="utf-8")
        words += len(text.split())
        lines = text.count("\n")
        if lines > MOST_LINES:
            yield f"{page.relative_to(ROOT)}: {lines} lines, at most {MOST_LINES}: split it, or move details to docs/reference"
    if words > MOST_WORDS:
        yield f"docs/ outside reference and evidence: {words} words, at most {MOST_WORDS}"


def main():
    pages = sorted(DOCS.rglob("*.md"))
    found = [finding for page in [*pages, *OTHERS] if page.exists() for finding in broken_links(page)]
    known = reached(DOCS / "index.md")
    contents = (ROOT / "scripts/site/mkdocs.yml").read_text(encoding="utf-8")
    for page in pages:
        name = page.relative_to(DOCS).as_posix()
        if page not in known:
            found.append(f"docs/{name}: no links lead there from docs/index.md")
        if not re.search(rf"\s{re.escape(name)}$", contents, flags=re.M):
            found.append(f"docs/{name}: not in the contents of scripts/site/mkdocs.yml")
    found += sizes(pages)
    print("\n".join(found) or f"{len(pages)} pages")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
