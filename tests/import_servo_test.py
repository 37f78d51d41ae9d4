#!/usr/bin/env python3
"""`seam import servo` of logs with a habit of their own, made here with the truth known: joints that count the other way,
commands of 0 where the drive is off, commands and states in two files. `import_servo_test.py path/to/seam`"""
import json

import numpy as np

from importing import RNG, imported, refused, rows_of, run, run_tests, servo_log


def column(folder, name, **where):
    return np.array([float(r[name]) for r in rows_of(folder / "joints.csv") if all(r[k] == v for k, v in where.items())])


def lag_of(folder, out):
    run("add", "servo_lag", "--model", out / "nominal.yaml", "--data", out, "--out", folder / "lag.yaml", "--json",
        folder / "lag.json")
    return json.loads((folder / "lag.json").read_text())["parameters"]["tau_s"]


def table(path, header, *columns):
    path.write_text(header + "\n" + "".join(",".join(f"{x:.6f}" for x in row) + "\n" for row in zip(*columns)))
    return path


def test_reversed(folder):
    """Asked for, and right once the sign is given: as degrees, and as an encoder that counts down from a turn."""
    t, command, measured = servo_log()
    files = [table(folder / f"flip{k}.csv", "time,goal,present", t, command, -measured) for k in range(3)]
    named = ["--map", "command=goal,measured=present"]
    said = imported("servo", *files, *named, "--unit", "rad", out=folder / "asked")
    assert "does one of the two columns count the other way?" in said and "--reverse joint" in said, said
    assert "(3 runs)" in said and "exchanged" not in said, said
    assert "count the other way?" in run("check", folder / "asked")
    said = imported("servo", *files, *named, "--unit", "rad", "--reverse", "joint", out=folder / "given")
    assert "measured angles of joint with the other sign" in said and "warning" not in said, said
    assert np.allclose(column(folder / "given", "measured_rad", run="flip0"), measured, atol=1e-6)
    tau = lag_of(folder, folder / "given")
    assert abs(tau["value"] - 0.05) < 4 * tau["sigma"] + 1e-4, tau

    ticks = 4096 / (2 * np.pi)
    down = table(folder / "down.csv", "time,goal,present", t, 2048 + ticks * command, 2048 - ticks * measured)
    said = imported("servo", down, *named, "--unit", "ticks:4096", "--reverse", "joint", out=folder / "down")
    assert "whole turns added" in said, said
    assert np.allclose(column(folder / "down", "measured_rad") - np.pi, measured, atol=1e-4)
    # Of two joints one.
    two = table(folder / "two.csv", "time,arm_cmd,arm_pos,lift_cmd,lift_pos", t, command, measured, command, -measured)
    said = imported("servo", two, out=folder / "two")
    assert "--reverse lift" in said and "--reverse arm" not in said, said
    imported("servo", two, "--reverse", "lift", out=folder / "both")
    for joint in ("arm", "lift"):
        assert np.allclose(column(folder / "both", "measured_rad", joint=joint), measured, atol=1e-5)
    refused("servo", two, "--reverse", "lfit", out=folder / "none", words=["'lfit'", "did you mean 'lift'", "arm, lift"])


def test_stamps_with_their_unit(folder):
    t, command, measured = servo_log()
    log = table(folder / "stamps.csv", "stamp_ms,goal,angle", 1000 * t, command, measured)
    said = imported("servo", log, "--unit", "rad", out=folder / "stamps")
    assert "rad to rad" not in said, said
    assert np.allclose(column(folder / "stamps", "time_s"), t, atol=1e-6)
    # A pause is said with few digits, and no motor is followed through hours of it.
    t[200:] += 1e4
    log = table(folder / "pause.csv", "stamp_ms,goal,angle", 1000 * t, command, measured)
    said = imported("servo", log, "--unit", "rad", out=folder / "pause")
    assert "pause.csv:202: the clock jumps by 10000 s where 0.01 s are usual" in said, said
    motor = folder / "motor.yaml"
    motor.write_text("format: seam-model/1\neffects:\n  motor_servo: {stall_rad_per_s2: 300, back_emf_per_s: 20, gain: 4}\n")
    data, made = folder / "pause", folder / "made"
    for words in (("compare", "--data", data), ("diagnose", "--data", data), ("discover", "--data", data, "--out", made),
                  ("plan", "--protocol", data), ("measure", "--protocol", data, "--out", made)):
        said = run(*words, "--model", motor, code=1)
        assert "joints.csv:202: rows of one run are up to 1e+04 s apart" in said and "begin a new run" in said, (words, said)
    assert not made.exists()


