#!/usr/bin/env python3
"""Frames drawn by OpenGL, as a user makes them: a room of meshes and textures, the same bits again, from a log too, and what
is said where a file is missing or the ray caster is asked for what it has not.

Usage: opengl_test.py SEAM SOURCE_DIR [unittest arguments]
Where the build has no OpenGL, what it says of scenes that need it, and that it draws those that do not.
"""
import io
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import numpy as np
from PIL import Image

from viewing import viewer

import by_hand

SEAM, SOURCE = by_hand.arguments("seam", "source")
SWING = SOURCE / "scenarios/head_swing.yaml"


def seam(*arguments):
    done = subprocess.run([SEAM, *map(str, arguments)], stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=200,
                          env={**os.environ, "LC_ALL": "C"})
    return done.returncode, done.stdout + done.stderr


class Room(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        shutil.copytree(SOURCE / "models", self.folder / "models")
        shutil.copytree(SOURCE / "scenarios/room", self.folder / "scenarios/room")
        self.room = self.folder / "scenarios/room/room.yaml"
        self.room.write_text(self.room.read_text().replace("duration_s: 1", "duration_s: 0.2"))

    def frame(self, *arguments):
        code, text = seam("frame", self.room, "--robot", "red1", "--at", "0.1", *arguments)
        self.assertEqual(code, 0, text)
        return text.split("fingerprint ")[1].strip()

    def refused(self, *parts):
        code, text = seam("frame", self.room, "--robot", "red1", "--at", "0.1", "--out", self.folder / "no.png")
        self.assertEqual(code, 1, text)
        for part in parts:
            self.assertIn(part, text)
        self.assertFalse((self.folder / "no.png").exists())

    def test_a_room_is_drawn_and_drawn_again(self):
        first = self.frame("--out", self.folder / "a.png", "--stages", self.folder / "stages")
        self.assertEqual(self.frame("--out", self.folder / "b.png"), first)
        self.assertEqual((self.folder / "a.png").read_bytes(), (self.folder / "b.png").read_bytes())
        for stage in ("labels", "depth", "motion"):
            self.assertTrue(list((self.folder / "stages").glob(f"*_{stage}.png")))

    def test_a_bundle_has_meshes_materials_and_textures(self):
        log, bundle = self.folder / "run.mcap", self.folder / "room.seam"
        code, text = seam("run", self.room, "--log", log)
        self.assertEqual(code, 0, text)
        code, text = seam("sweep", "bundle", log, "--out", bundle)
        self.assertEqual((code, "their bits are those of" in text), (0, True), text)
        for name in ("chair.obj", "chair.mtl", "planks.jpg", "bricks.png"):
            (self.room.parent / name).unlink()
        log.unlink()
        code, text = seam("sweep", "rerun", bundle, "--run-programs")
        self.assertEqual((code, "equal: the run has the fingerprint" in text), (0, True), text)

    def test_the_log_names_the_renderer_and_is_made_again(self):
        log = self.folder / "run.mcap"
        code, text = seam("run", self.room, "--log", log)
        self.assertEqual(code, 0, text)
        code, text = seam("replay", "show", log, "--json", self.folder / "show.json")
        self.assertEqual(code, 0, text)
        versions = json.loads((self.folder / "show.json").read_text())["versions"]
        self.assertEqual(versions["renderer"], "opengl")
        self.assertIn("Mesa", versions["opengl"])
        self.assertIn("llvmpipe", versions["opengl_renderer"])
        self.assertEqual(versions["opengl_from"], "osmesa")
        # Frames that the run may not have asked for are the same bits too.
        code, text = seam("replay", "frames", log, "--robot", "red1", "--from", "0.05", "--to", "0.13", "--out", self.folder / "eyes")
        self.assertEqual(code, 0, text)
        drawn = {path.name: path.read_bytes() for path in (self.folder / "eyes").glob("*.png")}
        self.frame("--out", self.folder / "at.png")
        self.assertEqual(sorted(drawn), ["red1_000002.png", "red1_000003.png"])
        code, text = seam("replay", "frames", log, "--robot", "red1", "--renderer", "analytic", "--out", self.folder / "none")
        self.assertEqual((code, "--renderer opengl" in text), (1, True), text)
        at = np.array(Image.open(self.folder / "at.png"))
        self.assertTrue((np.array(Image.open(self.folder / "eyes/red1_000003.png")) == at).all())
        code, text = seam("replay", "verify", log)
        self.assertEqual((code, "the same" in text), (0, True), text)
        with open(self.folder / "scenarios/room/chair.obj", "a") as chair:
            chair.write("# moved\n")
        code, text = seam("replay", "verify", log)
        self.assertEqual((code, "chair.obj" in text, "has changed" in text), (1, True, True), text)

    def test_egl_draws_too_and_its_log_says_so(self):
        code, text = seam("frame", self.room, "--robot", "red1", "--at", "0.1", "--gl", "egl", "--out", self.folder / "egl.png")
        if code != 0 and "--gl egl: " in text:
            self.skipTest(text)
        self.assertEqual(code, 0, text)
        log = self.folder / "run.mcap"
        code, text = seam("run", self.room, "--gl", "egl", "--log", log)
        self.assertEqual(code, 0, text)
        code, text = seam("replay", "show", log, "--json", self.folder / "show.json")
        versions = json.loads((self.folder / "show.json").read_text())["versions"]
        self.assertEqual(versions["opengl_from"], "egl")
        code, text = seam("replay", "verify", log)
        self.assertEqual((code, "the same" in text), (0, True), text)
        self.frame("--out", self.folder / "osmesa.png", "--gl", "osmesa")
        apart = np.array(Image.open(self.folder / "egl.png")).astype(int) - np.array(Image.open(self.folder / "osmesa.png"))
        # The same version of Mesa gives the same bits, a graphics processor nearly the same picture.
        self.assertLess(np.abs(apart).mean(), 0.3)
        if "llvmpipe" in versions["opengl_renderer"]:
            self.assertEqual(np.abs(apart).max(), 0)

    def test_the_viewer_shows_its_stages_and_what_stands_there(self):
        log = self.folder / "run.mcap"
        code, text = seam("run", self.room, "--log", log)
        self.assertEqual(code, 0, text)
        self.frame("--out", self.folder / "at.png")
        with viewer(SEAM, log) as ask:
            info = ask("info")["logs"][0]
            pictures = {stage: np.array(Image.open(io.BytesIO(ask("frame", robot="red1", index=3, stage=stage))))
                        for stage in info["stages"]}
        self.assertTrue((pictures["rgb"] == np.array(Image.open(self.folder / "at.png"))).all())
        self.assertLessEqual({"rgb", "ycrcb", "labels", "depth", "scene", "sensor"}, pictures.keys())
        for stage, picture in pictures.items():
            self.assertEqual(picture.shape[:2], (144, 178), stage)
            self.assertGreater(len(np.unique(picture)), 2, stage)
        # The chair is as wide and deep from above as it is, whichever way it is turned.
        chair, = (np.array(item["footprint_m"]) for item in info["scenery"] if abs(item["top_m"] - 0.9) < 1e-6)
        x, y = chair.T
        self.assertAlmostEqual(0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1)), 0.42 * 0.42, places=6)

    def test_processes_elsewhere_draw_the_same_bits(self):
        # They are sent the meshes and the textures: they have none of the scenario's files.
        swing = self.folder / "scenarios/swing.yaml"
        swing.write_text(SWING.read_text().replace("duration_s: 2", "duration_s: 0.2"))
        for scene, drawing in ((self.room, "auto"), (swing, "opengl")):
            found = []
            for renderers in (0, 1):
                code, text = seam("run", scene, "--renderer", drawing, "--renderers", renderers, "--renderer-check", "2",
                                  "--json", self.folder / "run.json")
                self.assertEqual(code, 0, text)
                found.append(json.loads((self.folder / "run.json").read_text()))
            here, elsewhere = found
            self.assertGreater(here["frames"], 0)
            self.assertEqual(elsewhere["rendered_remotely"], here["frames"])
            self.assertEqual(elsewhere["fingerprint"], here["fingerprint"])

    def test_what_cannot_be_drawn_is_refused_by_name(self):
        code, text = seam("frame", self.room, "--robot", "red1", "--at", "0.1", "--renderer", "analytic", "--out",
                          self.folder / "no.png")
        self.assertEqual((code, "--renderer opengl" in text), (1, True), text)
        (self.folder / "scenarios/room/planks.jpg").write_bytes(b"\xff\xd8\xff no picture")
        self.refused("planks.jpg")
        shutil.copy(SOURCE / "scenarios/room/planks.jpg", self.folder / "scenarios/room/planks.jpg")
        text = self.room.read_text()
        for name, why in (("../chair.obj", "leads out of the folder"), ("/etc/passwd", "relative"),
                          ("none.obj", "none.obj")):
            self.room.write_text(text.replace("chair.obj", name))
            self.refused(why)
        self.room.write_text(text.replace("file: chair.obj", "file: chair.obj, scale: 0"))
        self.refused("scale")


