#!/usr/bin/env python3
"""Each program that a script, a test, CMake or CPack starts belongs to a package that scripts/dependencies.sh installs.

A developer's machine has programs that a bare Debian 12 has not, so that a forgotten package is noticed by strangers
alone. Programs are found in shell scripts (also those inside Python and C++), in lists that Python starts, in CMake files;
PACKAGE_OF says which package of Debian 12 each belongs to. Prints one line a finding; exit code 1 if there is any.
`--self-test` shows that each alarm works.
"""
import ast
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent

# Packages that each Debian has (Essential, or needed by one that is), and git, without which nobody has this checkout.
BARE = {"bash", "coreutils", "dash", "debianutils", "diffutils", "dpkg", "apt", "findutils", "git", "grep", "libc-bin", "mawk", "mount",
        "sed", "tar", "util-linux"}
# What a program starts in its turn, beside what it is asked to start.
STARTS = {
    "cmake": ["ninja", "c++", "ccache", "mold", "pkg-config", "protoc", "grpc_cpp_plugin", "grpc_python_plugin", "python3"],
    "cpack": ["file", "dpkg-shlibdeps", "strip", "ar", "tar"],  # Its generator DEB.
    "dpkg-shlibdeps": ["objdump"],
    "npm": ["node"],
    "npx": ["node"],
}
PACKAGE_OF = {
    "apt-config": "apt", "apt-get": "apt",
    "ar": "binutils", "objdump": "binutils", "strip": "binutils",
    "awk": "mawk",
    "bash": "bash", "sh": "dash",
    "c++": "g++", "g++": "g++",
    "c++filt": "binutils",
    "ccache": "ccache",
    "chroot": "coreutils",
    "clang++": "clang", "clang-format": "clang-format", "clang-tidy": "clang-tidy",
    "cmake": "cmake", "cpack": "cmake", "ctest": "cmake",
    "cmp": "diffutils", "diff": "diffutils",
    "debootstrap": "debootstrap",
    "dpkg-deb": "dpkg", "dpkg-query": "dpkg",
    "dpkg-shlibdeps": "dpkg-dev",
    "file": "file",
    "find": "findutils", "xargs": "findutils",
    "git": "git",
    "gnuplot": "gnuplot-nox",
    "grep": "grep",
    "grpc_cpp_plugin": "protobuf-compiler-grpc", "grpc_python_plugin": "protobuf-compiler-grpc",
    "ip": "iproute2",
    "ldd": "libc-bin",
    "mold": "mold",
    "mount": "mount",
    "ninja": "ninja-build",
    "node": "nodejs", "npm": "npm", "npx": "npm",
    "openssl": "openssl",
    "pkg-config": "pkgconf",
    "protoc": "protobuf-compiler",
    "python3": "python3-minimal",
    "qemu-x86_64": "qemu-user",
    "sed": "sed",
    "tar": "tar",
    "unshare": "util-linux",
    "which": "debianutils",
}
PACKAGE_OF |= dict.fromkeys(
    "basename cat chmod cp cut date dirname env false head id ln ls mkdir mktemp mv nproc paste pwd realpath rm seq sha256sum sleep sort "
    "tail tee test timeout touch tr true uname uniq wc yes".split(), "coreutils")
# Brought by a package of the list that exists to bring it.
BROUGHT_BY = {"g++": "build-essential", "dpkg-dev": "build-essential", "binutils": "build-essential",
              "pkgconf": "pkg-config", "python3-minimal": "python3"}
# What a machine may lack: its user says so and goes on, or asks for it.
OPTIONAL = {
    "debootstrap": "scripts/bare_machine.sh asks for it", "unshare": "scripts/bare_machine.sh asks for it",
    "gdb": "tests/debugging_test.py asks first", "man": "tests/install_test.py asks first", "zsh": "tests/install_test.py asks first",
    "munged": "tests/slurm_test.py asks first", "slurmctld": "tests/slurm_test.py asks first",
    "slurmd": "tests/slurm_test.py asks first", "sbatch": "tests/slurm_test.py asks first",
    "scancel": "tests/slurm_test.py asks first", "sacct": "tests/slurm_test.py asks first",
    "squeue": "tests/slurm_test.py asks first", "scontrol": "tests/slurm_test.py asks first",
    "sinfo": "tests/slurm_test.py asks first",
    "doxygen": "scripts/site.sh asks for it", "mkdocs": "scripts/site.sh asks for it",
    "snakemake": "tests/sweep_test.py asks first", "mrcal-calibrate-cameras": "scripts/camera_peers.py asks first",
}
# `seam` and its like: what the build makes, and names in examples that stand for a program of the reader's.
OWN = re.compile(r"^(seam.*|fuzz_.*|test_.*|golden_frames|vite)$")

