#!/usr/bin/env python3
"""The benchmark measures what it says: benchmark_test.py SEAM

Generators give the same bits each time. Their sets are read without complaint, and have the error 1 with the true
model. Scores of answers by hand are those counted by hand. The baselines that know all and nothing score as they must.
"""
import hashlib
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "benchmark"))

try:
    import numpy  # noqa: F401
except ImportError:
    print("numpy is missing: scripts/dependencies.sh installs it")
    sys.exit(77)

import answers  # noqa: E402
import baselines  # noqa: E402
import honesty  # noqa: E402
import kinds  # noqa: E402
import outside  # noqa: E402
import scores  # noqa: E402
import trust  # noqa: E402
from draws import Draw  # noqa: E402
from sets import COURSE, Plan, read_truths, write  # noqa: E402

SEAM = pathlib.Path(sys.argv.pop(1)).resolve()
# Fixed: other bits were other sets, and answers that are kept could not be compared with new ones.
FIRST_UNIFORM = 0.08975759018607565


def fingerprint(folder):
    digest = hashlib.sha256()
    for path in sorted(folder.rglob("*")):
        if path.is_file():
            digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()


def truth(hidden, course="one", **more):
    return {"set": "boards-0001", "sort": "boards", "course": course, "hidden": hidden, "ties": {}, "traces": {},
            "allowed": [], "outside": None, "unscored": []} | more


def name(effect, *others, **values):
    return {"effect": effect, "or": list(others), "values": values}


class Generators(unittest.TestCase):
    # Causes that are hidden in no other sort.
    ALONE = ("heads+mount_sag", "heads+backlash", "heads+exposure", "heads+exposure_stamp", "wheels+encoder_skew", "wheels+wheel_growth",
             "wheels+wheel_load", "walks+tracker_turn", "landmarks+landmark_delay", "landmarks+landmark_height",
             "boards+view_motion", "boards+focus_variation", "boards+focal_temperature", "flats+amplifier_glow", "flats+noise_filter")

    def test_draws_are_those_of_their_key(self):
        self.assertAlmostEqual(Draw("boards", 12).uniform(), FIRST_UNIFORM, places=15)
        self.assertEqual(Draw("a", 1).of("b").uniform(), Draw("a", 1, "b").uniform())
        counts = Draw("poisson").poisson(numpy.repeat([0.5, 20.0, 400.0], 20000)).reshape(3, -1)
        for mean, some in zip((0.5, 20.0, 400.0), counts):
            self.assertAlmostEqual(some.mean() / mean, 1, delta=0.02)
            self.assertAlmostEqual(some.var() / mean, 1, delta=0.04)

    def test_each_sort_is_repeated_checked_and_at_its_noise(self):
        for sort in (*kinds.SORTS, "imus+accel_vibration", *self.ALONE):
            with self.subTest(sort), tempfile.TemporaryDirectory() as scratch:
                number = 1
                first, again = (kinds.make_into(pathlib.Path(scratch) / part, sort, number) for part in ("a", "b"))
                self.assertEqual(fingerprint(first.parent.parent), fingerprint(again.parent.parent))
                self.assertFalse([path for path in first.rglob("*") if "truth" in path.name])
                done = subprocess.run([SEAM, "check", first], capture_output=True, text=True, check=False)
                self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
                self.assertIn("0 errors", done.stdout)
                result = pathlib.Path(scratch) / "compare.json"
                model = pathlib.Path(scratch) / "a/truth" / f"{first.name}.yaml"
                done = subprocess.run([SEAM, "compare", "--model", model, "--data", first, "--json", result],
                                      capture_output=True, text=True, check=False)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertAlmostEqual(json.loads(result.read_text())["error"], 1, delta=0.1)

    def test_every_case_of_a_sort_is_made(self):
        for sort in ("boards", "servos", "landmarks"):
            for number, course in enumerate(COURSE):
                made = kinds.SORTS[sort](Plan(sort, number))
                if course == "outside" and made.hidden:  # A cause that the catalogue has by now.
                    self.assertEqual(([*made.hidden], made.outside), (["gear_ripple"], ""), (sort, number))
                    continue
                self.assertEqual(bool(made.outside), course == "outside", (sort, number))
                self.assertEqual(bool(made.traces), course == "trace", (sort, number))
                self.assertEqual(len(made.hidden), Plan(sort, number).count, (sort, number))


    def test_every_cause_outside_the_catalogue_is_made(self):
        for sort in kinds.OUTSIDE:
            plan, made = kinds.make(sort, 1)
            self.assertEqual((made.outside, made.hidden, plan.course), (outside.cause_of(sort), {}, "outside"), sort)
            self.assertTrue(outside.DEPENDS_ON[plan.base][made.outside], sort)
        self.assertGreaterEqual(len(kinds.OUTSIDE), 40)
        for sort in ("servos+gear_ripple", "motors+torque_cogging"):
            self.assertEqual(outside.cause_of(sort), "")
        made = kinds.make("motors", 6)[1]  # Cogging was outside the catalogue once.
        self.assertEqual(([*made.hidden], made.outside), (["torque_cogging"], ""))


