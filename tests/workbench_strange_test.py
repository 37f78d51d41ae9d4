#!/usr/bin/env python3
"""`seam workbench`: sessions and requests as no page of ours makes them: a folder that goes away or is open twice, files that
changed since they were looked at, a session from somebody else, rows that nobody can choose.

Usage: workbench_meanwhile_test.py SEAM SOURCE_DIR [unittest arguments]
"""
import json
import os
import shutil
import sys
import threading
import unittest

from workbench_test import OfTheRoom as _OfTheRoom


class Strange(_OfTheRoom):
    def replace_by_a_file(self, folder):
        """Moved away in one step, since a folder that the server writes into cannot be emptied; where the server makes it
        anew before the file stands there, once more."""
        for n in range(100):
            folder.rename(folder.with_name(f"{folder.name}-{n}"))
            try:
                return folder.write_text("no folder\n")
            except IsADirectoryError:
                continue
        self.fail(f"{folder} is made again and again")

    def test_a_folder_that_goes_away(self):
        with self.page() as page:
            self.replace_by_a_file(self.session)  # While it is looked at, or just before.
            self.assertEqual(page.change("note", version="001", note="lost").status, 507)
            page.until(lambda: page.state["job"] is None)
            self.session.unlink()
            refused = page.change("note", version="001", note="lost")
            self.assertEqual(refused.status, 507)
            self.assertIn("001.yaml: is missing", refused.json["error"])
            self.assertFalse((self.session / "session.json").exists(), "a session without its models")

    def test_a_look_that_has_no_room(self):
        with self.page() as page:
            page.ask("cancel", {})
            page.until(lambda: page.state["job"] is None)
            shutil.rmtree(self.session / "cache", ignore_errors=True)
            (self.session / "cache").write_text("no folder\n")
            self.assertEqual(page.change("open", path=str(self.data)).status, 200)
            failed = page.until(lambda: (one := page.version("001"))["looked"] == "failed" and one)
            self.assertIn("cache", failed["trouble"])

    def test_rows_that_can_be_chosen(self):
        with self.page() as page:
            n, columns = page.table("rows?version=001")
            rows = n["n"]
            chosen = page.ask("selection", {"ranges": [[7, 9], [3, 4], [5, 5], [8, 12]]}, method="PUT")
            self.assertEqual(chosen.status, 200)
            self.assertEqual(page.state["selection"], [[3, 5], [7, 12]])
            for wrong in ([[0, rows]], [[-5, 2]], [[5, 2]], [[0, 1e300]], [[0, 1.5]], [[1]], ["a"], [[0, 0]] * 20001):
                refused = page.ask("selection", {"ranges": wrong}, method="PUT")
                self.assertEqual((refused.status, "ranges" in refused.json["error"]), (400, True), wrong[:3])
            self.assertEqual(page.state["selection"], [[3, 5], [7, 12]])

    def test_a_change_is_seen_while_it_is_computed(self):
        with self.page() as page:
            page.until(lambda: page.version("001")["looked"] == "running")
            seen = []
            watching = threading.Event()

            def watch():
                while not watching.is_set():
                    seen.append((page.state["job"] or {}).get("what", ""))

            watcher = threading.Thread(target=watch)
            watcher.start()
            self.assertEqual(page.change("add", effect="rolling_shutter").status, 200)
            watching.set()
            watcher.join()
            first = seen.index("add rolling_shutter")
            last = len(seen) - 1 - seen[::-1].index("add rolling_shutter")
            self.assertEqual(set(seen[first:last + 1]), {"add rolling_shutter"})
            self.assertGreater(last, first)

    def test_one_program_at_a_time(self):
        with self.page() as page:
            with self.assertRaisesRegex(AssertionError, "another workbench has this session open"):
                with self.page():
                    pass
            port = page.address.rstrip("/").rsplit(":", 1)[1]
            with self.assertRaisesRegex(AssertionError, f"--port {port}: cannot be had"):
                with self.page(self.data, "--session", self.folder / "another", "--port", port):
                    pass
            self.assertEqual(page.change("open", path=str(self.data)).status, 200)  # The same program may.
            self.assertEqual(page.change("note", version="001", note="kept").status, 200)
        with self.page() as page:
            self.assertEqual(page.version("001")["note"], "kept")

    def test_what_was_computed_of_other_files_is_computed_again(self):
        def error():
            with self.page() as page:
                return page.looked_at("001")["error"]

        first = error()
        self.assertEqual(error(), first)
        model = self.session / "versions/001.yaml"
        kept = model.read_text()
        model.write_text(kept.replace("fx_px: 161.9", "fx_px: 170"))
        self.assertNotEqual(model.read_text(), kept, "the test no longer changes the model")
        self.assertNotEqual(error(), first)
        model.write_text(kept)
        self.assertEqual(error(), first)
        points = self.data / "points.csv"
        lines = points.read_text().splitlines(keepends=True)
        points.write_text("".join(lines[:1 + len(lines) // 2]))
        with self.page() as page:
            head, _ = page.table("rows?version=001")
            self.assertEqual(head["n"], len(lines) // 2)

    def test_a_cache_that_is_damaged(self):
        with self.page() as page:
            page.looked_at("001")
            page.table("rows?version=001")
        for name, content in (("rows.bin", b""), ("search.json", b'{"ended": true, "candidates": 5'), ("compare.json", b"[]"),
                              ("diagnose.json", b'{"suggestion": {"yaml": 7}}')):
            (self.session / "cache/001" / name).write_bytes(content)
            with self.page() as page:
                self.assertGreater(page.looked_at("001")["error"], 1, name)
                self.assertGreater(page.table("rows?version=001")[0]["n"], 0)

    def test_a_session_from_somebody_else(self):
        secret = self.folder / "secret.txt"
        secret.write_text("effects: secret\n")
        with self.page() as page:
            page.table("rows?version=001")
            self.assertEqual(page.change("leave-out", ranges=[[0, 5]], reason="doubtful").status, 200)
            page.ask("cancel", {})
        file = self.session / "session.json"
        saved = json.loads(file.read_text())

        def refused(says, spoil):
            state = json.loads(json.dumps(saved))
            spoil(state)
            file.write_text(json.dumps(state))
            with self.assertRaisesRegex(AssertionError, says):
                with self.page():
                    pass

        second = saved["versions"][1]
        command = ["add", "rolling_shutter", "--plugin", "/tmp/evil.so", "--run-programs"]
        for says, change in (
                ("002.*expected 002|expected 003", {"versions": [*saved["versions"], second]}),
                ("parent: expected a version before it", {"versions": [saved["versions"][0], {**second, "parent": "002"}]}),
                ("command of the workbench itself", {"versions": [saved["versions"][0], {**second, "name": "x", "arguments": command}]}),
                ("expected add or fit", {"versions": [saved["versions"][0], {**second, "arguments": ["replay"]}]}),
                ("copied: expected", {"versions": [{**saved["versions"][0], "copied": str(secret)}], "current": "001"}),
                ("lines of observations", {"versions": [saved["versions"][0], {**second, "left_out": [
                    {"lines": [2 ** 40], "reason": "x"}]}]}),
                ("expected one line", {"versions": [saved["versions"][0], {**second, "left_out": [
                    {"lines": [2], "reason": "x\n7,y"}]}]}),
                ("revision: ", {"revision": -5}), ("revision: ", {"revision": 2 ** 64 - 1}),
                ("undone: ", {"undone": ["009"]}), ("current: ", {"current": "009"}), ("selection: ", {"selection": [[1]]}),
                ("of another kind of value", {"data": 5}), ("of another kind of value", {"versions": [7]}),
                ("format: ", {"format": [1]})):
            refused(says, lambda state: state.update(change))
        file.write_text(json.dumps(saved))
        for name in ("versions/002.yaml", "left-out.csv", "session.json", "cache"):
            path = self.session / name
            aside = path.rename(path.with_name("aside"))
            path.symlink_to(secret)
            with self.assertRaisesRegex(AssertionError, "leads out|outside|inside"):
                with self.page():
                    pass
            path.unlink()
            aside.rename(path)
        self.assertEqual(secret.read_text(), "effects: secret\n")
        with self.page() as page:
            self.assertEqual(page.state["current"], "002")

    def test_a_set_whose_model_is_a_link(self):
        (self.data / "nominal.yaml").unlink()
        (self.data / "nominal.yaml").symlink_to("/etc/hostname")
        with self.assertRaisesRegex(AssertionError, "nominal.yaml"):
            with self.page():
                pass
        self.assertFalse(self.session.exists())

    def test_the_folder_of_the_set_is_no_session(self):
        with self.assertRaisesRegex(AssertionError, "the folder of the set itself"):
            with self.page(self.data, "--session", self.data):
                pass

    def test_a_name_that_is_no_text(self):
        other = os.fsencode(self.folder) + b"/room\xff"
        shutil.copytree(os.fsencode(self.data), other)
        with self.assertRaisesRegex(AssertionError, "UTF-8"):
            with self.page(os.fsdecode(other), "--session", self.session):
                pass
        self.assertFalse(self.session.exists())


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
