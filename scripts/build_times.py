#!/usr/bin/env python3
"""What building and testing cost: which targets, units, headers and tests take the time.

  scripts/build_times.py --measure [--folder build-times] [TARGET...]
                         builds from nothing, without the compiler's cache, and writes down what each unit took; then reports
  scripts/build_times.py [--folder build-times] [--tests build] [--most 20] [--csv FILE]
                         reports; --csv writes the table of docs/evidence/build.md (scripts/evidence.py --record)

Units are measured in processor seconds (user and system) of the compiler, which other programs on the machine hardly
change. A folder that was not built by --measure has its seconds of the clock instead (.ninja_log), with the compiler's
cache in them. Times of tests are those of CTest (Testing/Temporary/CTestCostData.txt of --tests): seconds of the clock,
so run them on an idle machine. A change of a header costs the units that read it, by `ninja -t deps`; its seconds are
those of two idle cores.
"""
import argparse
import collections
import csv
import json
import os
import pathlib
import re
import resource
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
CORES = 2
COST = "processor_seconds.log"


def launch(log, command):
    """Runs a compiler and appends the processor seconds and the name of what it wrote to the log."""
    code = subprocess.run(command).returncode
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    if "-o" in command:
        with open(log, "a", encoding="utf-8") as out:  # One write of a short line: lines of several processes do not mix.
            out.write(f"{used.ru_utime + used.ru_stime:.2f}\t{command[command.index('-o') + 1]}\n")
    return code


def measure(folder, targets):
    """A fresh build of the targets; those of earlier calls stay, so that groups may be measured one after the other."""
    launcher = f"{sys.executable};{pathlib.Path(__file__).resolve()};--launch;{folder / COST}"
    subprocess.run(["cmake", "--preset", "release", "-B", folder, "-DSEAM_CCACHE=OFF", f"-DCMAKE_CXX_COMPILER_LAUNCHER={launcher}"],
                   cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["cmake", "--build", folder, "-j", str(CORES), "--target", *(targets or ["all"])], check=True)


def root_of(folder):
    """The tree of a build folder."""
    cache = (folder / "CMakeCache.txt").read_text(encoding="utf-8")
    return pathlib.Path(re.search(r"^CMAKE_HOME_DIRECTORY:INTERNAL=(.*)$", cache, re.M)[1])


def group_of(unit):
    """Which of the builds that a developer waits for has the unit."""
    target = re.search(r"CMakeFiles/([^/]+)\.dir/", unit)
    name = target[1] if target else unit
    if name.startswith("bench_"):
        return "benchmarks"
    if name.startswith(("test_", "fuzz_", "seam_fuzz", "golden_frames", "mistaken_")):
        return "tests"
    return "program"


