"""A log in the viewer, for tests that ask it (docs/reference/viewer_api.md)."""
import contextlib
import json
import subprocess
import urllib.parse
import urllib.request


@contextlib.contextmanager
def viewer(seam, log):
    """Gives a function: ask("series", robot="red1") is the answer, parsed where it is JSON, else as bytes; ask.address is
    that of the page."""
    process = subprocess.Popen([seam, "view", log], stdout=subprocess.PIPE, stdin=subprocess.DEVNULL, text=True)
    address, _, token = process.stdout.readline().strip().partition("#token=")
    with urllib.request.urlopen(f"{address}api/enter", json.dumps({"token": token}).encode(), timeout=60) as entered:
        cookie = entered.headers["Set-Cookie"].split(";")[0]

    def ask(what, **query):
        request = urllib.request.Request(f"{address}api/{what}?{urllib.parse.urlencode(query)}", headers={"Cookie": cookie})
        with urllib.request.urlopen(request, timeout=60) as answer:
            content = answer.read()
            return json.loads(content) if answer.headers["Content-Type"] == "application/json" else content

    ask.address = f"{address}#token={token}"
    try:
        yield ask
    finally:
        process.kill()
        process.wait()
        process.stdout.close()
