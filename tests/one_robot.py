"""What tests of whole runs share: a scenario of one robot, and a library that plays the system to a program."""
import os
import subprocess


def scenario(source, name, duration_s, *, camera=", every_frame: true", rate="200", options="", ball=""):
    """One robot that swings its head. `camera`: keys behind its model, or None: no camera."""
    lens = "" if camera is None else f"    camera: {{model: {source}/models/ers210.yaml{camera}}}\n"
    return (f"format: seam-scenario/1\nname: {name}\nduration_s: {duration_s}\nseed: 5\nfield: {source}/models/field_2002.yaml\n"
            f"{ball}robots:\n  - id: r0\n    team: red\n    pose: {{x_m: -0.9, y_m: 0.4, theta_rad: 0.3}}\n"
            f"    body: {source}/models/robot_ers210.yaml\n{lens}"
            f"    behaviour: {{command: [head_swing, --rate, '{rate}'{options}]}}\n")


def loaded_before(folder, cc, code):
    """Compiles the code, in C, and returns a function that makes the environment of a program before which it is loaded."""
    source, library = folder / "system.c", folder / "system.so"
    source.write_text(code)
    subprocess.run([cc, "-x", "c", "-shared", "-fPIC", "-o", library, source, "-ldl"], check=True)
    return lambda **more: dict(os.environ, LD_PRELOAD=str(library), **{name: str(value) for name, value in more.items()})