class Set(unittest.TestCase):
    """Frames of a scene with a mesh and textures, compared with a model."""

    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.protocol = self.folder / "protocol"
        self.protocol.mkdir()
        for name in ("chair.obj", "chair.mtl", "bricks.png", "planks.jpg"):
            shutil.copy(SOURCE / "scenarios/room" / name, self.protocol)
        (self.protocol / "joints.csv").write_text("time_s,pan_rad\n0,-0.4\n0.5,0.4\n1,-0.4\n")
        (self.protocol / "frames.csv").write_text("frame,file,time_s\n0,frames/0.png,0.2\n1,frames/1.png,0.7\n")
        (self.protocol / "measurement.yaml").write_text(
            "format: seam-measurement/1\nkind: frames\ntitle: A room\ngroup: frame\nscene: scene.yaml\n"
            "camera: {width_px: 89, height_px: 72, frame_period_s: 0.04}\n"
            "files: {frames: frames.csv, joints: joints.csv}\n"
            "rig: {chain: [{translate_m: [0, 0, 0.3]}, {joint: pan, axis: [0, 0, 1]}]}\n")
        self.scene("")

    def scene(self, more):
        (self.protocol / "scene.yaml").write_text(
            "format: seam-scene/1\nbackground_rgb: [0.3, 0.4, 0.5]\nobjects:\n"
            "  - {shape: rectangle, centre_m: [1, 0, 0], size_m: [6, 6], texture: planks.jpg}\n"
            "  - {shape: box, centre_m: [1.5, 0.4, 0.2], size_m: [0.3, 0.3, 0.4], texture: bricks.png}\n"
            "  - {shape: mesh, file: chair.obj, pose: {x_m: 1.2, y_m: -0.3, yaw_rad: 0.5}}\n" + more)

    def model(self, name, more):
        path = self.folder / f"{name}.yaml"
        path.write_text("format: seam-model/1\nname: m\neffects:\n  pinhole: {fx_px: 81, fy_px: 81, cx_px: 44, cy_px: 35.5}\n"
                        f"  exposure: {{exposure_s: 0.005}}\n  read_noise: {{sigma_dn: 1.5}}\n{more}")
        return path

    def error(self, model):
        code, text = seam("compare", "--model", model, "--data", self.folder / "data", "--json", self.folder / "out.json")
        self.assertEqual(code, 0, text)
        return json.loads((self.folder / "out.json").read_text())["error"]

    def test_a_set_of_a_room_is_made_and_held_against_models(self):
        truth = self.model("truth", "  rolling_shutter: {line_delay_s: 0.0004}\n")
        code, text = seam("measure", "--model", truth, "--protocol", self.protocol, "--seed", "1", "--out", self.folder / "data")
        self.assertEqual(code, 0, text)
        self.assertTrue((self.folder / "data/chair.mtl").is_file())
        self.assertAlmostEqual(self.error(truth), 1, delta=0.05)
        self.assertGreater(self.error(self.model("still", "")), 2)

    def test_files_outside_the_sets_folder_are_refused(self):
        for more, part in (("  - {shape: mesh, file: ../chair.obj}\n", "chair.obj"),
                           ("  - {shape: mesh, file: {name: passwd, folder: /etc}}\n", "in the scene's folder"),
                           ("  - {shape: mesh, file: none.obj}\n", "none.obj")):
            self.scene(more)
            code, text = seam("measure", "--model", self.model("truth", ""), "--protocol", self.protocol, "--seed", "1",
                              "--out", self.folder / "no")
            self.assertEqual(code, 1, text)
            self.assertIn(part, text)
            self.assertEqual(list((self.folder / "no").glob("*")), [])


