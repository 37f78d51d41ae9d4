#!/usr/bin/env python3
"""Who may ask `seam view`: viewer_test.py SEAM SOURCE_DIR [unittest arguments]."""
import json
import subprocess
import sys
import unittest
import urllib.error
import urllib.request

import by_hand
from viewing import viewer

SEAM, SOURCE = by_hand.arguments("seam", "source")
LOG = SOURCE / "replays/match.mcap"


class Viewer(unittest.TestCase):
    def test_the_viewer_answers_only_who_has_its_token(self):
        with viewer(SEAM, LOG) as ask:
            self.assertEqual(ask("info")["format"], "seam-view/1")
            address, _, token = ask.address.partition("#token=")

            def status(path, data=None, **headers):
                request = urllib.request.Request(address + path, data, {name.replace("_", "-"): text for name, text in headers.items()})
                try:
                    with urllib.request.urlopen(request, timeout=60) as answer:
                        return answer.status, answer.headers
                except urllib.error.HTTPError as error:
                    with error:
                        return error.code, error.headers

            self.assertEqual(status("api/info")[0], 401)
            self.assertEqual(status("api/info", Cookie=f"seam-{address.split(':')[2][:-1]}={token}")[0], 401, "the token is no cookie")
            self.assertEqual(status("api/enter", json.dumps({"token": "0" * 64}).encode())[0], 401)
            code, headers = status("api/enter", json.dumps({"token": token}).encode())
            self.assertEqual(code, 200)
            self.assertRegex(headers["Set-Cookie"], "HttpOnly.*SameSite=Strict")
            cookie = headers["Set-Cookie"].split(";")[0]
            code, headers = status("api/info", Cookie=cookie)
            self.assertEqual(code, 200)
            self.assertRegex(headers["Content-Security-Policy"], "default-src 'none'; script-src 'self';")
            for wrong in ({"Host": "evil.example"}, {"Origin": "http://evil.example"}, {"Origin": "null"},
                          {"Sec_Fetch_Site": "same-site"}, {"Sec_Fetch_Site": "cross-site"}):
                self.assertEqual(status("api/info", Cookie=cookie, **wrong)[0], 403, wrong)
            # Each part would be in the answer, a thousand times all of it.
            many = "bytes=" + ",".join(["0-"] * 1000)
            for path in ("", "index.html", "api/info"):
                for headers in ({}, {"Cookie": cookie}):
                    code, said = status(path, Range=many, **headers)
                    self.assertEqual((code, said["Content-Length"]), (416, "0"), path)
            self.assertEqual(status("api/info", Cookie=cookie, Range="bytes=0-3")[0], 206)

    def test_no_number_is_no_time(self):
        for wrong in ("nan", "-nan", ""):
            done = subprocess.run([SEAM, "view", LOG, "--at", wrong], stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=60)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertRegex(done.stderr, f"--at: found '{wrong}', expected a number")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
