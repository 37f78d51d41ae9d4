#!/usr/bin/env python3
"""clangd knows each file: editors_test.py

The folder that .clangd names is that of a preset, whose compile commands name each source of the tree, one command a
file: sources that are compiled together have none of their own.
"""
import json
import pathlib
import re
import subprocess
import sys
import tempfile

# Sources of builds without OpenGL or with a sanitizer, what a test or `seam open-r build` compiles, and what needs OpenCV where it is missing.
NO_PART = ("render/gl/absent/", "cmake/", "open_r/examples/", "tests/camera_info_reader.cc", "detector/")
ROOT = pathlib.Path(__file__).resolve().parent.parent


def main():
    folder = re.search(r"^  CompilationDatabase: (\S+)$", (ROOT / ".clangd").read_text(), re.M).group(1)
    presets = json.loads((ROOT / "CMakePresets.json").read_text())["configurePresets"]
    preset = next(p for p in presets if p.get("binaryDir") == f"${{sourceDir}}/{folder}")
    with tempfile.TemporaryDirectory() as build:
        done = subprocess.run(["cmake", "--preset", preset["name"], "-B", build], cwd=ROOT, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        known = {str(pathlib.Path(entry["file"])) for entry in json.loads((pathlib.Path(build) / "compile_commands.json").read_text())}
    names = subprocess.run(["git", "-C", ROOT, "ls-files", "*.cc"], capture_output=True, text=True, check=True).stdout.split()
    missing = [name for name in names if (ROOT / name).exists() and str(ROOT / name) not in known and not name.startswith(NO_PART)]
    for name in missing:
        print(f"{name}: no compile command of its own in the preset {preset['name']}")
    return 1 if missing else 0


if __name__ == "__main__":
    sys.exit(main())
