#!/usr/bin/env python3
"""What the programs write: claimed before anything is computed, whole or not at all, never over an input.

Usage: outputs_test.py BUILD_DIR SOURCE_DIR CC [unittest arguments]
"""
import json
import os
import pathlib
import shutil
import signal
import socket
import stat
import subprocess
import sys
import tempfile
import time
import unittest

import by_hand
import one_robot

BUILD, SOURCE, CC = by_hand.arguments("build", "source", "cxx")
SEAM = BUILD / "seam"
LIMIT_S = 120

# The number of the thread of the C++ library that is refused, counted from 1, is in REFUSED_THREAD.
NO_THREADS = r"""
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
typedef int (*create)(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*);
int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*work)(void*), void* argument) {
  static int started;
  Dl_info caller;
  if (dladdr(__builtin_return_address(0), &caller) && strstr(caller.dli_fname, "libstdc++") &&
      ++started == atoi(getenv("REFUSED_THREAD")))
    return EAGAIN;
  return ((create)dlsym(RTLD_NEXT, "pthread_create"))(thread, attributes, work, argument);
}
"""


def seam(*arguments, **more):
    return subprocess.run([SEAM, *map(str, arguments)], capture_output=True, text=True, timeout=LIMIT_S, **more)


class Outputs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.shared = pathlib.Path(cls.folder.name)
        cls.scenario = cls.shared / "s.yaml"
        cls.scenario.write_text(one_robot.scenario(SOURCE, "outputs", 0.3))
        cls.long = cls.shared / "long.yaml"
        cls.long.write_text(one_robot.scenario(SOURCE, "outputs", 10000))
        cls.log = cls.shared / "run.mcap"
        done = seam("run", cls.scenario, "--log", cls.log, "--log-frames")
        assert done.returncode == 0, done.stderr

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def setUp(self):
        here = tempfile.TemporaryDirectory()
        self.addCleanup(here.cleanup)
        self.here = pathlib.Path(here.name)

    def refused(self, word, *arguments, code=1):
        done = seam(*arguments)
        self.assertEqual(done.returncode, code, (arguments, done.stderr))
        self.assertIn(word, done.stderr, arguments)
        self.assertNotIn("finished", done.stdout, "it was computed first")
        return done

    def start(self, *arguments, **more):
        process = subprocess.Popen([SEAM, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **more)
        self.addCleanup(lambda: (process.poll() is None and process.kill(), process.wait(), process.stdout.close(),
                                 process.stderr.close()))
        return process

    def test_a_path_that_cannot_be_written_is_told_before_the_computation(self):
        nowhere = self.here / "no" / "folder"
        for option in ("--json", "--log"):
            self.refused("cannot be written", "run", self.long, option, nowhere)
        (self.here / "file").write_text("")
        self.refused("cannot make this folder", "run", self.long, "--frames", self.here / "file")
        self.refused("cannot make this folder", "new-effect", "slip", "--stage", "geometry", "--out", self.here / "file")
        missing = ["--model", self.here / "no.yaml", "--data", self.here]
        for command in (["compare"], ["diagnose"], ["discover", "--out", self.here / "m"], ["fit", "--out", self.here / "m"]):
            self.refused(f"{nowhere}: cannot be written", *command, *missing, "--json", nowhere)
        for command in ("compare", "diagnose"):
            self.refused(f"{nowhere}: cannot be written", command, *missing, "--report", nowhere)
        self.refused(f"{nowhere}: cannot be written", "replay", "verify", self.log, "--json", nowhere)
        self.refused(f"{nowhere}: cannot be written", "study", "odometry", "--seeds", 1000, "--json", nowhere)
        self.assertEqual([path.name for path in self.here.iterdir()], ["file"])

    def test_devices_and_links_stay_what_they_are(self):
        device = self.here / "null"
        try:
            os.mknod(device, 0o666 | stat.S_IFCHR, os.makedev(1, 3))
            self.assertEqual(seam("replay", "show", self.log, "--json", device).returncode, 0)
            self.assertTrue(stat.S_ISCHR(device.stat().st_mode))
        except PermissionError:
            pass  # Only root makes devices, and only root could replace one.
        target, link = self.here / "target.json", self.here / "link.json"
        link.symlink_to("target.json")
        self.assertEqual(seam("replay", "show", self.log, "--json", link).returncode, 0)
        self.assertTrue(link.is_symlink())
        self.assertEqual(json.loads(target.read_text())["format"], "seam-show/1")
        fifo = self.here / "fifo"
        os.mkfifo(fifo)
        reader = subprocess.Popen(["cat", fifo], stdout=subprocess.PIPE)
        self.assertEqual(seam("replay", "show", self.log, "--json", fifo).returncode, 0)
        self.assertIn(b"seam-show/1", reader.communicate()[0])

    def test_a_full_disk_is_an_error(self):
        for arguments in (["run", self.scenario, "--json", "/dev/full"], ["run", self.scenario, "--log", "/dev/full"],
                          ["replay", "show", self.log, "--json", "/dev/full"]):
            done = seam(*arguments)
            self.assertEqual(done.returncode, 1, arguments)
            self.assertIn("No space left", done.stderr)
        with open("/dev/full", "w") as full:
            done = subprocess.run([SEAM, "effects"], stdout=full, stderr=subprocess.PIPE, text=True)
        self.assertEqual(done.returncode, 1)
        self.assertIn("standard output cannot be written", done.stderr)
        # A limit of a file's size acts as a full disk on files of a folder.
        limited = ["bash", "-c", 'trap "" XFSZ; ulimit -f "$1"; shift; exec "$@"', "limit"]
        done = subprocess.run([*limited, "1", SEAM, "replay", "export", self.log, "--out", self.here / "export"],
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertIn("File too large", done.stderr)
        # It is reported when it happens, not after ten thousand seconds.
        done = subprocess.run([*limited, "1", SEAM, "run", self.long, "--frames", self.here / "frames"],
                              capture_output=True, text=True, timeout=LIMIT_S)
        self.assertEqual(done.returncode, 1)
        self.assertIn("File too large", done.stderr)
        self.assertEqual([path.name for path in (self.here / "frames").glob("*.part")], [])

    def test_an_input_is_never_written(self):
        before = self.log.read_bytes()
        link = self.here / "link.mcap"
        link.symlink_to(self.log)
        (self.here / "hard.mcap").hardlink_to(self.log) if hasattr(pathlib.Path, "hardlink_to") else None
        others = [self.log.parent / "." / self.log.name, link, *self.here.glob("hard.mcap")]
        for other in map(str, others):
            for force in ([], ["--force"]):
                self.refused("the same file as", "replay", "resume", self.log, "--log", other, *force, code=2)
                self.refused("the same file as", "replay", "whatif", self.log, "--robot", "r0", "--client", "head_swing",
                             "--log", other, *force, code=2)
            for command in ("feed", "whatif"):
                self.refused("the same file as", "replay", command, self.log, "--robot", "r0", "--by-hand", other, code=2)
            self.refused("the same file as", "replay", "recover", self.log, "--out", other, code=2)
            self.refused("the same file as", "replay", "verify", self.log, "--json", other, code=2)
        self.refused("the same file as", "run", self.scenario, "--log", self.scenario, "--force", code=2)
        self.assertEqual(self.log.read_bytes(), before)
        own = self.here / "own.yaml"
        own.write_text("effects: {}\n")
        analysed = ["--model", SOURCE / "docs/tutorial/nominal.yaml", "--data", SOURCE / "docs/tutorial/room"]
        self.refused("the same file as", "add", own, *analysed, "--out", own, code=2)
        self.refused("the same file as", "diagnose", "--candidates", own, *analysed, "--suggest", own, code=2)
        self.assertEqual(own.read_text(), "effects: {}\n")
        # Nor are the tables of a set, nor its measurement.yaml.
        room = self.here / "room"
        shutil.copytree(SOURCE / "docs/tutorial/room", room)
        analysed[-1] = room
        for file in ("points.csv", "joints.csv", "measurement.yaml"):
            kept = (room / file).read_bytes()
            for option in ("--json", "--report", "--attitudes-out"):
                self.refused("the same file as", "compare", *analysed, option, room / file, code=2)
            self.refused("the same file as", "discover", *analysed, "--out", room / file, code=2)
            self.refused("the same file as", "export", analysed[1], "--to", "mrcal", "--data", room, "--out", room / file, code=2)
            self.assertEqual((room / file).read_bytes(), kept)
        # Nor the pictures that a table names, nor what measurement.yaml names elsewhere than under files.
        self.protocol()
        flats = self.here / "sets/flat_fields"
        (flats / "lamp.txt").write_text("of the laboratory\n")
        with (flats / "measurement.yaml").open("a") as settings:
            settings.write("apparatus: {papers: [lamp.txt]}\n")
        for file in ("frames/0003.png", "lamp.txt"):
            kept = (flats / file).read_bytes()
            self.refused("the same file as", "compare", "--model", SOURCE / "models/ers210_full.yaml", "--data", flats, "--json",
                         flats / file, code=2)
            self.assertEqual((flats / file).read_bytes(), kept)
        frames = self.here / "frames"
        self.assertEqual(seam("run", self.scenario, "--frames", frames).returncode, 0)
        picture = next(frames.glob("*.png"))
        kept = picture.read_bytes()
        self.refused("the same file as", "contact-sheet", frames, "--out", picture, code=2)
        self.assertEqual(picture.read_bytes(), kept)
        model = self.here / "model.yaml"
        shutil.copy(analysed[1], model)
        kept = model.read_bytes()
        self.refused("the same file as", "compare", "--models", model, model, "--data", room, "--report", model, code=2)
        self.refused("the same file as", "frame", self.scenario, "--robot", "r0", "--at", "0.1", "--model", model, "--out", model, code=2)
        self.refused("the same file as", "frame", self.scenario, "--robot", "r0", "--at", "0.1", "--model", f"r0={model}", "--out", model, code=2)
        self.assertEqual(model.read_bytes(), kept)

    def test_two_outputs_are_two_files(self):
        analysed = ["--model", SOURCE / "docs/tutorial/nominal.yaml", "--data", SOURCE / "docs/tutorial/room"]
        one = self.here / "one"
        self.refused("two outputs have this name", "compare", *analysed, "--json", one, "--report", self.here / "." / "one", code=2)
        self.refused("two outputs have this name", "discover", *analysed, "--json", one, "--out", one, code=2)
        self.assertFalse(one.exists())

    def test_an_earlier_run_is_overwritten_only_where_asked(self):
        log, frames = self.here / "l.mcap", self.here / "f"
        command = ["run", self.scenario, "--log", log, "--frames", frames]
        self.assertEqual(seam(*command).returncode, 0)
        self.assertRegex(seam("contact-sheet", frames, "--out", self.here / "sheet.png").stdout, r" frames of 1 run\n$")
        before = log.read_bytes()
        (frames / "r0_000099.png").write_text("of a longer run")
        self.refused("--force", "run", self.scenario, "--log", log)
        self.refused("--force", "run", self.scenario, "--frames", frames)
        self.assertEqual(log.read_bytes(), before)
        self.assertEqual(seam(*command, "--force").returncode, 0)
        self.assertEqual(log.read_bytes(), before)
        self.assertFalse((frames / "r0_000099.png").exists(), "frames of two runs in one folder")
        eyes = ["replay", "frames", log, "--robot", "r0", "--out", frames]
        self.refused("--force", *eyes)
        self.assertEqual(seam(*eyes, "--force").returncode, 0)

    def test_a_log_is_replaced_when_the_new_one_is_whole(self):
        log, part = self.here / "l.mcap", self.here / "l.mcap.part"
        log.write_bytes(self.log.read_bytes())
        log.chmod(0o640)
        before = log.read_bytes()
        run = self.start("run", self.long, "--log", log, "--force")
        while not (part.exists() and part.stat().st_size > 100_000):
            self.assertIsNone(run.poll())
            time.sleep(0.01)
        self.assertEqual(log.read_bytes(), before)
        self.refused("another run is writing", "run", self.scenario, "--log", log, "--force")
        run.kill()  # What it wrote stays beside the old log.
        run.wait()
        self.assertEqual(log.read_bytes(), before)
        self.assertEqual(seam("replay", "verify", part, "--no-frames").returncode, 0)
        limited = ["bash", "-c", 'trap "" XFSZ; ulimit -f "$1"; shift; exec "$@"', "limit"]
        failed = subprocess.run([*limited, "1", SEAM, "run", self.long, "--log", log, "--force"], capture_output=True, text=True,
                                timeout=LIMIT_S)
        self.assertEqual(failed.returncode, 1, failed.stderr)
        self.assertEqual(log.read_bytes(), before)
        self.assertFalse(part.exists())
        self.assertEqual(seam("run", self.scenario, "--log", log, "--force", "--seed", 5).returncode, 0)
        self.assertNotEqual(log.read_bytes(), before)
        self.assertEqual(sorted(path.name for path in self.here.iterdir()), ["l.mcap"])
        self.assertEqual(log.stat().st_mode & 0o777, 0o640)

    def protocol(self):
        """A small protocol of points."""
        done = seam("camera-calibrate", "--model", SOURCE / "models/ers210_full.yaml", "--out", self.here / "sets", "--frames", 4,
                    "--points", 20, "--levels", 1, "--repeats", 2)
        self.assertEqual(done.returncode, 0, done.stderr)
        return self.here / "sets/protocols/room"

    def test_a_set_is_overwritten_only_where_asked(self):
        protocol, made = self.protocol(), self.here / "made"
        command = ["measure", "--model", SOURCE / "models/ers210_full.yaml", "--protocol", protocol, "--out", made, "--seed"]
        self.assertEqual(seam(*command, 1).returncode, 0)
        before = {path.name: path.read_bytes() for path in made.iterdir()}
        self.refused("--force", *command, 2)
        self.assertEqual({path.name: path.read_bytes() for path in made.iterdir()}, before)
        (made / "notes.txt").write_text("mine")
        done = seam(*command, 2, "--force")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual({path.name for path in made.iterdir()}, {*before, "notes.txt"})
        self.assertNotEqual({path.name: path.read_bytes() for path in made.iterdir()}, before)
        self.refused("the protocol itself", "measure", "--model", SOURCE / "models/ers210_full.yaml", "--protocol", protocol, "--out",
                     protocol, "--force")
        self.assertEqual(sorted(path.name for path in self.here.iterdir()), ["made", "sets"])

    def test_a_signal_leaves_nothing_half_made(self):
        made = self.here / "sets"
        for sent in (signal.SIGINT, signal.SIGTERM):
            run = self.start("camera-calibrate", "--model", SOURCE / "models/ers210_full.yaml", "--out", made, "--frames", 4000,
                             preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
            while not (made / ".unfinished").exists():
                self.assertIsNone(run.poll())
                time.sleep(0.001)
            run.send_signal(sent)
            self.assertEqual(run.wait(LIMIT_S), -sent)
            self.assertEqual(list(made.iterdir()), [])

    def test_one_writer_a_log_and_one_server_a_socket(self):
        log, address = self.here / "l.mcap", f"unix:{self.here}/socket"
        serve = ["serve", self.long, "--listen", address]
        first = self.start(*serve, "--log", log)
        self.assertIn("listening", first.stdout.readline())
        self.refused("another run is writing", "run", self.scenario, "--log", log, "--force")
        self.refused("another server listens", *serve)
        first.kill()  # Its socket stays behind, and is distinguished from a live one.
        first.wait()
        self.assertTrue((self.here / "socket").is_socket())
        second = self.start(*serve)
        self.assertIn("listening", second.stdout.readline())
        second.terminate()
        self.assertEqual(second.wait(LIMIT_S), 0)
        (self.here / "socket").write_text("mine")
        self.refused("is no socket", *serve)
        for port in ("99999", "-1", "http", ""):
            self.refused("expected host:port", "serve", self.long, "--listen", f"127.0.0.1:{port}", code=2)

    def test_closed_standard_streams(self):
        """What would be printed does not land in a file that takes the place of a closed stream."""
        for closed in ((0,), (1,), (2,), (0, 1, 2)):
            log = self.here / f"{''.join(map(str, closed))}.mcap"
            redirections = " ".join(f"{stream}>&-" if stream else "0<&-" for stream in closed)
            done = subprocess.run(["bash", "-c", f'exec "$@" {redirections}', "bash", SEAM, "run", self.scenario, "--log", log,
                                   "--log-frames"], timeout=LIMIT_S)
            self.assertEqual(done.returncode, 0, closed)
            self.assertEqual(log.read_bytes(), self.log.read_bytes(), closed)

    def test_signals_end_a_run(self):
        for sent in (signal.SIGHUP, signal.SIGTERM):
            log = self.here / f"{sent}.mcap"
            run = self.start("run", self.long, "--log", log, preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_DFL))
            while not (log.exists() and log.stat().st_size > 100_000):
                self.assertIsNone(run.poll())
                time.sleep(0.01)
            run.send_signal(sent)
            self.assertEqual(run.wait(LIMIT_S), 0, sent)
            self.assertIn("stopped", run.stdout.read())
            self.assertEqual(seam("replay", "verify", log, "--no-frames").returncode, 0)
        # A log that waits for its reader does not outlive a wish to end.
        fifo = self.here / "fifo"
        os.mkfifo(fifo)
        run = self.start("run", self.scenario, "--log", fifo)
        time.sleep(0.3)
        run.terminate()
        self.assertEqual(run.wait(LIMIT_S), -signal.SIGTERM)

    def test_limits_of_the_system_are_errors(self):
        """Few open files, little memory: a message, and no process that is aborted."""
        refused = 0
        for limit, values in (("-n", (5, 6, 8, 12, 14, 16, 20, 26)), ("-v", (60_000, 150_000, 300_000, 400_000, 500_000, 600_000))):
            for value in values:
                done = subprocess.run(["bash", "-c", 'ulimit "$1" "$2"; shift 2; exec "$@"', "limit", limit, str(value), SEAM, "run",
                                       self.scenario], capture_output=True, text=True, timeout=LIMIT_S)
                self.assertIn(done.returncode, (0, 1), (limit, value, done.stderr))
                self.assertTrue(done.returncode == 0 or "seam: " in done.stderr, (limit, value, done.stderr))
                refused += done.returncode
        self.assertGreaterEqual(refused, 8)

    def test_a_thread_that_cannot_start_is_an_error(self):
        environment = one_robot.loaded_before(self.here, CC, NO_THREADS)
        refused = 0
        for number in range(1, 8):
            done = seam("run", self.scenario, "--log", self.here / "l.mcap", "--frames", self.here / f"f{number}", "--force",
                        "--render-threads", 2, env=environment(REFUSED_THREAD=number))
            self.assertIn(done.returncode, (0, 1), (number, done.stderr))
            refused += done.returncode
            self.assertEqual("cannot start a thread" in done.stderr, done.returncode == 1, done.stderr)
        self.assertGreaterEqual(refused, 4)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]], verbosity=2)
