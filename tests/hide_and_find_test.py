#!/usr/bin/env python3
"""An effect is hidden in rendered frames, markers are found in the pictures as a user's program would, and the effect is
found again from where they were seen. Only pictures pass from the one side to the other.

Usage: hide_and_find_test.py SEAM [unittest arguments]
"""
import json
import math
import pathlib
import subprocess
import sys
import tempfile
import unittest

import PIL.Image

import by_hand

SEAM = by_hand.arguments("seam")
LIMIT_S = 200
WIDTH_PX, HEIGHT_PX, FX_PX, FY_PX, CX_PX, CY_PX = 178, 144, 161.9, 162.5, 88.5, 71.5
EFFECTS = (f"  pinhole: {{fx_px: {FX_PX}, fy_px: {FY_PX}, cx_px: {CX_PX}, cy_px: {CY_PX}}}\n"
           "  exposure: {exposure_s: 0.004}\n")
SENSOR = "  read_noise: {sigma_dn: 1.5}\n"
RADIUS_M = 0.03
BACKGROUND_DN = (76.5, 76.5, 76.5)
# Balls of seven colours: name, colour, place in the rig's world.
BALLS = [("red", (0.9, 0.3, 0.3), (1.4, -0.5, 0.55)), ("green", (0.3, 0.9, 0.3), (1.5, -0.25, 0.0)),
         ("blue", (0.3, 0.3, 0.9), (1.3, 0.05, 0.5)), ("yellow", (0.9, 0.9, 0.3), (1.6, 0.3, 0.1)),
         ("violet", (0.9, 0.3, 0.9), (1.4, 0.55, 0.4)), ("cyan", (0.3, 0.9, 0.9), (1.5, 0.0, -0.2)),
         ("white", (0.9, 0.9, 0.9), (1.4, 0.6, -0.1))]
FRAMES = 40
# Balls of a dozen pixels are found to 0.01 px on average; their rims between pixels make an error that is no noise.
NOISE = "noise: {u_px: 0.04, v_px: 0.04}\n"


def png_rows(path):
    """Rows of (r, g, b) of an 8-bit RGB PNG."""
    with PIL.Image.open(path) as image:
        assert image.mode == "RGB", image.mode
        pixels = list(image.getdata())
        return [pixels[start:start + image.width] for start in range(0, len(pixels), image.width)]


def markers(rows):
    """Where each ball's centre is seen: the centroid of its share of each pixel."""
    sums = {name: [0.0, 0.0, 0.0, False] for name, _, _ in BALLS}
    for v, row in enumerate(rows):
        for u, pixel in enumerate(row):
            off = [p - b for p, b in zip(pixel, BACKGROUND_DN)]
            if max(map(abs, off)) < 15:
                continue
            best = None
            for name, rgb, _ in BALLS:
                full = [255 * c - b for c, b in zip(rgb, BACKGROUND_DN)]
                share = sum(o * f for o, f in zip(off, full)) / sum(f * f for f in full)
                miss = sum((o - share * f) ** 2 for o, f in zip(off, full))
                if best is None or miss < best[0]:
                    best = (miss, name, share)
            _, name, share = best
            total = sums[name]
            total[0] += share
            total[1] += share * u
            total[2] += share * v
            total[3] |= u < 3 or v < 3 or u > WIDTH_PX - 4 or v > HEIGHT_PX - 4
    for name, _, (x, y, z) in BALLS:
        weight, u, v, cut = sums[name]
        if weight < 12 or cut:
            continue
        # A sphere's outline is an ellipse whose centre lies further out than the sphere's, by 1 / (1 - (r / depth)^2).
        u, v = u / weight - CX_PX, v / weight - CY_PX
        depth = math.dist((x, y, z), (0.0666, 0, 0.243)) / math.hypot(1, u / FX_PX, v / FY_PX)
        shrink = 1 - (RADIUS_M / depth) ** 2
        yield name, (x, y, z), CX_PX + u * shrink, CY_PX + v * shrink


