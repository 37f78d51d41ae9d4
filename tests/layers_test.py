#!/usr/bin/env python3
"""House rules that a machine can check: rooms and the arrows between them, banned calls, mutable
statics, clocks, lengths of files, functions and lines, files in a room.

Prints one line a finding, with what to do instead; exit code 1 if there is any. `--self-test` shows
that each alarm works.
"""
import collections
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent

# What a folder may include of others (docs/design/architecture.md).
FOLDERS = {
    "sim_core": set(),
    "effects": {"sim_core"},
    "mcap": {"sim_core"},
    "render": {"sim_core", "effects"},
    "proto": {"seam", "foxglove", "dm_env_rpc"},  # seam/v1: generated
    "scheduler": {"sim_core", "effects", "mcap", "proto", "seam", "foxglove"},
    "measurement": {"sim_core", "effects"},
    "robot_sdk": {"proto", "seam"},
    "open_r": {"robot_sdk"},
    "app": {"sim_core", "effects", "mcap", "render", "scheduler", "measurement", "seam"},
    "detector": set(),
    "tools": {"sim_core", "effects", "mcap", "render", "scheduler", "measurement", "app", "proto", "seam", "dm_env_rpc", "open_r"},
}
# What a room may include of its own folder, beside itself. "." is the folder's own files; a name that
# ends in "/*" stands for each room below it, which know nothing of each other.
ROOMS = {
    "sim_core": {
        "signals": [],
        "base": ["signals"],
        "system": ["base"],
        "input": ["base"],
        "scene": ["base", "input"],
        "body": ["base", "input", "scene"],
        "scenario": ["base", "input", "scene", "body"],
        "world": ["base", "input", "scene", "body", "scenario"],
    },
    "effects": {
        ".": [],
        "stages/sensor": ["."],
        "stages/torque": ["."],
        "stages/walk": ["."],
        "stages": [".", "stages/sensor", "stages/torque", "stages/walk"],
        "stages/inertial": [".", "stages"],
        "stages/robots": [".", "stages", "stages/inertial", "stages/walk"],
        "formulas": [".", "stages", "stages/sensor", "stages/walk"],
        "catalogue/*": [".", "stages", "stages/inertial", "stages/sensor", "stages/torque", "stages/walk"],
        "schema": ["."],
        "proof": [".", "stages", "stages/inertial", "stages/sensor", "stages/torque", "stages/walk"],
    },
    "proto": {".": []},
    "mcap": {".": []},
    "render": {
        "base": [],
        "colour": [],
        "cast": ["base"],
        "filter": ["base", "cast"],
        "assets": [],
        "gl/offscreen": [],
        "gl": ["base", "cast", "assets", "gl/offscreen"],
        "gl/absent": ["gl", "assets"],
        ".": ["base", "cast", "filter", "colour", "gl"],
        "pictures": ["base", "."],
        "golden": ["base", ".", "gl"],
    },
    "scheduler": {
        "loop": [],
        "wire": ["loop"],
        "log": ["loop", "wire"],
        "replay": ["loop", "wire", "log"],
        "remote_render": ["loop", "wire"],
        "listen": [],
        "clients": ["loop", "wire", "listen"],
        "server": ["loop", "wire", "remote_render", "listen", "clients"],
    },
    "measurement": {
        "numerics": [],
        "sets": [],
        "imaging": ["numerics"],
        "problem": ["numerics", "sets"],
        "fitting": ["numerics", "problem"],
        "fitting/structure": ["numerics", "problem"],
        "noise": ["numerics", "problem"],
        "kinds": ["sets", "imaging", "problem"],
        "kinds/photometry/stack": ["sets", "imaging", "problem", "numerics"],
        "kinds/photometry/likelihood": ["kinds/photometry/stack", "sets", "imaging", "problem", "numerics"],
        "kinds/photometry/structure": ["kinds/photometry/likelihood", "kinds/photometry/stack", "sets", "problem", "numerics"],
        "kinds/photometry/means": ["kinds/photometry/structure", "kinds/photometry/likelihood", "kinds/photometry/stack", "problem", "numerics"],
        "kinds/photometry": ["kinds", "kinds/photometry/means", "kinds/photometry/structure", "kinds/photometry/likelihood", "kinds/photometry/stack", "sets", "imaging", "problem", "numerics", "fitting"],
        "kinds/points/target": ["numerics"],
        "gyro": ["sets", "numerics"],
        "kinds/points/motion": ["kinds/points/target", "gyro", "numerics"],
        "kinds/points/data": ["kinds/points/target", "gyro", "sets", "problem", "numerics", "noise"],
        "kinds/points": ["kinds", "kinds/points/data", "kinds/points/motion", "kinds/points/target", "gyro", "sets", "imaging", "problem", "numerics", "fitting", "noise"],
        "kinds/joints/torque": ["sets", "problem"],
        "kinds/joints": ["kinds", "kinds/joints/torque", "sets", "imaging", "problem", "numerics", "fitting", "noise"],
        "kinds/imu/spectra": ["problem", "numerics"],
        "kinds/imu": ["kinds", "kinds/imu/spectra", "gyro", "sets", "problem", "numerics", "fitting"],
        "kinds/*": ["kinds", "sets", "imaging", "problem", "numerics", "fitting", "noise"],
        "check": ["numerics", "imaging", "kinds", "sets", "problem", "fitting", "judge", "search", "search/models"],
        "infer": ["numerics", "problem", "fitting"],
        "judge": ["numerics", "problem", "fitting"],
        "suggest": ["numerics", "problem", "fitting", "judge"],
        "search": ["numerics", "problem", "fitting", "infer", "judge", "suggest"],
        "search/models": ["fitting", "judge", "search"],
        "report/columns": ["sets", "problem"],
        "report/curves": ["problem"],
        "report/trust": ["judge", "problem", "search"], "report/unnamed": ["search"],
        "report": ["report/columns", "report/curves", "report/trust", "report/unnamed", "sets", "problem", "fitting", "infer", "judge", "search", "search/models",
                   "suggest", "check"],
        "plan": ["sets", "check", "problem", "kinds", "numerics", "fitting", "judge", "search", "report"],
        "study": ["imaging", "kinds", "judge", "search"],
    },
    "robot_sdk": {
        ".": [],
        "vision": [],
        "localization": ["vision"],
        "team": [".", "vision", "localization"],
        "examples": [".", "vision", "localization", "team"],
    },
    "open_r": {
        "include/system": [], "include/objects/OPENR": [], "include/robot/OPENR": [], "include/network": [],
        "files": [],
        "programs": ["files"],
        "library": ["files"],
        "network": ["library"],
        "robot": ["files", "library"],
        "host": ["files", "library", "network", "robot"],
    },
    "app": {"trust": [], ".": ["trust"], "signals": [], "session": ["trust", ".", "signals"], "logs": ["trust", ".", "signals"], "episodes": ["logs", "bundle"], "predictors": [".", "trust", "sweep", "sweep/plan"], "exchange": [],
            "import/draft": ["exchange"], "import/files": [], "import/bags": ["import/files"],
            "import/pictures": [".", "import/draft", "import/files", "import/bags"],
            "import/servo": ["import/draft", "import/files", "import/bags"],
            "import/cameras": ["import/draft", "import/files", "import/pictures", "exchange", "."],
            "import/kinds": ["import/draft", "import/files", "import/bags", "import/pictures", "import/servo", "import/cameras", "exchange", "logs", "."],
            "import/tracks": ["import/draft", "import/files", "import/kinds", "import/bags"], "import": ["import/draft", "import/files", "import/kinds", "import/servo", "import/tracks"],
            "sweep/plan": [".", "session"], "sweep": [".", "session", "sweep/plan"],
            "bundle": [".", "session", "sweep", "sweep/plan"]},
    "detector": {".": []},
    "tools": {
        ".": [],
        "experiments": ["."],
        "experiments/head_swing": [".", "experiments"],
        "replay": ["."],
        "pages": ["."],
        "viewer": [".", "pages"],
        "workbench/look": [".", "commands"],
        "workbench/see": [],
        "workbench/session": ["pages"],
        "workbench": [".", "commands", "pages", "workbench/look", "workbench/see", "workbench/session"],
        "sweep": [".", "experiments"],
        "commands": [".", "experiments"],
        "network": [".", "dm_env_rpc"],
        "dm_env_rpc": ["."],
        "open_r": ["."],
        "robots": ["."],
    },
}
# What a room may include beyond its folder's layers: the detectors whose measurements are predicted.
PARTS = {"app/predictors": ("robot_sdk/vision/",)}
# Outside their folders these headers do not appear.
PRIVATE_HEADERS = {
    r"grpcpp?/": {"proto", "scheduler/server", "scheduler/remote_render", "robot_sdk", "tools", "bench", "tests"},
    r"box2d/": {"sim_core"},
    r"muParser": {"effects"},
    r"png\.h": {"sim_core"},
    r"jpeglib\.h": {"render/assets"},
    r"assimp/": {"render/assets"},
    r"E?GL/": {"render/gl/offscreen"},
    r"CLI/": {"app"},
    r"httplib": {"tools/pages", "tools/viewer", "tools/workbench"},
    r"sqlite3": {"app/sweep"},
    r"(?:opencv2|libexif)/": {"detector", "bench"},
    r"apriltag/": {"sim_core/scene", "render/golden", "detector", "bench"},
    r"tinyxml2": {"app/import/files", "sim_core/body"},
    r"bzlib": {"app/import/bags"},
    r"lz4frame": {"mcap"},
}
BANNED = {
    r"\b(?:std::)?(?:rand|srand|drand48)\s*\(": "use sim_core/base/random.h: numbers keyed by (seed, stream, index)",
    r"std::(?:mt19937|default_random_engine|random_device)": "use sim_core/base/random.h",
    r"using namespace std\b": "name what you use",
    r"\bgets\s*\(|\bstrcpy\s*\(|\bsprintf\s*\(": "use fmt or std::string",
}
# Clocks of the wall: how long a person or a client has waited, never what is computed.
CLOCK = re.compile(r"\b(?:system_clock|steady_clock|high_resolution_clock|gettimeofday|clock_gettime)\b|\btime\s*\(\s*(?:nullptr|NULL)")
CLOCK_PLACES = {
    "app/session/behaviours.cc", "app/session/progress.cc", "app/session/progress.h", "app/session/run_session.cc", "app/sweep/sweep_progress.h", "app/terminal_progress.cc", "app/terminal_progress.h",
    "app/sweep/sweep_progress.cc", "app/import/bags/reading_progress.cc", "app/import/bags/reading_progress.h", "robot_sdk/robot.cc",
    "scheduler/listen/accept_loop.cc", "scheduler/listen/connection_count.h", "scheduler/remote_render/remote_renderer.cc", "scheduler/remote_render/render_client.cc",
    "scheduler/clients/client_hub.h", "scheduler/server/grpc_listener.cc", "scheduler/server/stream.h",
    "scheduler/server/direct_lines.h", "scheduler/clients/token_tries.h", "tools/dm_env_rpc/world.cc",
}
# Statics that change: what plugins register, a library's own switch, formulas compiled for each thread.
STATIC = re.compile(r"^\s*(?:static|thread_local)\s+(?!const\b|constexpr\b|inline const)[^()]*(?:=|;|\{)")
STATIC_PLACES = {"effects/registry.cc", "effects/formulas/formula.cc", "scheduler/server/grpc_listener.cc"}
# State and pixels: transcendental functions come from sim_core/base/maths.h.
EXACT_FOLDERS = {"sim_core", "effects", "render", "scheduler"}
INEXACT = re.compile(r"\bstd::(sin|cos|tan|asin|acos|atan|atan2|exp|expm1|log|log1p|log2|log10|pow|sinh|cosh|tanh)\s*\(")
MAX_LINES = 400
MAX_COLUMNS = 100
MAX_FUNCTION_LINES = 70
MAX_FILES = 26
# What a statement that opens a block begins with where it is no function.
NO_FUNCTION = re.compile(r"\s*(?:namespace|class|struct|union|enum|extern|template\b.*\b(?:class|struct) \w+ |#|//|\}|if|for|while|switch|do|else|case|return|const\w* )")
STATEMENT_ENDS = re.compile(r"[;{}]\s*(?://.*)?$|^\s*$|^\s*(?://|#)|:$")


