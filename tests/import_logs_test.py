#!/usr/bin/env python3
"""`seam import` of servos' logs, ranges and trajectories, made here with the truth known; faults of data that are to be
named. `import_logs_test.py path/to/seam`"""
import json

import numpy as np

from importing import RNG, error_of, imported, mat_file, refused, rows_of, run, run_tests, servo_log


def test_servo(folder):
    t, command, measured = servo_log()
    deg = np.degrees
    (folder / "run.csv").write_text("time_ms,goal,angle,supply\n" + "".join(
        f"{1000 * a:.1f},{deg(b)!r},{deg(c)!r},7.4\n" for a, b, c in zip(t, command, measured)))
    out = folder / "servo"
    imported("servo", folder / "run.csv", "--map", "command=goal,measured=angle,voltage=supply", "--unit", "deg", out=out)
    rows = rows_of(out / "joints.csv")
    assert np.allclose([float(r["command_rad"]) for r in rows], command, atol=1e-12)
    assert np.allclose([float(r["time_s"]) for r in rows], t, atol=1e-9) and rows[0]["voltage_v"] == "7.4"
    # A lag of 50 ms is found in it.
    run("add", "servo_lag", "--model", out / "nominal.yaml", "--data", out, "--out", folder / "lag.yaml", "--json",
        folder / "lag.json")
    tau = json.loads((folder / "lag.json").read_text())["parameters"]["tau_s"]
    assert abs(tau["value"] - 0.05) < 4 * tau["sigma"] + 1e-4, tau
    # Our own table is read again.
    imported("servo", out / "joints.csv", out=folder / "again")
    assert [r["measured_rad"] for r in rows_of(folder / "again" / "joints.csv")] == [r["measured_rad"] for r in rows]

    entries = [{"timestamp": a, "goal_position": b, "position": c, "torque_enable": True} for a, b, c in
               zip(t, command, measured)]
    (folder / "bam.json").write_text(json.dumps({"kp": 100, "motor": "x", "entries": entries}))
    imported("servo", folder / "bam.json", out=folder / "bam")
    assert {r["kp"] for r in rows_of(folder / "bam" / "joints.csv")} == {"100"}
    series = {"times": list(t), "data": np.stack([measured, command], 1).tolist(),
              "signal_mapping": {"arm_qpos": [2, [0]], "arm_ctrl": [5, [1]]}}
    (folder / "sysid.json").write_text(json.dumps(series))
    imported("servo", folder / "sysid.json", out=folder / "sysid")
    rows = rows_of(folder / "sysid" / "joints.csv")
    assert {r["joint"] for r in rows} == {"arm"} and np.allclose([float(r["command_rad"]) for r in rows], command)

    # As spreadsheets of other countries, data loggers and learning robots write the same.
    truth = [r["measured_rad"] for r in rows_of(folder / "sysid" / "joints.csv")]
    comma = "\ufeffZeit;Soll [deg];Ist [deg]\r\n" + "".join(
        f"{a:.3f};{deg(b):.9f};{deg(c):.9f}\r\n".replace(".", ",") for a, b, c in zip(t, command, measured))
    dates = "timestamp,command,position,note\n" + "".join(
        f'2024-05-01T12:00:{a:06.3f}+02:00,{b:.9f},{c:.9f},"up, and ""down"""\n' for a, b, c in zip(t, command, measured))
    tabs = "time [ms]\tgoal position (deg)\tpresent_position_deg\n" + "".join(
        f"{1000 * a:.1f}\t{deg(b):.9f}\t{deg(c):.9f}\n" for a, b, c in zip(t, command, measured))
    pairs = "time,arm_cmd,arm_pos,lift_cmd,lift_pos,arm_vel\n" + "".join(
        f"{a:.3f},{b:.9f},{c:.9f},{2 * b:.9f},{2 * c:.9f},0\n" for a, b, c in zip(t, command, measured))
    lines = "\n".join(json.dumps({"t": a, "action": [b], "observation.state": [c]}) for a, b, c in zip(t, command, measured))
    for name, text, more in (("comma.csv", comma, ["--map", "time=Zeit,command=Soll,measured=Ist"]), ("dates.csv", dates, []),
                             ("tabs.tsv", tabs, []), ("pairs.csv", pairs, []), ("lines.jsonl", lines, [])):
        (folder / name).write_text(text)
        out = folder / f"as-{name}"
        imported("servo", folder / name, *more, out=out)
        rows = rows_of(out / "joints.csv")
        first = [r for r in rows if r["joint"] in (rows[0]["joint"], "arm")]
        assert np.allclose([float(r["measured_rad"]) for r in first], [float(x) for x in truth], atol=1e-8), name
        assert np.allclose([float(r["time_s"]) - float(first[0]["time_s"]) for r in first], t, atol=1e-6), name
    assert {r["joint"] for r in rows_of(folder / "as-pairs.csv" / "joints.csv")} == {"arm", "lift"}
    assert rows_of(folder / "as-dates.csv" / "joints.csv")[0]["time_s"].startswith("1714557600.")
    for name, text, words in (("wide.csv", "time,command,position\n0,1,2\n".encode("utf-16"), ["UTF-16"]),
                              ("twice.csv", b"t,command,command,position\n0,1,1,2\n1,2,2,3\n", ["'command' stands twice"]),
                              ("bare.csv", b"0,1,2\n1,2,3\n", ["expected a header"]),
                              ("ragged.csv", b"t,command,position\n0,1,2\n1,2\n", [":3:", "2 cells, expected 3"]),
                              ("binary.csv", b"t,command,position\n\0\0", ["binary"])):
        (folder / name).write_bytes(text)
        refused("servo", folder / name, out=folder / "none", words=[name, *words])

    def spoilt(name, change, words, *more):
        table = [[f"{a:.4f}", repr(float(b)), repr(float(c))] for a, b, c in zip(t, command, measured)]
        change(table)
        path = folder / f"{name}.csv"
        path.write_text("t,command,position\n" + "".join(",".join(r) + "\n" for r in table))
        refused("servo", path, *more, out=folder / f"not-{name}", words=[f"{name}.csv", *words])

    def each(column, of):
        return lambda table: [row.__setitem__(column, of(row)) for row in table]

    spoilt("degrees", each(2, lambda r: str(40 + deg(float(r[2])))), ["degrees", "--unit deg"])
    spoilt("ms", each(0, lambda r: str(1000 * float(r[0]))), [":3:", "--time-unit"])
    spoilt("back", lambda table: table.insert(50, list(table[10])), [":52:", "forwards"])
    spoilt("nan", lambda table: table[7].__setitem__(2, "nan"), [":9", "finite"])
    spoilt("same", each(1, lambda r: r[2]), ["really the measurement"])
    (folder / "swap.csv").write_text("t,command,position\n" + "".join(
        f"{a:.4f},{c!r},{b!r}\n" for a, b, c in zip(t, command, measured)))
    assert "exchanged" in imported("servo", folder / "swap.csv", out=folder / "swap")
    (folder / "lfs.csv").write_text("version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n")
    refused("servo", folder / "lfs.csv", out=folder / "lfs", words=["Git LFS"])
    (folder / "cut.json").write_text(json.dumps({"entries": entries})[:-40])
    refused("servo", folder / "cut.json", out=folder / "cut", words=["cut.json", "JSON"])
    refused("servo", folder / "run.csv", "--map", "command=gaol", out=folder / "map", words=["gaol", "did you mean 'goal'"])
    refused("servo", folder / "run.csv", "--board", "9x6", out=folder / "board", words=["--board"], code=2)
    refused("servoo", folder / "run.csv", out=folder / "kind", words=["unknown kind 'servoo', did you mean 'servo'?"],
            code=2)
    said = run("import", "zzzzzzzz", folder / "run.csv", "--out", folder / "kind", code=2)
    assert said.count("bouguet") == 1, said
    assert "is there already" in run("import", "servo", folder / "bam.json", "--out", folder / "bam", code=1)