class Shapes(unittest.TestCase):
    def test_a_recorded_run_is_drawn_by_the_other_renderer(self):
        with tempfile.TemporaryDirectory() as folder:
            log, found = pathlib.Path(folder) / "run.mcap", []
            code, text = seam("run", SWING, "--set", "duration_s=0.2", "--log", log)
            self.assertEqual(code, 0, text)
            for renderer in ("auto", "opengl"):
                code, text = seam("replay", "frames", log, "--robot", "red1", "--renderer", renderer, "--out",
                                  pathlib.Path(folder) / renderer)
                self.assertEqual(code, 0, text)
                found.append([np.array(Image.open(path)).astype(int)
                              for path in sorted((pathlib.Path(folder) / renderer).glob("*.png"))])
            self.assertGreater(len(found[0]), 2)
            apart = abs(np.array(found[0]) - np.array(found[1]))
            self.assertGreater(apart.max(), 0)
            self.assertLessEqual(apart.mean(), 0.3)

    def test_both_renderers_make_nearly_the_same_frame(self):
        with tempfile.TemporaryDirectory() as folder:
            found = []
            for renderer in ("analytic", "opengl"):
                out = pathlib.Path(folder) / f"{renderer}.png"
                code, text = seam("frame", SWING, "--robot", "red1", "--at", "0.5", "--renderer", renderer, "--out", out)
                self.assertEqual(code, 0, text)
                found.append(np.array(Image.open(out)).astype(int))
            apart = abs(found[0] - found[1])
            self.assertGreater(apart.max(), 0)
            self.assertLessEqual(apart.mean(), 0.3)
            self.assertGreaterEqual((apart <= 6).mean(), 0.999)