def test_torques(folder):
    """By habit, by each joint's name, by the map; with the sign of the angles; blank where nothing is."""
    t, command, measured = servo_log()
    torque = np.round(np.sin(3 * t), 3)
    one = table(folder / "one.csv", "time,goal,present,effort", t, command, measured, torque)
    said = imported("servo", one, "--map", "command=goal,measured=present", "--unit", "rad", out=folder / "one")
    assert "effort_nm" in said, said
    assert np.allclose(column(folder / "one", "effort_nm"), torque, atol=1e-6)
    two = table(folder / "two.csv", "time,arm_cmd,arm_pos,arm_torque,lift_cmd,lift_pos,lift_torque", t, command, measured,
                torque, command, -measured, -2 * torque)
    imported("servo", two, "--reverse", "lift", out=folder / "two")
    assert np.allclose(column(folder / "two", "effort_nm", joint="arm"), torque, atol=1e-6)
    assert np.allclose(column(folder / "two", "effort_nm", joint="lift"), 2 * torque, atol=1e-6)
    mapped = table(folder / "mapped.csv", "time,goal,present,amperes", t, command, measured, torque)
    names = "command=goal,measured=present,effort="
    imported("servo", mapped, "--map", names + "amperes", "--unit", "rad", out=folder / "mapped")
    assert np.allclose(column(folder / "mapped", "effort_nm"), torque, atol=1e-6)
    refused("servo", mapped, "--map", names + "ampers", "--unit", "rad", out=folder / "none",
            words=["'ampers'", "--map effort", "did you mean 'amperes'"])


def test_words_for_numbers(folder):
    """What stands in a column of ours and is no number is refused, or said; nothing is dropped without a word."""
    t, command, measured = servo_log()
    torque = np.round(np.sin(3 * t), 3)
    names = ["--map", "command=goal,measured=present", "--unit", "rad"]
    whole = table(folder / "whole.csv", "time,goal,present,effort,kp", t, command, measured, torque, 8 + 0 * t).read_text().splitlines()

    def written(name, change):
        lines = [whole[0]] + [",".join(change(k, line.split(","))) for k, line in enumerate(whole[1:])]
        (folder / name).write_text("\n".join(lines) + "\n")
        return folder / name

    def replaced(column, text, rows):
        return lambda k, cells: cells[:column] + [text if k in rows else cells[column]] + cells[column + 1:]

    words = written("words.csv", replaced(3, "high", [5]))
    refused("servo", words, *names, out=folder / "none", words=["words.csv:7: effort: found 'high'", "a number or nothing"])
    gains = written("gains.csv", replaced(4, "eight", [0]))
    refused("servo", gains, *names, out=folder / "none", words=["gains.csv:2: kp: found 'eight'"])
    for name, text in (("nan.csv", "NaN"), ("blank.csv", "")):
        said = imported("servo", written(name, replaced(3, text, range(10, 40))), *names, out=folder / name[:-4])
        assert "30 of 400 rows have no number in column effort" in said, said
        assert [r["effort_nm"] == "" for r in rows_of(folder / name[:-4] / "joints.csv")] == [10 <= k < 40 for k in range(400)]
        said = imported("servo", written("all" + name, replaced(3, text, range(400))), *names, out=folder / f"all-{name[:-4]}")
        assert f"all{name}: column effort holds no number: left out" in said and "effort_nm" not in said, said
    none = written("none.csv", replaced(3, "off", range(400)))
    said = imported("servo", none, *names, out=folder / "off")
    assert "column effort holds no number ('off' in" in said and "none.csv:2): left out" in said, said
    refused("servo", none, "--map", "command=goal,measured=present,effort=effort", "--unit", "rad", out=folder / "no",
            words=["'effort'", "--map effort"])
    refused("servo", none, "--map", "command=goal,measured=present,kp=kq", "--unit", "rad", out=folder / "no",
            words=["signal 'kq' (--map kp=...) is missing", "did you mean 'kp'"])