def test_names_that_no_import_asks_for(folder):
    """A slip in --map must not be passed over, whatever the kind: the known names are listed."""
    (folder / "table.csv").write_text("time,command,position\n0,1,2\n1,2,3\n")
    kind, kinds = "", {}
    for line in run("import", "--help").splitlines():
        if line.startswith("  ") and line[2:3].isalpha():
            kind = line.split()[0]
        if "names for --map: " in line:
            kinds[kind] = line.split("--map: ")[1].split(", ")
    assert {"images", "servo", "ranges", "opencv", "kalibr", "ros", "flats"} <= set(kinds), kinds
    for kind, names in kinds.items():
        refused(kind, folder / "table.csv", "--map", f"{names[0]}=time,banana=time", out=folder / "none", code=2,
                words=["--map banana=time: unknown name 'banana'", f"import {kind}", *names])


def test_ranges(folder):
    t = 1000 + np.arange(600) * 0.2
    path = np.stack([t, 20 * np.cos(t / 9), 15 * np.sin(t / 7), t / 9], axis=1)
    beacons = np.array([[3, -30.0, 5.0], [7, 12.0, -28.0], [9, 25.0, 30.0]])
    ranges = []
    for i in range(0, 600, 2):
        b = beacons[i // 2 % 3]
        ranges.append([t[i], 2, b[0], np.hypot(path[i, 1] - b[1], path[i, 2] - b[2]) * 1.05 + 0.05 * RNG.standard_normal()])
    ranges = np.array(ranges)
    (folder / "p.mat").write_bytes(mat_file({"GT": path, "TD": ranges, "TL": beacons}))
    out = folder / "mat"
    imported("ranges", folder / "p.mat", out=out)
    assert len(rows_of(out / "observations.csv")) == 300 and rows_of(out / "landmarks.csv")[1]["landmark"] == "7"
    run("add", "range_scale", "--model", out / "nominal.yaml", "--data", out, "--out", folder / "r.yaml", "--json",
        folder / "r.json")
    scale = json.loads((folder / "r.json").read_text())["parameters"]["scale"]
    assert abs(scale["value"] - 0.05) < 4 * scale["sigma"], scale

    def write(name, header, rows):
        (folder / name).write_text(header + "\n" + "".join(";".join(repr(float(x)) for x in row) + "\n" for row in rows))
        return folder / name

    tables = [write("path.csv", "time;x;y;theta", path), write("ranges.csv", "t;anchor;distance", ranges[:, [0, 2, 3]]),
              write("beacons.csv", "id;x;y", beacons)]
    imported("ranges", *tables, out=folder / "csv")
    assert [r["range_m"] for r in rows_of(folder / "csv" / "observations.csv")] == [
        r["range_m"] for r in rows_of(out / "observations.csv")]
    # Further columns come along where every row has a number; constants, counters and words do not.
    more = text_table(folder / "more.csv", "t,anchor,distance,seq,humidity,fixed,gap,state", [
        [*row, i, 50 + 9 * np.sin(0.3 * i), 3, "" if i == 4 else i % 3, "ok"] for i, row in enumerate(ranges[:, [0, 2, 3]])])
    said = imported("ranges", tables[0], more, tables[2], out=folder / "more")
    assert "kept beside them: humidity\n" in said, said
    kept = rows_of(folder / "more" / "observations.csv")
    assert list(kept[0])[5:] == ["humidity"] and float(kept[2]["humidity"]) == 50 + 9 * np.sin(0.6), kept[2]
    # Units in the names of columns, and loggers that write 0 or nan where nothing answered.
    some = ["time [ms];beacon;range (mm)\n"] + [
        f"{1000 * t:.3f};{b:.0f};{'0' if i % 50 == 0 else 'nan' if i % 50 == 1 else repr(float(1000 * r))}\n"
        for i, (t, _, b, r) in enumerate(ranges)]
    (folder / "named.csv").write_text("".join(some))
    said = imported("ranges", tables[0], folder / "named.csv", tables[2], out=folder / "named")
    assert "12 of 300 rows are blank, nan or a range of 0" in said, said
    assert len(rows_of(folder / "named" / "observations.csv")) == 288
    mm = ranges.copy()
    mm[:, 3] *= 1000
    tables[1] = write("mm.csv", "t;anchor;distance", mm[:, [0, 2, 3]])
    refused("ranges", *tables, out=folder / "mm", words=["mm.csv:2", "millimetres"])
    tables[1] = write("ranges.csv", "t;anchor;distance", ranges[:, [0, 2, 3]])
    tables[2] = write("turned.csv", "id;x;y", beacons[:, [0, 2, 1]])
    assert "exchanged" in imported("ranges", *tables, out=folder / "turned")


def text_table(path, header, rows):
    path.write_text(header + "\n" + "".join(",".join(x if isinstance(x, str) else repr(float(x)) for x in row) + "\n"
                                            for row in rows))
    return path


def driven(n=800, dt=0.1):
    """Times and poses of a robot that drives about in a room of 6 m x 5 m."""
    t = np.arange(n) * dt
    x, y = 3 + 1.9 * np.sin(0.31 * t), 2.5 + 1.6 * np.sin(0.47 * t + 1)
    return t, x, y, np.unwrap(np.arctan2(np.gradient(y), np.gradient(x)))


def ranges_to(anchors, t, x, y, z=0.0):
    a = anchors[np.arange(len(t)) % len(anchors)]
    return a[:, 0], np.sqrt((a[:, 1] - x) ** 2 + (a[:, 2] - y) ** 2 + (a[:, 3] - z) ** 2)


def discovered(out, folder):
    run("discover", "--model", out / "nominal.yaml", "--data", out, "--out", folder / "d.yaml", "--json", folder / "d.json")
    return json.loads((folder / "d.json").read_text())


def test_beacons_above_the_plane(folder):
    """Ranges are distances in space where the tables say heights; nothing is wrong with them but their noise."""
    t, x, y, theta = driven()
    anchors = np.array([[1, 0, 0, 2.2], [2, 6, 0, 2.6], [3, 6, 5, 1.9], [4, 0, 5, 2.2]])
    who, exact = ranges_to(anchors, t, x, y, 0.3)
    path = text_table(folder / "path.csv", "time,x,y,theta,z", np.stack([t, x, y, theta, 0 * t + 0.3], 1))
    seen = text_table(folder / "ranges.csv", "time,anchor,range",
                      np.stack([t, who, exact + 0.02 * RNG.standard_normal(len(t))], 1))
    high = text_table(folder / "anchors.csv", "anchor,x,y,z", anchors)
    out = folder / "high"
    said = imported("ranges", seen, high, path, out=out)
    assert "lies in a plane" not in said, said
    assert [float(row["z_m"]) for row in rows_of(out / "landmarks.csv")] == [2.2, 2.6, 1.9, 2.2]
    assert rows_of(out / "poses.csv")[0]["z_m"] == "0.3"
    found = discovered(out, folder)
    assert found["verdict"] == "adequate" and not found["steps"] and abs(found["error"] - 1) < 0.1, found
    # In centimetres, and by names of their own.
    own = text_table(folder / "own.csv", "anchor,x,y,above [cm]", anchors * [1, 1, 1, 100])
    imported("ranges", seen, own, path, "--map", "z=above", out=folder / "own")  # The path keeps its z.
    assert np.allclose([float(row["z_m"]) for row in rows_of(folder / "own" / "landmarks.csv")], anchors[:, 3])
    # A scale of the ranges is found beside the heights, at its value.
    text_table(folder / "ranges.csv", "time,anchor,range", np.stack([t, who, 1.03 * exact + 0.02 * RNG.standard_normal(len(t))], 1))
    imported("ranges", seen, high, path, out=folder / "scaled")
    found = discovered(folder / "scaled", folder)
    step = found["steps"][0]
    assert step["effect"] == "range_scale" and len(found["steps"]) == 1, found["steps"]
    assert abs(step["parameters"]["scale"]["value"] - 0.03) < 0.002, step
    # A path without heights is said to be at 0; beacons without them lie in a plane.
    low = text_table(folder / "low.csv", "time,x,y,theta", np.stack([t, x, y, theta], 1))
    assert "taken at z = 0" in imported("ranges", seen, high, low, out=folder / "low")
    flat = text_table(folder / "flat.csv", "anchor,x,y", anchors[:, :3])
    assert "a column z of the beacons" in imported("ranges", seen, flat, low, out=folder / "flat")
    refused("ranges", seen, high, path, "--map", "range=banana", out=folder / "none", words=["banana", "--map range="])


def test_flying_among_beacons(folder):
    """The heights of a path that leaves the plane are used or asked for, never left out in silence."""
    t, x, y, theta = driven()
    z = 1.0 + 0.8 * np.sin(0.23 * t)
    anchors = np.array([[1, 0, 0, 0.2], [2, 6, 0, 2.6], [3, 6, 5, 0.1], [4, 0, 5, 2.4]])
    who, exact = ranges_to(anchors, t, x, y, z)
    path = text_table(folder / "path.csv", "time,x,y,z,theta", np.stack([t, x, y, z, theta], 1))
    seen = text_table(folder / "ranges.csv", "time,anchor,range",
                      np.stack([t, who, exact + 0.02 * RNG.standard_normal(len(t))], 1))
    imported("ranges", seen, text_table(folder / "anchors.csv", "anchor,x,y,z", anchors), path, out=folder / "set")
    error = error_of(folder / "set")
    assert 0.7 < error < 1.1, error
    refused("ranges", seen, text_table(folder / "flat.csv", "anchor,x,y", anchors[:, :3]), path, out=folder / "none",
            words=["path.csv", "leaves the plane", "column z of the beacons"])


def test_bearings_alone(folder):
    t, x, y, theta = driven()
    marks = np.array([[1, 0, 0], [2, 6, 0], [3, 6, 5], [4, 0, 5]])
    a = marks[np.arange(len(t)) % 4]
    bearing = np.arctan2(a[:, 2] - y, a[:, 1] - x) - theta + 0.02 + 0.005 * RNG.standard_normal(len(t))
    bearing = np.angle(np.exp(1j * bearing))
    where = text_table(folder / "marks.csv", "landmark,x,y", marks)
    path = text_table(folder / "path.csv", "time,x,y,theta", np.stack([t, x, y, theta], 1))
    for name, factor, more in (("bearing_deg", 180 / np.pi, []), ("bearing", 1, []), ("alpha", 1, ["--map", "bearing=alpha"]),
                               ("bearing", 180 / np.pi, ["--unit", "bearing=deg"])):
        seen = text_table(folder / "seen.csv", f"time,landmark,{name}", np.stack([t, a[:, 0], factor * bearing], 1))
        out = folder / f"set-{name}-{factor:.0f}"
        imported("ranges", seen, where, path, *more, out=out)
        rows = rows_of(out / "observations.csv")
        assert np.allclose([float(r["bearing_rad"]) for r in rows], bearing, atol=1e-9)
        assert {r["range_m"] for r in rows} == {""}
    # The camera looks 20 mrad to the right of the robot's front.
    found = discovered(out, folder)
    step = found["steps"][0]
    assert step["effect"] == "mount_misalignment" and len(found["steps"]) == 1, found["steps"]
    assert abs(step["parameters"]["yaw_rad"]["value"] + 0.02) < 0.002, step
    text_table(folder / "seen.csv", "time,landmark,bearing", np.stack([t, a[:, 0], 180 / np.pi * bearing], 1))
    refused("ranges", seen, where, path, out=folder / "none", words=["seen.csv:", "--unit bearing=deg"])
    text_table(folder / "path.csv", "time,x,y", np.stack([t, x, y], 1))
    refused("ranges", seen, where, path, "--unit", "deg", out=folder / "none", words=["path.csv", "column theta"])


def test_trajectories(folder):
    t = np.arange(500) * 0.02
    theta = 0.4 * t
    x, y = np.cos(theta) * 2, np.sin(theta) * 2
    yaw = theta + np.pi / 2
    q = np.stack([np.cos(yaw / 2), 0 * t, 0 * t, np.sin(yaw / 2)], axis=1)
    (folder / "gt.csv").write_text("#timestamp [ns],p_x,p_y,p_z,q_RS_w [],q_RS_x [],q_RS_y [],q_RS_z []\n" + "".join(
        f"{1403715524907143168 + int(round(a * 1e9))},{b!r},{c!r},1.0,{','.join(map(repr, map(float, d)))}\n"
        for a, b, c, d in zip(t, x, y, q)))
    imported("euroc", folder / "gt.csv", out=folder / "euroc")
    first = rows_of(folder / "euroc" / "poses.csv")[0]
    assert first["time_s"] == "1403715524.907143168" and abs(float(first["qw"]) - q[0, 0]) < 1e-8

    def tum(name, x, y, yaw):
        lines = [f"{100 + a:.4f} {b!r} {c!r} 0 0 0 {np.sin(d / 2)!r} {np.cos(d / 2)!r}" for a, b, c, d in zip(t, x, y, yaw)]
        (folder / name).write_text("# timestamp tx ty tz qx qy qz qw\n" + "\n".join(lines) + "\n")
        return folder / name

    # An odometry that thinks it went 4 % farther than it did.
    truth, estimate = tum("truth.txt", x, y, yaw), tum("estimate.txt", 1.04 * x, 1.04 * y, yaw)
    out = folder / "walk"
    imported("tum", truth, estimate, out=out)
    run("add", "odometry_scale", "--model", out / "nominal.yaml", "--data", out, "--out", folder / "o.yaml", "--json",
        folder / "o.json")
    found = json.loads((folder / "o.json").read_text())["parameters"]["vx_scale"]
    assert abs(found["value"] - (1 / 1.04 - 1)) < 1e-3, found
    tum("mm.txt", 1e6 * x, 1e6 * y, yaw)
    refused("tum", folder / "mm.txt", out=folder / "mm", words=["mm.txt", "millimetres"])
    # A flight is no walk in a plane: neither one that climbs nor one that tilts.
    lines = truth.read_text().splitlines()
    climbs = [lines[0]] + [" ".join([*line.split()[:3], f"{0.001 * i:.4f}", *line.split()[4:]])
                           for i, line in enumerate(lines[1:])]
    (folder / "climbs.txt").write_text("\n".join(climbs))
    refused("tum", truth, folder / "climbs.txt", out=folder / "fly", words=["climbs.txt", "leaves the plane", "heights differ"])
    tilts = [lines[0]]
    for i, line in enumerate(lines[1:]):
        half, other = 0.5 * yaw[i], 0.2 * np.sin(0.05 * i)  # Rz(yaw) Rx(tilt).
        q = [np.cos(half) * np.sin(other), np.sin(half) * np.sin(other), np.sin(half) * np.cos(other),
             np.cos(half) * np.cos(other)]
        tilts.append(" ".join(line.split()[:4] + [repr(float(c)) for c in q]))
    (folder / "tilts.txt").write_text("\n".join(tilts))
    refused("tum", folder / "tilts.txt", estimate, out=folder / "tilt", words=["tilts.txt", "the body tilts by"])
    # As the rig of a set of points it is kept whole.
    imported("tum", folder / "climbs.txt", out=folder / "rig")
    assert abs(float(rows_of(folder / "rig" / "poses.csv")[-1]["z_m"]) - 0.499) < 1e-9
    text = truth.read_text().splitlines()
    text[9] = text[9].rsplit(" ", 1)[0] + " 0.1"
    (folder / "q.txt").write_text("\n".join(text))
    refused("tum", folder / "q.txt", out=folder / "q", words=["q.txt:10", "quaternion"])
    (folder / "kitti.txt").write_text("1 0 0 0 0 1 0 0 0 0 1 0\n" * 9)
    refused("tum", folder / "kitti.txt", out=folder / "k", words=["12 columns, as KITTI's poses have"])
    refused("tum", folder / "gt.csv", out=folder / "ns", words=["gt.csv:2", "--time-unit"])
    text = truth.read_text().splitlines()
    (folder / "back.txt").write_text("\n".join(text[:40] + text[20:60]))
    refused("tum", folder / "back.txt", out=folder / "b", words=["back.txt:41", "forwards"])


run_tests(globals())
