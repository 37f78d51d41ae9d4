#!/usr/bin/env python3
"""An effect answers for itself: nobody else knows it by name.

Looks for names of the catalogue's effects as string literals outside their own files, the registry and the tests.
Records may name other effects where they say how they are distinguished (`.advice`) and with which they come
(`.companions`). `--self-test` checks that a
name in the wrong place is noticed.
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
FOLDERS = ["sim_core", "effects", "mcap", "render", "scheduler", "measurement", "app", "tools"]
# Labels of random streams are part of every recorded run. The stage that draws from a stream names it, once.
STREAM = re.compile(r'\.child\(\s*"[a-z_]+"\s*\)')
STREAM_FOLDER = "effects/stages/"
# Words that are more than an effect's name.
MEANT_OTHERWISE = {
    ("render/renderer.cc", "vignetting"): "the picture of the gain field, in `seam frame --stages`",
    ("app/import/kinds/flats.cc", "exposure"): "a column's name in other people's tables",
    ("app/import/table.cc", "exposure"): "the same",
    ("app/import/cameras/foreign_cameras.cc", "pinhole"): "basalt's own word for a camera model",
    ("app/import/kinds/kalibr.cc", "pinhole"): "Kalibr's own word for a camera model",
    ("app/import/kinds/opencv.cc", "fisheye"): "OpenCV's and ROS's own word for a lens",
    ("app/exchange/lens.cc", "fisheye"): "a form of lens, in the words of other programs",
    ("app/import/pictures/camera_info.cc", "fisheye"): "ROS's own word for a lens",
}


def names():
    return {f.stem for f in (ROOT / "effects" / "catalogue").glob("*/*.cc")}


def is_test(path):
    return path.name.endswith((".test.cc", ".perf.cc", ".fuzz.cc"))


def findings(path, text, known):
    """(line number, name) of each name that stands where it should not."""
    relative = path.relative_to(ROOT).as_posix()
    text = re.sub(r"//[^\n]*", "", text)
    if relative.startswith(STREAM_FOLDER):
        text = STREAM.sub(lambda match: " " * len(match.group()), text)
    own = None
    if relative.startswith("effects/catalogue/"):
        own = path.stem
        # The list of those from which an advice tells: up to the next field of the record.
        text = re.sub(r"\.companions = \{[^}]*\}", "", text)
        text = re.sub(r"\.advice =.*?(?=\n      \.)", lambda match: re.sub(r"[^\n]", " ", match.group()), text,
                      flags=re.S)
    for match in re.finditer(r'"([a-z_]+)"', text):
        name = match.group(1)
        if name in known and name != own and (relative, name) not in MEANT_OTHERWISE:
            yield text.count("\n", 0, match.start()) + 1, name


def main():
    known = names()
    if "--self-test" in sys.argv:
        path = ROOT / "measurement" / "x.cc"
        assert list(findings(path, 'int a;\nbool b = name == "fisheye";\n', known)) == [(2, "fisheye")]
        assert not list(findings(path, '// Like "fisheye".\nbool b = name == "fish";\n', known))
        assert list(findings(path, 'stream.child("read_noise")', known)) == [(1, "read_noise")]
        assert not list(findings(ROOT / "effects" / "stages" / "x.h", 'stream.child("read_noise")', known))
        return 0
    wrong = 0
    for folder in FOLDERS:
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix not in (".cc", ".h", ".inc") or is_test(path):
                continue
            for line, name in findings(path, path.read_text(), known):
                print(f"{path.relative_to(ROOT)}:{line}: knows the effect '{name}' by name; ask its record "
                      f"(effects/answers.h, effects/questions.h)")
                wrong += 1
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
