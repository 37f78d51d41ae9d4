#!/usr/bin/env python3
"""What `cmake --install` makes works where it is moved to: programs, behaviours, pages, packages for CMake, pkg-config and
pip, manual pages, completion. `install_test.py BUILD_DIR SOURCE_DIR PYTHON CXX [--deb]`

--deb: the packages of Debian as well, and that apt can resolve what they need.
"""
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import urllib.request

import by_hand

BUILD, SOURCE, PYTHON, CXX = by_hand.arguments("build", "source", "python", "cxx")
LIMIT_S = 280  # A hang is a failure.

BEHAVIOUR = """#include "robot_sdk/robot.h"
int main(int argc, char** argv) {
  seam::sdk::Robot robot(argc, argv);
  robot.on_observation([&](const seam::sdk::Observation&) { robot.head({.pan_rad = 0.2}); });
  return robot.run();
}
"""

PROJECT = """cmake_minimum_required(VERSION 3.25)
project(outside LANGUAGES CXX)
find_package(seam 0.3 CONFIG REQUIRED)
find_package(seam_sdk 0.3 CONFIG REQUIRED)
if(NOT EXISTS ${SEAM_PROGRAM})
  message(FATAL_ERROR "no program ${SEAM_PROGRAM}")
endif()
add_executable(watch watch.cc)
target_link_libraries(watch PRIVATE seam::sdk)
add_library(shear MODULE shear/shear.cc shear/plugin.cc)
target_link_libraries(shear PRIVATE seam::plugin)
set_target_properties(shear PROPERTIES PREFIX "")
"""

WATCH_PY = """#!{python}
from seam_sdk import Robot
robot = Robot()
for seen in robot.observations():
    robot.head(pan_rad=0.1)
"""


def run(*command, code=0, **others):
    # Nothing of this build may be found by the environment.
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("SEAM_", "PYTHON"))}
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, timeout=LIMIT_S,
                          env=environment, **others)
    if done.returncode != code:
        sys.exit(f"{' '.join(map(str, command))}: exit code {done.returncode}, expected {code}\n{done.stdout}{done.stderr}")
    return done.stdout + done.stderr


def scenario(models, command):
    return (f"format: seam-scenario/1\nname: outside\nduration_s: 0.3\nseed: 5\nfield: {models}/field_2002.yaml\n"
            f"robots:\n  - id: r0\n    team: red\n    pose: {{x_m: 0, y_m: 0.4, theta_rad: 0}}\n    body: {models}/robot_ers210.yaml\n"
            f"    camera: {{model: {models}/ers210.yaml}}\n    behaviour: {{command: [{command}]}}\n")


def installed(folder):
    """The tree, installed in one place and moved to another."""
    run("cmake", "--install", BUILD, "--prefix", folder / "first")
    prefix = folder / "moved" / "to here"
    prefix.parent.mkdir()
    (folder / "first").rename(prefix)
    return prefix


def check_texts(prefix):
    """All is there; no file for people, shells and build systems names where it was built or installed first."""
    share = prefix / "share/seam"
    for folder in ("models", "scenarios"):
        assert {path.name for path in (SOURCE / folder).glob("*.yaml")} <= {path.name for path in (share / folder).iterdir()}
    assert {path.name for path in (SOURCE / "docs/reference/schemas").iterdir()} <= {path.name for path in (share / "schemas").iterdir()}
    assert (prefix / "share/zsh/site-functions/_seam").exists() and any((prefix / "share/man/man1").iterdir())
    for path in prefix.rglob("*"):
        if path.suffix in (".cmake", ".pc", ".py", ".1", ".yaml", ".json", ".proto", ".h") and path.is_file():
            text = path.read_text()
            assert str(BUILD) not in text and str(prefix.parent.parent / "first") not in text, path
    if shutil.which("man"):
        page = run("man", "--warnings", "-P", "cat", "-l", prefix / "share/man/man1/seam-run.1")
        assert "--log TEXT" in page and "warning" not in page, page
    completion = prefix / "share/bash-completion/completions/seam"
    said = run("bash", "-c", f'source "{completion}"; COMP_WORDS=(seam run --rend); COMP_CWORD=2; _seam; echo ${{COMPREPLY[@]}};'
               'COMP_WORDS=(seam run --renderer o); COMP_CWORD=3; _seam; echo ${COMPREPLY[@]};'
               'COMP_WORDS=(seam replay ver); COMP_CWORD=2; _seam; echo ${COMPREPLY[@]}').splitlines()
    assert "--renderer" in said[0].split() and "--renderers" in said[0].split(), said
    assert said[1:] == ["opengl", "verify"], said
    if shutil.which("zsh"):
        run("zsh", "-n", prefix / "share/zsh/site-functions/_seam")


