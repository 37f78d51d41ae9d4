#!/usr/bin/env python3
"""All files of ours in the tree agree with the schemas in docs/: schemas_test.py SOURCE_DIR

Looks at YAML files by their `format:` line and at the yaml blocks of the pages; a few spoilt ones must not pass.
"""
import copy
import json
import pathlib
import re
import subprocess
import sys

import by_hand

by_hand.arguments("source")

try:
    import jsonschema
    import yaml
except ImportError as missing:
    print(f"skipped: {missing} (scripts/dependencies.sh)")
    sys.exit(77)

SOURCE = pathlib.Path(sys.argv[1]).resolve()
SCHEMAS = {f"seam-{name}/1": json.loads((SOURCE / f"docs/reference/schemas/{name}.schema.json").read_text(encoding="utf-8"))
           for name in ("scenario", "model", "measurement", "scene", "sweep")}


class Reader(yaml.SafeLoader):
    """Numbers as YAML 1.2 has them: 1e-5 is one."""


Reader.add_implicit_resolver("tag:yaml.org,2002:float",
                             re.compile(r"^[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)[eE][-+]?[0-9]+$"), list("-+0123456789."))


def errors(document):
    validator = jsonschema.Draft202012Validator(SCHEMAS[document["format"]])
    return [f"{'/'.join(map(str, error.absolute_path))}: {error.message[:200]}"
            for error in validator.iter_errors(document)]


def documents():
    names = subprocess.run(["git", "-C", str(SOURCE), "ls-files", "*.yaml", "docs/*.md"], capture_output=True,
                           text=True, check=True).stdout.split()
    for name in names:
        text = (SOURCE / name).read_text(encoding="utf-8")
        parts = re.findall(r"^```yaml\n(.*?)^```", text, re.M | re.S) if name.endswith(".md") else [text]
        for part in parts:
            if part.startswith("%YAML:1.0"):
                continue  # OpenCV's storage, which is no YAML of ours.
            document = yaml.load(part, Loader=Reader)
            if isinstance(document, dict) and document.get("format") in SCHEMAS:
                yield name, document


def main():
    wrong, seen = [], {}
    for name, document in documents():
        seen.setdefault(document["format"], document)
        wrong += [f"{name}: {error}" for error in errors(document)]
    wrong += [f"no file of {form}" for form in SCHEMAS if form not in seen]
    for form, key, value in (("seam-model/1", "effects", {"pinhole": {"fx_px": "wide"}}),
                             ("seam-measurement/1", "kind", "guesses"),
                             ("seam-measurement/1", "camera", {"width_px": 0, "height_px": 100}),
                             ("seam-scene/1", "objects", [{"shape": "cone", "rgb": [0, 0, 0]}]),
                             ("seam-sweep/1", "vary", [{"path": "seed", "range": [1, 2], "values": [3]}]),
                             ("seam-scenario/1", "duration_s", -1)):
        spoilt = copy.deepcopy(seen[form])
        spoilt[key] = value
        if not errors(spoilt):
            wrong.append(f"{form} with {key}: {value} passes")
    print("\n".join(wrong) or f"all agree: {', '.join(sorted(seen))}")
    return bool(wrong)


if __name__ == "__main__":
    sys.exit(main())
