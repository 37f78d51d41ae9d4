#!/usr/bin/env python3
"""What docs/reference/compatibility.md says of newer and older files is what the program says: compatibility_test.py SEAM"""
import pathlib
import subprocess
import sys
import tempfile

import by_hand

by_hand.arguments("seam")

ROOT = pathlib.Path(__file__).resolve().parent.parent
SEAM = pathlib.Path(sys.argv[1]).resolve()
PAGE = " ".join((ROOT / "docs/reference/compatibility.md").read_text(encoding="utf-8").split())
MODEL = "format: seam-model/1\nname: x\neffects: {}\n"
# A file of tomorrow, and what today's program says of it; the words before "..." are quoted on the page.
NEWER = [
    (MODEL.replace("/1", "/2"), "m.yaml:1: format: found 'seam-model/2', did you mean 'seam-model/1'?"),
    (MODEL.replace("{}", "{warp_drive: {k: 1}}"), "effects: unknown effect 'warp_drive', did you mean "),
    (MODEL + "new_key: 3\n", "unknown key 'new_key', known: effects, format, history, name"),
]


def run(*arguments, cwd):
    done = subprocess.run([SEAM, *arguments], cwd=cwd, capture_output=True, text=True, timeout=60)
    return done.returncode, done.stdout + done.stderr


def main():
    with tempfile.TemporaryDirectory() as folder:
        for text, expected in NEWER:
            (pathlib.Path(folder) / "m.yaml").write_text(text, encoding="utf-8")
            code, said = run("check", "m.yaml", cwd=folder)
            assert code == 1 and expected in said, (text, code, said)
        for _, expected in NEWER[:2]:
            assert expected in PAGE, expected
        code, said = run("replay", "verify", ROOT / "replays/corpus/older.mcap", cwd=folder)
        assert code == 0 and "the same" in said and said.count("not compared: ") >= 4, (code, said)
    code, said = run("--version", cwd=ROOT)
    version = next(line.split()[2] for line in (ROOT / "CMakeLists.txt").read_text().splitlines() if line.startswith("project(seam VERSION"))
    assert code == 0 and said.split()[:2] == ["seam", version], said
    return 0


if __name__ == "__main__":
    sys.exit(main())
