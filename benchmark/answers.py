"""Answers of a program to sets: the format `seam-answer/1`, and the adapter by which SEAM gives them."""
import json
import math
import pathlib
import re
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
# What a program says of a cause that it has no name for, where it does.
OF_UNNAMED = {"depends_on", "formula_error"}


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
        if set(given) - OF_UNNAMED != FIELDS:
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

# Variables of formulas by the names of the quantities that they are.
VARIABLES = {"t": "time", "q": "command_rad", "x": "column", "y": "row", "u": "column", "v": "row", "r2": "radius",
             "vx": "vx_cmd_mps", "vy": "vy_cmd_mps", "omega": "omega_cmd_radps", "theta": "heading",
             "rate": "joint_rate"}


def variables_of(formula):
    """Of the terms behind each output's name and its colon; a target's coordinates are its own."""
    parts = [part.partition(":") for part in re.split(r"[,;]\s*(?=\w+:)", formula)]
    words = {word for _, _, terms in parts for word in re.findall(r"[A-Za-z_]\w*", terms)}
    names = VARIABLES | ({axis: f"target {axis}" for axis in "xyz"} if {name for name, _, _ in parts} & set("xyz") else {})
    return sorted(names.get(word, word) for word in words - {"sin", "cos", "pi", "sign", "abs", "exp", "max", "sqrt"})


def of_discover(found):
    """The answer that a result of `seam discover --json` is."""
    names = []
    said = re.search(r"((?:[\w@.-]+, )*[\w@.-]+) (?:is|are) missing", found["headline"])
    stated = said.group(1).split(", ") if said else []
    for step in found["steps"]:
        values = {name: [v["value"], v["sigma"]] for name, v in step["parameters"].items()
                  if v["value"] is not None and v["sigma"] is not None}
        names.append({"effect": step["effect"], "or": step.get("indistinguishable_from", [])[:MOST_ALTERNATIVES],
                      "values": values} | ({} if step["effect"] in stated else {"hint": True}))
    unexplained = found["verdict"] == "unexplained_structure"
    given = answer(names, unexplained, found["error"])
    if unexplained:
        depends_on = [name for names in found.get("unnamed_cause", {}).get("depends_on", []) for name in names]
        if not depends_on and found["structure"]:
            depends_on = re.split(r"[*]", found["structure"][0]["covariate"])
        given["depends_on"] = depends_on + variables_of(found.get("suggestion", {}).get("formula", ""))
        if "suggestion" in found:
            given["formula_error"] = found["suggestion"]["error"]
    return given


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
