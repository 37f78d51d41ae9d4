#!/usr/bin/env python3
"""`seam plan`, and what then is measured: plan_test.py SEAM SOURCE_DIR [unittest arguments]."""
import json
import math
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile
import unittest

import by_hand

SEAM, SOURCE = by_hand.arguments("seam", "source")
sys.path.insert(0, str(SOURCE / "scripts"))
import plan_check  # noqa: E402

TUTORIAL = SOURCE / "docs/tutorial"
NOMINAL = TUTORIAL / "nominal.yaml"


def seam(*arguments):
    done = subprocess.run([SEAM, *map(str, arguments)], stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=300)
    return done.returncode, done.stdout + done.stderr


class Plan(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.scratch.name)
        cls.room = cls.folder / "room"
        shutil.copytree(TUTORIAL / "room", cls.room)
        lines = (cls.room / "points.csv").read_text(encoding="utf-8").splitlines(keepends=True)
        (cls.room / "points.csv").write_text("".join(lines[:1 + len(lines) // 3]), encoding="utf-8")
        cls.plan, cls.text = cls.planned("--effects", "frame_latency,rolling_shutter", "--report", cls.folder / "plan.html")

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    @classmethod
    def planned(cls, *more):
        path = cls.folder / "plan.json"
        code, text = seam("plan", "--model", NOMINAL, "--protocol", cls.room, "--json", path, *more)
        assert code == 0, text
        return json.loads(path.read_text(encoding="utf-8")), text

    def effect(self, name, plan=None):
        return next(e for e in (plan or self.plan)["effects"] if e["effect"] == name)

    def made(self, line_delay_s, seed):
        truth, data = self.folder / "truth.yaml", self.folder / "made"
        text = NOMINAL.read_text(encoding="utf-8")
        self.assertIn("effects:\n", text)
        truth.write_text(text.replace("effects:\n", f"effects:\n  rolling_shutter: {{line_delay_s: {line_delay_s!r}}}\n"), encoding="utf-8")
        code, said = seam("measure", "--model", truth, "--protocol", self.room, "--seed", seed, "--out", data, "--force")
        self.assertEqual(code, 0, said)
        return data

    def test_what_is_planned_comes_out(self):
        planned = self.effect("rolling_shutter")
        size = planned["smallest_found"]["line_delay_s"]
        sigma = planned["parameters"]["line_delay_s"]["sigma"]
        self.assertTrue(4 < size / sigma < 8, (size, sigma))
        found = self.folder / "added.json"
        code, text = seam("add", "rolling_shutter", "--model", NOMINAL, "--data", self.made(size, 1), "--out", self.folder / "m.yaml",
                          "--json", found)
        self.assertEqual(code, 0, text)
        fitted = json.loads(found.read_text(encoding="utf-8"))["parameters"]["line_delay_s"]
        self.assertAlmostEqual(fitted["sigma"] / sigma, 1, delta=0.08)  # Its misfit is one set's.
        self.assertLess(abs(fitted["value"] - size), 4 * sigma)

        def first(data):
            result = self.folder / "diagnosed.json"
            code, text = seam("diagnose", "--model", NOMINAL, "--data", data, "--json", result)
            self.assertEqual(code, 0, text)
            best = [c for c in json.loads(result.read_text(encoding="utf-8"))["candidates"] if c["significant"]][:1]
            return bool(best) and "rolling_shutter" in [best[0]["effect"], *best[0]["indistinguishable_from"]]

        self.assertEqual([first(self.made(1.4 * size, seed)) for seed in (2, 3)], [True, True])
        self.assertEqual([first(self.made(0.3 * size, seed)) for seed in (2, 3)], [False, False])

    def test_more_and_faster(self):
        changes = {c["change"]: c for c in self.plan["changes"]}
        self.assertEqual(list(changes), ["twice as many frames", "four times as many frames", "the same motion twice as fast"])
        now = self.effect("rolling_shutter")
        more, fast = (self.effect("rolling_shutter", changes[name]) for name in ("four times as many frames", "the same motion twice as fast"))
        self.assertAlmostEqual(more["parameters"]["line_delay_s"]["sigma"] / now["parameters"]["line_delay_s"]["sigma"], 0.5, places=3)
        # Rows are moved by the rate of the head.
        self.assertAlmostEqual(fast["parameters"]["line_delay_s"]["sigma"] / now["parameters"]["line_delay_s"]["sigma"], 0.5, delta=0.03)
        self.assertLess(fast["smallest_found"]["line_delay_s"], 0.6 * now["smallest_found"]["line_delay_s"])

    def test_text_and_page(self):
        self.assertIn(self.plan["headline"], self.text)
        self.assertIn("four times as many frames", self.text)
        page = (self.folder / "plan.html").read_text(encoding="utf-8")
        self.assertIn("seam-plan/1", page)
        self.assertIn("rolling_shutter", page)

    def test_a_pair(self):
        plan, text = self.planned("--improve", "rolling_shutter,frame_latency")
        improved = plan["improve"]
        self.assertEqual((improved["effect"], improved["other"]), ("rolling_shutter", "frame_latency"))
        costs = [p["cost"] for p in improved["proposals"]]
        self.assertEqual(costs, sorted(costs))
        self.assertTrue(costs, text)

    def test_a_pair_that_nothing_separates(self):
        plan, text = self.planned("--improve", "frame_latency,exposure")
        self.assertEqual(plan["improve"]["proposals"], [])
        self.assertIn("no change that was tried separates frame_latency from exposure", text)
        self.assertNotIn("cheapest first", text)

    def test_an_effect_of_the_model_without_a_free_parameter(self):
        plan, text = self.planned("--effects", "pinhole")
        self.assertEqual((plan["effects"], [n["effect"] for n in plan["not_planned"]]), ([], ["pinhole"]), text)
        self.assertIn("no free parameter", text)

    def test_all_effects(self):
        plan, text = self.planned()
        names = [e["effect"] for e in plan["effects"]]
        self.assertIn("frame_latency", names)
        self.assertGreater(plan["looks"], 10)
        self.assertEqual(plan["changes"], [])
        why = {n["effect"]: n["why"] for n in plan["not_planned"]}
        self.assertIn("errors are not independent", why["point_scatter"], text)
        self.assertEqual(self.effect("rolling_shutter", plan)["smallest_found"], self.effect("rolling_shutter")["smallest_found"])

    def test_a_spread_is_known_as_the_scatter_of_as_many_numbers(self):
        protocol = self.folder / "circles"
        protocol.mkdir()
        model = self.folder / "circles.yaml"
        model.write_text("format: seam-model/1\nname: made\neffects:\n" + plan_check.landmarks(protocol), encoding="utf-8")
        code, text = seam("plan", "--model", model, "--protocol", protocol, "--effects", "bearing_noise,range_wander",
                          "--json", self.folder / "noise.json")
        self.assertEqual(code, 0, text)
        plan = json.loads((self.folder / "noise.json").read_text(encoding="utf-8"))
        noise = self.effect("bearing_noise", plan)
        more, sigma = noise["smallest_found"]["sigma_rad"], noise["parameters"]["sigma_rad"]["sigma"]
        # The root of a variance of n normal numbers, less what was known of it; two of three groups are fitted.
        stated, bearings = 0.01, 12 * 8 * 6
        fitted = ((stated ** 2 + more ** 2) / (more * sigma)) ** 2 / 2
        self.assertTrue(0.55 < fitted / bearings < 0.85, text)
        # Of a gain of likelihood n share^2 the rules ask about ten units and more.
        share = 0.5 * math.log(1 + (more / stated) ** 2)
        self.assertTrue(8 < bearings * share ** 2 < 30, text)
        self.assertEqual([n["effect"] for n in plan["not_planned"]], ["range_wander"], text)

    def test_a_board_with_unknown_poses_stands_for_itself(self):
        board = self.folder / "board"
        board.mkdir()
        noise = random.Random(3)
        rows = ["frame,time_s,point,x_m,y_m,z_m,u_px,v_px"]
        for frame in range(12):
            turn, tip = 0.5 * frame, 0.7 - 0.1 * frame
            for point in range(48):
                x, y = 0.03 * (point % 8) - 0.105, 0.03 * (point // 8) - 0.075
                x_C, along = x * math.cos(turn) - y * math.sin(turn), x * math.sin(turn) + y * math.cos(turn)
                y_C, z_C = along * math.cos(tip), 0.5 + along * math.sin(tip)
                u, v = 400 * x_C / z_C + 320, 400 * y_C / z_C + 240
                rows.append(f"{frame},{frame}.0,{point},{x},{y},0,{u + noise.gauss(0, 0.1):.4f},{v + noise.gauss(0, 0.1):.4f}")
        (board / "points.csv").write_text("\n".join(rows) + "\n")
        (board / "measurement.yaml").write_text(
            "format: seam-measurement/1\nkind: points\ntitle: board\ncamera: {width_px: 640, height_px: 480}\n"
            "group: frame\nfiles: {points: points.csv}\nrig: {pose: unknown}\nnoise: {u_px: 0.1, v_px: 0.1}\n")
        (board / "nominal.yaml").write_text("format: seam-model/1\nname: nominal\neffects:\n  pinhole: {" + ", ".join(
            f"{name}: {{value: {value}, free: true}}" for name, value in
            (("fx_px", 400), ("fy_px", 400), ("cx_px", 320), ("cy_px", 240))) + "}\n")
        result = self.folder / "board.json"
        code, text = seam("plan", "--model", board / "nominal.yaml", "--protocol", board, "--json", result,
                          "--effects", "radial_distortion,pinhole")
        self.assertEqual(code, 0, text)
        plan = json.loads(result.read_text(encoding="utf-8"))
        # The motion of the views is nobody's protocol: more of them is all that may change.
        self.assertEqual([c["change"] for c in plan["changes"]], ["twice as many frames", "four times as many frames"])
        fitted = self.folder / "fitted.json"
        code, text = seam("fit", "--model", board / "nominal.yaml", "--data", board, "--out", self.folder / "board.yaml", "--json", fitted)
        self.assertEqual(code, 0, text)
        own = json.loads(fitted.read_text(encoding="utf-8"))["parameters"]
        for name, planned in self.effect("pinhole", plan)["parameters"].items():
            self.assertAlmostEqual(planned["sigma"] / own["pinhole." + name]["sigma"], 1, delta=0.15, msg=name)

    def test_flat_fields_are_known_as_their_formulas_say(self):
        protocol = self.folder / "flats"
        protocol.mkdir()
        model = self.folder / "flats.yaml"
        model.write_text("format: seam-model/1\nname: made\neffects:\n" + plan_check.flats(protocol).replace(
            "  shot_noise: {electrons_per_dn: {value: 2, free: true}}\n", ""), encoding="utf-8")
        result = self.folder / "flats.json"
        code, text = seam("plan", "--model", model, "--protocol", protocol, "--json", result,
                          "--effects", "linear_response,read_noise,uneven_lighting,lamp_fluctuation,hot_pixels")
        self.assertEqual(code, 0, text)
        plan = json.loads(result.read_text(encoding="utf-8"))
        # Without photons all values of the fitted frames have one noise, which rounding adds to.
        values, noise = 32 * 24 * 56, math.sqrt(3 ** 2 + 1 / 12)
        read = self.effect("read_noise", plan)["parameters"]["sigma_dn"]["sigma"]
        fitted = (noise ** 2 / 3 / read) ** 2 / 2 / values
        self.assertTrue(0.6 < fitted < 0.8, fitted)
        levels = (0, 0.1, 0.2, 0.35, 0.5, 0.7, 0.85)
        about_mean = sum(light ** 2 for light in levels) / 7 - (sum(levels) / 7) ** 2
        gain = self.effect("linear_response", plan)["parameters"]["gain_dn"]["sigma"]
        self.assertAlmostEqual(gain / (noise / math.sqrt(fitted * values * about_mean)), 1, delta=0.1)
        light = self.effect("uneven_lighting", plan)
        self.assertGreater(light["smallest_found"]["gx"], 4 * light["parameters"]["gx"]["sigma"])
        self.assertIsNone(light["ties"])
        self.assertEqual({n["effect"] for n in plan["not_planned"]}, {"lamp_fluctuation", "hot_pixels"}, text)
        self.assertEqual([c["change"] for c in plan["changes"]], ["twice as many frames", "four times as many frames"])
        more = self.effect("read_noise", plan["changes"][1])["parameters"]["sigma_dn"]["sigma"]
        self.assertAlmostEqual(more / read, 0.5, delta=0.03)

    def test_what_is_wrong_is_told(self):
        def refused(code, said, *arguments):
            given = seam("plan", "--model", NOMINAL, *arguments)
            self.assertEqual((given[0], said in given[1]), (code, True), given[1])

        refused(2, "did you mean 'rolling_shutter'", "--protocol", self.room, "--effects", "rolling_shuter")
        refused(2, "found no names", "--protocol", self.room, "--effects", ",")
        refused(2, "expected two", "--protocol", self.room, "--improve", "rolling_shutter")
        refused(1, "nowhere", "--protocol", self.folder / "nowhere")
        refused(2, "--protocol", "--effects", "rolling_shutter")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