class Honesty(unittest.TestCase):
    PANE = truth({}, "outside", outside="glass", depends_on=["column", "row"])

    def judged(self, names, **more):
        return honesty.judged(self.PANE, answers.answer(names, unexplained=more.pop("unexplained", True)) | more)

    def test_what_is_said_and_what_is_not(self):
        hint = name("board_warp") | {"hint": True}
        self.assertEqual(self.judged([hint], depends_on=["time", "column"], formula_error=1.02), (True,) * 4)
        self.assertEqual(self.judged([], depends_on=["time"]), (False, True, False, True))
        self.assertEqual(self.judged([name("board_warp")], depends_on=["row"]), (True, True, False, False))
        self.assertEqual(self.judged([], unexplained=False, depends_on=["row"]), (False, False, False, True))
        self.assertEqual(honesty.judged(self.PANE, None), (False,) * 4)

    def test_names_of_the_first_line(self):
        found = {"verdict": "unexplained_structure", "error": 1.2, "structure": [], "steps": [
            {"effect": effect, "parameters": {}} for effect in ("thin_prism", "board_warp", "walk_noise")],
            "unnamed_cause": {"depends_on": [["row", "view"]]},
            "headline": "No known effect explains what depends on row. What matters beside it: thin_prism, board_warp are "
                        "missing; board_warp moves predictions by 2 x noise; noise of unknown cause: walk_noise (1 x noise)"}
        given = answers.of_discover(found)
        self.assertEqual(honesty.stand_ins(given), ["thin_prism", "board_warp"])
        self.assertEqual(given["depends_on"], ["row", "view"])
        self.assertEqual(answers.variables_of("u: 0.1 * (x - cx) * sin(2 * pi * t / 3); v: 2 * y"),
                         ["column", "cx", "row", "time"])
        self.assertEqual(answers.variables_of("vx: 2 * max(3 - t, 0) * vx, vy: 1 * exp(-theta / 2)"),
                         ["heading", "time", "vx_cmd_mps"])
        self.assertEqual(answers.variables_of("z: -0.13 * x * y"), ["target x", "target y"])


class Trust(unittest.TestCase):
    def test_counts_by_kind_and_verdict(self):
        lag = {"servo_lag": {"tau_s": 0.02}}
        truths = {str(k): truth(hidden, course, kind="joints") | {"set": str(k)} for k, (hidden, course) in enumerate(
            [(lag, "one"), (lag, "one"), ({}, "none"), (lag, "one")])}
        given = {"0": answers.answer([name("servo_lag")]), "1": answers.answer([name("backlash")]),
                 "2": answers.answer([]), "3": answers.answer([], failed="timeout")}
        self.assertEqual(trust.counts(truths, given), {("joints", "named"): [2, 1], ("joints", "nothing"): [1, 1]})
        self.assertIn('{"joints", "named", 2, 1},', trust.header(trust.counts(truths, given)))


