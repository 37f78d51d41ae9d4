#!/usr/bin/env python3
"""House rules that a machine can check: the layer table, banned calls, file and line lengths.

Prints one line a finding, with what to do instead; exit code 1 if there is any.
"""
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent

# What a folder may include (docs/architecture.md).
LAYERS = {
    "sim_core": set(),
    "effects": {"sim_core"},
    "mcap": {"sim_core"},
    "render": {"sim_core", "effects"},
    "proto": {"seam"},  # seam/v1: generated
    "scheduler": {"sim_core", "effects", "mcap", "proto", "seam"},
    "measurement": {"sim_core", "effects"},
    "robot_sdk": {"proto", "seam"},
    "tools": {"sim_core", "effects", "mcap", "render", "scheduler", "measurement", "seam"},
}
# What a folder may include of another beyond its layers: the detectors whose measurements are predicted.
PARTS = {"tools": ("robot_sdk/vision/",)}
# Outside their folder these headers do not appear.
PRIVATE_HEADERS = {
    r"grpcpp?/": {"proto", "scheduler", "robot_sdk", "tools", "bench", "tests"},
    r"box2d/": {"sim_core"},
    r"ceres/": {"measurement"},
    r"muParser": {"effects"},
    r"png\.h": {"sim_core"},
}
BANNED = {
    r"\b(?:std::)?(?:rand|srand|drand48)\s*\(": "use sim_core/base/random.h: numbers keyed by (seed, stream, index)",
    r"std::(?:mt19937|default_random_engine|random_device)": "use sim_core/base/random.h",
    r"using namespace std\b": "name what you use",
    r"\bgets\s*\(|\bstrcpy\s*\(|\bsprintf\s*\(": "use fmt or std::string",
}
# State and pixels: transcendental functions come from sim_core/base/maths.h.
EXACT_FOLDERS = {"sim_core", "effects", "render", "scheduler"}
INEXACT = re.compile(r"\bstd::(sin|cos|tan|asin|acos|atan|atan2|exp|expm1|log|log1p|log2|log10|pow|sinh|cosh|tanh)\s*\(")
MAX_LINES = 600
MAX_COLUMNS = 130


def sources():
    names = subprocess.run(["git", "-C", str(ROOT), "ls-files", "--cached", "--others", "--exclude-standard",
                            "*.h", "*.cc"], capture_output=True, text=True, check=True).stdout.split()
    return [ROOT / name for name in names if (ROOT / name).exists()]


def findings_in(path):
    relative = path.relative_to(ROOT)
    folder = relative.parts[0]
    is_test = ".test." in path.name or ".perf." in path.name or ".fuzz." in path.name
    lines = path.read_text(encoding="utf-8").splitlines()
    if len(lines) > MAX_LINES:
        yield f"{relative}: {len(lines)} lines, at most {MAX_LINES}: split it by idea"
    for number, line in enumerate(lines, 1):
        where = f"{relative}:{number}"
        if len(line) > MAX_COLUMNS:
            yield f"{where}: {len(line)} columns, at most {MAX_COLUMNS}"
        include = re.match(r'\s*#include\s+["<]([^">]+)[">]', line)
        if include:
            target = include.group(1).split("/")[0] if "/" in include.group(1) else ""
            quoted = '"' in line
            part = include.group(1).startswith(PARTS.get(folder, ()))
            if quoted and folder in LAYERS and target not in LAYERS[folder] | {folder} and target in LAYERS and not part:
                yield f"{where}: {folder}/ must not include {include.group(1)} (layer table)"
            for pattern, allowed in PRIVATE_HEADERS.items():
                if re.match(pattern, include.group(1)) and folder not in allowed:
                    yield f"{where}: <{include.group(1)}> stays inside {', '.join(sorted(allowed))}"
        code = line.split("//")[0]
        for pattern, instead in BANNED.items():
            if re.search(pattern, code):
                yield f"{where}: banned call: {instead}"
        if folder in EXACT_FOLDERS and not is_test:
            match = INEXACT.search(code)
            if match:
                yield f"{where}: std::{match.group(1)} differs between machines: use maths::{match.group(1)}"


def main():
    found = [finding for path in sources() for finding in findings_in(path)]
    for finding in found:
        print(finding)
    print(f"{len(found)} findings")
    return 1 if found else 0


if __name__ == "__main__":
    if "--self-test" in sys.argv:
        # The alarm itself works: a wrong include is found.
        bad = ROOT / "sim_core" / "zz_layer_alarm.h"
        bad.write_text('#include "render/renderer.h"\n')
        try:
            assert any("layer table" in finding for finding in findings_in(bad)), "the planted include was not found"
        finally:
            bad.unlink()
        print("ok")
    else:
        sys.exit(main())
