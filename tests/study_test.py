#!/usr/bin/env python3
"""`seam study`: Ctrl-C keeps the sets that are finished, and leaves no folder behind. Usage: study_test.py SEAM"""
import json
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time

seam = pathlib.Path(sys.argv[1]).resolve()
with tempfile.TemporaryDirectory() as folder:
    scratch = pathlib.Path(folder)
    result = scratch / "study.json"
    study = subprocess.Popen([seam, "study", "odometry", "--seeds", "5000", "--json", result], stdout=subprocess.PIPE,
                             stderr=subprocess.PIPE, text=True, env={**os.environ, "TMPDIR": str(scratch)})
    # A set is there as soon as its folder is: the study is well under way after some more.
    deadline = time.monotonic() + 60
    while not list(scratch.glob("seam-study-*/set")) and time.monotonic() < deadline:
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

    unknown = subprocess.run([seam, "study", "points", "--effect", "frame_latancy"], capture_output=True, text=True)
    assert unknown.returncode == 1 and "frame_latency" in unknown.stderr, unknown
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
