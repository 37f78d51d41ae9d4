#!/usr/bin/env python3
"""`seam workbench`: a whole journey through its interface (docs/reference/workbench_api.md), what it refuses, and that
what was shown as saved is there.

Usage: workbench_test.py SEAM SOURCE_DIR [unittest arguments]
"""
import contextlib
import io
import json
import os
import pathlib
import re
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import urllib.error
import urllib.request
import zipfile

import by_hand

SEAM, SOURCE = by_hand.arguments("seam", "source")
LIMIT_S = 120


class Answer:
    def __init__(self, status, headers, content):
        self.status, self.headers, self.content = status, headers, content

    @property
    def json(self):
        return json.loads(self.content)


def decoded(table):
    """The head and the columns of a binary table."""
    length, = struct.unpack_from("<I", table)
    head = json.loads(table[4:4 + length])
    return head, {name: struct.unpack_from(f"<{head['n']}f", table, 4 + length + 4 * head["n"] * k)
                  for k, name in enumerate(head["columns"])}


class Page:
    """What a browser would be: the address that the program printed, and the cookie that it got for the token."""

    def __init__(self, folder, *arguments, enter=True, limits=None):
        self.process = subprocess.Popen(
            [SEAM, "workbench", *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            stdin=subprocess.DEVNULL, cwd=folder, env=dict(os.environ, XDG_STATE_HOME=str(folder)), preexec_fn=limits)
        self.address, _, self.token = self.process.stdout.readline().strip().partition("#token=")
        if not self.address:
            raise AssertionError(self.process.communicate()[1])
        self.headers = {}
        if enter:
            entered = self.ask("enter", {"token": self.token})
            cookie = entered.headers["Set-Cookie"]
            assert "HttpOnly" in cookie and "SameSite=Strict" in cookie, cookie
            self.headers = {"Cookie": cookie.split(";")[0]}

    def ask(self, what, body=None, method=None, headers=None, content=None):
        data = content if content is not None else None if body is None else json.dumps(body).encode()
        path = what if what.startswith("/") else f"/api/{what}"
        request = urllib.request.Request(self.address.rstrip("/") + path, data=data, method=method,
                                         headers={"Content-Type": "application/json", **self.headers, **(headers or {})})
        try:
            with urllib.request.urlopen(request, timeout=LIMIT_S) as answer:
                return Answer(answer.status, answer.headers, answer.read())
        except urllib.error.HTTPError as error:
            return Answer(error.code, error.headers, error.read())

    @property
    def state(self):
        return self.ask("state").json

    def change(self, what, **body):
        return self.ask(what, {"revision": self.state["revision"], **body})

    def until(self, found):
        """Waits until it gives something."""
        end = time.monotonic() + LIMIT_S
        while time.monotonic() < end:
            result = found()
            if result:
                return result
            time.sleep(0.05)
        raise AssertionError(f"nothing came; the last state: {self.state}")

    def table(self, what):
        """Columns of a binary table, once it is there."""
        def read():
            answer = self.ask(what)
            assert answer.status in (200, 202), answer.content
            return answer if answer.status == 200 else None
        return decoded(self.until(read).content)

    def version(self, name):
        return next(one for one in self.state["versions"] if one["id"] == name)

    def looked_at(self, name):
        return self.until(lambda: (one := self.version(name))["error"] is not None and one)

    def events(self, last=None):
        """What the stream says, behind the event of this number."""
        request = urllib.request.Request(f"{self.address}api/events", headers={**self.headers, **({"Last-Event-ID": last} if last else {})})
        with urllib.request.urlopen(request, timeout=LIMIT_S) as stream:
            event = {}
            while True:
                line = stream.readline().decode().rstrip("\n")
                key, _, value = line.partition(": ")
                if value:  # No comment.
                    event[key] = value
                elif event:
                    yield event
                    event = {}

    def end(self, number=signal.SIGTERM):
        self.process.send_signal(number)
        self.process.wait(timeout=30)
        self.process.stdout.close()
        self.process.stderr.close()


class OfTheRoom(unittest.TestCase):
    """Each test has the tutorial's room in a folder of its own."""

    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.made = pathlib.Path(cls.scratch.name) / "made/room"
        subprocess.run([SEAM, "measure", "--model", SOURCE / "docs/tutorial/robot.yaml", "--protocol",
                        SOURCE / "docs/tutorial/room", "--seed", "1", "--out", cls.made], check=True, capture_output=True)
        shutil.copy(SOURCE / "docs/tutorial/nominal.yaml", cls.made)

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(dir=self.scratch.name))
        self.data = self.folder / "room"
        shutil.copytree(self.made, self.data)
        self.session = self.folder / "work"

    @contextlib.contextmanager
    def page(self, *arguments, **options):
        page = Page(self.folder, *(arguments or (self.data, "--session", self.session)), **options)
        try:
            yield page
        finally:
            if page.process.poll() is None:
                page.end()