def tracked(*patterns):
    names = subprocess.run(["git", "-C", str(ROOT), "ls-files", "--cached", "--others", "--exclude-standard",
                            *patterns], capture_output=True, text=True, check=True).stdout.split()
    return [name for name in names if (ROOT / name).exists()]


def is_test(name):
    return any(part in name for part in (".test.", ".perf.", ".fuzz.", "testing.h", "test_scenes.h", "moving_scenes.h", "brute_force.h", "brute_triangles.h"))


def place_of(name):
    """The folder and the room of a file."""
    parts = name.split("/")
    return parts[0], "/".join(parts[1:-1]) or "."


def row_of(folder, room):
    """The row of ROOMS for a room, by its own name or as one of several alike."""
    rows = ROOMS.get(folder, {})
    if room in rows:
        return rows[room]
    return rows.get(room.rsplit("/", 1)[0] + "/*") if "/" in room else None


def arrow_finding(name, included):
    """Why a file must not include another one; None where it may."""
    folder, room = place_of(name)
    if folder not in FOLDERS or "/" not in included:
        return None
    target, target_room = place_of(included)
    if target != folder:
        known = target in FOLDERS or target in {"seam", "foxglove", "dm_env_rpc"}
        part = included.startswith(PARTS.get(f"{folder}/{room}", ()))
        if known and not part and target not in FOLDERS[folder]:
            return f"{folder}/ must not include {included} (layer table)"
        return None
    row = row_of(folder, room)
    if row is None:
        return f"the room {folder}/{room} is not in the table of rooms of tests/layers_test.py"
    if target_room != room and target_room not in row:
        return f"the room {folder}/{room} must not include {included} (table of rooms)"
    return None


