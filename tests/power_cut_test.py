#!/usr/bin/env python3
"""A power cut in a run with --durable: what was synced is there, verifies, and can be recovered.

A library that is loaded before the program plays the disk: of the files in a folder it keeps what was synced (content
by fsync of the file, names by fsync of the folder), and nothing else. It ends the program in the middle of a write.

Usage: power_cut_test.py BUILD_DIR SOURCE_DIR CC [unittest arguments]
"""
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import unittest

import by_hand
import one_robot

BUILD, SOURCE, CC = by_hand.arguments("build", "source", "cxx")
SEAM = BUILD / "seam"
LIMIT_S = 120

# VOLATILE: the folder whose files are on the disk only as far as they were synced; DISK: what the disk holds of them,
# inode-N (content) and name-F (the inode's number). CUT: the number of the write to such a file in whose middle the
# power goes, counted from 1; 0: never.
DISK_SHIM = r"""
#define _GNU_SOURCE
#include <dirent.h>
#include <dlfcn.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
typedef ssize_t (*write_call)(int, const void*, size_t);
static int is_volatile(int fd) {
  char link[64], path[PATH_MAX];
  const char* root = getenv("VOLATILE");
  snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
  const ssize_t length = readlink(link, path, sizeof path - 1);
  if (length < 0) return 0;
  path[length] = 0;
  return strncmp(path, root, strlen(root)) == 0;
}
static void keep(const char* kind, const char* name, const void* bytes, size_t size) {
  char path[PATH_MAX], temporary[PATH_MAX + 8];
  snprintf(path, sizeof path, "%s/%s-%s", getenv("DISK"), kind, name);
  snprintf(temporary, sizeof temporary, "%s.part", path);
  FILE* file = fopen(temporary, "wb");
  fwrite(bytes, 1, size, file);
  fclose(file);
  rename(temporary, path);
}
static void keep_content(int fd, ino_t inode, size_t size) {
  char link[64], name[32], *bytes = malloc(size + 1);
  snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
  snprintf(name, sizeof name, "%lu", (unsigned long)inode);
  const int reader = open(link, O_RDONLY);
  size_t got = 0;
  for (ssize_t part; got < size && (part = read(reader, bytes + got, size - got)) > 0;) got += part;
  close(reader);
  keep("inode", name, bytes, got);
  free(bytes);
}
static void keep_names(int fd) {
  DIR* folder = fdopendir(dup(fd));
  for (struct dirent* entry; (entry = readdir(folder));) {
    char number[32];
    if (entry->d_name[0] == '.') continue;
    keep("name", entry->d_name, number, (size_t)snprintf(number, sizeof number, "%lu", (unsigned long)entry->d_ino));
  }
  closedir(folder);
}
int fsync(int fd) {
  struct stat status;
  if (!is_volatile(fd) || fstat(fd, &status) != 0) return 0;
  if (S_ISDIR(status.st_mode)) keep_names(fd);
  if (S_ISREG(status.st_mode)) keep_content(fd, status.st_ino, (size_t)status.st_size);
  return 0;
}
int fdatasync(int fd) { return fsync(fd); }
ssize_t write(int fd, const void* bytes, size_t size) {
  static int writes;
  const write_call real = (write_call)dlsym(RTLD_NEXT, "write");
  if (!is_volatile(fd) || ++writes != atoi(getenv("CUT"))) return real(fd, bytes, size);
  real(fd, bytes, size / 2);
  raise(SIGKILL);
  return -1;
}
"""


class PowerCut(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.scratch.name).resolve()
        cls.scenario = cls.folder / "s.yaml"
        cls.scenario.write_text(one_robot.scenario(SOURCE, "power_cut", 6, camera=None, rate="2",
                                                   ball="ball: {x_m: 0.3, y_m: 0.2, vx_mps: 0.4}\n"))
        cls.environment = staticmethod(one_robot.loaded_before(cls.folder, CC, DISK_SHIM))

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    def run_and_cut(self, name, write, *options):
        """The log as the program left it, the log as the disk has it (None: not there), and the exit code."""
        volatile, disk = self.folder / f"{name}-volatile", self.folder / f"{name}-disk"
        volatile.mkdir()
        disk.mkdir()
        log = volatile / "run.mcap"
        done = subprocess.run([SEAM, "run", self.scenario, "--log", log, *options], capture_output=True, text=True, timeout=LIMIT_S,
                              env=self.environment(VOLATILE=volatile, DISK=disk, CUT=write))
        entry = disk / "name-run.mcap"
        if not entry.exists():
            return log, None, done.returncode
        left = self.folder / f"{name}.mcap"
        content = disk / f"inode-{entry.read_text()}"
        left.write_bytes(content.read_bytes() if content.exists() else b"")
        return log, left, done.returncode

    def seam(self, *arguments):
        return subprocess.run([SEAM, *map(str, arguments)], capture_output=True, text=True, timeout=LIMIT_S)

    def verified_s(self, log):
        done = self.seam("replay", "verify", log)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return float(re.search(r"([0-9.]+) s", done.stdout).group(1)), done.stdout

    def test_what_was_synced_verifies_after_the_cut(self):
        times = []
        # The first writes are the file's head: magic, definitions, attachment, header; then one is a chunk.
        for write in (22, 24, 26, 28):
            log, left, code = self.run_and_cut(f"cut-{write}", write, "--durable")
            self.assertEqual(code, -signal.SIGKILL, "the program ended before the power went")
            self.assertIsNotNone(left, "the log's name was not on the disk")
            written, kept = log.read_bytes(), left.read_bytes()
            self.assertEqual(written[:len(kept)], kept)
            self.assertGreater(len(written), len(kept), "half a chunk was written and not synced")
            verified, _ = self.verified_s(left)
            times.append(verified)
        self.assertEqual(times, sorted(set(times)), "each chunk that was synced can be verified")
        self.assertLessEqual(max(b - a for a, b in zip(times, times[1:])), 2 * 0.51)

    def test_zeros_where_the_data_did_not_come_through_are_told(self):
        log, left, _ = self.run_and_cut("zeros", 26, "--durable")
        kept = left.read_bytes()
        before, _ = self.verified_s(left)
        # File systems may keep the new length without the new data.
        left.write_bytes(kept + bytes(len(log.read_bytes()) - len(kept)))
        whole = self.folder / "zeros-whole.mcap"
        done = self.seam("replay", "recover", left, "--out", whole)
        self.assertIn(done.returncode, (0, 3), done.stderr)
        self.assertNotIn("nothing was lost", done.stdout)
        self.assertEqual(self.verified_s(whole)[0], before)

    def test_a_whole_run_is_on_the_disk_as_it_was_written(self):
        log, left, code = self.run_and_cut("whole", 0, "--durable")
        self.assertEqual(code, 0)
        self.assertEqual(log.read_bytes(), left.read_bytes())

    def test_without_the_option_the_cut_costs_the_log(self):
        """So the disk above is one that loses what was not synced."""
        _, left, code = self.run_and_cut("lost", 26)
        self.assertEqual(code, -signal.SIGKILL)
        self.assertIsNone(left)

    def test_the_option_needs_a_log(self):
        done = self.seam("run", self.scenario, "--durable")
        self.assertEqual(done.returncode, 2)
        self.assertIn("give --log too", done.stderr)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]])
