#!/usr/bin/env python3
"""An effect outside the tree: `seam new-effect` for every stage, formatted, built against the headers, proved, and loaded
with --plugin.  plugin_test.py SEAM HEADERS CXX [--quick]

--quick: one stage from end to end; of the others the compiler reads what was written."""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

import by_hand

by_hand.arguments("seam", "source", "cxx")

ROOT = pathlib.Path(__file__).resolve().parent.parent

STAGES = ["timing", "joint", "mount", "geometry", "corner_detector", "radiometry", "light", "sensor", "detector",
          "locomotion", "target"]


def run(*command):
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}: exit code {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout


def proved(seam, headers, cxx, out, name, given):
    """The template as it is passes its test; a hook with functions of SEAM's maths, too; a wrong hook fails it."""
    run("cmake", "-S", out, "-B", f"{out}/build", *given, f"-DCMAKE_CXX_COMPILER={cxx}", "-DCMAKE_CXX_FLAGS=-O0")
    source = pathlib.Path(out, f"{name}.cc")
    written = source.read_text()
    with_maths = written.replace("+= p[0]", "+= maths::exp(maths::log(1 + p[0])) - 1").replace(
        '#include "effects/', '#include "sim_core/base/maths.h"\n#include "effects/', 1)
    for text, passes in ((written.replace("+= p[0]", "+= p[0] + 0.001").replace("- p[0] *", "- 1.1 * p[0] *"), False), (with_maths, True), (written, True)):
        source.write_text(text)
        run("cmake", "--build", f"{out}/build")
        done = subprocess.run(["ctest", "--test-dir", f"{out}/build", "--output-on-failure"], capture_output=True, text=True)
        if (done.returncode == 0) != passes:
            sys.exit(f"{name}: ctest {done.returncode}, expected {'success' if passes else 'failure'}\n{text}{done.stdout}")
        if not passes and f"effect '{name}' does not meet its own example" not in done.stdout:
            sys.exit(f"{name}: {done.stdout}")
    text = run(seam, "--plugin", f"{out}/build/{name}.so", "effects", name)
    if f"{name} (stage " not in text:
        sys.exit(f"seam effects {name} says:\n{text}")


def main():
    seam, headers, cxx = sys.argv[1:4]
    quick = "--quick" in sys.argv
    with tempfile.TemporaryDirectory() as folder:
        # Where none are given, the headers are those of the tree that the program was built from.
        for stage in STAGES:
            given = [] if stage == "joint" else [f"-DSEAM_INCLUDE={headers}"]
            name = f"my_{stage}"
            out = os.path.join(folder, name)
            said = run(seam, "new-effect", name, "--stage", stage, "--out", out)
            if f"effects/catalogue/{stage}/" not in said or not (ROOT / "effects/catalogue" / stage).is_dir():
                sys.exit(f"new-effect does not name the folder of its stage:\n{said}")
            sources = sorted(os.path.join(out, file) for file in os.listdir(out) if file.endswith(".cc"))
            if shutil.which("clang-format"):
                run("clang-format", "--dry-run", "-Werror", f"--style=file:{ROOT}/.clang-format", *sources)
            if quick and stage != "joint":
                # All files of a stage are read as one, which saves their headers.
                first = [word for source in sources[:-1] for word in ("-include", source)]
                run(cxx, "-std=c++20", "-fsyntax-only", "-I", headers, *first, sources[-1])
                continue
            proved(seam, headers, cxx, out, name, given)
        broken = subprocess.run([seam, "effects", "--plugin", __file__], capture_output=True, text=True)
        if broken.returncode != 1 or "plugin_test.py" not in broken.stderr:
            sys.exit(f"a file that is no plugin: exit code {broken.returncode}, {broken.stderr}")
        # A base has no neutral value.
        run(seam, "effects", "pinhole", "--prove")
        nameless = subprocess.run([seam, "effects", "--prove"], capture_output=True, text=True)
        if nameless.returncode != 2 or "expected the NAME" not in nameless.stderr:
            sys.exit(f"effects --prove without a name: exit code {nameless.returncode}, {nameless.stderr}")


main()
