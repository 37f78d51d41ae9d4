#!/usr/bin/env python3
"""The models in docs/models.md are models: models_page_test.py SEAM docs/models.md

`seam check` reads every yaml block; a file of candidates is read as the effects of a model.
"""
import pathlib
import re
import subprocess
import sys
import tempfile


def main():
    seam, page = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2])
    blocks = re.findall(r"^```yaml\n(.*?)^```$", page.read_text(encoding="utf-8"), re.M | re.S)
    if len(blocks) < 5:
        return f"{page}: {len(blocks)} examples, expected more"
    with tempfile.TemporaryDirectory() as folder:
        for number, block in enumerate(blocks, 1):
            model = pathlib.Path(folder) / f"example{number}.yaml"
            model.write_text(block if block.startswith("format:") else "format: seam-model/1\n" + block, encoding="utf-8")
            done = subprocess.run([seam, "check", model], capture_output=True, text=True)
            if done.returncode != 0:
                return f"{page}, example {number}:\n{block}\n{done.stderr}"
    print(f"{len(blocks)} models read")
    return 0


if __name__ == "__main__":
    sys.exit(main())
