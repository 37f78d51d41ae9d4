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
    address = process.stdout.readline().strip()

    def ask(what, **query):
        with urllib.request.urlopen(f"{address}api/{what}?{urllib.parse.urlencode(query)}", timeout=60) as answer:
            content = answer.read()
            return json.loads(content) if answer.headers["Content-Type"] == "application/json" else content

    ask.address = address
    try:
        yield ask
    finally:
        process.kill()
        process.wait()
        process.stdout.close()