def without_macros(lines):
    """The lines, those of macros empty."""
    kept, inside = [], False
    for line in lines:
        inside = inside or line.lstrip().startswith("#")
        kept.append("" if inside else line)
        inside = inside and line.endswith("\\")
    return kept


def function_lengths(lines):
    """(line, length) of each function, as clang-format lays them out."""
    lines = without_macros(lines)
    at = 0
    while at < len(lines):
        if lines[at].endswith("{"):
            start = at
            while start > 0 and not STATEMENT_ENDS.search(lines[start - 1]):
                start -= 1
            head = " ".join(lines[start:at + 1])
            if not NO_FUNCTION.match(head) and "(" in head and "=" not in head.split("(")[0]:
                indent = re.match(" *", lines[start]).group(0)
                end = next((i for i in range(at + 1, len(lines)) if lines[i].startswith(indent + "}")), at)
                yield start + 1, end - start + 1
                at = end
        at += 1


def findings_in(name, lines):
    folder, room = place_of(name)
    test = is_test(name)
    if len(lines) > MAX_LINES:
        yield f"{name}: {len(lines)} lines, at most {MAX_LINES}: split it by idea"
    for start, length in function_lengths(lines):
        if length > MAX_FUNCTION_LINES:
            yield f"{name}:{start}: a function of {length} lines, at most {MAX_FUNCTION_LINES}"
    for number, line in enumerate(lines, 1):
        where = f"{name}:{number}"
        # What clang-format cannot break: raw strings.
        if len(line) > MAX_COLUMNS and 'R"(' not in line:
            yield f"{where}: {len(line)} columns, at most {MAX_COLUMNS}"
        include = re.match(r'\s*#include\s+["<]([^">]+)[">]', line)
        if include:
            why = arrow_finding(name, include.group(1)) if '"' in line and not test else None
            if why:
                yield f"{where}: {why}"
            for pattern, allowed in PRIVATE_HEADERS.items():
                if re.match(pattern, include.group(1)) and not {folder, f"{folder}/{room}"} & allowed:
                    yield f"{where}: <{include.group(1)}> stays inside {', '.join(sorted(allowed))}"
        code = line.split("//")[0]
        for pattern, instead in BANNED.items():
            if re.search(pattern, code):
                yield f"{where}: banned call: {instead}"
        if test or folder in {"bench", "fuzz", "tests"}:
            continue
        if CLOCK.search(code) and name not in CLOCK_PLACES:
            yield f"{where}: a wall clock: what is computed follows simulated time"
        if STATIC.match(code) and name not in STATIC_PLACES:
            yield f"{where}: a static that changes: pass it in, or make it const"
        if folder in EXACT_FOLDERS:
            match = INEXACT.search(code)
            if match:
                yield f"{where}: std::{match.group(1)} differs between machines: use maths::{match.group(1)}"