def check_program(prefix, folder):
    seam = prefix / "bin" / "seam"
    scenarios = prefix / "share/seam/scenarios"
    run(seam, "run", scenarios / "head_swing.yaml", "--set", "duration_s=0.3", "--log", folder / "run.mcap",
        "--renderers", "1", "--json", folder / "run.json", cwd=folder)
    assert json.loads((folder / "run.json").read_text())["end"] == "finished"
    run(seam, "replay", "verify", folder / "run.mcap")
    # The examples of the help, from a folder that holds none of these files.
    said = run(seam, "run", "scenarios/head_swing.yaml", "--set", "duration_s=0.1", cwd=folder)
    assert f"scenarios/head_swing.yaml is not here: {scenarios}" in said, said
    run(seam, "export", "models/ideal_camera.yaml", "--to", "opencv", "--out", folder / "lens.yaml", cwd=folder)
    assert "no_such.yaml" in run(seam, "run", "scenarios/no_such.yaml", cwd=folder, code=1)
    # A result's page has its plots, and the viewer its page.
    run(seam, "camera-calibrate", "--model", prefix / "share/seam/models/ers210_full.yaml", "--out", folder / "sets", "--frames",
        "4", "--points", "20", "--levels", "1", "--repeats", "2", cwd=folder)
    run(seam, "compare", "--model", prefix / "share/seam/models/ideal_camera.yaml", "--data", folder / "sets/room",
        "--json", folder / "c.json", cwd=folder)
    run(seam, "report", folder / "c.json", "--out", folder / "c.html", cwd=folder)
    if (BUILD / "share/seam/report.html").exists():
        assert "<script" in (folder / "c.html").read_text()
        viewer = subprocess.Popen([seam, "view", folder / "run.mcap"], stdout=subprocess.PIPE, text=True, cwd=folder)
        try:
            with urllib.request.urlopen(viewer.stdout.readline().strip(), timeout=30) as page:
                assert b"<script" in page.read()
        finally:
            viewer.kill()
            viewer.wait()
            viewer.stdout.close()


def check_outside_project(prefix, folder):
    """find_package, pkg-config and the template of an effect, against the moved tree alone."""
    project = folder / "project"
    project.mkdir()
    seam = prefix / "bin" / "seam"
    run(seam, "new-effect", "shear", "--stage", "geometry", "--out", project / "shear")
    template = (project / "shear/CMakeLists.txt").read_text()
    assert str(prefix / "include/seam") in template and str(SOURCE) not in template, template
    (project / "watch.cc").write_text(BEHAVIOUR)
    (project / "CMakeLists.txt").write_text(PROJECT)
    run("cmake", "-S", project, "-B", project / "build", f"-DCMAKE_PREFIX_PATH={prefix}", f"-DCMAKE_CXX_COMPILER={CXX}",
        "-DCMAKE_CXX_FLAGS=-O0")
    run("cmake", "--build", project / "build", "--parallel", "2")
    assert "shear (stage geometry)" in run(seam, "--plugin", project / "build/shear.so", "effects", "shear")
    # Programs are found beside the scenario that names them.
    models = prefix / "share/seam/models"
    (project / "watch.yaml").write_text(scenario(models, "./build/watch"))
    run(seam, "run", project / "watch.yaml", cwd=folder)
    paths = dict(os.environ, PKG_CONFIG_PATH=str(next(prefix.rglob("seam.pc")).parent))
    for name, header in (("seam", "effects/plugin.h"), ("seam_sdk", "robot_sdk/robot.h")):
        flags = subprocess.run(["pkg-config", "--cflags", name], env=paths, capture_output=True, text=True, check=True).stdout
        folders = re.findall(r"-I((?:\\.|\S)+)", flags)
        assert any((pathlib.Path(folder.replace("\\", "")) / header).exists() for folder in folders), (name, flags)
        version = subprocess.run(["pkg-config", "--modversion", name], env=paths, capture_output=True, text=True, check=True)
        said = run(seam, "--version").strip()
        assert re.fullmatch(rf"seam {re.escape(version.stdout.strip())}( \(commit [0-9a-f]+(-changed)?\))?", said), said
        assert said.removeprefix("seam ") == run(prefix / "bin/seam-render", "--version").strip().removeprefix("seam-render ")


