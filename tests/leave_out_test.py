#!/usr/bin/env python3
"""Rows that a person leaves out of a set take part in nothing: leave_out_test.py SEAM SOURCE_DIR [unittest arguments]."""
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

import by_hand

SEAM, SOURCE = by_hand.arguments("seam", "source")
TUTORIAL = SOURCE / "docs/tutorial"
SERVO = """format: seam-measurement/1
kind: joints
noise: {measured_rad: 0.001}
group: run
files: {joints: joints.csv}
"""
SERVO_MODEL = """format: seam-model/1
name: servo
effects:
  ideal_servo: {}
"""


def seam(*arguments):
    done = subprocess.run([SEAM, *map(str, arguments)], stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=300)
    return done.returncode, done.stdout + done.stderr


class LeaveOut(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.scratch.name)
        code, text = seam("measure", "--model", TUTORIAL / "robot.yaml", "--protocol", TUTORIAL / "room", "--seed", "3",
                          "--out", cls.folder / "good")
        assert code == 0, text

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    def set_with(self, name, lines, change):
        """A copy of the set, those lines of its points changed: by None a line is blank, so that the others keep their numbers."""
        folder = self.folder / name
        shutil.copytree(self.folder / "good", folder, dirs_exist_ok=True)
        rows = (folder / "points.csv").read_text(encoding="utf-8").split("\n")
        for line in lines:
            rows[line - 1] = change(rows[line - 1]) if change else ""
        (folder / "points.csv").write_text("\n".join(rows), encoding="utf-8")
        return folder

    def left_out(self, text):
        path = self.folder / "left-out.csv"
        path.write_text(text, encoding="utf-8")
        return path

    def result(self, command, data, *more):
        path = self.folder / "result.json"
        out = ["--out", self.folder / "model.yaml"] if command[0] in ("fit", "add", "discover") else []
        code, text = seam(*command, "--model", TUTORIAL / "nominal.yaml", "--data", data, *out, "--json", path, *more)
        self.assertEqual(code, 0, text)
        found = json.loads(path.read_text(encoding="utf-8"))
        model = (self.folder / "model.yaml").read_text(encoding="utf-8") if out else ""
        return found, text, re.sub(r"data(_fingerprint)?: .*", "", model)

    def test_the_answer_is_that_of_the_set_without_these_rows(self):
        lines = [5, 77, 78, 300, 1200]

        def spoil(row):
            cells = row.split(",")
            return ",".join(cells[:-2] + ["1.25e7", cells[-1]])

        spoilt, without = self.set_with("spoilt", lines, spoil), self.set_with("spoilt-not", lines, None)
        code, text = seam("compare", "--model", TUTORIAL / "nominal.yaml", "--data", spoilt)
        self.assertEqual(code, 1, text)  # Values that no image has.
        reasons = ["blurred", "wrong corner", "blurred", "blurred", "wrong corner"]
        file = self.left_out("row,reason\n" + "".join(f"{line},{why}\n" for line, why in zip(lines, reasons)))
        page = self.folder / "page.html"
        for command in (["compare"], ["diagnose"], ["discover"], ["fit"], ["add", "rolling_shutter"]):
            with self.subTest(command):
                page_of = ["--report", page] if command[0] == "compare" else []
                # The title of a set is that of its folder.
                found, text, model = self.result(command, spoilt, "--leave-out", file, *page_of)
                expected, expected_text, expected_model = self.result(command, without)
                self.assertEqual(found.pop("left_out"), {"rows": 5, "reasons": [{"reason": "blurred", "rows": 3},
                                                                                {"reason": "wrong corner", "rows": 2}]})
                sentence = "5 rows left out by choice: 3 blurred, 2 wrong corner"
                self.assertEqual(found["notes"].pop(0), sentence)
                self.assertEqual(found.pop("notes"), expected.pop("notes", []))
                self.assertEqual(found, expected)
                self.assertEqual(model, expected_model)
                if command[0] in ("compare", "diagnose", "discover"):
                    self.assertIn(sentence, text)
                if page_of:
                    self.assertIn(sentence, page.read_text(encoding="utf-8"))
                    self.assertIn(f"--leave-out {file}", page.read_text(encoding="utf-8"))

    def test_other_tables_are_named(self):
        file = self.left_out("file,row,reason\njoints,9,slipped\n,5,blurred\n")
        found, _, _ = self.result(["compare"], self.folder / "good", "--leave-out", file)
        folder = self.set_with("less", [5], None)
        rows = (folder / "joints.csv").read_text(encoding="utf-8").split("\n")
        rows[8] = ""
        (folder / "joints.csv").write_text("\n".join(rows), encoding="utf-8")
        expected, _, _ = self.result(["compare"], folder)
        self.assertEqual(found["left_out"]["rows"], 2)
        self.assertEqual((found["error"], found["structure"], found["n"]), (expected["error"], expected["structure"], expected["n"]))
        self.assertNotEqual(found["error"], self.result(["compare"], self.folder / "good")[0]["error"])

    def test_a_servo_log(self):
        folder = self.folder / "servo"
        folder.mkdir()
        (folder / "measurement.yaml").write_text(SERVO, encoding="utf-8")
        (self.folder / "servo.yaml").write_text(SERVO_MODEL, encoding="utf-8")
        rows = [f"{run},{0.01 * i:.2f},a,{0.1 * ((i * run) % 7):.3f},{0.1 * ((i * run) % 7) + 0.001 * ((i * 37 + run) % 5 - 2):.4f}"
                for run in range(1, 9) for i in range(40)]
        given = ["--model", self.folder / "servo.yaml", "--data", folder]

        def compared(lines, *more):
            (folder / "joints.csv").write_text("run,time_s,joint,command_rad,measured_rad\n" + "\n".join(lines) + "\n", encoding="utf-8")
            code, text = seam("compare", *given, "--json", self.folder / "servo.json", *more)
            self.assertEqual(code, 0, text)
            return json.loads((self.folder / "servo.json").read_text(encoding="utf-8"))

        gross = list(rows)
        gross[10] = rows[10].rsplit(",", 1)[0] + ",3.0"  # Line 12.
        found = compared(gross, "--leave-out", self.left_out("row,reason\n12,slipped\n"))
        expected = compared(rows[:10] + [""] + rows[11:])
        self.assertEqual((found["error"], found["n"], found["outliers"]), (expected["error"], 319, expected["outliers"]))

    def refused(self, text, said, *more):
        file = self.left_out(text)
        given = ["--data", self.folder / "good", "--leave-out", file, *(more or ("--model", TUTORIAL / "nominal.yaml"))]
        code, said_by_seam = seam("compare", *given)
        self.assertEqual(code, 2, said_by_seam)
        self.assertIn(said, said_by_seam)

    def test_what_is_wrong_is_named(self):
        lines = len((self.folder / "good/points.csv").read_text(encoding="utf-8").splitlines())
        self.refused("row,reason\n5,blurred\n9999999,x\n",
                     f"left-out.csv:3: column row: found '9999999', expected a line of {self.folder}/good/points.csv with a row, 2 to {lines}")
        self.refused("row,reason\n1,header\n", "left-out.csv:2: column row: found '1'")
        self.refused("row,reason\n5.5,x\n", "left-out.csv:2: column row: found '5.5'")
        self.refused("row,reason\n5,x\n7,y\n5,z\n", "left-out.csv:4: column row: found '5', expected each row once: line 2 has it already")
        self.refused("row,reason\n5,\n", "left-out.csv:2: column reason: found '', expected why the row is left out")
        self.refused("row,reason\n5,a,b\n", "left-out.csv:2: found 3 cells, expected 2")
        self.refused("row\n5\n", "left-out.csv:1: column 'reason' is missing")
        self.refused("row,reason,who\n5,a,b\n", "left-out.csv:1: found column 'who'")
        self.refused("", "left-out.csv")
        self.refused("file,row,reason\npoint,5,x\n", "left-out.csv:2: column file: found 'point', expected a name under `files:`")
        self.refused("row,reason\n" + "".join(f"{line},x\n" for line in range(2, lines + 1)), "leaves out every row of")
        self.refused("row,reason\n5,x\n", "--leave-out needs --model", "--models", TUTORIAL / "nominal.yaml", TUTORIAL / "robot.yaml")
        code, said_by_seam = seam("fit", "--model", TUTORIAL / "nominal.yaml", "--data", self.folder / "good", "--out", self.folder / "m.yaml",
                          "--leave-out", self.folder / "missing.csv")
        self.assertEqual((code, "missing.csv" in said_by_seam), (2, True), said_by_seam)

    def test_a_header_alone_leaves_nothing_out(self):
        found, _, _ = self.result(["compare"], self.folder / "good", "--leave-out", self.left_out("row,reason\n"))
        self.assertEqual(found, self.result(["compare"], self.folder / "good")[0])


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