class Scores(unittest.TestCase):
    def test_names(self):
        lag, play = {"servo_lag": {"tau_s": 0.02}}, {"stiction": {"dead_band_rad": 0.1}}
        tied = truth(play, ties={"stiction": ["backlash"]})
        cases = [(truth(lag), [name("servo_lag")], True, False), (truth(lag), [], False, False),
                 (truth(lag), [name("servo_lag"), name("backlash")], False, False),
                 (truth(lag), [name("servo_latency", "servo_lag")], True, True),
                 (tied, [name("backlash")], True, False), (tied, [name("backlash"), name("stiction")], False, False),
                 (truth(lag, traces={"backlash": {}}), [name("servo_lag"), name("backlash")], True, False),
                 (truth({}, "none"), [], True, False), (truth({}, "none"), [name("backlash")], False, False)]
        for hidden, names, right, by_tie in cases:
            got = scores.score(hidden, answers.answer(names))
            self.assertEqual((got.right, got.by_tie), (right, by_tie), (hidden, names))
        self.assertFalse(scores.score(truth(lag), answers.answer([name("servo_lag")], unexplained=True)).right)
        self.assertFalse(scores.score(truth(lag), answers.answer([name("servo_lag")], failed="timeout")).right)
        self.assertFalse(scores.score(truth(lag), None).right)

    def test_causes_outside_the_catalogue(self):
        pane = truth({}, "outside", outside="glass")
        self.assertTrue(scores.score(pane, answers.answer([name("board_warp")], unexplained=True)).right)
        stand_in = scores.score(pane, answers.answer([name("board_warp")]))
        self.assertEqual((stand_in.right, stand_in.honest, stand_in.needless), (False, False, ["board_warp"]))

    def test_values_in_stated_errors(self):
        lag = truth({"servo_lag": {"tau_s": 0.02}})
        got = scores.score(lag, answers.answer([name("servo_lag", tau_s=[0.023, 0.002])]))
        self.assertEqual([(key, round(z, 6)) for key, z in got.deviations], [("servo_lag.tau_s", 1.5)])
        glow = truth({"amplifier_glow": {"fall_u_per_px": 0.05}})
        got_glow = scores.score(glow, answers.answer([name("amplifier_glow", fall_u_per_px=[-0.051, 0.001])]))
        self.assertAlmostEqual(got_glow.deviations[0][1], 1)
        row = scores.row("servos", [got])
        self.assertEqual(row[scores.COLUMNS.index("Values within 1, 2, 10 errors")], "0, 1, 1 of 1")

    def test_intervals_and_pairs(self):
        low, high = scores.wilson(8, 10)  # Wilson 1927, as R's prop.test without correction gives it.
        self.assertAlmostEqual(low, 0.4902, places=4)
        self.assertAlmostEqual(high, 0.9433, places=4)
        self.assertEqual(scores.at_least(5, 5), 1 / 32)
        self.assertEqual(scores.at_least(0, 3), 1)

    def test_files(self):
        with tempfile.TemporaryDirectory() as scratch:
            path = pathlib.Path(scratch) / "answers.json"
            answers.write(path, "by hand", {"boards-0001": answers.answer([name("board_warp", x_m=[0.1, 0.01])])})
            self.assertEqual(answers.read(path)["answers"]["boards-0001"]["names"][0]["effect"], "board_warp")
            path.write_text(path.read_text().replace("[0.1, 0.01]", "0.1"))
            with self.assertRaisesRegex(answers.BadAnswer, r"board_warp.x_m is 0.1, expected \[value, sigma\]"):
                answers.read(path)


class Baselines(unittest.TestCase):
    def test_all_nothing_and_a_library(self):
        with tempfile.TemporaryDirectory() as scratch:
            out = pathlib.Path(scratch)
            for number in range(len(COURSE)):
                plan = Plan("landmarks", number)
                write(kinds.SORTS["landmarks"](plan), plan, out)
            truths = read_truths(out)

            def rights(baseline):
                given = {key: baselines.BASELINES[baseline](out / "sets" / key, one) for key, one in truths.items()}
                return [s.right for s in scores.scored(truths, given)]
            self.assertTrue(all(rights("oracle")))
            self.assertEqual(rights("nothing"), [course == "none" for course in COURSE])
            for baseline in ("stepwise", "lasso"):
                self.assertEqual([rights(baseline)[k] for k in (0, 8)], [True, True], baseline)


class Commands(unittest.TestCase):
    def run_step(self, *arguments):
        done = subprocess.run([sys.executable, ROOT / "benchmark/run.py", *arguments], capture_output=True, text=True,
                              check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def test_make_ask_score(self):
        with tempfile.TemporaryDirectory() as scratch:
            out, given = pathlib.Path(scratch) / "sets", pathlib.Path(scratch) / "given.json"
            self.run_step("make", out, "--sort", "landmarks", "--first", "3", "--sets", "1")
            self.run_step("seam", out, given, "--seam", SEAM)
            self.assertEqual(list(json.loads(given.read_text())["answers"]), ["landmarks-0003"])
            # Answers of two programs do not mix.
            done = subprocess.run([sys.executable, ROOT / "benchmark/run.py", "seam", out, given, "--seam", SEAM, "--program",
                                   "another"], capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 1)
            self.assertIn("name another file", done.stderr)
            self.assertIn("1 of 1", self.run_step("score", out, given, "--wrong"))
            other = pathlib.Path(scratch) / "oracle.json"
            self.run_step("baseline", "oracle", out, other)
            self.assertIn("| together | 1 | 0 | 0 |", self.run_step("pair", out, given, other))

    def test_answers_that_are_kept_are_read(self):
        for path in (ROOT / "benchmark/results").glob("*.json"):
            self.assertTrue(answers.read(path)["answers"], path)


if __name__ == "__main__":
    unittest.main()
