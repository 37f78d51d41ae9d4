#!/usr/bin/env python3
"""Renders the tables of docs/evidence/ from their result files.

  scripts/evidence.py              renews the tables of all pages
  scripts/evidence.py --check      names what differs; exit code 1 if anything does
  scripts/evidence.py --record PAGE TABLE FILE.csv --command COMMAND --machine MACHINE
                                   takes columns and rows from a CSV file, commit and date from git, and renews the page

docs/evidence/results/PAGE.json holds the tables of docs/evidence/PAGE.md by name: `command` that repeats the result
(Markdown), `machine`, `recorded` (commits and dates of the figures), `columns` and `rows`, whose cells are Markdown. In the page a table
stands between <!-- result: NAME --> and <!-- end -->. A table of words alone, without a result, stands behind
<!-- words -->; tables that other scripts write keep their own markers.
"""
import argparse
import csv
import json
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGES = ROOT / "docs/evidence"
RESULT = re.compile(r"(<!-- result: (?P<name>[\w-]+) -->\n).*?(<!-- end -->)", re.S)
# What scripts/experiments.py writes, blocks of code, tables of words.
ELSEWHERE = re.compile(r"^<!-- table: \S+ -->\n.*?^<!-- end -->$|^```.*?^```$|^<!-- words -->\n(?:\|[^\n]*\n)+", re.M | re.S)
# Contents, and what scripts/matrix.sh writes with commit and date.
OTHER_PAGES = {"index.md", "matrix.md"}
FIELDS = {"command", "machine", "recorded", "columns", "rows"}


def rendered(table):
    lines = ["| " + " | ".join(cells) + " |" for cells in (table["columns"], *table["rows"])]
    lines.insert(1, "|" + "---|" * len(table["columns"]))
    recorded = ", ".join(f"{entry['date']} (`{entry['commit']}`)" for entry in table["recorded"])
    return "\n".join(lines) + f"\n\n*By {table['command']} on {table['machine']}; recorded {recorded}.*\n"


def faults(name, table):
    if set(table) != FIELDS:
        yield f"{name}: has the fields {sorted(table)}, expected {sorted(FIELDS)}"
        return
    if not table["command"] or not table["machine"] or not table["recorded"] or not table["rows"]:
        yield f"{name}: command, machine, recorded and rows must not be empty"
    for entry in table["recorded"]:
        if not re.fullmatch(r"[0-9a-f]{7,40}", entry.get("commit", "")) or not re.fullmatch(r"\d{4}-\d\d-\d\d", entry.get("date", "")):
            yield f"{name}: recorded holds {entry}, expected a commit and a date"
    for row in table["rows"]:
        if len(row) != len(table["columns"]):
            yield f"{name}: a row of {len(row)} cells, expected {len(table['columns'])}: {row}"


def page_findings(page, tables, check):
    """What is wrong with a page; renews its tables unless this is a check."""
    text, used = page.read_text(encoding="utf-8"), []
    for name, table in tables.items():
        yield from faults(f"{page.stem}.json: {name}", table)

    def renewed(match):
        used.append(match["name"])
        table = tables.get(match["name"])
        return match.group() if table is None else match[1] + rendered(table) + match[3]

    wanted = RESULT.sub(renewed, text)
    for name in used:
        if name not in tables:
            yield f"{page.name}: table {name} has no result in results/{page.stem}.json"
    for name in tables:
        if used.count(name) != 1:
            yield f"{page.name}: shows table {name} {used.count(name)} times, expected once"
    rest = ELSEWHERE.sub("", RESULT.sub("", text))
    for header in re.findall(r"^\|.*\|\n(?=\|[ :|-]+\|$)", rest, re.M):
        yield f"{page.name}: a table without a result file: {header.strip()}"
    if wanted == text:
        return
    if check:
        yield f"{page.name}: its tables are not those of results/{page.stem}.json: scripts/evidence.py renews them"
    else:
        page.write_text(wanted, encoding="utf-8")
        print(f"renewed {page.relative_to(ROOT)}")


def results_of(page):
    path = PAGES / "results" / f"{page}.json"
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}


def written(tables):
    """One row a line, so that a change of a figure is a change of a line."""
    def row_list(rows):
        return "[\n" + ",\n".join("      " + json.dumps(row, ensure_ascii=False) for row in rows) + "\n    ]"

    parts = []
    for name, table in tables.items():
        fields = [f'    {json.dumps(key)}: ' + (row_list(table[key]) if key == "rows" else json.dumps(table[key], ensure_ascii=False))
                  for key in ("command", "machine", "recorded", "columns", "rows")]
        parts.append(f"  {json.dumps(name)}: {{\n" + ",\n".join(fields) + "\n  }")
    return "{\n" + ",\n".join(parts) + "\n}\n"


def record(page, name, file, command, machine):
    columns, *rows = csv.reader(file.open(encoding="utf-8"))
    commit, date = subprocess.run(["git", "-C", ROOT, "log", "-1", "--format=%h %cs"], capture_output=True, text=True,
                                  check=True).stdout.split()
    tables = results_of(page)
    tables[name] = {"command": command, "machine": machine, "recorded": [{"commit": commit, "date": date}], "columns": columns,
                    "rows": rows}
    (PAGES / "results").mkdir(exist_ok=True)
    (PAGES / "results" / f"{page}.json").write_text(written(tables), encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--record", nargs=3, metavar=("PAGE", "TABLE", "FILE.csv"))
    parser.add_argument("--command", default="")
    parser.add_argument("--machine", default="")
    given = parser.parse_args()
    if given.record:
        if not given.command or not given.machine:
            parser.error("--record: expected --command and --machine")
        record(given.record[0], given.record[1], pathlib.Path(given.record[2]), given.command, given.machine)
    found = []
    for page in sorted(PAGES.glob("*.md")):
        if page.name not in OTHER_PAGES:
            found += page_findings(page, results_of(page.stem), given.check)
    known = {page.stem for page in PAGES.glob("*.md")}
    found += [f"{path.name}: no page of this name" for path in (PAGES / "results").glob("*.json") if path.stem not in known]
    for finding in found:
        print(finding)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
