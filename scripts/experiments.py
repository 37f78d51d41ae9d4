#!/usr/bin/env python3
"""Repeats the paper's experiments and writes their tables and plots into docs/evidence/experiments.md.

    scripts/experiments.py --short          3 seeds; 10 minutes on two idle cores
    scripts/experiments.py --full           20 seeds; 70 minutes on two idle cores
    scripts/experiments.py --fill           nothing is run, the page is filled from what is in out/

Interrupted, it goes on where it was. A table stands between <!-- table: FILE --> and <!-- end -->,
FILE below the output folder; pictures that the page shows from docs/images are copied from there too.
"""
import argparse
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs/evidence/experiments.md"
BLOCK = re.compile(r"(<!-- table: (\S+) -->\n).*?(<!-- end -->)", re.S)
PICTURE = re.compile(r"\]\(\.\./images/(\S+\.png)\)")


def run(seam, *arguments, to=None):
    """Runs seam; what it prints goes to `to`, below its own command line."""
    words = [str(argument) for argument in arguments]
    print("seam", *words, flush=True)
    done = subprocess.run([seam, *words], stdout=subprocess.PIPE, text=True, check=True)
    if to is not None:
        with open(to, "a", encoding="utf-8") as file:
            shown = " ".join(word.replace(f"{to.parent}/", "") for word in words)
            file.write(f"$ seam {shown}\n{done.stdout}")


def record(seam, folder):
    """The locked camera is measured; the other mode's cameras are compared with the record."""
    def told(name):
        path = folder / name
        path.unlink(missing_ok=True)
        path.write_text("```\n", encoding="utf-8")
        return path

    recorded = folder / "recorded"
    run(seam, "measure", "--model", folder / "locked.yaml", "--protocol", folder / "protocol", "--seed", 1, "--out", recorded)
    to = told("frame_sync.txt")
    run(seam, "compare", "--model", folder / "scheduled.yaml", "--data", recorded, to=to)
    run(seam, "diagnose", "--model", folder / "scheduled.yaml", "--data", recorded, to=to)
    run(seam, "add", "frame_sync", "--model", folder / "scheduled.yaml", "--data", recorded, "--out", folder / "with_lock.yaml", to=to)
    run(seam, "compare", "--model", folder / "with_lock.yaml", "--data", recorded, to=to)
    both = told("both.txt")
    run(seam, "add", "frame_sync", "--model", folder / "instant.yaml", "--data", recorded, "--out", folder / "step1.yaml", to=both)
    run(seam, "diagnose", "--model", folder / "step1.yaml", "--data", recorded, to=both)
    run(seam, "add", "rolling_shutter", "--model", folder / "step1.yaml", "--data", recorded, "--out", folder / "step2.yaml", to=both)
    run(seam, "add", "exposure", "--model", folder / "step2.yaml", "--data", recorded, "--out", folder / "step3.yaml", to=both)
    for path in (to, both):
        with open(path, "a", encoding="utf-8") as file:
            file.write("```\n")


def fill(out):
    """Tables and pictures into the page."""
    def table(match):
        file = out / match.group(2)
        if not file.is_file():
            print(f"{file}: not there, the page keeps what it has", file=sys.stderr)
            return match.group(0)
        return match.group(1) + file.read_text(encoding="utf-8") + match.group(3)

    text = BLOCK.sub(table, PAGE.read_text(encoding="utf-8"))
    PAGE.write_text(text, encoding="utf-8")
    for name in PICTURE.findall(text):
        for picture in sorted(out.glob(f"*/{name}")):
            shutil.copyfile(picture, ROOT / "docs/images" / name)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    size = parser.add_mutually_exclusive_group(required=True)
    for name in ("short", "full", "fill"):
        size.add_argument(f"--{name}", action="store_true")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out"))
    parser.add_argument("--seam", type=pathlib.Path, default=ROOT / "build" / "seam")
    chosen = parser.parse_args()
    if not chosen.fill:
        seeds = ["--seeds", 20 if chosen.full else 3]
        for name, options in (("ball-distance", []), ("head-swing-bias", seeds), ("localization", seeds)):
            folder = chosen.out / name
            run(chosen.seam, "experiment", name, *options, "--out", folder, "--json", folder / "result.json")
        record(chosen.seam, chosen.out / "head-swing-bias" / "measure")
    fill(chosen.out)


if __name__ == "__main__":
    main()
