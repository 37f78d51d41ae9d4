"""What tests of whole runs share: scenarios of one and of several robots, and a library that plays the system to a program."""
import os
import subprocess


def scenario(source, name, duration_s, *, camera=", every_frame: true", rate="200", options="", ball=""):
    """One robot that swings its head. `camera`: keys behind its model, or None: no camera."""
    lens = "" if camera is None else f"    camera: {{model: {source}/models/ers210.yaml{camera}}}\n"
    return (f"format: seam-scenario/1\nname: {name}\nduration_s: {duration_s}\nseed: 5\nfield: {source}/models/field_2002.yaml\n"
            f"{ball}robots:\n  - id: r0\n    team: red\n    pose: {{x_m: -0.9, y_m: 0.4, theta_rad: 0.3}}\n"
            f"    body: {source}/models/robot_ers210.yaml\n{lens}"
            f"    behaviour: {{command: [head_swing, --rate, '{rate}'{options}]}}\n")


def turns_of(source, name, *robots, duration_s=0.5, apart_m=1.0, camera_period_s=0.1, behaviour="", phases_s=(0,), more=""):
    """Robots with small frames and turns of 32 ms. `behaviour`: keys before its clock, whose phases the robots take in turn; `more`:
    lines of each robot. `ID` in it is its name."""
    text = f"format: seam-scenario/1\nname: {name}\nduration_s: {duration_s}\nseed: 5\nfield: {source}/models/field_2002.yaml\nrobots:\n"
    for number, robot in enumerate(robots):
        clock = f"{{period_s: 0.032, phase_s: {phases_s[number % len(phases_s)]}}}"
        text += (f"  - id: {robot}\n    team: red\n    pose: {{x_m: {apart_m * number - 0.9}, y_m: 0.4, theta_rad: 0.3}}\n"
                 f"    body: {source}/models/robot_ers210.yaml\n"
                 f"    camera: {{model: {source}/models/ers210.yaml, width_px: 44, height_px: 36, clock: {{period_s: {camera_period_s}}}}}\n"
                 f"    behaviour: {{{behaviour}clock: {clock}}}\n{more}").replace("ID", robot)
    return text


def loaded_before(folder, cc, code):
    """Compiles the code, in C, and returns a function that makes the environment of a program before which it is loaded."""
    source, library = folder / "system.c", folder / "system.so"
    source.write_text(code)
    subprocess.run([cc, "-x", "c", "-shared", "-fPIC", "-o", library, source, "-ldl"], check=True)
    return lambda **more: dict(os.environ, LD_PRELOAD=str(library), **{name: str(value) for name, value in more.items()})