def unit_seconds(folder):
    """{object: seconds}, the latest for each."""
    if (folder / COST).exists():
        lines = (line.split("\t") for line in (folder / COST).read_text(encoding="utf-8").splitlines())
        return {unit: float(seconds) for seconds, unit in lines}
    log = folder / ".ninja_log"
    if not log.exists():
        sys.exit(f"build_times.py: {folder} holds no build: make one by scripts/build_times.py --measure --folder {folder}")
    fields = [line.split("\t") for line in log.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    return {name: (int(end) - int(begin)) / 1000 for begin, end, _, name, *_ in fields if name.endswith((".o", ".gch"))}


def headers_read(listed, folder, root=ROOT):
    """{object: the headers of this tree that it reads} of `ninja -t deps`, with those of its precompiled header."""
    reads, unit = {}, None
    for line in listed.splitlines():
        if line and not line.startswith(" "):
            unit = line.split(":")[0]
            reads[unit] = set()
        elif line.strip():
            reads[unit].add(os.path.normpath(folder / line.strip()))
    precompiled = {str(folder / unit): files for unit, files in reads.items() if unit.endswith(".gch")}
    tree = {}
    for unit, files in reads.items():
        for once in files & set(precompiled):
            files = files | precompiled[once]
        tree[unit] = {os.path.relpath(file, root) for file in files if file.startswith(f"{root}/") and file.endswith(".h")
                      and not file.startswith(f"{folder}/")}
    return tree


def header_costs(reads, seconds):
    """[(seconds, units, header)] of the headers of each object, the dearest first."""
    units, cost = collections.Counter(), collections.Counter()
    for unit, headers in reads.items():
        if unit in seconds and group_of(unit) != "benchmarks":
            for header in headers:
                units[header] += 1
                cost[header] += seconds[unit]
    return sorted(((cost[header] / CORES, units[header], header) for header in units), reverse=True)


def test_seconds(build):
    """[(seconds, test, label)]; no rows where the tests have not run."""
    path = build / "Testing/Temporary/CTestCostData.txt"
    if not path.exists():
        return []
    cost = {parts[0]: float(parts[2]) for parts in map(str.split, path.read_text(encoding="utf-8").splitlines()) if len(parts) == 3}
    listed = json.loads(subprocess.run(["ctest", "--test-dir", build, "--show-only=json-v1"], capture_output=True, text=True,
                                       check=True).stdout)
    rows = []
    for test in listed["tests"]:
        labels = next((entry["value"] for entry in test["properties"] if entry["name"] == "LABELS"), ["no label"])
        rows.append((cost.get(test["name"], 0.0), test["name"], "slow" if "slow" in labels else labels[0]))
    return sorted(rows, reverse=True)


def report(folder, build, most):
    """Prints the lists; returns the rows of the page's table."""
    seconds = unit_seconds(folder)
    groups, counts = collections.Counter(), collections.Counter()
    for unit, cost in seconds.items():
        groups[group_of(unit)] += cost
        counts[group_of(unit)] += 1
    print("seconds of the " + ("compiler's processor" if (folder / COST).exists() else "clock") + " by group")
    rows = []
    for group, cost in groups.most_common():
        print(f"{cost:8.0f}  {counts[group]:4} units  {group}")
        rows.append([f"Compile: {group}", str(counts[group]), f"{cost:.0f} s", f"{cost / CORES / 60:.1f} min"])
    print(f"\nthe {most} dearest units")
    for unit, cost in sorted(seconds.items(), key=lambda entry: -entry[1])[:most]:
        print(f"{cost:8.1f}  {unit}")
    listed = subprocess.run(["ninja", "-C", folder, "-t", "deps"], capture_output=True, text=True, check=True).stdout
    headers = header_costs(headers_read(listed, folder, root_of(folder)), seconds)
    print(f"\nthe {most} dearest headers: seconds on {CORES} cores, units")
    for cost, units, header in headers[:most]:
        print(f"{cost:8.0f}  {units:4}  {header}")
    if headers:
        cost, units, header = headers[0]
        rows.append([f"Change of the dearest header, `{header}`", str(units), f"{cost * CORES:.0f} s", f"{cost:.0f} s"])
        cost, units, header = headers[len(headers) // 2]
        rows.append(["Change of the median header", str(units), f"{cost * CORES:.0f} s", f"{cost:.0f} s"])
    tests = test_seconds(build)
    by_label, counts = collections.Counter(), collections.Counter()
    for cost, _, label in tests:
        by_label[label] += cost
        counts[label] += 1
    print("\ntest seconds by label")
    for label, cost in by_label.most_common():
        print(f"{cost:8.0f}  {counts[label]:4} tests  {label}")
        rows.append([f"Tests: {label}", str(counts[label]), f"{cost:.0f} s", f"{cost / CORES / 60:.1f} min"])
    print(f"\nthe {most} dearest tests that are not slow")
    for cost, name, label in [row for row in tests if row[2] != "slow"][:most]:
        print(f"{cost:8.1f}  {label:8}  {name}")
    return rows


def main():
    if sys.argv[1:2] == ["--launch"]:
        return launch(sys.argv[2], sys.argv[3:])
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--measure", action="store_true")
    parser.add_argument("--folder", type=pathlib.Path, default=ROOT / "build-times")
    parser.add_argument("--tests", type=pathlib.Path, default=ROOT / "build")
    parser.add_argument("--most", type=int, default=20)
    parser.add_argument("--csv", type=pathlib.Path)
    parser.add_argument("targets", nargs="*")
    given = parser.parse_args()
    folder = given.folder.resolve()
    if given.targets and not given.measure:
        parser.error("targets go with --measure")
    if given.measure:
        measure(folder, given.targets)
    rows = report(folder, given.tests.resolve(), given.most)
    if given.csv:
        with given.csv.open("w", encoding="utf-8", newline="") as out:
            csv.writer(out).writerows([["What", "Units or tests", "Processor or test seconds", "On two idle cores"], *rows])
    return 0


if __name__ == "__main__":
    sys.exit(main())