def test_many_joints_and_odd_names(folder):
    """Hundreds of columns take seconds, not minutes; torques of some joints alone are said; a name of a file ends no cell."""
    t = np.arange(30) * 0.01
    lines = ["time," + ",".join(f"command_{i},position_{i}" for i in range(400))]
    lines += [f"{a:.2f}," + ",".join(f"{0.1 * np.sin(9 * a):.4f},{0.1 * np.sin(9 * a - 0.3):.4f}" for _ in range(400)) for a in t]
    many = folder / 'a,"b\nc.csv'
    many.write_text("\n".join(lines) + "\n")
    imported("servo", many, "--unit", "rad", out=folder / "many")
    rows = rows_of(folder / "many" / "joints.csv")
    assert len(rows) == 400 * 30 and {row["run"] for row in rows} == {"a__b_c"}, rows[0]
    samples = [{"time": a, "command": [np.sin(a), 0.5 * a], "position": [np.sin(a - 0.1), 0.5 * a - 0.1], "effort": [0.5, "x"]} for a in t]
    (folder / "some.json").write_text(json.dumps(samples))
    said = imported("servo", folder / "some.json", "--unit", "rad", out=folder / "some")
    assert "column effort has not one number for each of 2 joints: left out" in said, said


def test_off(folder):
    """A drive that is off in parts of a log, where its command reads 0 or nothing."""
    t, command, measured = servo_log()
    off = (np.arange(len(t)) % 100) > 70
    held = measured + 2
    for k in range(1, len(t)):
        held[k] = held[k - 1] if off[k] else held[k - 1] + (command[k] + 2 - held[k - 1]) * (1 - np.exp(-0.01 / 0.05))
    held += 1e-4 * RNG.standard_normal(len(t))
    log = table(folder / "off.csv", "time,command,position", t, np.where(off, 0, command + 2), held)
    said = imported("servo", log, out=folder / "asked")
    assert f"command_rad is 0 in {off.sum()} rows" in said and "was the drive off there?" in said, said
    assert "lines 73-101, 173-201" in said and "--off-where command=0" in said, said
    said = imported("servo", log, "--off-where", "command=0", out=folder / "marked")
    assert f"torque_enable 0 in {off.sum()} rows of {len(t)}" in said and "warning" not in said, said
    assert np.array_equal(column(folder / "marked", "torque_enable"), 1 - off)
    # No command at all there, by another column, and beside a column that marks other rows.
    lines = log.read_text().splitlines()
    blank = [lines[0]] + [",".join([a.split(",")[0], "" if o else a.split(",")[1], a.split(",")[2]])
                          for a, o in zip(lines[1:], off)]
    (folder / "blank.csv").write_text("\n".join(blank) + "\n")
    refused("servo", folder / "blank.csv", out=folder / "none", words=["blank.csv:73", "finite"])
    imported("servo", folder / "blank.csv", "--off-where", "command=none", out=folder / "blank")
    assert np.array_equal(column(folder / "blank", "torque_enable"), 1 - off)
    table(folder / "mode.csv", "time,command,position,mode,torque_enable", t, command, measured, 3 * off, t > 1)
    imported("servo", folder / "mode.csv", "--off-where", "mode=3", out=folder / "mode")
    assert np.array_equal(column(folder / "mode", "torque_enable"), (t > 1) & ~off)
    refused("servo", log, "--off-where", "mode=3", out=folder / "none", words=["'mode' (--off-where) is missing"])
    refused("servo", log, "--off-where", "command", out=folder / "none", words=["SIGNAL=NUMBER"], code=2)


def two_joints():
    """Commands and angles of two joints, logged by two processes at times of their own; the command of each state row."""
    t, command, measured = servo_log()
    asked, seen = t + 0.002 * RNG.random(len(t)), t + 0.0025 + 0.002 * RNG.random(len(t))
    command, measured = np.stack([command, -0.5 * command], 1), np.stack([measured, -0.5 * measured], 1)
    before = np.searchsorted(asked, seen, side="right") - 1
    return asked, command, seen, measured, command[before]


def lists(path, header, times, rows, before="", separator=", ", behind=None):
    path.parent.mkdir(exist_ok=True)
    lines = [header]
    for k, (t, row) in enumerate(zip(times, rows)):
        tail = "" if behind is None else "," + behind(k)
        lines.append(f'{before}{1e6 * t:.0f},"[{separator.join(f"{x:.6f}" for x in row)}]"{tail}')
    path.write_text("\n".join(lines) + "\n")
    return path


