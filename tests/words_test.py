#!/usr/bin/env python3
"""The tree is written in plain words: words_test.py [--list]

A short list of turns that strangers do not understand, each with its plain word. Pages, scripts, tests' texts and the help
of commands must be free of all of them, code of those that stand in CODE. Left out: measurement/, files that are made, and
the terms of the program's own output (`stands_in_for`). --self-test shows that the alarm works.
"""
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
# Of code alone: any form of the word, but the name of a C function and of a header.
IN_CODE = r"\btold\b(?!\.h)|\btells\b|\btelling\b|\btell\b(?! ?[(,])"
# What is looked for, and the plain word.
TURNS = [
    (r"\bin the place of\b", "instead of; replaces"),
    (r"\btold apart\b|\btells? (?:\w+ ){0,5}apart\b", "separated; separates, distinguishes"),
    (r"\b(?:held|holds?|holding) (?:[\w`]+ ){0,4}against\b", "compared with; compares with"),
    (r"\b(?:is|are|was|were|be|been) told\b", "is reported, is estimated, gets"),
    (r"\b(?:data|views|frames|residuals) (?:do not |cannot |can )?tell\b", "constrain; estimate; show"),
    (r"\btells? (?:nothing|little|most|more|less) of\b", "does not constrain; constrains"),
    (r"\bsays? nothing of\b", "does not constrain; does not mention"),
    (r"\bstands? where what\b|\bwhere what \w+ stood\b", "takes the position of"),
    (r"\bwhat (?:came|goes|went|stood) (?:last|first|before)\b", "name it"),
    (r"\bused to be\b|\bwas mended\b|\bsince then\b", "say what is true now; git has the history"),
    (r"\bby the program (?:before|of today)\b|\bthe program before\b", "state the commit or the date"),
    (r"\blucks?\b(?! explains)", "chance"),
    (r"\b\w*tangled\b|\bforetaste\b", "correlated; preview"),
    (r"\bways? of (?:its|their|our) own\b", "name it"),
    (r"\bwho wants to\b", "if you want to"),
    (r"\b(?:were|was) asked(?: for)?\)", "target"),
    (IN_CODE, "reports, gets, shows, separates, estimates, is constrained"),
]
# In code: words that mislead readers; more of the list follows as rooms are rewritten.
CODE = {IN_CODE, r"\b\w*tangled\b|\bforetaste\b", r"\bwhat (?:came|goes|went|stood) (?:last|first|before)\b",
        r"\btold apart\b|\btells? (?:\w+ ){0,5}apart\b", r"\bin the place of\b", r"\blucks?\b(?! explains)",
        r"\bstands? where what\b|\bwhere what \w+ stood\b"}
PAGES = (".md", ".sh", ".py", ".yaml", ".yml", ".cff")
SOURCES = (".cc", ".h", ".inc", ".proto", ".ts", ".tsx", ".mjs", ".cmake", "CMakeLists.txt")
LEFT_OUT = re.compile(r"^(?:measurement/|web/package-lock|fuzz/corpus/|replays/corpus/|tests/golden/|tests/words_test\.py$|"
                      r"scenarios/outcomes/|docs/evidence/experiments\.md$)")


def findings(name, text):
    """(line, what was found, the plain word)"""
    turns = [turn for turn in TURNS if (turn[0] != IN_CODE if name.endswith(PAGES) else turn[0] in CODE)]
    if name.endswith(".md") and name != "docs/reference/commands.md":
        # What programs print is quoted as it is.
        text = re.sub(r"^```.*?^```$", lambda block: "\n" * block.group().count("\n"), text, flags=re.M | re.S)
    for number, line in enumerate(text.splitlines(), 1):
        for turn, plain in turns:
            for match in re.finditer(turn, line, flags=re.I):
                yield number, match.group(), plain


def main():
    if "--self-test" in sys.argv:
        assert [found for found in findings("docs/x.md", "Hold it against the log.\nEffects told apart.\n")] == [
            (1, "Hold it against", "compared with; compares with"), (2, "told apart", "separated; separates, distinguishes")]
        assert not list(findings("docs/x.md", "The data do not constrain it. Compare the two.\n"))
        assert list(findings("tools/x.cc", "// What came last stands where what went stood.\n"))
        assert [found for _, found, _ in findings("app/x.cc", "// An error is told at once.\n  const bool told = tell(x);\n")] == ["told"] * 2
        assert not list(findings("tests/x_test.py", "told = 1\n"))
        return 0
    names = subprocess.run(["git", "-C", str(ROOT), "ls-files"], capture_output=True, text=True, check=True).stdout.splitlines()
    wrong = 0
    for name in names:
        if LEFT_OUT.match(name) or not name.endswith(PAGES + SOURCES) or not (ROOT / name).exists():
            continue
        for line, found, plain in findings(name, (ROOT / name).read_text(encoding="utf-8")):
            print(f"{name}:{line}: '{found}': write: {plain}")
            wrong += 1
    print(f"{wrong} findings")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
