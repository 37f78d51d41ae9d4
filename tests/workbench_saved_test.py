#!/usr/bin/env python3
"""`seam workbench`: what was shown as saved is there after whatever happens: the server is killed in the midst of a write, the
disk is full, two tabs write at once.

Usage: workbench_saved_test.py SEAM SOURCE_DIR [unittest arguments]
"""
import http.client
import json
import random
import resource
import shutil
import signal
import sys
import threading
import unittest

from workbench_test import OfTheRoom as _OfTheRoom

ROUNDS = 6          # A kill each, at another moment of a write.
FILE_LIMIT = 65536  # Bytes; no table of the room's rows fits, a session of a few steps does.


def full_disk():
    """No file of this process grows beyond the limit: a write fails there, as on a full disk."""
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (FILE_LIMIT, FILE_LIMIT))


class Saved(_OfTheRoom):
    def test_killed_in_the_midst_of_a_write(self):
        moment = random.Random(1)
        noted = 0
        for _ in range(ROUNDS):
            with self.page() as page:
                saved = page.version("001")["note"]
                self.assertIn(saved, ([""] if noted == 0 else [f"note {noted}", f"note {noted + 1}"]))
                noted = int(saved.split()[1]) if saved else 0
                page.ask("cancel", {})
                revision = page.state["revision"]
                stop = threading.Event()

                def kill():
                    stop.wait(moment.uniform(0.02, 0.15))
                    page.process.kill()

                killer = threading.Thread(target=kill)
                killer.start()
                try:
                    while True:
                        body = {"revision": revision, "version": "001", "note": f"note {noted + 1}"}
                        answer = page.ask("note", body)
                        if answer.status != 200:
                            self.fail(f"{answer.status}: {answer.content}")
                        revision, noted = answer.json["revision"], noted + 1
                except (OSError, http.client.HTTPException):  # It is gone: the last note may be there or not, those before are.
                    pass
                killer.join()
                page.end(signal.SIGKILL)
            json.loads((self.session / "session.json").read_text())
        self.assertGreater(noted, ROUNDS)

    def test_killed_while_an_effect_is_added(self):
        for after_s in (0.02, 0.1, 0.2, 0.4):
            with self.page() as page:
                page.looked_at("001")
                revision = page.state["revision"]
                adding = threading.Thread(target=self.add_until_killed, args=(page, revision))
                adding.start()
                adding.join(after_s)
                page.end(signal.SIGKILL)
                adding.join()
            with self.page() as page:  # All of the step, or nothing of it.
                state = page.state
                ids = [one["id"] for one in state["versions"]]
                self.assertIn((ids, state["current"], state["revision"]),
                              [(["001"], "001", revision), (["001", "002"], "002", revision + 1)])
                if len(ids) > 1:
                    break
                page.looked_at("001")
        if len(ids) == 1:
            with self.page() as page:
                page.looked_at("001")
                self.assertEqual(page.change("add", effect="rolling_shutter").json["current"], "002")
        with self.page() as page:
            self.assertAlmostEqual(page.looked_at("002")["error"], 1, delta=0.05)

    def add_until_killed(self, page, revision):
        try:
            page.ask("add", {"revision": revision, "effect": "rolling_shutter"})
        except (OSError, http.client.HTTPException):
            pass

    def test_a_full_disk(self):
        with self.page() as page:  # Begun while there was room.
            page.looked_at("001")
            page.change("note", version="001", note="kept")
            page.ask("cancel", {})
        kept = (self.session / "session.json").read_bytes()
        shutil.rmtree(self.session / "cache")
        with self.page(self.data, "--session", self.session, limits=full_disk) as page:
            failed = page.until(lambda: (one := page.version("001"))["looked"] == "failed" and one)
            self.assertIn("rows.bin", failed["trouble"])  # What cannot be shown is said.
            long = "x" * 9000
            refused = page.change("note", version="001", note=long)
            while refused.status == 200 and len((self.session / "session.json").read_bytes()) < FILE_LIMIT:
                refused = page.change("formula/fit", stage="geometry", name="shift",
                                      text=f'u: "u + k"\nparameters:\n  k: {{neutral: 0}}\n# {long}\n')
            self.assertEqual(refused.status, 507, refused.content)
            self.assertIn("not saved", refused.json["error"])
            before = page.state
            self.assertEqual(json.loads((self.session / "session.json").read_text())["revision"], before["revision"])
            self.assertEqual(page.change("note", version="001", note="short again").status, 200)
        self.assertNotEqual((self.session / "session.json").read_bytes(), kept)
        with self.page() as page:  # With room again, nothing is missing.
            self.assertEqual(page.version("001")["note"], "short again")
            self.assertEqual([one["id"] for one in page.state["versions"]], [one["id"] for one in before["versions"]])
            page.table("rows?version=001")

    def test_what_cannot_be_saved_is_said(self):
        with self.page() as page:
            page.table("rows?version=001")
            page.ask("cancel", {})
            saved = (self.session / "session.json").read_bytes()
            (self.session / "session.json").unlink()  # As a disk that takes nothing more: no file of that name can be made.
            (self.session / "session.json").mkdir()
            refused = page.change("note", version="001", note="lost")
            self.assertEqual(refused.status, 507)
            self.assertIn("not saved", refused.json["error"])
            self.assertEqual(page.version("001")["note"], "")
            (self.session / "session.json").rmdir()
            (self.session / "session.json").write_bytes(saved)
            self.assertEqual(page.change("note", version="001", note="kept").status, 200)

    def test_two_tabs_add_at_once(self):
        with self.page() as page:
            page.looked_at("001")
            revision = page.state["revision"]
            answers = []

            def add(effect):
                answers.append(page.ask("add", {"revision": revision, "effect": effect}))

            tabs = [threading.Thread(target=add, args=(effect,)) for effect in ("rolling_shutter", "frame_latency")]
            for tab in tabs:
                tab.start()
            for tab in tabs:
                tab.join()
            self.assertEqual(sorted(answer.status for answer in answers), [200, 409])
            late = next(answer for answer in answers if answer.status == 409)
            self.assertTrue(late.json["error"])
            state = page.state
            self.assertEqual([one["id"] for one in state["versions"]], ["001", "002"])
            again = page.ask("undo", {"revision": revision})  # A tab that has not read the new state.
            self.assertEqual((again.status, again.json["revision"]), (409, state["revision"]))
            self.assertEqual(page.state["current"], "002")

    def test_no_step_in_the_midst_of_a_step(self):
        with self.page() as page:
            page.table("rows?version=001")
            revision = page.state["revision"]
            answers = []
            adding = threading.Thread(target=lambda: answers.append(
                page.ask("add", {"revision": revision, "effect": "rolling_shutter"})))
            adding.start()
            while adding.is_alive():
                answers.append(page.ask("leave-out", {"revision": revision, "ranges": [[0, 5]], "reason": "pushed"}))
            adding.join()
            self.assertEqual([answer.status for answer in answers].count(200), 1, [a.content for a in answers])
            state = page.state
            self.assertEqual([one["id"] for one in state["versions"]], ["001", "002"])
            self.assertEqual(state["revision"], revision + 1)
        twice = json.loads((self.session / "session.json").read_text())
        twice["versions"].append(twice["versions"][1])
        (self.session / "session.json").write_text(json.dumps(twice))
        with self.assertRaisesRegex(AssertionError, "002: expected 003 as the id"):
            with self.page():
                pass

    def test_another_set_is_opened_while_one_is_looked_at(self):
        other = shutil.copytree(self.data, self.folder / "other")
        with self.page(self.data, other) as page:
            for folder in (other, self.data, other):
                self.assertEqual(page.ask("open", {"path": str(folder)}).status, 200)
                page.until(lambda: page.version("001")["looked"] in ("running", "yes"))
            page.table("rows?version=001")
            self.assertNotIn("cancelled", page.ask("search?version=001").json)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