def crowded_rooms(names):
    counts = collections.Counter(str(pathlib.PurePosixPath(name).parent) for name in names)
    for room, count in sorted(counts.items()):
        if count > MAX_FILES:
            yield f"{room}/: {count} files, at most {MAX_FILES}: make rooms"


def merge_findings(name, text):
    """What a merge left behind, in any text: only C++ is compiled."""
    for number, line in enumerate(text.splitlines(), 1):
        if re.match(r"(?:<{7}|>{7}) \S", line):
            yield f"{name}:{number}: a merge that was not ended: choose a side"


def project_version():
    return re.search(r"project\(seam VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text()).group(1)


def version_findings(name, text, version):
    """The version stands in CMakeLists.txt; what CMake does not make states the same one."""
    stated = {"CITATION.cff": r"^version: (.*)$", "web/package.json": r'^  "version": "(.*)"'}.get(name)
    if stated and re.findall(stated, text, flags=re.M) != [version]:
        yield f"{name}: not the version {version} of CMakeLists.txt"
    if name.endswith((".cc", ".h")) and not is_test(name) and f'{version}"' in text:
        yield f"{name}: a version in a literal: SEAM_VERSION or seam_built_from.h have that of CMakeLists.txt"


def findings():
    found, version = [], project_version()
    for name in tracked("*.h", "*.cc", "CITATION.cff", "web/package.json"):
        found += version_findings(name, (ROOT / name).read_text(encoding="utf-8"), version)
    for name in tracked("*.sh", "*.py", "*.md", "*.txt", "*.cmake", "*.yaml", "*.ts", "*.tsx", "*.json", "*.proto"):
        found += merge_findings(name, (ROOT / name).read_text(encoding="utf-8"))
    for name in tracked("*.h", "*.cc", "*.inc"):
        found += findings_in(name, (ROOT / name).read_text(encoding="utf-8").splitlines())
    return found + list(crowded_rooms(tracked("*.h", "*.cc", "*.inc")))


def self_test():
    """Each alarm is heard, on text that never touches the tree."""
    alarms = {
        "layer table": ("sim_core/world/x.h", ['#include "render/renderer.h"']),
        "table of rooms": ("measurement/kinds/points/x.cc", ['#include "measurement/kinds/joints/joints.h"']),
        "is not in the table": ("render/cellar/x.cc", ['#include "render/renderer.h"']),
        "stays inside": ("effects/x.cc", ["#include <box2d/box2d.h>"]),
        "banned call": ("app/x.cc", ["  int x = rand();"]),
        "wall clock": ("effects/x.cc", ["auto now = std::chrono::steady_clock::now();"]),
        "static that changes": ("effects/x.cc", ["  static int count = 0;"]),
        "differs between machines": ("render/x.cc", ["x = std::sin(y);"]),
        "columns": ("app/x.cc", ["x" * (MAX_COLUMNS + 1)]),
        "lines, at most": ("app/x.cc", [""] * (MAX_LINES + 1)),
        "a function of": ("app/x.cc", ["int f() {", *["  f();"] * MAX_FUNCTION_LINES, "}"]),
    }
    for alarm, (name, lines) in alarms.items():
        heard = list(findings_in(name, lines))
        assert any(alarm in finding for finding in heard), f"no alarm '{alarm}': {heard}"
    assert not list(findings_in("measurement/kinds/points/x.cc", ['#include "measurement/numerics/maximise.h"']))
    assert list(merge_findings("x.sh", "<" * 7 + " HEAD\n"))
    assert list(version_findings("app/x.cc", 'puts("seam 1.2.3");', "1.2.3"))
    assert list(version_findings("CITATION.cff", "version: 1.2.2\n", "1.2.3"))
    assert list(crowded_rooms([f"app/{i}.cc" for i in range(MAX_FILES + 1)]))
    print("ok")


def main():
    if "--self-test" in sys.argv:
        self_test()
        return 0
    found = findings()
    for finding in found:
        print(finding)
    print(f"{len(found)} findings")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
