#!/usr/bin/env python3
"""A servo's log in degrees to a set of kind joints: servo_log_to_set.py LOG.csv SET [--joint pan] ...

LOG.csv has a header and a row a sample: time, commanded angle, measured angle, and what else was logged (load, voltage,
temperature), which is kept. Columns that end with _deg become _rad. The log is cut into runs where the servo rested:
each run of a set begins at rest, and whole runs are held out.
"""
import argparse
import csv
import math
import pathlib


def read_log(options):
    """Rows (time, command, measured, other cells), in degrees turned to radians; and the names of the other columns."""
    with open(options.log, newline="", encoding="utf-8-sig") as file:
        reader = csv.DictReader(file)
        known = (options.time, options.command, options.measured)
        others = [name for name in reader.fieldnames if name not in known]
        rows = []
        for row in reader:
            time_s = float(row[options.time]) * options.time_unit_s
            if rows and time_s <= rows[-1][0]:
                continue  # The same sample once more.
            cells = [repr(math.radians(float(row[n]))) if n.endswith("_deg") else row[n] for n in others]
            rows.append((time_s, math.radians(float(row[options.command])),
                         math.radians(float(row[options.measured])), cells))
    return rows, [n[:-4] + "_rad" if n.endswith("_deg") else n for n in others]


def runs_of(rows, rest_s):
    """The number of the run of each row: a new one begins with the last row before a command that follows a rest."""
    numbers, run, changed_s = [], 0, rows[0][0]
    for i, row in enumerate(rows):
        changes = i + 1 < len(rows) and rows[i + 1][1] != row[1]
        if changes and i > 0 and row[0] - changed_s >= rest_s:
            run += 1
        if changes:
            changed_s = rows[i + 1][0]
        numbers.append(run)
    return numbers


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("log")
    parser.add_argument("set", type=pathlib.Path)
    parser.add_argument("--joint", default="pan")
    parser.add_argument("--time", default="time_s")
    parser.add_argument("--time-unit-s", type=float, default=1, help="0.001 for milliseconds")
    parser.add_argument("--command", default="goal_deg")
    parser.add_argument("--measured", default="present_deg")
    parser.add_argument("--rest-s", type=float, default=0.5, help="a command that held so long has been reached")
    options = parser.parse_args()
    rows, others = read_log(options)
    options.set.mkdir(parents=True, exist_ok=True)
    with open(options.set / "joints.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["run", "time_s", "joint", "command_rad", "measured_rad", *others])
        for run, (time_s, command, measured, cells) in zip(runs_of(rows, options.rest_s), rows):
            writer.writerow([run, f"{time_s:.6f}", options.joint, f"{command:.7f}", f"{measured:.7f}", *cells])
    (options.set / "measurement.yaml").write_text(
        f"format: seam-measurement/1\nkind: joints\ntitle: {options.joint} servo, {options.log}\n"
        "group: run\nfiles: {joints: joints.csv}\n", encoding="utf-8")


if __name__ == "__main__":
    main()