class Workbench(OfTheRoom):
    def test_the_whole_journey(self):
        with self.page() as page:
            first = page.looked_at("001")
            self.assertGreater(first["error"], 2)
            self.assertEqual(first["structure"][0]["covariate"], "row*pan_rate")
            set_ = page.until(lambda: (now := page.state["set"])["rows"] and now)
            self.assertEqual((set_["kind"], set_["file"], set_["group"]), ("points", "points.csv", "frame"))
            self.assertIn({"name": "u_px", "unit": "px"}, [{k: c[k] for k in ("name", "unit")} for c in set_["columns"]])
            head, rows = page.table("rows?version=001")
            self.assertEqual(head["n"], set_["rows"])
            self.assertTrue({"line", "group", "held_out", "row", "pan_rate", "r:u_px", "s:v_px"} <= rows.keys())
            candidate = page.until(lambda: next((c for c in page.ask("search?version=001").json["candidates"]
                                                 if c["effect"] == "rolling_shutter"), None))
            self.assertLess(candidate["error"], 1.2)
            head, fitted = page.table("preview?version=001&effect=rolling_shutter")
            self.assertIn(head["how"], ("fit", "linear"))
            self.assertLess(sum(r * r for r in fitted["r:u_px"]), 0.1 * sum(r * r for r in rows["r:u_px"]))
            state = page.change("add", effect="rolling_shutter").json
            self.assertEqual(state["current"], "002")
            self.assertIn("seam add rolling_shutter", state["command"])
            self.assertAlmostEqual(page.looked_at("002")["error"], 1, delta=0.05)
            self.assertEqual(page.change("undo").json["current"], "001")
            self.assertEqual(page.change("redo").json["current"], "002")
            page.change("undo")
            state = page.change("add", effect="frame_latency").json  # A branch.
            self.assertEqual([(v["id"], v["parent"]) for v in state["versions"]],
                             [("001", None), ("002", "001"), ("003", "001")])
            formula = {"stage": "geometry", "name": "shift", "text": 'u: "u + k"\nparameters:\n  k: {neutral: 0}\n'}
            self.assertEqual(page.ask("formula/check", formula).json, {"ok": True, "parameters": ["k"]})
            wrong = page.ask("formula/check", {**formula, "text": 'u: "u + r3"\n'}).json
            self.assertIs(wrong["ok"], False)
            self.assertIn("unknown name 'r3', did you mean 'r2'", wrong["error"])
            page.change("goto", version="002")
            self.assertEqual(page.change("formula/fit", **formula).json["current"], "004")
            page.table("rows?version=004")
            page.change("note", version="004", note="an 'idea'\nto keep")
            self.assertEqual(page.change("leave-out", ranges=[[0, 2], [7, 7]], reason="blurred, all").json["current"], "005")
            left_out = page.state["left_out"]
            self.assertEqual(left_out, [{"ranges": [[0, 2], [7, 7]], "count": 4, "reason": "blurred; all"}])
            self.assertEqual((self.session / "left-out.csv").read_text(),
                             "row,reason\n2,blurred; all\n3,blurred; all\n4,blurred; all\n9,blurred; all\n")
            page.looked_at("005")
            head, rows = page.table("rows?version=005")
            self.assertEqual(head["n"], set_["rows"])
            self.assertEqual([i for i, out in enumerate(rows["left_out"]) if out], [0, 1, 2, 7])
            self.assertNotEqual(rows["r:u_px"][7], rows["r:u_px"][7])  # No value.
            page.change("fit")
            before = page.state
            # Nothing is free in it: its file has the values that the page shows.
            exported = page.ask("export?what=model&version=002")
            self.assertEqual(exported.content, (self.session / "versions/002.yaml").read_bytes())
            script = page.ask("script").content
        with self.page() as page:  # Another process: nothing is lost.
            after = page.state
            for key in ("revision", "current", "left_out", "selection"):
                self.assertEqual(after[key], before[key])
            self.assertEqual([(v["id"], v["name"], v["note"], v["command"]) for v in after["versions"]],
                             [(v["id"], v["name"], v["note"], v["command"]) for v in before["versions"]])
        self.repeats(script)

    def repeats(self, script):
        (self.folder / "again.sh").write_bytes(script)
        done = subprocess.run(["sh", "again.sh", "again"], cwd=self.folder, capture_output=True, text=True,
                              env=dict(os.environ, SEAM=str(SEAM)))
        self.assertEqual(done.returncode, 0, done.stderr)
        files = sorted(path.name for path in (self.session / "versions").iterdir())
        self.assertEqual(files, sorted(path.name for path in (self.folder / "again/versions").iterdir()))
        for name in ["left-out.csv", *(f"versions/{file}" for file in files)]:
            self.assertEqual((self.folder / "again" / name).read_bytes(), (self.session / name).read_bytes(), name)

    def test_two_tabs(self):
        with self.page() as page:
            page.table("rows?version=001")
            old = page.state["revision"]
            page.change("note", version="001", note="mine")
            late = page.ask("note", {"revision": old, "version": "001", "note": "theirs"})
            self.assertEqual((late.status, late.json["revision"]), (409, old + 1))
            self.assertEqual(page.version("001")["note"], "mine")
            page.ask("selection", {"ranges": [[1, 3]]}, method="PUT")
            self.assertEqual(page.state["selection"], [[1, 3]])

    def test_each_candidate_has_a_linear_preview_before_its_fit(self):
        done = subprocess.run([SEAM, "workbench", self.data, "--look", self.folder / "look", "--model", self.data / "nominal.yaml"],
                              capture_output=True, text=True, check=True, timeout=LIMIT_S)
        events = [json.loads(line) for line in done.stdout.splitlines()]
        name = "rolling_shutter"
        shown = [at for at, event in enumerate(events) if event["event"] == "preview" and event["effect"] == name]
        listed, *fitted = [at for at, event in enumerate(events) if event["event"] == "search"]
        self.assertEqual((len(shown), events[listed]["done"]), (2, 0))
        self.assertLess(listed, shown[0])  # The list by score, what a step leaves, the fits.
        self.assertLess(shown[0], fitted[0])
        tables = [decoded((self.folder / f"look/{how}-{name}.bin").read_bytes()) for how in ("step", "fit")]
        (step, by_step), (fit, by_fit) = tables
        self.assertEqual((step["how"], fit["how"]), ("linear", "fit"))
        self.assertAlmostEqual(step["error"], fit["error"], delta=0.1)
        value = {head["how"]: head["parameters"]["line_delay_s"]["value"] for head in (step, fit)}
        self.assertAlmostEqual(value["linear"], value["fit"], delta=0.02 * abs(value["fit"]))
        _, before = decoded((self.folder / "look/rows.bin").read_bytes())
        channels = ("u_px", "v_px", "radial_px", "tangential_px")
        self.assertLessEqual({f"s:{one}" for one in channels}, before.keys())
        self.assertEqual(by_step.keys(), {f"r:{one}" for one in channels})  # Stated errors are as before.
        _, scattered = decoded((self.folder / "look/fit-point_scatter.bin").read_bytes())
        self.assertNotEqual(scattered["s:u_px"], before["s:u_px"])
        apart, moved = (sum((a - b) ** 2 for a, b in zip(other["r:u_px"], by_fit["r:u_px"])) for other in (by_step, before))
        self.assertLess(apart, 0.05 ** 2 * moved)  # What is drawn.
        search = json.loads((self.folder / "look/search.json").read_text())
        self.assertEqual((search["prospects"], search["ended"]), ([], True))
        # A spread, a count of levels, another lens: no linear step foresees them.
        for name in ("frame_jitter", "point_scatter", "encoder_quantisation", "fisheye"):
            first, fit = (decoded((self.folder / f"look/{how}-{name}.bin").read_bytes())[0] for how in ("step", "fit"))
            self.assertEqual((first["how"], fit["how"]), ("first", "fit"), name)
            self.assertAlmostEqual(first["error"] / fit["error"], 1, delta=0.1, msg=name)

    def test_flat_fields_have_previews_before_fits(self):
        sample, data = SOURCE / "scenarios/samples/flats", self.folder / "flats"
        subprocess.run([SEAM, "measure", "--model", sample / "robot.yaml", "--protocol", sample, "--seed", "1", "--out", data],
                       check=True, capture_output=True)
        subprocess.run([SEAM, "workbench", data, "--look", self.folder / "look", "--model", sample / "nominal.yaml"],
                       capture_output=True, check=True, timeout=LIMIT_S)
        for name in ("vignetting", "pixel_gain_spread", "response_gamma"):
            first, fit = (decoded((self.folder / f"look/{how}-{name}.bin").read_bytes())[0] for how in ("step", "fit"))
            self.assertEqual((first["how"], fit["how"]), ("first", "fit"), name)
            self.assertAlmostEqual(first["error"] / fit["error"], 1, delta=0.3, msg=name)

    def test_a_bad_request_says_what_is_wrong(self):
        with self.page() as page:
            page.table("rows?version=001")
            revision = page.state["revision"]
            for what, content in (("add", b"{"), ("add", b"[]"), ("add", b"{}"), ("add", b"\xff\xfe"), ("cancel", b'"text"'),
                                  ("add", b'{"revision": "one", "effect": "rolling_shutter"}'),
                                  ("undo", b'{"revision": 1.5}'), ("undo", b'{"revision": -1}'),
                                  ("note", b'{"revision": 1e999, "version": "001", "note": ""}'),
                                  ("undo", b"[" * 1000 + b"]" * 1000), ("formula/check", b'{"stage": 1}'),
                                  ("plan", b'{"effects": "rolling_shutter"}'),
                                  ("plan", b'{"effects": ["--plugin=../dropped/evil.so"]}'),
                                  ("leave-out", b'{"revision": %d, "ranges": [[1]], "reason": "x"}' % revision),
                                  ("leave-out", b'{"revision": %d, "ranges": [[2, 1]], "reason": "x"}' % revision)):
                answer = page.ask(what, content=content, method="POST")
                self.assertEqual(answer.status, 400, (what, content, answer.content))
                self.assertTrue(answer.json["error"], what)
            for what in ("line?row=x", "line?row=99999999999", "export?what=nothing"):
                self.assertEqual(page.ask(what).status, 400, what)
            self.assertEqual(page.ask("selection", content=b'{"ranges": {}}', method="PUT").status, 400)
            self.assertEqual(page.state["revision"], revision)

    def test_the_session_as_an_archive(self):
        with self.page() as page:
            page.looked_at("001")
            page.change("add", effect="rolling_shutter")
            formula = {"stage": "geometry", "name": "shift", "text": 'u: "u + k"\nparameters:\n  k: {neutral: 0}\n'}
            page.change("formula/fit", **formula)
            page.until(lambda: page.ask("export?what=report").status == 200)
            packed = page.ask("export?what=session")
            self.assertIn("session.zip", packed.headers["Content-Disposition"])
            with zipfile.ZipFile(io.BytesIO(packed.content)) as archive:
                self.assertIsNone(archive.testzip())
                names = set(archive.namelist())
                kept = ["session.json", "left-out.csv", "versions/001.yaml", "versions/002.yaml", "versions/003.yaml",
                        "effects/003.yaml"]
                for name in kept:
                    self.assertEqual(archive.read(f"session/{name}"), (self.session / name).read_bytes())
                self.assertEqual(archive.read("session/session.sh"), page.ask("script").content)
                self.assertIn(b"<html", archive.read("session/reports/003.html"))
            self.assertLessEqual({f"session/{name}" for name in kept} | {"session/session.sh"}, names)

    def test_models_for_other_programs(self):
        with self.page() as page:
            page.looked_at("001")
            self.assertEqual([one["name"] for one in page.ask("formats").json["formats"]], ["opencv", "ros", "mrcal", "kalibr", "json"])
            for name, ending in (("opencv", "yaml"), ("mrcal", "cameramodel")):
                answer = page.ask("export", {"version": "001", "format": name, "drop": False})
                self.assertEqual(answer.status, 200, answer.content)
                self.assertEqual(answer.json["name"], f"{self.data.name}-001-{name}.{ending}")
                done = subprocess.run([SEAM, "export", self.session / "versions/001.yaml", "--to", name, "--data", self.data, "--out",
                                       self.folder / "file"], capture_output=True, text=True, check=True)
                self.assertEqual(answer.json["text"], (self.folder / "file").read_text(), done.stdout)
            page.change("add", effect="rolling_shutter")
            page.looked_at("002")
            wanted = {"version": "002", "format": "opencv", "drop": False}
            refused = page.ask("export", wanted)
            self.assertEqual(refused.status, 400)
            self.assertIn("cannot hold effect 'rolling_shutter'", refused.json["error"])
            dropped = page.ask("export", {**wanted, "drop": True}).json
            self.assertTrue(any("without rolling_shutter" in note for note in dropped["notes"]), dropped["notes"])
            for wrong in ({"format": "--plugin=x"}, {"version": "../001"}, {"drop": "yes"}):
                self.assertIn(page.ask("export", {**wanted, **wrong}).status, (400, 404), wrong)

    def test_an_export_has_the_values_that_the_page_shows(self):
        nominal = self.data / "nominal.yaml"
        nominal.write_text(nominal.read_text().replace("fx_px: 161.9", "fx_px: {value: 140, free: true}"))
        subprocess.run([SEAM, "fit", "--model", nominal, "--data", self.data, "--out", self.folder / "fitted.yaml"], check=True,
                       capture_output=True)
        fitted = self.focal_length((self.folder / "fitted.yaml").read_text())
        self.assertGreater(abs(fitted - 140), 5)
        with self.page() as page:
            page.looked_at("001")
            shown = self.focal_length(page.ask("export?what=model&version=001").content.decode())
            self.assertAlmostEqual(shown, fitted, delta=0.2)  # Rows that judge take no part in what is shown.
            camera = page.ask("export", {"version": "001", "format": "ros", "drop": False}).json["text"]
            self.assertAlmostEqual(float(re.search(r"data: \[([0-9.]+),", camera)[1]), shown, delta=0.001)

    @staticmethod
    def focal_length(model):
        return float(re.search(r"fx_px: \{value: ([0-9.]+)", model)[1])

    def test_a_formula_is_proposed(self):
        slipping = SOURCE / "docs/tutorial/slipping_robot.yaml"
        subprocess.run([SEAM, "measure", "--model", slipping, "--protocol", SOURCE / "docs/tutorial/room", "--seed", "2", "--out",
                        self.folder / "slips"], check=True, capture_output=True)
        subprocess.run([SEAM, "add", "rolling_shutter", "--model", self.data / "nominal.yaml", "--data", self.data, "--out",
                        self.folder / "slips/nominal.yaml"], check=True, capture_output=True)
        with self.page(self.folder / "slips", "--session", self.session) as page:
            self.assertIs(page.ask("suggest", {}).json["searched"], False)
            found = page.until(lambda: (now := page.ask("suggest", {}).json)["searched"] and now)
            proposal, = found["proposals"]
            self.assertEqual(proposal["stage"], "geometry")
            self.assertIn("* t", proposal["formula"])
            search = page.ask("search?version=001").json
            self.assertEqual(search["suggestion"]["text"], proposal["text"])
            self.assertIn("formula", page.version("001")["headline"])
            written = {key: proposal[key] for key in ("stage", "text")}
            self.assertIs(page.ask("formula/check", {**written, "name": "slips"}).json["ok"], True)
            page.change("formula/fit", **written, name="slips")
            self.assertAlmostEqual(page.looked_at("002")["error"], proposal["error"], delta=0.02)

    def test_events_number_and_resume(self):
        with self.page() as page:
            page.table("rows?version=001")
            page.ask("cancel", {})
            first = next(page.events())
            self.assertEqual(first["event"], "state")
            page.change("note", version="001", note="one")
            again = next(page.events(first["id"]))
            self.assertGreater(int(again["id"]), int(first["id"]))

    def test_an_event_says_that_a_look_has_ended(self):
        with self.page() as page:
            last_search = False
            for event in page.events():
                data = json.loads(event["data"])
                if event["event"] == "search":
                    last_search = data["progress"] is None
                elif event["event"] == "state" and (last_search or data["versions"][0]["looked"] == "yes"):
                    self.assertEqual(data["versions"][0]["looked"], "yes")
                    break

    def test_a_plan_says_how_far_it_is_and_can_be_cancelled(self):
        with self.page() as page:
            page.table("rows?version=001")
            page.ask("cancel", {})
            first = next(page.events())["id"]
            plan = page.ask("plan", {"effects": []}).json  # Of all effects: a second or more.
            whole = [one["effect"] for one in plan["not_planned"] if not one["parameter"]]
            planned = {one["effect"] for one in plan["effects"]}
            self.assertEqual((len(set(whole)), planned & set(whole)), (len(whole), set()))
            self.assertLessEqual({one["effect"] for one in plan["not_planned"] if one["parameter"]}, planned)
            said = []
            for event in page.events(first):
                data = json.loads(event["data"])
                if event["event"] == "job":
                    said.append(data)
                elif event["event"] == "state" and said and data["job"] is None:
                    first = event["id"]
                    break
            self.assertEqual({job["what"] for job in said}, {"plan"})
            counted = [job for job in said if job["doing"] == "planning: effects planned"]
            self.assertTrue(all(0 <= job["done"] <= job["of"] for job in said), said)
            self.assertTrue(any(job["done"] > 0 for job in counted), said)
            answers = []
            asking = threading.Thread(target=lambda: answers.append(page.ask("plan", {"effects": []})))
            asking.start()
            next(event for event in page.events(first) if event["event"] == "job")
            page.ask("cancel", {})
            asking.join()
            self.assertEqual(answers[0].status, 409, answers[0].content)
            self.assertIsNone(page.state["job"])

    def test_who_may_ask(self):
        with self.page(enter=False) as page:
            self.assertEqual(page.ask("state").status, 401)
            self.assertEqual(page.ask("enter", {"token": "0" * 64}).status, 401)
            self.assertEqual(page.ask("state", headers={"Cookie": "seam-1=" + page.token}).status, 401)
        with self.page() as page:
            self.assertEqual(page.ask("state").status, 200)
            self.assertEqual(page.ask("state", headers={"Host": "evil.example"}).status, 403)
            for origin in ("http://evil.example", "null", "http://127.0.0.1:1"):
                self.assertEqual(page.ask("cancel", {}, headers={"Origin": origin}).status, 403, origin)
            self.assertEqual(page.ask("state", headers={"Sec-Fetch-Site": "same-site"}).status, 403)
            self.assertEqual(page.ask("cancel", {}, headers={"Origin": page.address.rstrip("/")}).status, 200)
            policy = page.ask("state").headers["Content-Security-Policy"]
            self.assertIn("script-src 'self'", policy)
            self.assertNotIn("script-src 'self' 'unsafe-inline'", policy)

    def test_only_what_was_opened(self):
        other = self.folder / "other"
        shutil.copytree(self.made, other)
        with self.page() as page:
            self.assertEqual(page.ask("open", {"path": str(other)}).status, 403)
            for path in ("/../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "/api/preview?version=001&effect=../compare",
                         "/api/rows?version=../001", "/api/export?what=model&version=../../room/nominal"):
                answer = page.ask(path)
                self.assertIn(answer.status, (400, 404), path)
                self.assertNotIn(b"root:", answer.content)
            self.assertEqual(page.change("add", effect="../../room/nominal.yaml").status, 400)
            self.assertEqual(page.change("add", effect="--out").status, 400)
            body = (b'--b\r\nContent-Disposition: form-data; name="files"; filename="../../evil"\r\n\r\nx\r\n--b--\r\n')
            sent = page.ask("upload", content=body, headers={"Content-Type": "multipart/form-data; boundary=b"})
            self.assertEqual(sent.status, 400)
            self.assertFalse((self.folder.parent / "evil").exists())

    def test_samples_are_one_click_away(self):
        with self.page("--session", self.session) as page:
            samples = page.state["samples"]
            self.assertGreaterEqual(len(samples), 3)
            self.assertEqual(len({sample["kind"] for sample in samples}), len(samples))
            for sample in samples:
                state = page.ask("open", {"path": sample["path"]}).json
                self.assertEqual((state["set"]["kind"], state["set"]["title"]), (sample["kind"], sample["title"]))
                self.assertGreater(page.looked_at("001")["error"], 1.2)
            again = page.ask("open", {"path": samples[0]["path"]}).json
            self.assertEqual(again["set"]["kind"], samples[0]["kind"])
            self.assertEqual(len(list(self.folder.glob("sample-*"))), 2 * len(samples))  # Each with its session.
            self.assertEqual(page.ask("open", {"path": "sample:nonsense"}).status, 403)

    def drop(self, page, **files):
        """Files by their names, as a browser sends them."""
        parts = [f'--b\r\nContent-Disposition: form-data; name="files"; filename="{name.replace("__", ".")}"\r\n\r\n{text}\r\n'
                 for name, text in files.items()]
        return page.ask("upload", content=("".join(parts) + "--b--\r\n").encode(),
                        headers={"Content-Type": "multipart/form-data; boundary=b"})

    def test_dropped_files_are_imported(self):
        rows = [f"{0.01 * k:.2f},{(k // 7) % 3},{(k // 7) % 3 + 0.01 * (k % 2)}" for k in range(300)]
        with self.page("--session", self.session) as page:
            wrong = "\n".join(["time_s,goal,angle", *rows[:5], "0.05,x,1", *rows[6:]])
            taken = self.drop(page, swing__csv=wrong).json["import"]
            kinds = {kind["name"]: kind for kind in page.ask("imports").json["kinds"]}
            self.assertIn("map", kinds["servo"]["options"])
            given = {"dropped": taken["dropped"], "kind": "servo", "options": {"map": "command=goal,measured=angle", "unit": "deg"}}
            refused = page.ask("import", given)
            self.assertEqual(refused.status, 400)
            self.assertRegex(refused.json["error"], r"^swing\.csv:7: goal: found no number")
            self.assertIsNone(page.state["set"])
            self.assertEqual(page.ask("import", {**given, "options": {"out": "/tmp/evil"}}).status, 400)
            self.assertEqual(page.ask("import", {**given, "dropped": "dropped/../room"}).status, 400)
            self.assertEqual(page.ask("import", {**given, "kind": "--help"}).status, 400)
            taken = self.drop(page, swing__csv="\n".join(["time_s,goal,angle", *rows])).json["import"]
            self.assertEqual(taken["kind"], "servo")
            state = page.ask("import", {**given, "dropped": taken["dropped"]}).json
            self.assertEqual(state["set"]["kind"], "joints")
            self.assertTrue(state["set"]["folder"].endswith("set-swing"))
            self.assertIsNotNone(page.looked_at("001")["error"])

    def test_dropped_files_are_recognised(self):
        log = json.dumps({"entries": [{"timestamp": 0.0, "goal_position": 0.0, "position": 0.1}]})
        series = "# Measurement for EMVA1288 Standard Release 3.0\nv 3.0\nn 12 640 480\n"
        with self.page("--session", self.session) as page:
            for files, kind in (({"run__json": log}, "servo"), ({"Data__txt": series}, "emva1288"), ({"notes__txt": "buy milk"}, "")):
                self.assertEqual(self.drop(page, **files).json["import"]["kind"], kind)

    def test_pictures_of_a_set(self):
        """Only those in the set, or dropped on the page: a link of a foreign set may lead anywhere."""
        (self.data / "pictures").mkdir()
        (self.data / "pictures/1.png").write_bytes(b"a picture")
        with self.page() as page:
            answer = page.ask("picture?frame=1.png")
            self.assertEqual((answer.status, answer.content, answer.headers["Content-Type"]), (200, b"a picture", "image/png"))
            for frame in ("2.png", "../measurement.yaml", "../pictures/1.png", ""):
                self.assertEqual(page.ask(f"picture?frame={frame}").status, 404, frame)
            shutil.move(self.data / "pictures", self.folder / "elsewhere")
            (self.data / "pictures").symlink_to(self.folder / "elsewhere")
            self.assertEqual(page.ask("picture?frame=1.png").status, 404)
            shutil.move(self.folder / "elsewhere", self.folder / "dropped-7")
            (self.data / "pictures").unlink()
            (self.data / "pictures").symlink_to(self.folder / "dropped-7")
            self.assertEqual(page.ask("picture?frame=1.png").status, 200)

    def test_frames_of_a_camera(self):
        with self.page() as page:
            page.table("rows?version=001")
            sliders = page.ask("see?version=001").json["effects"]
            self.assertEqual(sliders[0]["name"], "pinhole")
            self.assertIn("rolling_shutter", [one["name"] for one in sliders if not one["in_model"]])

            def seen(changes, coarse=True):
                answer = page.ask("see", {"version": "001", "changes": changes, "head_rate_radps": 2.0, "coarse": coarse})
                self.assertEqual(answer.status, 200, answer.content)
                length, = struct.unpack_from("<I", answer.content)
                head = json.loads(answer.content[4:4 + length])
                pixels = answer.content[4 + length:]
                self.assertEqual(len(pixels), 3 * head["width_px"] * head["height_px"])
                return head, pixels

            fitted = page.looked_at("001")["effects"]["pinhole"]  # What is free is shown as it was fitted.
            for parameter in sliders[0]["parameters"]:
                self.assertEqual(parameter["value"], fitted[parameter["name"]]["value"])
            head, plain = seen({})
            self.assertEqual((head["width_px"], head["height_px"]), (178, 144))
            self.assertEqual(seen({"rolling_shutter": {"line_delay_s": 0}})[1], plain)
            slanted = seen({"rolling_shutter": {"line_delay_s": 2.4e-4}})[1]
            differing = [sum(a != b for a, b in zip(slanted[k:k + 534], plain[k:k + 534])) for k in range(0, len(plain), 534)]
            # Later rows are seen later: the first is the same, those below are shifted more and more.
            self.assertEqual(differing[0], 0)
            self.assertGreater(sum(differing[72:]), sum(differing[:72]))
            for changes in ({"nonsense": {}}, {"pinhole": {"nonsense": 1}}, {"pinhole": {"fx_px": -1}}, {"pinhole": {"fx_px": "x"}}):
                answer = page.ask("see", {"version": "001", "changes": changes, "head_rate_radps": 0, "coarse": True})
                self.assertEqual(answer.status, 400, changes)

    def test_names_are_text(self):
        text = (self.data / "measurement.yaml").read_text()
        title = next(line for line in text.splitlines() if line.startswith("title:"))
        (self.data / "measurement.yaml").write_text(text.replace(title, "title: <script>alert(1)</script>"))
        with self.page() as page:
            answer = page.ask("state")
            self.assertEqual(answer.json["set"]["title"], "<script>alert(1)</script>")
            self.assertEqual(answer.headers["Content-Type"], "application/json")
            self.assertEqual(answer.headers["X-Content-Type-Options"], "nosniff")

    def test_what_it_refuses_at_the_terminal(self):
        for arguments, said in ((["nowhere"], "nowhere"), ([self.folder], "measurement.yaml"),
                                ([self.data, "--model", "m.yaml"], "--look")):
            done = subprocess.run([SEAM, "workbench", *arguments], cwd=self.folder, capture_output=True, text=True,
                                  stdin=subprocess.DEVNULL, timeout=30)
            self.assertIn(done.returncode, (1, 2), done.stdout)
            self.assertIn(said, done.stderr)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
