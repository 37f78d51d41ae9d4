#!/usr/bin/env python3
"""The benchmark of programs that find what is missing in a model.

  benchmark/run.py make OUT [--sort SORT ...] [--first 0] [--sets 10]     makes sets (OUT/sets) and OUT/truth
  benchmark/run.py seam OUT ANSWERS.json --seam build/seam [--timeout 120] asks `seam discover`
  benchmark/run.py baseline NAME OUT ANSWERS.json                          asks a baseline
  benchmark/run.py score OUT ANSWERS.json [--csv TABLE.csv] [--wrong]      scores answers
  benchmark/run.py outside OUT ANSWERS.json [--wrong]                      of causes outside the catalogue: what is said of them
  benchmark/run.py summary OUT ANSWERS.json MORE.json ...                  a row a program
  benchmark/run.py pair OUT ANSWERS.json OTHERS.json                       compares two programs on the same sets
  benchmark/run.py trust OUT ANSWERS.json [MORE.json ...]                  how often verdicts were right, by kind and verdict
  benchmark/run.py truth OUT --seam build/seam                             errors of the true models: near 1

`--answered` leaves out sets that the first file has no answer to: else they count as wrong. --csv FILE: the table.
The page benchmark/README.md has the formats and what is scored.
"""
import argparse
import csv
import json
import pathlib
import subprocess
import sys
import tempfile
import time

import answers
import baselines
import honesty
import kinds
import scores
import trust
from sets import read_truths


def chosen(options):
    """Sorts that were asked for; "outside" stands for each cause outside the catalogue."""
    return [sort for name in options.sort or () for sort in (kinds.OUTSIDE if name == "outside" else [name])]


def make(options):
    for sort in chosen(options) or kinds.SORTS:
        for number in range(options.first, options.first + options.sets):
            kinds.make_into(options.out, sort, number)
    return 0


def wanted_sets(options):
    """By number first, so that a run that is cut short has all sorts alike."""
    named = [(*folder.name.rsplit("-", 1)[::-1], folder) for folder in (options.out / "sets").iterdir()]
    return [folder for _, sort, folder in sorted(named) if not options.sort or sort in chosen(options)]


def seam(options):
    """Sets that the file has an answer to are left: an interrupted run goes on."""
    version = subprocess.run([options.seam, "--version"], capture_output=True, text=True, check=True).stdout.strip()
    known, program = {}, options.program or version
    if options.answers.exists():
        before = answers.read(options.answers)
        if before["program"] != program:
            return f"{options.answers}: has answers of {before['program']}, not of {program}: name another file"
        known = before["answers"]
    for folder in wanted_sets(options):
        if folder.name in known:
            continue
        known[folder.name] = given = answers.run_seam(options.seam.resolve(), folder, options.timeout)
        answers.write(options.answers, program, known, timeout_s=options.timeout)
        names = " ".join(name["effect"] for name in given["names"]) or "-"
        print(f"{folder.name:16} {given['failed'] or names}{' UNEXPLAINED' if given['unexplained'] else ''} "
              f"{given['cpu_s']:.1f} s", flush=True)
    return 0


def baseline(options):
    truths, given = read_truths(options.out), {}
    for folder in wanted_sets(options):
        began = time.process_time()
        one = baselines.BASELINES[options.name](folder, truths.get(folder.name))
        if one is not None:
            given[folder.name] = one | {"cpu_s": time.process_time() - began}
    answers.write(options.answers, options.name, given)
    return 0


def markdown(columns, lines):
    return "\n".join("| " + " | ".join(cells) + " |" for cells in (columns, ["---"] * len(columns), *lines))


def show(columns, lines, options):
    print(markdown(columns, lines))
    if options.csv:
        with open(options.csv, "w", newline="", encoding="utf-8") as file:
            csv.writer(file).writerows([columns, *lines])


def asked_truths(options, first):
    return {name: truth for name, truth in read_truths(options.out).items()
            if (not options.sort or truth["sort"] in chosen(options)) and (not options.answered or name in first)}


