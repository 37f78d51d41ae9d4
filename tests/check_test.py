#!/usr/bin/env python3
"""`seam check` says what every file of ours holds, and what is wrong with a set that was spoilt.

Usage: check_test.py SEAM SOURCE_DIR [unittest arguments]
"""
import csv
import json
import os
import pathlib
import shutil
import sqlite3
import subprocess
import sys
import tempfile
import unittest

import by_hand

SEAM, SOURCE = by_hand.arguments("seam", "source")
NOMINAL = SOURCE / "docs/tutorial/nominal.yaml"


def seam(*arguments):
    done = subprocess.run([SEAM, *map(str, arguments)], stdin=subprocess.DEVNULL, capture_output=True, text=True,
                          timeout=120)
    return done.returncode, done.stdout + done.stderr


class FilesOfOurs(unittest.TestCase):
    def holds(self, path, *said):
        code, text = seam("check", SOURCE / path)
        self.assertEqual(code, 0, text)
        for part in said:
            self.assertIn(part, text)

    def test_each_format(self):
        self.holds("scenarios/match.yaml", "seam-scenario/1", "duration", "robot        red1")
        self.holds("models/ers210.yaml", "seam-model/1", "pinhole", "fx_px = ")
        self.holds("models/field_2002.yaml", "field: 4.2 m x 2.7 m")
        self.holds("models/robot_ers210.yaml", "robot: ", "parts")
        self.holds("models/colour_table_2002.yaml", "orange", "of 32 segments")
        self.holds("docs/tutorial/camera_slip.yaml", "effects of your own", "camera_slip")
        self.holds("docs/tutorial/room", "a protocol", "0 errors")
        self.holds("docs/tutorial/room/measurement.yaml", "kind points")
        self.holds("replays/corpus/whole.mcap", "log of scenario corpus", "until")

    def test_all_files_in_the_tree(self):
        for folder in ("models", "scenarios"):
            for path in sorted((SOURCE / folder).glob("*.yaml")):
                self.holds(path, "a valid seam-")

    def test_formulas_are_tried_over_their_ranges(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "mine.yaml"

            def check(text, value):
                path.write_text("format: seam-model/1\nname: mine\neffects:\n  mine: {stage: joint, "
                                f"q: \"{text}\", parameters: {{k: {{value: {value}, neutral: 0, min: 0, max: 1}}}}}}\n")
                return seam("check", path)

            code, text = check("q + k*sqrt(rate)", 1)
            self.assertEqual((code, "effects.mine: the formula gives q = " in text), (1, True), text)
            code, text = check("q + k*sqrt(rate)", 0)
            self.assertEqual((code, "warning: effects.mine" in text), (0, True), text)
            code, text = check("q + k*rate", 0.01)
            self.assertEqual((code, "warning" in text), (0, False), text)

    def test_a_camera_that_no_picture_shows(self):
        """Refused by whatever makes pictures, with the effect's name and what to use instead."""
        with tempfile.TemporaryDirectory() as folder:
            model, scenario = pathlib.Path(folder) / "camera.yaml", pathlib.Path(folder) / "swing.yaml"
            scenario.write_text((SOURCE / "scenarios/head_swing.yaml").read_text().replace("../models/ers210.yaml", str(model))
                                .replace("../models", str(SOURCE / "models")))
            commands = [["check", scenario], ["run", scenario, "--set", "duration_s=0.1"],
                        ["frame", scenario, "--robot", "red1", "--at", "0", "--out", pathlib.Path(folder) / "frame.png"]]
            for name, values, instead in (("flat_port", "{index: 1.333, distance_m: 0.03}", "radial_polynomial"),
                                          ("view_motion", "{turn_sigma_rad: 0.003}", "the robot's own motion"),
                                          ("focus_variation", "{sigma: 0.01}", "focal_drift")):
                model.write_text((SOURCE / "models/ers210.yaml").read_text() + f"  {name}: {values}\n")
                for command in commands:
                    code, text = seam(*command)
                    self.assertEqual((code, f"no picture shows '{name}': " in text, instead in text), (1, True, True), text)
                code, text = seam("check", model)
                self.assertEqual((code, f"warning: as a robot's camera it is refused: no picture shows '{name}'" in text),
                                 (0, True), text)
            model.write_text((SOURCE / "models/ers210.yaml").read_text() + "  flat_port: {}\n")
            for command in commands:
                code, text = seam(*command)
                self.assertEqual((code, "no picture" in text), (0, False), text)

    def test_what_is_wrong_is_told(self):
        for name in ("corrupted", "truncated", "headless", "text", "bomb"):
            code, text = seam("check", SOURCE / f"replays/corpus/{name}.mcap")
            self.assertEqual(code, 1, text)
        damaged = bytearray((SOURCE / "replays/corpus/whole.mcap").read_bytes())
        damaged[-60] ^= 1
        with tempfile.TemporaryDirectory() as folder:
            log, results = pathlib.Path(folder) / "index.mcap", pathlib.Path(folder) / "results.sqlite"
            log.write_bytes(damaged)
            code, text = seam("check", log)
            self.assertEqual((code, "warning" in text and "the index is damaged at offset" in text), (0, True), text)
            sqlite3.connect(results).execute("CREATE TABLE t (a)").connection.commit()
            code, text = seam("check", results)
            self.assertEqual((code, "`seam sweep status`" in text), (1, True), text)
        code, text = seam("check", SOURCE / "docs/tutorial.md")
        self.assertEqual(code, 1, text)
        code, text = seam("check", "/dev/zero")
        self.assertEqual((code, "is a device, expected a file" in text), (1, True), text)


class Sets(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.scratch.name)
        code, text = seam("measure", "--model", SOURCE / "docs/tutorial/robot.yaml", "--protocol",
                          SOURCE / "docs/tutorial/room", "--seed", "1", "--out", cls.folder / "good")
        assert code == 0, text

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    def spoilt(self, change_rows=None, change_yaml=None):
        folder = self.folder / self.id().rsplit(".", 1)[-1]
        shutil.copytree(self.folder / "good", folder)
        if change_rows:
            with open(folder / "points.csv", newline="", encoding="utf-8") as file:
                rows = list(csv.DictReader(file))
            columns = list(rows[0])
            rows = change_rows(rows)
            with open(folder / "points.csv", "w", newline="", encoding="utf-8") as file:
                writer = csv.DictWriter(file, columns, lineterminator="\n")
                writer.writeheader()
                writer.writerows(rows)
        if change_yaml:
            path = folder / "measurement.yaml"
            path.write_text(change_yaml(path.read_text(encoding="utf-8")), encoding="utf-8")
        return folder

    def refused(self, folder, *said):
        """By check and by every analysis command."""
        for command in (["check", folder], ["compare", "--model", NOMINAL, "--data", folder],
                        ["diagnose", "--model", NOMINAL, "--data", folder],
                        ["fit", "--model", NOMINAL, "--data", folder, "--out", folder / "out.yaml"],
                        ["add", "rolling_shutter", "--model", NOMINAL, "--data", folder, "--out", folder / "out.yaml"],
                        ["discover", "--model", NOMINAL, "--data", folder, "--out", folder / "out.yaml"]):
            code, text = seam(*command)
            self.assertEqual(code, 1, text)
            for part in said:
                self.assertIn(part, text, command)

    def test_a_protocol_is_no_set_yet(self):
        room = SOURCE / "docs/tutorial/room"
        for command in ("compare", "diagnose"):
            code, text = seam(command, "--model", NOMINAL, "--data", room)
            self.assertEqual((code, "a protocol, in which nothing is measured yet" in text), (1, True), text)

    def test_values_without_noise_are_warned_of(self):
        def warned(protocol, *arguments):
            code, text = seam("measure", "--model", NOMINAL, "--protocol", protocol, "--out", self.folder / "exact", "--force", *arguments)
            self.assertEqual(code, 0, text)
            return "warning: the values are made without noise" in text

        exact = self.spoilt(change_yaml=lambda text: "".join(line for line in text.splitlines(True) if not line.startswith("noise:")))
        self.assertEqual([warned(exact), warned(exact, "--noise", "off"), warned(self.folder / "good")], [True, False, False])

    def test_an_effect_that_the_model_has_is_refitted(self):
        code, text = seam("add", "rolling_shutter", "--model", SOURCE / "docs/tutorial/robot.yaml", "--data", self.folder / "good",
                          "--out", self.folder / "again.yaml")
        self.assertEqual((code, "refitted rolling_shutter, which the model has already" in text), (0, True), text)

    def test_a_good_set(self):
        code, text = seam("check", self.folder / "good", "--model", NOMINAL)
        self.assertEqual(code, 0, text)
        for part in ("pan_rad              rad", "118 by frame", "0.15 stated", "0 equal", "0 points lie outside",
                     "0 points stand behind", "testable", "chromatic_aberration: points have no colour",
                     "0 errors, 0 warnings"):
            self.assertIn(part, text)

    def test_doubled_rows(self):
        self.refused(self.spoilt(lambda rows: rows + rows), "points.csv:2245", "line 2", "2243 of 4486 rows")

    def test_another_camera(self):
        self.refused(self.spoilt(change_yaml=lambda text: text.replace("width_px: 178", "width_px: 80")),
                     "points.csv:2: column u_px: found '", "80 x 144")

    def test_an_absurd_cell(self):
        def change(rows):
            rows[5]["v_px"] = "1e30"
            return rows
        self.refused(self.spoilt(change), "points.csv:7: column v_px: found '1e30'")

    def test_exchanged_columns(self):
        def change(rows):
            for row in rows:
                row["u_px"], row["v_px"] = row["v_px"], row["u_px"]
            return rows
        self.refused(self.spoilt(change), "u_px and v_px exchanged?")

    def test_axes_are_doubted_with_their_evidence(self):
        def change(rows):
            for row in rows:
                row["x_m"] = -float(row["x_m"])
            return rows
        folder = self.spoilt(change)
        result, page = self.folder / "axes.json", self.folder / "axes.html"
        code, text = seam("compare", "--model", NOMINAL, "--data", folder, "--json", result, "--report", page)
        self.assertEqual(code, 0, text)
        self.assertIn("units? axes?", text)
        self.assertIn("stands behind the camera, one of ", text)
        # The terminal, the JSON and the page say the same first.
        found = json.loads(result.read_text(encoding="utf-8"))
        self.assertEqual(text.splitlines()[:1 + len(found["doubts"])], [found["headline"], *found["doubts"]])
        self.assertIn("units? axes?", page.read_text(encoding="utf-8"))

    def test_names_that_lead_out(self):
        secret = self.folder / "secret.csv"
        secret.write_text("time_s,tilt_rad,pan_rad\n0,0,0\n1,0,0\n", encoding="utf-8")
        folder = self.spoilt(change_yaml=lambda text: text.replace("joints: joints.csv", "joints: ../secret.csv"))
        self.refused(folder, "measurement.yaml:", "'../secret.csv'")
        code, text = seam("measure", "--model", NOMINAL, "--protocol", folder, "--seed", "1", "--out",
                          self.folder / "made" / "deep")
        self.assertEqual(code, 1, text)
        self.assertFalse((self.folder / "made" / "secret.csv").exists())

    def test_links_in_the_output_folder(self):
        out = self.folder / "linked"
        out.mkdir()
        victim = self.folder / "victim.csv"
        victim.write_text("mine\n", encoding="utf-8")
        os.symlink(victim, out / "joints.csv")
        code, text = seam("measure", "--model", NOMINAL, "--protocol", SOURCE / "docs/tutorial/room", "--seed", "1",
                          "--out", out)
        self.assertEqual(code, 1, text)
        self.assertEqual(victim.read_text(encoding="utf-8"), "mine\n")

    def test_terminal_escapes_are_shown(self):
        folder = self.spoilt(change_yaml=lambda text: text.replace("title: ", 'title: "\\e[31m" #'))
        for command in (["check", folder], ["compare", "--model", NOMINAL, "--data", folder]):
            code, text = seam(*command)
            self.assertEqual(code, 0, text)
            self.assertNotIn("\x1b", text)
            self.assertIn("\\x1b[31m", text)


class DeepResults(unittest.TestCase):
    def test_nested_json(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "deep.json"
            path.write_text("[" * 200000 + "]" * 200000, encoding="utf-8")
            code, text = seam("report", path, "--out", pathlib.Path(folder) / "out.html")
            self.assertEqual(code, 1, text)
            self.assertIn("nested deeper", text)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=1)
