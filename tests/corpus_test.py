#!/usr/bin/env python3
"""Every log of replays/corpus is read as expected.json says: exit code, messages, number of losses; each
within 30 s and 500 MB. Usage: corpus_test.py SEAM"""
import json
import pathlib
import resource
import subprocess
import sys
import tempfile

import by_hand

SEAM = by_hand.arguments("seam")
CORPUS = pathlib.Path(__file__).resolve().parent.parent / "replays" / "corpus"


def limit():
    resource.setrlimit(resource.RLIMIT_DATA, (500 << 20, 500 << 20))


def look(path, folder):
    report = folder / f"{path.stem}.json"
    done = subprocess.run([SEAM, "replay", "recover", path, "--out", folder / path.name, "--json", report],
                          capture_output=True, text=True, timeout=30, preexec_fn=limit)
    found = json.loads(report.read_text()) if report.exists() else {}
    if done.returncode == 1 and not done.stderr.startswith("seam: "):
        raise AssertionError(f"{path.name}: no message: {done.stderr}")
    return {"recover": done.returncode, "messages": found.get("messages", 0), "losses": len(found.get("losses", []))}


def main():
    expected = json.loads((CORPUS / "expected.json").read_text())
    failures = 0
    with tempfile.TemporaryDirectory() as temporary:
        for path in sorted(CORPUS.glob("*.mcap")):
            found = look(path, pathlib.Path(temporary))
            if found != expected.get(path.name):
                print(f"{path.name}: found {found}, expected {expected.get(path.name)}")
                failures += 1
            for command in ("show", "verify"):  # Never a crash, whatever they find.
                done = subprocess.run([SEAM, "replay", command, path], capture_output=True, timeout=60, preexec_fn=limit)
                if done.returncode not in (0, 1):
                    print(f"{path.name}: {command} ended with {done.returncode}")
                    failures += 1
    print(f"{len(expected)} logs, {failures} failures")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