KEYWORDS = set("""if then elif else fi for while until do done case esac in function select time coproc ! [ [[ ]] { } : . alias
    break cd command compgen complete continue declare echo eval exec exit export getopts hash help history jobs kill let local
    mapfile popd printf pushd read readonly return set shift shopt source suspend test times trap type ulimit umask unalias
    unset wait""".split())
# Words that stand before a program's name.
BEFORE = {"if", "then", "elif", "else", "while", "until", "do", "!", "exec", "command", "time", "{", "(", "sudo", "xargs", "env",
          "eval", "trap", "part", "check", "inside"}


def without_strings(line):
    """A line of shell without comments and the text in quotes, but with the commands that stand in $(...) there."""
    line = re.sub(r"'[^']*'", "Q", line)
    line = re.sub(r"(^|\s)#.*", "", line)
    line = re.sub(r'"((?:\\.|[^"\\])*)"', lambda text: "Q" + " ".join(f"$({inner})" for inner in
                                                                    re.findall(r"\$\(([^()]*)\)", text.group(1))), line)
    return line


def shell_programs(text):
    """The names of the programs that a piece of shell starts, by the place where they stand."""
    text = re.sub(r"\\\n", " ", text)
    text = re.sub(r"<<'?(\w+)'?\n.*?\n\1\n", "\n", text, flags=re.S)
    text = re.sub(r"\b[A-Za-z_]\w*\+?=\([^()]*\)", " ", text)  # lists
    functions = set(re.findall(r"^\s*([A-Za-z_]\w*)\(\)", text, flags=re.M))
    for line in text.splitlines():
        line = without_strings(line)
        line = re.sub(r"^\s*[^\s()]+\)\s", " ", line)  # a case's pattern
        for piece in re.split(r"\|\||&&|[|;]|\$\(|<\(|\)|(?<![>&\d])&(?![>\d])", line):
            words = piece.split()
            expected = True  # a program's name, after what may stand before one
            while words and expected:
                word = words.pop(0)
                if re.match(r"^[A-Za-z_]\w*\+?=", word) or word.startswith(("-", ">", "<", "2>")):
                    continue
                if word in BEFORE:
                    continue
                if word in ("for", "case", "select", "function", "local", "declare"):
                    break
                expected = False
                if word in KEYWORDS or word in functions:
                    continue
                if re.match(r"^[a-z][a-z0-9_.+-]*$", word) and not word.endswith((".sh", ".py")):
                    yield word


def strings(node):
    return [part.value for part in node.elts if isinstance(part, ast.Constant) and isinstance(part.value, str)]


# Functions of tests that start a program, by its name or by a list.
STARTERS = {"run", "Popen", "call", "check_call", "check_output", "which"}


def python_programs(text):
    """The names of the programs that a Python file starts: `subprocess.run(["git", ...])`, `run("cmake", ...)`, names of lists that
    begin with a program, shell scripts given to bash."""
    runs_any = "def run(*command" in text  # Elsewhere `run` starts the program under test.
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.List) and len(node.elts) > 1:
            first = node.elts[0]
            words = strings(node)
            if isinstance(first, ast.Constant) and first.value in PACKAGE_OF and PACKAGE_OF[first.value] not in BARE:
                yield first.value
            if words[:2] == ["bash", "-c"] and len(words) > 2:
                yield from shell_programs(words[2])
        if not isinstance(node, ast.Call) or not node.args:
            continue
        name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        first = node.args[0]
        if name not in STARTERS:
            continue
        if isinstance(first, (ast.List, ast.Tuple)) and first.elts:
            first = first.elts[0]
        elif name == "run" and not (runs_any and isinstance(node.func, ast.Name)):
            continue
        if isinstance(first, ast.Constant) and isinstance(first.value, str) and re.match(r"^[a-z][a-z0-9_.+-]*$", first.value):
            yield first.value


def cmake_programs(text):
    for name in re.findall(r"find_program\(\s*\w+\s+([a-z][\w.+-]*)", text):
        yield name
    for name in re.findall(r"\bCOMMAND\s+([a-z][\w.+-]*)(?![\w:])", text):
        yield name
    if re.search(r"include\(CPack\)", text):
        yield "cpack"


def cpp_programs(text):
    """Shell in a literal of a file that hands one to the shell."""
    if re.search(r"\b(popen|system)\(", text):
        for literal in re.findall(r'"((?:\\.|[^"\\\n])*)"', text):
            if re.search(r"&&|--parsable", literal):
                yield from shell_programs(literal)


def started(names):
    """{program: [files that start it]} of the files named."""
    found = {}
    for name in names:
        text = (ROOT / name).read_text(errors="replace")
        if name.endswith(".sh"):
            programs = shell_programs(text)
        elif name.endswith(".py"):
            programs = python_programs(text)
        elif name.endswith((".cmake", "CMakeLists.txt")):
            programs = cmake_programs(text)
        else:
            programs = cpp_programs(text)
        for program in programs:
            found.setdefault(program, []).append(name)
    pending = list(found)
    while pending:
        program = pending.pop()
        for child in STARTS.get(program, []):
            if child not in found:
                pending.append(child)
                found[child] = [f"{program} ({found[program][0]})"]
    return found


