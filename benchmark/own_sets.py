"""What generators with a question of their own share: their options, and the answers of a program to it."""
import argparse
import json
import subprocess
import sys


def options_of(description):
    options = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("seam")
    options.add_argument("--sets", type=int, default=20)
    options.add_argument("--first", type=int, default=0)
    options.add_argument("--keep")
    return options.parse_args()


def asked(seam, command, data, model, out, *words):
    done = subprocess.run([seam, command, "--data", data, "--model", model, "--json", out, *words], capture_output=True, text=True)
    if done.returncode not in (0, 1):
        sys.exit(f"{command} {data}: {done.stderr}")
    return json.loads(out.read_text())