def score(options):
    given = answers.read(options.answers)["answers"]
    some = scores.scored(asked_truths(options, given), given)
    show(scores.COLUMNS, scores.table(some), options)
    for s in some if options.wrong else ():
        far = [f"{key} {z:+.1f}" for key, z in s.deviations if abs(z) > 5]
        if not s.right or far:
            print(f"{s.name:16} {s.course:8} missing {' '.join(s.missing) or '-'}; needless "
                  f"{' '.join(s.needless) or '-'}; error {s.error and round(s.error, 3)} {s.failed} {' '.join(far)}")
    return 0


def outside(options):
    given = answers.read(options.answers)["answers"]
    truths = {name: truth for name, truth in asked_truths(options, given).items() if truth["outside"]}
    show(honesty.COLUMNS, honesty.table(truths, given), options)
    for line in honesty.wrong(truths, given) if options.wrong else ():
        print(line)
    return 0


def trust_table(options):
    """Answers of several files count together, the last that has one to a set."""
    given = {}
    for path in (options.answers, *options.others):
        given |= answers.read(path)["answers"]
    print(trust.header(trust.counts(read_truths(options.out), given)), end="")
    return 0


def files_scored(options):
    files = [answers.read(path) for path in (options.answers, *options.others)]
    truths = asked_truths(options, files[0]["answers"])
    return [(file["program"], scores.scored(truths, file["answers"])) for file in files]


def summary(options):
    lines = [scores.row(program, some) for program, some in files_scored(options)]
    show(["Program", *scores.COLUMNS[1:]], lines, options)
    return 0


def pair(options):
    (_, first), (_, second) = files_scored(options)
    show(scores.PAIR_COLUMNS, scores.pair(first, second), options)
    return 0


def truth(options):
    """With the true model a set's error is that of its noise: the generators' physics is the catalogue's."""
    for folder in wanted_sets(options):
        with tempfile.TemporaryDirectory() as scratch:
            out = pathlib.Path(scratch) / "compare.json"
            done = subprocess.run([options.seam, "compare", "--model", options.out / "truth" / f"{folder.name}.yaml",
                                   "--data", folder, "--json", out], capture_output=True, text=True, check=False)
            said = f"error {json.loads(out.read_text())['error']:.3f}" if out.exists() else done.stderr.strip()
            known = json.loads((options.out / "truth" / f"{folder.name}.json").read_text())
            print(f"{folder.name:16} {known['course']:8} {said:12} {' '.join(known['hidden'])} "
                  f"{known['outside'] or ''}", flush=True)
    return 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    steps = parser.add_subparsers(dest="step", required=True)
    positions = {"make": (), "seam": ("answers",), "baseline": ("name", "answers"), "score": ("answers",), "outside": ("answers",),
                 "summary": ("answers", "others"), "trust": ("answers", "others"), "pair": ("answers", "others"), "truth": ()}
    for step, given in positions.items():
        one = steps.add_parser(step)
        if "name" in given:
            one.add_argument("name", choices=baselines.BASELINES)
        one.add_argument("out", type=pathlib.Path)
        for name in given:
            if name != "name":
                more = {"nargs": {"summary": "+", "trust": "*"}.get(step, 1)} if name == "others" else {}
                one.add_argument(name, type=pathlib.Path, **more)
        one.add_argument("--sort", action="append", choices=[*kinds.SORTS, *kinds.CAUSES, *kinds.OUTSIDE, "outside"])
        if step == "make":
            one.add_argument("--first", type=int, default=0)
            one.add_argument("--sets", type=int, default=10)
        if step in ("seam", "truth"):
            one.add_argument("--seam", type=pathlib.Path, required=True)
        if step == "seam":
            one.add_argument("--timeout", type=int, default=120, help="seconds of processor time a set")
            one.add_argument("--program", help="the name that the answers carry")
        if step in ("score", "outside", "summary", "pair"):
            one.add_argument("--csv", type=pathlib.Path)
            one.add_argument("--answered", action="store_true")
        if step in ("score", "outside"):
            one.add_argument("--wrong", action="store_true", help="names the sets that are wrong")
    options = parser.parse_args()
    return {"trust": trust_table}.get(options.step, globals().get(options.step))(options)


if __name__ == "__main__":
    sys.exit(main())
