#!/usr/bin/env python3
"""The recipes of docs/design/recipes.md work as they stand: recipes_test.py SEAM CXX

In a copy of the tree the blocks of each recipe are run (sh) and written (cpp, behind its path); then every C++ file that
changed is formatted, obeys the house rules, and compiles. Also what a recipe relies on: each row of the table of imports
has its corpus, its line of help and of the page; each Python test that takes arguments starts without them.
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import textwrap

import by_hand

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs/design/recipes.md"
BLOCK = re.compile(r"^ *<!-- recipe: (?P<name>\w+)(?: (?P<path>\S+))? -->\n(?P<indent> *)```(?P<kind>sh|cpp)\n(?P<text>.*?)^ *```$",
                   re.M | re.S)


def git(*arguments, cwd=ROOT):
    return subprocess.run(["git", *arguments], cwd=cwd, capture_output=True, text=True, check=True).stdout


def copy_of_tree(folder):
    for name in git("ls-files", "--cached", "--others", "--exclude-standard").splitlines():
        if not (ROOT / name).is_file():
            continue
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, folder / name)
    git("init", "-q", cwd=folder)
    git("add", "-A", cwd=folder)


def run(*command, cwd, **more):
    done = subprocess.run(command, cwd=cwd, capture_output=True, text=True, **more)
    assert done.returncode == 0, f"{' '.join(map(str, command))}\n{done.stdout}{done.stderr}"
    return done.stdout


def follow(seam, cxx, tree):
    """Follows all recipes; the names of the changed files."""
    environment = dict(os.environ, PATH=f"{seam.parent}:{os.environ['PATH']}", CXX=cxx)
    recipes = set()
    for block in BLOCK.finditer(PAGE.read_text(encoding="utf-8")):
        recipes.add(block["name"])
        text = textwrap.dedent(block["text"])
        if block["kind"] == "cpp":
            (tree / block["path"]).write_text(text)
        else:
            before = git("diff", cwd=tree) + git("status", "--short", cwd=tree)
            for line in text.splitlines():
                run("bash", "-euc", line, cwd=tree, env=environment)
                # A sed that finds nothing changes nothing.
                after = git("diff", cwd=tree) + git("status", "--short", cwd=tree)
                assert not line.startswith(("sed", "mv", "printf")) or after != before, f"changed nothing: {line}"
                before = after
    assert recipes == {"effect", "command", "import"}, recipes
    git("add", "-A", "-N", cwd=tree)
    return git("diff", "--name-only", cwd=tree).splitlines()


def compiles(cxx, tree, names):
    """As one unit each, as the compiler reads them; the program's table of commands, too."""
    for name in [*(name for name in names if name.endswith(".cc")), "tools/program.cc"]:
        run(cxx, "-std=c++20", "-fsyntax-only", "-Wall", "-Wextra", "-Werror", "-Wno-missing-field-initializers", f"-I{tree}", name,
            cwd=tree)


def imports():
    """What is wrong with a row of the table of imports."""
    table = (ROOT / "app/import/table.cc").read_text()
    page = (ROOT / "docs/reference/import.md").read_text()
    corpus = {path.read_bytes().split(b"\n")[0].decode() for path in (ROOT / "fuzz/corpus/import").iterdir()}
    rows = re.split(r'\{\.name = "', table)[1:]
    assert len(rows) > 10, rows
    for row in rows:
        name = row.split('"')[0]
        if ".fuzzed = false" not in row and name not in corpus:
            yield f"import {name}: no input in fuzz/corpus/import/ that begins with a line '{name}'"
        if not re.search(rf"^\|.*`{name}`.*\|", page, re.M):
            yield f"import {name}: no row in the table of docs/reference/import.md"


def tests_by_hand():
    for path in sorted((ROOT / "tests").glob("*.py")):
        text = path.read_text()
        if re.search(r"sys\.argv\[1[\]:]", text) and "by_hand.arguments(" not in text and path.name not in ("by_hand.py", "recipes_test.py"):
            yield f"{path.name}: takes arguments without by_hand.arguments(...)"
    for given, whole in ((["x_test.py"], 3), (["x_test.py", "Kills.test_one"], 4), (["x_test.py", str(PAGE), str(ROOT)], 3)):
        argv, sys.argv = sys.argv, list(given)
        source, node = by_hand.arguments("source", "node")
        found, sys.argv = sys.argv, argv
        if not source.exists() or (given[1:2] == ["Kills.test_one"] and node.name != "mcap_node"):
            yield f"by_hand: {given} gave {source}, {node}"
        if len(found) != whole or "/" not in found[1] or found[3:] != given[1:1 + len(found[3:])]:
            yield f"by_hand: {given} became {found}"


def main():
    seam, cxx = by_hand.arguments("seam", "cxx")
    found = [*imports(), *tests_by_hand()]
    with tempfile.TemporaryDirectory() as name:
        tree = pathlib.Path(name)
        copy_of_tree(tree)
        changed = follow(seam, cxx, tree)
        assert {"effects/registry.cc", "tools/command.h", "app/import/table.cc"} <= set(changed), changed
        if shutil.which("clang-format"):
            run("clang-format", "-i", *(file for file in changed if file.endswith((".cc", ".h"))), cwd=tree)
        compiles(cxx, tree, changed)
        for test in ("layers_test.py", "effect_names_test.py"):
            run("python3", f"tests/{test}", cwd=tree)
    for finding in found:
        print(finding)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