def packages_of(script):
    """What a script installs: its list of packages."""
    text = (ROOT / script).read_text()
    lists = re.findall(r"^packages=\((.*?)^\)", text, flags=re.S | re.M) + re.findall(r"for package in ([\w +.-]+);", text)
    return {word for words in lists for word in words.split()}


def findings(found, installed, installed_by_matrix):
    for program, users in sorted(found.items()):
        where = ", ".join(sorted(set(users))[:3])
        if OWN.match(program) or program in OPTIONAL:
            continue
        package = PACKAGE_OF.get(program)
        if package is None:
            yield f"{where}: starts '{program}': add it to PACKAGE_OF (or OPTIONAL) in tests/packages_test.py"
            continue
        of_matrix = all(user.startswith("scripts/") for user in users) and package in installed_by_matrix
        if package not in BARE and BROUGHT_BY.get(package, package) not in installed and not of_matrix:
            yield f"{where}: starts '{program}' of the package '{package}', which scripts/dependencies.sh does not install"


def wrong_packages():
    """Packages of the table that are here and do not hold their program."""
    if not shutil.which("dpkg-query"):
        return
    by_package = {}
    for program, package in PACKAGE_OF.items():
        by_package.setdefault(package, []).append(program)
    for package, programs in sorted(by_package.items()):
        listed = subprocess.run(["dpkg-query", "-L", package], capture_output=True, text=True)
        if listed.returncode == 0:
            held = {pathlib.PurePath(line).name for line in listed.stdout.splitlines() if "/bin/" in line or "/sbin/" in line}
            # Names that the system of alternatives, or another vendor's package, gives.
            held |= {"mawk": {"awk"}, "debianutils": {"which"}, "g++": {"c++"}, "gnuplot-nox": {"gnuplot"}, "nodejs": {"npm", "npx"}}.get(package, set())
            for program in programs:
                if program not in held:
                    yield f"tests/packages_test.py: PACKAGE_OF says that '{package}' holds '{program}', which it does not"


def files():
    listed = subprocess.run(["git", "-C", str(ROOT), "ls-files", "*.sh", "tests/*.py", "scripts/*.py", "*.cmake", "*CMakeLists.txt",
                             "tools/*.cc", "app/*.cc"], capture_output=True, text=True, check=True).stdout.split()
    return [name for name in listed if (ROOT / name).exists() and name != "tests/packages_test.py"]


def self_test():
    shell = ("set -e\nhere=$(dirname \"$0\")\nlist=(one two)\nfirst() { awk x; }\nif command -v fromcheck >/dev/null; then A=1 afterset; fi\n"
             "first | piped --x || orelse # not this\ncase $x in word) incase ;; esac\necho \"in text $(intext a)\" && 'quoted'\n")
    assert set(shell_programs(shell)) == {"dirname", "awk", "fromcheck", "afterset", "piped", "orelse", "incase", "intext"}, set(
        shell_programs(shell))
    python = "def run(*command): pass\nsubprocess.run(['bash', '-c', 'inner | sort'])\nrun('outer', 'x')\nshutil.which('asked')\nsubprocess.Popen([SEAM, 'no'])\n"
    assert set(python_programs(python)) == {"bash", "inner", "sort", "outer", "asked"}, set(python_programs(python))
    assert set(cmake_programs("find_program(X mold)\nCOMMAND node a\nCOMMAND ${Y} z\nCOMMAND protobuf::protoc")) == {"mold", "node"}
    assert set(cpp_programs('std::system("cd x && gnuplot y");')) == {"gnuplot"}
    found = started(files())
    ours, matrix = packages_of("scripts/dependencies.sh"), packages_of("scripts/matrix.sh")
    # Each package that a program of ours needs is missed when it is taken from the list.
    needed = {BROUGHT_BY.get(PACKAGE_OF[program], PACKAGE_OF[program]) for program in found if program in PACKAGE_OF} & ours - BARE
    assert {"file", "build-essential", "gnuplot-nox", "iproute2", "cmake", "ninja-build", "nodejs"} <= needed, needed
    for package in needed:
        assert list(findings(found, ours - {package}, matrix)), f"nobody misses {package}"
    assert any("nobody_has_it" in line for line in findings({"nobody_has_it": ["x.sh"]}, ours, matrix))
    print(f"each of {len(needed)} packages is missed when it is left out")


def main():
    if "--self-test" in sys.argv:
        return self_test()
    found = started(files())
    bad = [*findings(found, packages_of("scripts/dependencies.sh"), packages_of("scripts/matrix.sh")), *wrong_packages()]
    print("\n".join([*bad, f"{len(bad)} findings, {len(found)} programs"]))
    return 1 if bad or len(found) < 20 else 0


if __name__ == "__main__":
    sys.exit(main())
