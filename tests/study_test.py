#!/usr/bin/env python3
"""`seam study`: Ctrl-C keeps the sets that are finished and leaves no folder behind; kept results go on after kill -9. Usage: study_test.py SEAM"""
import json
import os
import pathlib
import re
import signal
import sqlite3
import subprocess
import tempfile
import time

import by_hand

seam = by_hand.arguments("seam")
with tempfile.TemporaryDirectory() as folder:
    scratch = pathlib.Path(folder)
    result = scratch / "study.json"
    study = subprocess.Popen([seam, "study", "odometry", "--seeds", "5000", "--json", result], stdout=subprocess.PIPE,
                             stderr=subprocess.PIPE, text=True, env={**os.environ, "TMPDIR": str(scratch)})
    # A set is there as soon as its folder is: the study is well under way after some more.
    deadline = time.monotonic() + 60
    while not list(scratch.glob("seam-study-*/set-*")) and time.monotonic() < deadline:
        time.sleep(0.1)
    time.sleep(5)
    study.send_signal(signal.SIGINT)
    out, err = study.communicate(timeout=120)
    assert study.returncode == 0, (study.returncode, err)
    assert "stopped" in out, out
    finished = int(re.search(r"false alarms \d+/(\d+)", out).group(1))
    assert 0 < finished < 5000, out
    written = json.loads(result.read_text())
    assert written["stopped"] is True and written["rows"][0]["sets"] == finished, written
    assert not list(scratch.glob("seam-study-*")), "the study left its folder behind"

    # What kept its results goes on after a death at any moment, and ends as a study that nothing stopped.
    few = [seam, "study", "odometry", "--groups", "3", "--effect", "walk_lag", "--size", "4"]
    kept = scratch / "kept.sqlite"

    def finished():
        try:
            with sqlite3.connect(f"file:{kept}?mode=ro", uri=True) as database:
                return database.execute("SELECT count(*) FROM jobs").fetchone()[0]
        except sqlite3.OperationalError:
            return 0

    whole = subprocess.run([*few, "--seeds", "7", "--jobs", "1", "--json", scratch / "whole.json"], capture_output=True, text=True)
    assert whole.returncode == 0, whole
    dies = subprocess.Popen([*few, "--seeds", "5", "--jobs", "2", "--results", kept], stdout=subprocess.DEVNULL,
                            env={**os.environ, "TMPDIR": str(scratch)})
    deadline = time.monotonic() + 60
    while finished() < 3 and time.monotonic() < deadline:
        time.sleep(0.02)
    dies.kill()
    dies.wait()
    assert 3 <= finished() < 6, finished()  # The standard error and two sets or more of the five.
    on = subprocess.run([*few, "--seeds", "7", "--results", kept, "--json", scratch / "on.json"], capture_output=True, text=True)
    assert on.returncode == 0 and on.stdout == whole.stdout, (on, whole)
    assert (scratch / "on.json").read_text() == (scratch / "whole.json").read_text()
    assert finished() == 8
    # Another study's results are refused, and left as they are; so is what is none.
    other = subprocess.run([*few, "--seeds", "2", "--material", "0.1", "--results", kept], capture_output=True, text=True)
    assert other.returncode == 1 and "other settings" in other.stderr and finished() == 8, other
    (scratch / "text.sqlite").write_text("no results at all, but long enough to be taken for some " * 9)
    none = subprocess.run([*few, "--results", scratch / "text.sqlite"], capture_output=True, text=True)
    assert none.returncode == 1 and "text.sqlite" in none.stderr, none
    with sqlite3.connect(kept) as database:
        database.execute("UPDATE jobs SET result = '{}' WHERE job = 2")
    forged = subprocess.run([*few, "--results", kept], capture_output=True, text=True)
    assert forged.returncode == 1 and "kept result" in forged.stderr, forged

    unknown = subprocess.run([seam, "study", "points", "--effect", "frame_latancy"], capture_output=True, text=True)
    assert unknown.returncode == 1 and "frame_latency" in unknown.stderr, unknown
    word = subprocess.run([seam, "study", "points", "--effect", "frame_latency", "--size", "nan"], capture_output=True, text=True)
    assert word.returncode == 2 and "--size nan: expected a number" in word.stderr, word
    # Sets like recordings, and what they cannot be.
    like = scratch / "like.json"
    done = subprocess.run([seam, "study", "odometry", "--groups", "2", "--uneven", "--misfit", "0.05", "--material", "0.1",
                           "--hide", "{odometry_scale: {vx_scale: 0.1}, walk_lag: {tau_s: 0.3}}", "--seeds", "1",
                           "--json", like], capture_output=True, text=True)
    assert done.returncode == 0, done
    told = json.loads(like.read_text())
    assert told["conditions"] == "2 groups, uneven time steps, a smooth misfit of 0.05", told
    assert told["material"] == 0.1 and told["rows"][0]["alarms"]["hits"] == 1, told
    images = subprocess.run([seam, "study", "photometry", "--wander", "1"], capture_output=True, text=True)
    assert images.returncode == 1 and "only --groups" in images.stderr, images
    both = subprocess.run([seam, "study", "odometry", "--effect", "walk_lag", "--hide", "{walk_lag: {tau_s: 1}}"],
                          capture_output=True, text=True)
    assert both.returncode == 2, both
print("ok")
