#!/usr/bin/env python3
"""An effect outside the tree: `seam new-effect` for every stage, built against the headers, tested,
and loaded with --plugin.  plugin_test.py SEAM HEADERS CXX [--quick]

--quick: one stage from end to end; of the others the compiler reads what was written."""
import os
import subprocess
import sys
import tempfile

STAGES = ["timing", "joint", "mount", "geometry", "corner_detector", "radiometry", "light", "sensor", "detector",
          "locomotion", "target"]


def run(*command):
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}: exit code {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout


def main():
    seam, headers, cxx = sys.argv[1:4]
    quick = "--quick" in sys.argv
    with tempfile.TemporaryDirectory() as folder:
        # Where none are given, the headers are those of the tree that the program was built from.
        for stage in STAGES:
            given = [] if stage == "joint" else [f"-DSEAM_INCLUDE={headers}"]
            name = f"my_{stage}"
            out = os.path.join(folder, name)
            run(seam, "new-effect", name, "--stage", stage, "--out", out)
            if quick and stage != "joint":
                # All files of a stage are read as one, which saves their headers.
                sources = sorted(os.path.join(out, file) for file in os.listdir(out) if file.endswith(".cc"))
                first = [word for source in sources[:-1] for word in ("-include", source)]
                run(cxx, "-std=c++20", "-fsyntax-only", "-I", headers, *first, sources[-1])
                continue
            run("cmake", "-S", out, "-B", f"{out}/build", *given, f"-DCMAKE_CXX_COMPILER={cxx}")
            run("cmake", "--build", f"{out}/build")
            run("ctest", "--test-dir", f"{out}/build", "--output-on-failure")
            text = run(seam, "--plugin", f"{out}/build/{name}.so", "effects", name)
            if f"{name} (stage {stage})" not in text:
                sys.exit(f"seam effects {name} says:\n{text}")
        broken = subprocess.run([seam, "effects", "--plugin", __file__], capture_output=True, text=True)
        if broken.returncode != 1 or "plugin_test.py" not in broken.stderr:
            sys.exit(f"a file that is no plugin: exit code {broken.returncode}, {broken.stderr}")


main()
