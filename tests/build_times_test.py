#!/usr/bin/env python3
"""scripts/build_times.py finds what units and headers cost, in a small build made here: build_times_test.py"""
import pathlib
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))
import build_times  # noqa: E402

# As `ninja -t deps` prints it: a unit of a test reads a header by its precompiled one.
DEPS = """a/CMakeFiles/test_a.dir/x.cc.o: #deps 2, deps mtime 1 (VALID)
    ../a/x.h
    a/CMakeFiles/test_a.dir/pch.hxx.gch

a/CMakeFiles/test_a.dir/pch.hxx.gch: #deps 2, deps mtime 1 (VALID)
    ../base/heavy.h
    /usr/include/c++/12/string

b/CMakeFiles/seam_b.dir/y.cc.o: #deps 2, deps mtime 1 (VALID)
    ../base/heavy.h
    generated/z.h
"""


def main():
    with tempfile.TemporaryDirectory() as name:
        root = pathlib.Path(name)
        folder = root / "build"
        folder.mkdir()
        written = folder / "one.o"
        log = folder / build_times.COST
        code = build_times.launch(log, [sys.executable, "-c", "import sys; open(sys.argv[2], 'w').close(); sys.exit(3)", "-o", str(written)])
        assert code == 3 and written.exists(), "a compiler's exit code must be handed on"
        assert list(build_times.unit_seconds(folder)) == [str(written)], log.read_text()

        reads = build_times.headers_read(DEPS, folder, root)
        assert reads["a/CMakeFiles/test_a.dir/x.cc.o"] == {"a/x.h", "base/heavy.h"}, reads
        seconds = {"a/CMakeFiles/test_a.dir/x.cc.o": 4.0, "a/CMakeFiles/test_a.dir/pch.hxx.gch": 2.0, "b/CMakeFiles/seam_b.dir/y.cc.o": 6.0}
        assert build_times.header_costs(reads, seconds) == [(6.0, 3, "base/heavy.h"), (2.0, 1, "a/x.h")]
        assert [build_times.group_of(unit) for unit in reads] == ["tests", "tests", "program"]
        assert build_times.group_of("bench/CMakeFiles/bench_find.dir/find.perf.cc.o") == "benchmarks"

        log.unlink()
        (folder / ".ninja_log").write_text("# ninja log v5\n0\t1500\t1\tb/y.cc.o\tab\n0\t9\t1\tlibb.a\tab\n")
        assert build_times.unit_seconds(folder) == {"b/y.cc.o": 1.5}
    return 0


if __name__ == "__main__":
    sys.exit(main())