def check_pair(out, measured, command, joints):
    for i, joint in enumerate(joints):
        assert np.allclose(column(out, "measured_rad", joint=joint), measured[:, i], atol=1e-5), joint
        assert np.allclose(column(out, "command_rad", joint=joint), command[:, i], atol=1e-5), joint


def test_two_files(folder):
    """A file of commands and one of states: lists in cells by place and by name, columns by joint, several runs."""
    asked, command, seen, measured, expected = two_joints()
    units = ["--unit", "rad", "--time-unit", "us"]
    pair = [lists(folder / "control.csv", "type,timestamp,positions", asked, command, "Control,"),
            lists(folder / "state_motor.csv", "type,timestamp,positions,currents", seen, measured, "StateMotor,",
                  behind=lambda k: '"[0.1, 0.2]"')]
    for order in (pair, pair[::-1]):
        out = folder / order[0].stem
        said = imported("servo", *order, *units, out=out)
        assert "commands and states of 1 pairs of files joined by time" in said and "warning" not in said, said
        check_pair(out, measured, expected, ["joint0", "joint1"])
    tau = lag_of(folder, folder / "control")
    assert abs(tau["value"] - 0.05) < 0.004, tau
    # States before the first command have none, and are counted.
    late = lists(folder / "late" / "control.csv", "timestamp,positions", asked[100:], command[100:])
    said = imported("servo", late, pair[1], *units, "--map",
                    f"command={late}:positions,measured=state_motor.csv:positions", out=folder / "cut")
    first = int(np.searchsorted(seen, asked[100]))
    assert f"{first} of {len(seen)} states stand before the first command" in said, said
    check_pair(folder / "cut", measured[first:], expected[first:], ["joint0", "joint1"])
    # Names of joints in a column, in another order in each file, and from row to row.
    named = [lists(folder / "n" / "commands.csv", "timestamp,goal,names", asked, command[:, ::-1], separator=" ",
                   behind=lambda k: '"[\'lift\', \'arm\']"'),
             lists(folder / "n" / "states.csv", "timestamp,angles,names", seen,
                   np.where((np.arange(len(seen)) % 2 == 1)[:, None], measured[:, ::-1], measured),
                   behind=lambda k: '"[""lift"", ""arm""]"' if k % 2 else '"[""arm"", ""lift""]"')]
    imported("servo", *named, *units, out=folder / "named")
    check_pair(folder / "named", measured, expected, ["arm", "lift"])
    # A column a joint, in two runs, separated by folders.
    files = []
    for k in range(2):
        (folder / f"run{k}").mkdir()
        files.append(table(folder / f"run{k}" / "targets.csv", "t,arm,lift", asked, *((1 + k) * command.T)))
        files.append(table(folder / f"run{k}" / "joint_states.csv", "t,arm,lift,arm_velocity", seen, *((1 + k) * measured.T), seen))
    said = imported("servo", *files, out=folder / "runs")
    for k in range(2):
        for i, joint in enumerate(("arm", "lift")):
            got = column(folder / "runs", "measured_rad", run=f"run{k}-joint_states", joint=joint)
            assert np.allclose(got, (1 + k) * measured[:, i], atol=1e-5), (k, joint)
    refused("servo", files[1], files[3], out=folder / "none", words=["run0/joint_states.csv (states)", "no pairs"])
    far = lists(folder / "far" / "control.csv", "timestamp,positions", asked + 1000, command)
    refused("servo", far, pair[1], *units, "--map", f"command={far}:positions,measured=state_motor.csv:positions",
            out=folder / "none", words=["do not overlap in time"])
    one = lists(folder / "one" / "control.csv", "timestamp,positions", asked, command[:, :1])
    refused("servo", one, folder / "state_motor.csv", *units, "--map",
            f"command={one}:positions,measured=state_motor.csv:positions", out=folder / "none", words=["1 commands", "2 angles"])
    ragged = pair[0].read_text().replace("]", ", 1]", 9).replace(", 1]", "]", 8)
    (folder / "control.csv").write_text(ragged)
    refused("servo", *pair, *units, out=folder / "none", words=["control.csv:10", "a list of 2 items"])


