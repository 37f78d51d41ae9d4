#!/usr/bin/env python3
"""The tables of docs/evidence/ are what scripts/evidence.py renders, and what differs is noticed: evidence_test.py"""
import copy
import pathlib
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))
import evidence  # noqa: E402

TABLE = {"command": "`seam x`", "machine": "two cores", "recorded": [{"commit": "0123abc", "date": "2026-01-31"}],
         "columns": ["A", "B"], "rows": [["1", "2"]]}
PAGE = "# X\n\n<!-- result: one -->\n<!-- end -->\n\n<!-- words -->\n| What | Why |\n|---|---|\n| a | b |\n"
SPOILT = {  # What is done to the table or the page, and what must be said.
    "its tables are not those": lambda tables, text: text.replace("| 1 | 2 |", "| 1 | 3 |"),
    "a row of 1 cells": lambda tables, text: tables["one"].update(rows=[["1"]]),
    "expected a commit and a date": lambda tables, text: tables["one"].update(recorded=[{"commit": "today", "date": "2026-01-31"}]),
    "must not be empty": lambda tables, text: tables["one"].update(command=""),
    "has no result in": lambda tables, text: tables.clear(),
    "shows table one 0 times": lambda tables, text: "# X\n",
    "a table without a result file": lambda tables, text: text.replace("<!-- words -->\n", ""),
}


def found_in(folder, tables, text):
    page = pathlib.Path(folder) / "x.md"
    page.write_text(text)
    return list(evidence.page_findings(page, tables, check=True))


def main():
    with tempfile.TemporaryDirectory() as folder:
        page = pathlib.Path(folder) / "x.md"
        page.write_text(PAGE)
        evidence.ROOT = pathlib.Path(folder)
        assert not list(evidence.page_findings(page, {"one": TABLE}, check=False))
        good = page.read_text()
        assert "| 1 | 2 |\n\n*By `seam x` on two cores; recorded 2026-01-31 (`0123abc`).*\n<!-- end -->" in good, good
        assert not found_in(folder, {"one": TABLE}, good)
        for said, spoil in SPOILT.items():
            tables = {"one": copy.deepcopy(TABLE)}
            text = spoil(tables, good)
            found = found_in(folder, tables, text if isinstance(text, str) else good)
            assert any(said in finding for finding in found), (said, found)
    sys.argv = ["evidence.py", "--check"]
    evidence.ROOT = ROOT
    return evidence.main()


if __name__ == "__main__":
    sys.exit(main())
