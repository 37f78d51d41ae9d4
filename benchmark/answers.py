"""Answers of a program to sets: the format `seam-answer/1`, and the adapter by which SEAM gives them."""
import json
import math
import pathlib
import resource
import signal
import subprocess
import tempfile

FORMAT = "seam-answer/1"
# Names that a program may give as alternatives of one name: more would be no answer.
MOST_ALTERNATIVES = 4
# Signals of the limit on processor time.
ENDS = {signal.SIGXCPU: "timeout", signal.SIGKILL: "timeout"}
FIELDS = {"names", "unexplained", "error", "cpu_s", "failed"}


class BadAnswer(Exception):
    pass


def answer(names=(), unexplained=False, error=None, cpu_s=None, failed=None):
    """One set's answer. A name: {"effect": NAME, "or": [NAME ...], "values": {parameter: [value, sigma]}}."""
    return {"names": list(names), "unexplained": unexplained, "error": error, "cpu_s": cpu_s, "failed": failed}


def checked_name(where, name):
    if not isinstance(name, dict) or not isinstance(name.get("effect"), str):
        raise BadAnswer(f"{where}: {name!r} is no name, expected {{\"effect\": NAME, \"or\": [], \"values\": {{}}}}")
    if len(name.get("or", [])) > MOST_ALTERNATIVES:
        raise BadAnswer(f"{where}: {name['effect']} has {len(name['or'])} alternatives, expected at most "
                        f"{MOST_ALTERNATIVES}")
    for parameter, value in name.get("values", {}).items():
        two = isinstance(value, list) and len(value) == 2
        if not two or not all(v is None or isinstance(v, (int, float)) for v in value):
            raise BadAnswer(f"{where}: {name['effect']}.{parameter} is {value!r}, expected [value, sigma]")


def read(path):
    """The file's head and its answers by set."""
    text = json.loads(pathlib.Path(path).read_text())
    if text.get("format") != FORMAT:
        raise BadAnswer(f"{path}: format is {text.get('format')!r}, expected {FORMAT}")
    if not isinstance(text.get("program"), str) or not isinstance(text.get("answers"), dict):
        raise BadAnswer(f"{path}: expected 'program', a text, and 'answers', by the names of sets")
    for name, given in text["answers"].items():
        if set(given) != FIELDS:
            raise BadAnswer(f"{path}: {name} has the fields {sorted(given)}, expected {sorted(FIELDS)}")
        if not isinstance(given["unexplained"], bool):
            raise BadAnswer(f"{path}: {name}: unexplained is {given['unexplained']!r}, expected true or false")
        for effect in given["names"]:
            checked_name(f"{path}: {name}", effect)
    return text


def rounded(value):
    if isinstance(value, float):
        return float(f"{value:.8g}") if math.isfinite(value) else None
    if isinstance(value, dict):
        return {key: rounded(v) for key, v in value.items()}
    return [rounded(v) for v in value] if isinstance(value, list) else value


def write(path, program, answers, **more):
    """One set a line, so that two files are compared by eye."""
    head = json.dumps({"format": FORMAT, "program": program, **more})[:-1]
    lines = ",\n".join(f"  {json.dumps(name)}: {json.dumps(rounded(given))}" for name, given in sorted(answers.items()))
    pathlib.Path(path).write_text(f"{head}, \"answers\": {{\n{lines}\n}}}}\n")


# -- SEAM -------------------------------------------------------------------------------------------------------------

def of_discover(found):
    """The answer that a result of `seam discover --json` is."""
    names = []
    for step in found["steps"]:
        values = {name: [v["value"], v["sigma"]] for name, v in step["parameters"].items()
                  if v["value"] is not None and v["sigma"] is not None}
        names.append({"effect": step["effect"], "or": step.get("indistinguishable_from", [])[:MOST_ALTERNATIVES],
                      "values": values})
    return answer(names, found["verdict"] == "unexplained_structure", found["error"])


def run_seam(binary, folder, timeout_s):
    """Runs the search on a set; the limit is of processor time, so that a busy machine changes no answer."""
    with tempfile.TemporaryDirectory() as scratch:
        out = pathlib.Path(scratch) / "found.json"
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        failed = None
        try:
            done = subprocess.run(
                [binary, "discover", "--model", folder / "nominal.yaml", "--data", folder, "--json", out, "--out",
                 pathlib.Path(scratch) / "found.yaml"], capture_output=True, text=True, timeout=20 * timeout_s,
                check=False, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (timeout_s, timeout_s + 1)))
            if not out.exists():
                failed = ENDS.get(-done.returncode) or (done.stderr.strip() or f"ended with {done.returncode}")[:300]
        except subprocess.TimeoutExpired:
            failed = "timeout"
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        cpu_s = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
        if failed:
            return answer(cpu_s=cpu_s, failed=failed)
        return of_discover(json.loads(out.read_text())) | {"cpu_s": cpu_s}