def test_episodes(folder):
    """Episodes of a learning robot as JSON Lines, and as the Parquet file that is to be converted."""
    t, command, measured = servo_log()
    lines = [json.dumps({"action": [c, 2 * c], "observation.state": [m, 2 * m], "timestamp": a, "frame_index": k,
                         "episode_index": e}) for e in range(2) for k, (a, c, m) in enumerate(zip(t, command, measured))]
    (folder / "episodes.jsonl").write_text("\n".join(lines) + "\n")
    imported("servo", folder / "episodes.jsonl", "--unit", "rad", out=folder / "out")
    for episode in ("0", "1"):
        assert np.allclose(column(folder / "out", "measured_rad", run=episode, joint="joint1"), 2 * measured, atol=1e-12)
    (folder / "episode_000000.parquet").write_bytes(b"PAR1" + bytes(100) + b"PAR1")
    refused("servo", folder / "episode_000000.parquet", out=folder / "none",
            words=["Parquet", "pandas.read_parquet", "lines=True"])
    # Names of the joints from the data set's own file; what has no command is left out.
    lines = [json.dumps({"action": [c, 2 * c], "observation.state": [m, 2 * m], "timestamp": a, "frame_index": k, "index": k,
                         "next.done": False, "episode_index": 0}) for k, (a, c, m) in enumerate(zip(t, command, measured))]
    (folder / "episodes.jsonl").write_text("\n".join(lines) + "\n")
    features = {"action": {"names": ["lift.pos", "arm.pos"]}, "observation.state": {"names": {"motors": ["lift.pos", "arm.pos"]}},
                "timestamp": {"names": None}}
    (folder / "info.json").write_text(json.dumps({"codebase_version": "v2.1", "features": features}))
    imported("servo", folder / "episodes.jsonl", folder / "info.json", "--unit", "rad", out=folder / "named")
    assert np.allclose(column(folder / "named", "measured_rad", joint="arm"), 2 * measured, atol=1e-12)
    assert list(rows_of(folder / "named" / "joints.csv")[0]) == ["run", "time_s", "joint", "command_rad", "measured_rad"]
    refused("servo", folder / "info.json", out=folder / "none", words=["info.json", "expected the episodes beside it"])
    features["action"]["names"] = ["lift.pos"]
    (folder / "info.json").write_text(json.dumps({"features": features}))
    refused("servo", folder / "episodes.jsonl", folder / "info.json", out=folder / "none", words=["action has 2 numbers", "names: 1"])
    (folder / "info.json").write_text("{}")
    refused("servo", folder / "episodes.jsonl", folder / "info.json", out=folder / "none", words=["info.json: features: missing"])


def test_arrays(folder):
    """Logs as numpy saves them: MuJoCo's time, qpos and ctrl, packed or not, with what does not belong to them."""
    t, command, measured = servo_log()
    q, u = np.stack([measured, -0.5 * measured], 1), np.stack([command, -0.5 * command], 1)
    for save, name in ((np.savez, "plain"), (np.savez_compressed, "packed")):
        save(folder / f"{name}.npz", time=t, qpos=q, ctrl=u.astype(np.float64), qvel=0 * q, frames=np.zeros((len(t), 4, 4, 3), np.uint8),
             timestep=0.002, note="a log", joint_names=np.array(["arm", "lift"]))
        imported("servo", folder / f"{name}.npz", "--unit", "rad", out=folder / name)
        check_pair(folder / name, q, u, ["arm", "lift"])
    # On a free base the pose comes before the joints.
    np.savez(folder / "free.npz", time=t, qpos=np.hstack([np.zeros((len(t), 7)), q]), ctrl=u)
    refused("servo", folder / "free.npz", "--unit", "rad", out=folder / "none",
            words=["ctrl has 2 numbers, qpos has 9", "--map command=ctrl[0],measured=qpos[7]"])
    imported("servo", folder / "free.npz", "--unit", "rad", "--map", "command=ctrl[1],measured=qpos[8]", out=folder / "free")
    assert np.allclose(column(folder / "free", "measured_rad"), q[:, 1], atol=1e-12)
    # The same as a table.
    table(folder / "table.csv", "time,qpos_0,qpos_1,ctrl_0,ctrl_1", t, *q.T, *u.T)
    imported("servo", folder / "table.csv", "--unit", "rad", out=folder / "table")
    check_pair(folder / "table", q, u, ["joint0", "joint1"])
    np.savez(folder / "none.npz", note="nothing else")
    refused("servo", folder / "none.npz", out=folder / "none", words=["none.npz", "found note", "time, commands"])
    (folder / "cut.npz").write_bytes((folder / "plain.npz").read_bytes()[:5000])
    refused("servo", folder / "cut.npz", out=folder / "none", words=["cut.npz", "damaged or cut"])


run_tests(globals())