def check_open_r(prefix, folder):
    """Programs for an AIBO, by open_r_add_object() and by `seam open-r build`, against the moved tree alone."""
    seam, examples = prefix / "bin" / "seam", SOURCE / "open_r/examples"
    project = folder / "open_r"
    shutil.copytree(examples / "localization", project)
    shutil.copytree(examples / "moving_head", project / "head")
    with (project / "CMakeLists.txt").open("a") as file:
        file.write("add_subdirectory(head)\n")
    (project / "head/CMakeLists.txt").write_text(
        "open_r_add_object(swing FILE SWINGHD.BIN STICK MS STUB SwingHead/stub.cfg SOURCES SwingHead/SwingHead.cc)\n")
    run("cmake", "-S", project, "-B", project / "build", f"-DCMAKE_PREFIX_PATH={prefix}", f"-DCMAKE_CXX_COMPILER={CXX}",
        "-DCMAKE_CXX_FLAGS=-O0")
    run("cmake", "--build", project / "build", "--parallel", "2")
    models = prefix / "share/seam/models"
    path = project / "run.yaml"
    for stick, said in (("build/MS", "Localizer: at "), ("build/head/MS", "SwingHead: sent commands for")):
        path.write_text(scenario(models, f"open_r, {project / stick}]").replace("]]", "], clock: {period_s: 0.008}"))
        assert said in run(seam, "run", path, cwd=folder)
    said = run(PYTHON, SOURCE / "scripts/open_r_table.py", seam, project / "build/MS", "--quick", cwd=folder)
    assert re.search(r"Paired difference.* [-+]\d+\.\d ± \d+\.\d mm \(95 %, 2 poses\)", said), said
    (project / "head/CMakeLists.txt").write_text("open_r_add_object(swing FILE swing.so SOURCES a.cc)\n")
    assert "expected the name in OBJECT.CFG" in run("cmake", project / "build", code=1)
    run(seam, "open-r", "build", examples / "moving_head", "--compiler", CXX, "--out", folder / "head", "--log",
        folder / "head.mcap", cwd=folder)
    run(seam, "replay", "verify", folder / "head.mcap")


def check_python(prefix, folder):
    """A behaviour in Python needs nothing but its first line; what cannot be started is named."""
    seam, models = prefix / "bin" / "seam", prefix / "share/seam/models"
    here = folder / "python"
    here.mkdir()
    path = here / "watch.yaml"
    path.write_text(scenario(models, "./watch.py"))
    program = here / "watch.py"
    assert "is not there" in run(seam, "run", path, code=1)
    program.write_text(WATCH_PY.format(python=PYTHON))
    assert "is not executable" in run(seam, "run", path, code=1)
    program.chmod(0o755)
    for text, fault in (("import seam_sdk\n", "has no #!"), ("", "has no #!"), ("#!/no/python\n", "'/no/python'")):
        program.write_text(text)
        assert fault in run(seam, "run", path, code=1)
    program.write_text(WATCH_PY.format(python=PYTHON))
    has_package = (prefix / "share/seam/python/seam_sdk").exists()
    if has_package:
        run(seam, "run", path, "--json", here / "run.json", cwd=folder)
        assert json.loads((here / "run.json").read_text())["decisions"] > 5
        path.write_text(scenario(models, "head_swing.py, --no-frames"))
        run(seam, "run", path, cwd=folder)
    bare = here / "bare.yaml"
    bare.write_text(scenario(models, "watch.py"))
    assert "write ./watch.py" in run(seam, "run", bare, code=1, cwd=here)
    if has_package and subprocess.run([PYTHON, "-m", "pip", "--version"], capture_output=True).returncode == 0:
        package = folder / "site"
        # An index that answers nobody: what pip takes from a network fails.
        run(PYTHON, "-m", "pip", "install", "--index-url", "http://127.0.0.1:9/", "--retries", "0", "--no-deps", "--target",
            package, SOURCE / "robot_sdk/python")
        run(PYTHON, "-c", f"import sys; sys.path.insert(0, {str(package)!r}); import seam_sdk; "
            f"assert seam_sdk.__file__.startswith({str(package)!r}); seam_sdk.Robot")


def check_debian_packages(folder):
    if not shutil.which("dpkg-shlibdeps") or not any(pathlib.Path("/var/lib/apt/lists").glob("*_Packages*")):
        print("skipped: no dpkg-shlibdeps, or apt knows no packages (apt-get update)")
        sys.exit(77)
    run("cpack", "-G", "DEB", "--config", BUILD / "CPackConfig.cmake", "-B", folder / "deb")
    packages = {path.name.split("_")[0]: path for path in (folder / "deb").glob("*.deb")}
    images = {"seam-images"} if (BUILD / "seam-pictures").exists() else set()
    assert set(packages) == {"seam", "libseam-sdk-dev", "python3-seam"} | images, packages
    needs = {name: run("dpkg-deb", "-f", path, "Depends") for name, path in packages.items()}
    for library in ("libgrpc++1", "libprotobuf", "libc6", "libyaml-cpp", "libbox2d"):
        assert library in needs["seam"], needs
    assert "opencv" not in needs["seam"], needs
    said = run("apt-get", "install", "--simulate", "--no-install-recommends", *packages.values())
    for name in packages:
        assert f"Inst {name} " in said, said
    run("dpkg-deb", "-x", packages["seam"], folder / "root")
    run(folder / "root/usr/bin/seam", "run", folder / "root/usr/share/seam/scenarios/head_swing.yaml", "--set",
        "duration_s=0.2")
    run("dpkg-deb", "-x", packages["python3-seam"], folder / "root")
    for module in ("seam_sdk/robot.py", "seam_gym/env.py"):
        assert (folder / "root/usr/lib/python3/dist-packages" / module).exists(), module


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        if "--deb" in sys.argv:
            return check_debian_packages(folder)
        prefix = installed(folder)
        check_texts(prefix)
        check_program(prefix, folder)
        check_outside_project(prefix, folder)
        check_open_r(prefix, folder)
        check_python(prefix, folder)


main()