class HideAndFind(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.here = pathlib.Path(self.folder.name)

    def seam(self, *arguments):
        done = subprocess.run([SEAM, *map(str, arguments)], capture_output=True, text=True, timeout=LIMIT_S)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def model(self, name, effects):
        path = self.here / f"{name}.yaml"
        path.write_text(f"format: seam-model/1\nname: {name}\neffects:\n{effects}")
        return path

    def protocol(self):
        """A head that swings before the balls."""
        folder = self.here / "protocol"
        folder.mkdir()
        rig = "rig:\n  chain:\n    - {translate_m: [0, 0, 0.243]}\n    - {joint: pan, axis: [0, 0, 1]}\n    - {translate_m: [0.0666, 0, 0]}\n"
        camera = f"camera: {{width_px: {WIDTH_PX}, height_px: {HEIGHT_PX}, frame_period_s: 0.04}}\ngroup: frame\n"
        (folder / "measurement.yaml").write_text("format: seam-measurement/1\nkind: frames\n" + camera +
                                                 "scene: scene.yaml\nfiles: {frames: frames.csv, joints: joints.csv}\n" + rig)
        self.points = "format: seam-measurement/1\nkind: points\n" + camera + "files: {points: points.csv, joints: joints.csv}\n" + NOISE + rig
        (folder / "joints.csv").write_text("time_s,pan_rad\n" + "".join(
            f"{0.008 * i:.3f},{0.45 * math.sin(8.0 * 0.008 * i):.7f}\n" for i in range(420)))
        (folder / "frames.csv").write_text("frame,file,time_s\n" + "".join(
            f"{i},frames/{i:04d}.png,{0.1 + 0.08 * i:.3f}\n" for i in range(FRAMES)))
        objects = "".join(f"  - {{shape: sphere, centre_m: {list(place)}, radius_m: {RADIUS_M}, rgb: {list(rgb)}}}\n"
                          for _, rgb, place in BALLS)
        (folder / "scene.yaml").write_text("format: seam-scene/1\nbackground_rgb: [0.3, 0.3, 0.3]\nshading: flat\nobjects:\n" + objects)
        return folder

    def observed(self, truth):
        """The set of points that the pictures of a camera show."""
        pictures, out = self.here / "pictures", self.here / "points"
        protocol = self.protocol()
        self.seam("measure", "--model", truth, "--protocol", protocol, "--seed", 5, "--out", pictures)
        out.mkdir()
        (out / "measurement.yaml").write_text(self.points)
        (out / "joints.csv").write_text((protocol / "joints.csv").read_text())
        lines = ["frame,time_s,point,x_m,y_m,z_m,u_px,v_px"]
        for i in range(FRAMES):
            for name, (x, y, z), u, v in markers(png_rows(pictures / f"frames/{i:04d}.png")):
                lines.append(f"{i},{0.1 + 0.08 * i:.3f},{name},{x},{y},{z},{u:.4f},{v:.4f}")
        (out / "points.csv").write_text("\n".join(lines) + "\n")
        self.assertGreater(len(lines), 3 * FRAMES)
        return out

    def found(self, hidden):
        data = self.observed(self.model("truth", EFFECTS + SENSOR + hidden))
        out = self.here / "discover.json"
        self.seam("discover", "--model", self.model("nominal", EFFECTS), "--data", data, "--out", self.here / "found.yaml",
                  "--json", out)
        return json.loads(out.read_text())

    def test_a_rolling_shutter(self):
        found = self.found("  rolling_shutter: {line_delay_s: 2.4e-4}\n")
        step = found["steps"][0]
        self.assertEqual(step["effect"], "rolling_shutter")
        self.assertAlmostEqual(step["parameters"]["line_delay_s"]["value"], 2.4e-4, delta=0.02 * 2.4e-4)
        self.assertLess(found["native"]["u_px"], 0.1)
        self.assertLess(found["error"], 0.1 * found["baseline"]["error"])

    def test_a_distorted_lens(self):
        found = self.found("  radial_distortion: {kappa: -0.12}\n")
        step = found["steps"][0]
        self.assertEqual(step["effect"], "radial_distortion")
        self.assertAlmostEqual(step["parameters"]["kappa"]["value"], -0.12, delta=0.006)
        self.assertLess(found["native"]["u_px"], 0.1)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[2:])