class Absent(unittest.TestCase):
    """A build with -DSEAM_OPENGL=OFF."""

    def test_what_needs_opengl_is_refused_by_name_and_the_rest_is_drawn(self):
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder) / "frame.png"
            for scene, renderer, told in ((SOURCE / "scenarios/room/room.yaml", "auto", ("planks.jpg", "-DSEAM_OPENGL=ON")),
                                          (SWING, "opengl", ("-DSEAM_OPENGL=ON", "--renderer analytic"))):
                code, text = seam("frame", scene, "--robot", "red1", "--at", "0.1", "--renderer", renderer, "--out", out)
                self.assertEqual(code, 1, text)
                for part in told:
                    self.assertIn(part, text)
                self.assertFalse(out.exists())
            code, text = seam("frame", SWING, "--robot", "red1", "--at", "0.1", "--out", out)
            self.assertEqual((code, out.exists()), (0, True), text)


def has_opengl():
    with tempfile.TemporaryDirectory() as scratch:
        return "this build has none" not in seam("frame", SWING, "--robot", "red1", "--at", "0.1", "--renderer", "opengl",
                                                 "--out", pathlib.Path(scratch) / "x.png")[1]


if __name__ == "__main__":
    kinds = ["Room", "Shapes"] if has_opengl() else ["Absent"]
    unittest.main(argv=[sys.argv[0], *(sys.argv[3:] or kinds)], verbosity=2)
