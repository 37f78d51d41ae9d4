"""What the tests of real recordings share: where these lie, a search among effects, and its answer by names.

The recordings are no part of the source; where they are missing a test is skipped and says so.
"""
import json
import pathlib
import subprocess
import sys
import tempfile
import time

import by_hand

SEAM = by_hand.arguments("seam")
HERE = pathlib.Path(__file__).resolve().parent.parent
SETS = pathlib.Path(sys.argv[2]) if len(sys.argv) > 2 else HERE.parent / "shared" / "measurements"
SKIP = 77


def has(name):
    if (SETS / name).is_dir():
        return True
    print(f"skipped: {SETS / name} is not there (a real recording that is not part of the source)")
    return False


def discover(folder, model):
    """The answer as JSON, the text beside it, and the model found."""
    begin = time.time()
    with tempfile.TemporaryDirectory() as out:
        out = pathlib.Path(out)
        done = subprocess.run([SEAM, "discover", "--model", model, "--data", folder, "--out", out / "m.yaml", "--json",
                               out / "d.json"], capture_output=True, text=True, timeout=900)
        assert done.returncode == 0, done.stderr
        print(done.stdout)
        print(f"{time.time() - begin:.0f} s")
        return json.loads((out / "d.json").read_text()), done.stdout, (out / "m.yaml").read_text()


def parameters(found):
    """Values and errors by "effect.parameter"; those of the last step that has them."""
    values = {}
    for step in found["steps"]:
        for name, value in step["parameters"].items():
            values[f"{step['effect']}.{name}"] = (value["value"], value["sigma"])
    return values
