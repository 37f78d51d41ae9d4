#!/usr/bin/env python3
"""`seam import`: files as other programs write them, made here, and sets with the truth known; faults of data that are
to be named. `import_test.py path/to/seam [folder of samples]`

Real files of other programs are not part of the source; where the folder is there, they are tried too.
"""
import csv
import json
import pathlib
import struct
import subprocess
import sys
import tempfile
import zlib

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from ros_bags import Cdr, mcap_file, ros1_bag  # noqa: E402

SEAM = pathlib.Path(sys.argv[1]).resolve()
HERE = pathlib.Path(__file__).resolve().parent.parent
SAMPLES = pathlib.Path(sys.argv[2]) if len(sys.argv) > 2 else HERE.parent / "shared" / "samples"
RNG = np.random.default_rng(18)


def run(*arguments, code=0):
    done = subprocess.run([SEAM, *map(str, arguments)], capture_output=True, text=True, timeout=120)
    assert done.returncode == code, (arguments, done.returncode, done.stdout, done.stderr)
    return done.stdout + done.stderr


def imported(kind, *arguments, out):
    """Imports, checks the set; what was said and the set's folder."""
    said = run("import", kind, *arguments, "--out", out)
    assert "0 errors" in run("check", out)
    return said


def refused(kind, *arguments, out, words, code=1):
    said = run("import", kind, *arguments, "--out", out, code=code)
    for word in words:
        assert word in said, (word, said)
    assert not out.exists(), out
    assert not list(out.parent.glob(f".{out.name}*")), "left behind"


def error_of(folder):
    run("compare", "--model", folder / "nominal.yaml", "--data", folder, "--json", folder.parent / "c.json")
    return json.loads((folder.parent / "c.json").read_text())["error"]


def rows_of(path):
    return list(csv.DictReader(path.open()))


# ---- servo


def servo_log(n=400):
    t = np.arange(n) * 0.01
    command = 0.5 * np.sin(2 * t) + 0.3 * np.sign(np.sin(3.1 * t))
    q, angles = 0.0, []
    for c in command:
        angles.append(q)
        q += (c - q) * (1 - np.exp(-0.01 / 0.05))
    return t, command, np.array(angles) + 1e-4 * RNG.standard_normal(n)


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
    refused("servoo", folder / "run.csv", out=folder / "kind", words=["servo"], code=2)
    assert "is there already" in run("import", "servo", folder / "bam.json", "--out", folder / "bam", code=1)


# ---- cameras

K = np.array([400.0, 405.0, 310.0, 236.0])
D = np.array([-0.2, 0.05, 0.001, -0.0015, 0.01])


def rodrigues(r):
    angle = np.linalg.norm(r)
    k = r / angle
    cross = np.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def project(p, K=K, D=D):
    x, y = p[:, 0] / p[:, 2], p[:, 1] / p[:, 2]
    r2 = x * x + y * y
    radial = 1 + r2 * (D[0] + r2 * (D[1] + r2 * D[4]))
    xd = x * radial + 2 * D[2] * x * y + D[3] * (r2 + 2 * x * x)
    yd = y * radial + D[2] * (r2 + 2 * y * y) + 2 * D[3] * x * y
    return np.stack([K[0] * xd + K[2], K[1] * yd + K[3]], axis=1)


def board(columns=9, rows=6, spacing=0.03):
    y, x = np.mgrid[0:rows, 0:columns]
    return np.stack([x.ravel() * spacing, y.ravel() * spacing, np.zeros(x.size)], axis=1)


def board_views(target, n=14, sigma=0.1):
    middle = target.mean(axis=0)
    views = []
    for _ in range(n):
        R = rodrigues(np.append(RNG.uniform(-0.5, 0.5, 2), RNG.uniform(-0.3, 0.3)))
        p = (target - middle) @ R.T + [RNG.uniform(-0.06, 0.06), RNG.uniform(-0.04, 0.04), RNG.uniform(0.3, 0.42)]
        views.append(project(p) + sigma * RNG.standard_normal((len(target), 2)))
    return views


def holds_camera(folder):
    text = (folder / "nominal.yaml").read_text()
    for value in [*K, *D]:
        assert f"{value:g}" in text, (value, text)
    error = error_of(folder)
    assert 0.8 < error < 1.25, error


def storage(views, extra=""):
    numbers = ", ".join(repr(float(x)) for view in views for x in view.ravel())
    return f"""%YAML:1.0
---
image_width: 640
image_height: 480
{extra}camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ {K[0]}, 0., {K[2]}, 0., {K[1]}, {K[3]}, 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 5
   cols: 1
   dt: d
   data: [ {", ".join(map(str, D))} ]
image_points: !!opencv-matrix
   rows: {len(views)}
   cols: {len(views[0])}
   dt: "2f"
   data: [ {numbers} ]
"""


def as_xml(text):
    import yaml
    tree = yaml.safe_load("\n".join(text.replace("!!opencv-matrix", "").splitlines()[2:]))

    def element(name, value):
        if isinstance(value, dict):
            return f'<{name} type_id="opencv-matrix">\n' + "".join(element(k, v) for k, v in value.items()) + f"</{name}>\n"
        inside = "\n".join(map(str, value)) if isinstance(value, list) else value
        return f"<{name}>{inside}</{name}>\n"

    return '<?xml version="1.0"?>\n<opencv_storage>\n' + "".join(element(k, v) for k, v in tree.items()) + "</opencv_storage>\n"


def test_opencv(folder):
    views = board_views(board())
    text = storage(views, "board_width: 9\nboard_height: 6\nsquare_size: 30.\n")
    (folder / "cv.yaml").write_text(text)
    assert "millimetres" in imported("opencv", folder / "cv.yaml", out=folder / "yaml")
    holds_camera(folder / "yaml")
    (folder / "cv.xml").write_text(as_xml(text))
    imported("opencv", folder / "cv.xml", out=folder / "xml")
    # XML here has the shortest decimals of the same numbers.
    assert rows_of(folder / "xml" / "points.csv") == rows_of(folder / "yaml" / "points.csv")
    (folder / "bare.yaml").write_text(storage(views))
    refused("opencv", folder / "bare.yaml", out=folder / "bare", words=["--board"], code=2)
    imported("opencv", folder / "bare.yaml", "--board", "9x6", "--spacing", "30", "--length-unit", "mm", out=folder / "given")
    holds_camera(folder / "given")
    refused("opencv", folder / "bare.yaml", "--board", "9x6", "--spacing", "30", out=folder / "mm", words=["millimetres"])
    refused("opencv", folder / "bare.yaml", "--board", "8x6", "--spacing", "0.03", out=folder / "wrong",
            words=["bare.yaml:", "48 points"])
    (folder / "uv.yaml").write_text(storage([view[:, ::-1] for view in views]))
    refused("opencv", folder / "uv.yaml", "--board", "9x6", "--spacing", "0.03", out=folder / "uv", words=["u and v are exchanged"])
    (folder / "cut.yaml").write_text(storage(views)[:-900])
    refused("opencv", folder / "cut.yaml", "--board", "9x6", "--spacing", "0.03", out=folder / "cut", words=["cut.yaml:"])
    mirrored = list(views)
    mirrored[3] = mirrored[3].reshape(6, 9, 2)[:, ::-1].reshape(-1, 2)
    mirrored.insert(6, mirrored[5])
    (folder / "mirror.yaml").write_text(storage(mirrored))
    said = imported("opencv", folder / "mirror.yaml", "--board", "9x6", "--spacing", "0.03", out=folder / "mirror")
    assert "1 of 15 views show the target mirrored" in said and "repeat the one before" in said, said


def test_kalibr(folder):
    size, ratio = 0.05, 0.3
    target = []
    for r in range(8):
        for c in range(12):
            target.append([(c // 2) * size * (1 + ratio) + (c % 2) * size, (r // 2) * size * (1 + ratio) + (r % 2) * size, 0])
    target = np.array(target)
    D4 = np.append(D[:4], 0)
    views = []
    for _ in range(10):
        R = rodrigues(RNG.uniform(-0.4, 0.4, 3))
        p = (target - target.mean(axis=0)) @ R.T + [0, 0, 0.45]
        views.append(project(p, D=D4) + 0.1 * RNG.standard_normal((len(target), 2)))
    (folder / "camchain.yaml").write_text(f"""cam0:
  camera_model: pinhole
  distortion_coeffs: {D[:4].tolist()}
  distortion_model: radtan
  intrinsics: {K.tolist()}
  resolution: [640, 480]
  timeshift_cam_imu: 0.004
  rostopic: /cam0/image_raw
""")
    (folder / "target.yaml").write_text(
        f"target_type: 'aprilgrid'\ntagCols: 6\ntagRows: 4\ntagSize: {size}\ntagSpacing: {ratio}\n")
    stamps = [1403636579763555584 + i * 50_000_000 for i in range(len(views))]
    lines = ["timestamp_ns,tag_id,corner,u,v"]
    for stamp, view in zip(stamps, views):
        for tag in range(24):
            for corner, (dr, dc) in enumerate([(0, 0), (0, 1), (1, 1), (1, 0)]):
                u, v = view[(2 * (tag // 6) + dr) * 12 + 2 * (tag % 6) + dc]
                lines.append(f"{stamp},{tag},{corner},{u!r},{v!r}")
    (folder / "corners.csv").write_text("\n".join(lines) + "\n")
    out = folder / "kalibr"
    imported("kalibr", folder / "camchain.yaml", folder / "target.yaml", folder / "corners.csv", out=out)
    assert rows_of(out / "points.csv")[0]["time_s"] == "1403636579.763555584"
    assert "frame_latency: {latency_s: 0.004}" in (out / "nominal.yaml").read_text()
    error = error_of(out)
    assert 0.8 < error < 1.25, error
    (folder / "corners.csv").write_text("\n".join(lines).replace(",23,0,", ",24,0,", 1) + "\n")
    refused("kalibr", folder / "camchain.yaml", folder / "target.yaml", folder / "corners.csv", out=folder / "tag",
            words=["corners.csv:", "96 points"])


def cameramodel(inputs=""):
    return f"""# made for a test
{{
    'lensmodel':  'LENSMODEL_OPENCV5',
    'intrinsics': [ {", ".join(map(str, [*K, *D]))},],
    'extrinsics': [ 0, 0, 0, 0, 0, 0 ],
    'imagersize': [ 640, 480 ],{inputs}
}}
"""


def test_mrcal(folder):
    import base64
    import io
    target, n = board(10, 10, 0.025), 9
    views = board_views(target, n)
    lines = ["# filename x y level"]
    for i, view in enumerate(views):
        lines += [f"frame{i}-cam0.png {u!r} {v!r} 0" for u, v in view]
    lines[5] = "frame0-cam0.png - - -"
    lines.append("frame77-cam0.png - - -")
    (folder / "corners.vnl").write_text("\n".join(lines) + "\n")
    (folder / "cam.cameramodel").write_text(cameramodel())
    arguments = [folder / "corners.vnl", folder / "cam.cameramodel", "--board", "10x10", "--spacing", "0.025"]
    imported("mrcal", *arguments, out=folder / "vnl")
    assert len(rows_of(folder / "vnl" / "points.csv")) == 100 * n - 1
    holds_camera(folder / "vnl")
    # Without a calibration the focal length is told from the views.
    said = imported("mrcal", folder / "corners.vnl", "--size", "640x480", *arguments[2:], out=folder / "free")
    assert "free" in said
    run("fit", "--model", folder / "free" / "nominal.yaml", "--data", folder / "free", "--out", folder / "f.yaml")
    refused("mrcal", folder / "corners.vnl", "--size", "640x480", "--board", "9x10", "--spacing", "0.025",
            out=folder / "corner", words=["corners.vnl:", "90 corners"])
    # What mrcal-calibrate-cameras keeps in a model.
    seen = np.concatenate([np.stack(views), np.ones((n, 100, 1))], axis=2).reshape(n, 10, 10, 3)
    seen[2, 3, 4, 2] = -1
    indices = np.stack([np.arange(n), np.zeros(n), -np.ones(n)], axis=1).astype(np.int32)
    packed = io.BytesIO()
    np.savez_compressed(packed, observations_board=seen, indices_frame_camintrinsics_camextrinsics=indices,
                        calibration_object_spacing=0.025, lensmodel="LENSMODEL_OPENCV5")
    text = base64.b85encode(packed.getvalue())
    (folder / "full.cameramodel").write_text(
        cameramodel(f"\n    'icam_intrinsics': 0,\n    'optimization_inputs': {text!r},"))
    said = imported("mrcal", folder / "full.cameramodel", out=folder / "inputs")
    assert "1 corners that mrcal left out" in said
    holds_camera(folder / "inputs")
    (folder / "cut.cameramodel").write_text(cameramodel()[:-30])
    refused("mrcal", folder / "cut.cameramodel", out=folder / "cut", words=["cut.cameramodel:", "cut"])


def matrix(name, array):
    """A matrix of a MAT-file of version 5."""
    array = np.atleast_2d(np.asarray(array, float))

    def element(kind, data):
        return struct.pack("<II", kind, len(data)) + data + b"\0" * (-len(data) % 8)

    inside = (element(6, struct.pack("<II", 6, 0)) + element(5, struct.pack("<ii", *array.shape)) +
              element(1, name.encode()) + element(9, array.T.tobytes()))
    return element(14, inside)


def mat_file(arrays, packed=True):
    data = b"MATLAB 5.0 MAT-file, made for a test".ljust(124) + b"\x00\x01IM"
    for name, array in arrays.items():
        one = matrix(name, array)
        if packed:
            one = zlib.compress(one)
            one = struct.pack("<II", 15, len(one)) + one
        data += one
    return data


def test_bouguet(folder):
    target = board()
    views = board_views(target)
    arrays = {"fc": K[:2, None], "cc": K[2:, None], "kc": D[:, None], "alpha_c": 0, "nx": 640, "ny": 480,
              "n_ima": len(views) + 1}
    for k, view in enumerate(views, 1):
        arrays[f"x_{k}"], arrays[f"X_{k}"] = view.T, 1000 * target.T
    arrays[f"x_{len(views) + 1}"] = arrays[f"X_{len(views) + 1}"] = np.nan
    for packed in (True, False):
        data = mat_file(arrays, packed)
        (folder / "Calib_Results.mat").write_bytes(data)
        out = folder / f"bouguet-{packed}"
        said = imported("bouguet", folder / "Calib_Results.mat", out=out)
        assert f"{54 * len(views)} corners in {len(views)} views" in said and "1 views hold NaN" in said, said
        holds_camera(out)
        for cut in (len(data) - 7, len(data) // 2, 140):
            (folder / "cut.mat").write_bytes(data[:cut])
            run("import", "bouguet", folder / "cut.mat", "--out", folder / "cut", code=1)
    (folder / "v73.mat").write_bytes(b"MATLAB 7.3 MAT-file".ljust(512))
    refused("bouguet", folder / "v73.mat", out=folder / "v73", words=["7.3", "-v7"])


def test_round_trip(folder):
    """Our own export comes back as the same model."""
    model = folder / "model.yaml"
    model.write_text("format: seam-model/1\nname: seen\neffects:\n"
                     "  pinhole: {fx_px: 400.5, fy_px: 401.5, cx_px: 320.25, cy_px: 239.5}\n"
                     "  radial_polynomial: {k1: -0.21, k2: 0.06, k3: 0}\n"
                     "  tangential_distortion: {p1: 0.003, p2: -0.002}\n"
                     "  rolling_shutter: {line_delay_s: 0.00002}\n")
    from_model = model.read_text().split("effects:")[1]
    for kind, form, name in [("opencv", "opencv", "a.yaml"), ("opencv", "ros", "b.yaml"), ("mrcal", "mrcal", "c.cameramodel"),
                             ("kalibr", "kalibr", "d.yaml")]:
        run("export", model, "--to", form, "--out", folder / name, "--size", "640x480",
            *([] if form == "kalibr" else ["--drop", "rolling_shutter"]))
        out = folder / f"back-{form}"
        imported(kind, folder / name, out=out)
        import yaml
        back = yaml.safe_load((out / "nominal.yaml").read_text())["effects"]
        truth = yaml.safe_load("effects:" + from_model)["effects"]
        if form != "kalibr":
            del truth["rolling_shutter"]
        assert back.keys() == truth.keys(), (form, back)
        for effect, values in truth.items():
            for parameter, value in values.items():
                assert abs(float(back[effect].get(parameter, 0)) - value) < 1e-7 * max(1, abs(value)), (form, effect, back)
        # The protocol that stands in for the corners can be measured.
        run("measure", "--model", out / "nominal.yaml", "--protocol", out, "--out", folder / f"made-{form}")
        assert len(rows_of(folder / f"made-{form}" / "points.csv")) > 500


# ---- ranges, trajectories


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
    mm = ranges.copy()
    mm[:, 3] *= 1000
    tables[1] = write("mm.csv", "t;anchor;distance", mm[:, [0, 2, 3]])
    refused("ranges", *tables, out=folder / "mm", words=["mm.csv:2", "millimetres"])
    tables[1] = write("ranges.csv", "t;anchor;distance", ranges[:, [0, 2, 3]])
    tables[2] = write("turned.csv", "id;x;y", beacons[:, [0, 2, 1]])
    assert "exchanged" in imported("ranges", *tables, out=folder / "turned")


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
    text = truth.read_text().splitlines()
    text[9] = text[9].rsplit(" ", 1)[0] + " 0.1"
    (folder / "q.txt").write_text("\n".join(text))
    refused("tum", folder / "q.txt", out=folder / "q", words=["q.txt:10", "quaternion"])


# ---- photometry


def png(array, bits):
    height, width = array.shape
    raw = b"".join(b"\0" + (row.astype(">u2") if bits == 16 else row.astype("u1")).tobytes() for row in array)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, bits, 0, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(raw)) + chunk(b"IEND", b""))


def flat(exposure, light, gain=0.4, black=20, dark_dn=2.0, size=(48, 64)):
    electrons = RNG.poisson(light * exposure * np.ones(size)) + dark_dn / gain * RNG.standard_normal(size)
    return np.clip(np.rint(gain * electrons + black), 0, 4095).astype(int)


def test_photometry(folder):
    series = folder / "series"
    (series / "images").mkdir(parents=True)
    lines = ["# a series", "v 3.0", "n 12 64 48"]
    for i, exposure in enumerate([1e-3, 2e-3, 4e-3, 8e-3]):
        for what, light in (("b", 1e6), ("d", 0)):
            lines.append(f"b {exposure * 1e9:.1f} {2e6 * exposure}" if what == "b" else f"d {exposure * 1e9:.1f}")
            for k in range(2):
                name = f"{what}_{i}_{k}.png"
                (series / "images" / name).write_bytes(png(flat(exposure, light), 16))
                lines.append(f"i images\\{name}")
    (series / "data.txt").write_text("\r\n".join(lines) + "\r\n")
    out = folder / "emva"
    imported("emva1288", series / "data.txt", out=out)
    assert "bits: 12" in (out / "measurement.yaml").read_text()
    run("discover", "--model", out / "nominal.yaml", "--data", out, "--out", folder / "s.yaml", "--json", folder / "s.json")
    figures = {f["name"]: f["value"] for f in json.loads((folder / "s.json").read_text())["figures"]["figures"]}
    assert abs(figures["system gain K"] - 0.4) < 0.04 and abs(figures["quantum efficiency"] - 50) < 5, figures
    (series / "data.txt").write_text("\n".join(lines).replace("d_2_1", "d_2_9") + "\n")
    refused("emva1288", series / "data.txt", out=folder / "lost", words=["data.txt:", "d_2_9.png is missing"])
    (series / "data.txt").write_text("\n".join(lines).replace("images\\d_2_1", "..\\..\\d_2_1") + "\n")
    refused("emva1288", series / "data.txt", out=folder / "slip", words=["data.txt:"])

    names = folder / "names"
    names.mkdir()
    for exposure in ("1ms", "2.5ms", "0p004s"):
        seconds = {"1ms": 1e-3, "2.5ms": 2.5e-3, "0p004s": 4e-3}[exposure]
        for k in range(2):
            (names / f"flat_{exposure}_{k}.png").write_bytes(png(flat(seconds, 1e6), 16))
            (names / f"dark_{exposure}_{k}.png").write_bytes(png(flat(seconds, 0), 16))
    imported("flats", names, out=folder / "flats")
    rows = rows_of(folder / "flats" / "frames.csv")
    assert sorted({float(r["exposure_s"]) for r in rows}) == [0.001, 0.0025, 0.004], rows
    assert {r["illumination"] for r in rows if "dark" in r["file"]} == {"0"}

    heads = folder / "fits"
    heads.mkdir()
    for k, exposure in enumerate([0.001, 0.001, 0.003, 0.003, 0.001, 0.001]):
        kind = "Dark Frame" if k >= 4 else "Flat Field"
        cards = ["SIMPLE  =                    T", "BITPIX  =                   16", "NAXIS   =                    2",
                 "NAXIS1  =                   64", "NAXIS2  =                   48", "BZERO   =                32768",
                 f"EXPTIME = {exposure:20} / s", f"IMAGETYP= '{kind}'", "END"]
        data = "".join(card.ljust(80) for card in cards).ljust(2880).encode()
        pixels = (flat(exposure, 0 if k >= 4 else 1e6) - 32768).astype(">i2").tobytes()
        (heads / f"{k}.fits").write_bytes(data + pixels.ljust((len(pixels) + 2879) // 2880 * 2880, b"\0"))
    said = imported("flats", heads, out=folder / "from-fits")
    assert "6 frames from FITS headers" in said and "2 of them dark" in said, said
    listed = folder / "listed"
    listed.mkdir()
    for k in range(4):
        (listed / f"{k}.png").write_bytes(png(flat(0.001 * (1 + k // 2), 1e6), 16))
    refused("flats", listed, out=folder / "unknown", words=["0.png", "exposure is not known"])
    (listed / "list.csv").write_text("file,exposure_ms,illumination\n" + "".join(f"{k}.png,{1 + k // 2},1\n" for k in range(4)))
    imported("flats", listed, out=folder / "csv")
    bomb = bytearray(png(np.zeros((4, 4), int), 8))
    bomb[16:24] = struct.pack(">II", 60000, 60000)
    bomb[29:33] = struct.pack(">I", zlib.crc32(bytes(bomb[12:29])))
    (listed / "3.png").write_bytes(bytes(bomb))
    refused("flats", listed, out=folder / "bomb", words=["3.png"])


# ---- bags


def bag_messages(ros1):
    t, command, measured = servo_log(300)
    joints = []
    for a, b, c in zip(t + 50, command, measured):
        joints.append(("/joint_states", "sensor_msgs/JointState", a,
                       Cdr(ros1).header(a).texts(["arm", "wrist"]).reals([c, 0.5 * c]).reals([]).reals([]).data))
        joints.append(("/commands", "std_msgs/Float64MultiArray", a + 0.001,
                       Cdr(ros1).put("I", 0, 0).reals([b, 0.5 * b]).data))
    walk, x, y, theta = [], 0.0, 0.0, 0.0
    for k in range(400):
        a = 100 + 0.05 * k
        vx, omega = 0.4 + 0.1 * np.sin(k / 40), 0.5 * np.sin(k / 25)
        walk.append(("/odom", "nav_msgs/Odometry", a, Cdr(ros1).header(a).text("base_link").put(
            "d", x, y, 0, 0, 0, np.sin(theta / 2), np.cos(theta / 2), *[0] * 36, vx, 0, 0, 0, 0, omega, *[0] * 36).data))
        walk.append(("/cmd_vel", "geometry_msgs/Twist", a, Cdr(ros1).put("d", vx, 0, 0, 0, 0, omega).data))
        middle = theta + 0.025 * omega
        x, y, theta = x + 0.95 * vx * 0.05 * np.cos(middle), y + 0.95 * vx * 0.05 * np.sin(middle), theta + 0.05 * omega
    info = [("/camera/camera_info", "sensor_msgs/CameraInfo", 5.0, Cdr(ros1).header(5).put("I", 480, 640).text("plumb_bob")
             .reals(list(D)).put("d", K[0], 0, K[2], 0, K[1], K[3], 0, 0, 1).data)]
    return joints, walk, info


def test_ros(folder):
    for ros1, name in ((False, "two.mcap"), (True, "one.bag"), (True, "bz2.bag")):
        joints, walk, info = bag_messages(ros1)

        def write(messages):
            data = ros1_bag(messages, "bz2" if "bz2" in name else "none") if ros1 else mcap_file(messages)
            (folder / name).write_bytes(data)
            return data

        data = write(joints)
        out = folder / f"joints-{name[:-5]}-{ros1}"
        imported("ros", folder / name, out=out)
        rows = rows_of(out / "joints.csv")
        assert len(rows) == 2 * 299 and {r["joint"] for r in rows} == {"arm", "wrist"}, len(rows)
        (folder / name).write_bytes(data[:len(data) // 2])
        run("import", "ros", folder / name, "--out", folder / "cut", code=1)
        write(walk)
        out = folder / f"walk-{name[:-5]}-{ros1}"
        imported("ros", folder / name, out=out)
        run("add", "odometry_scale", "--model", out / "nominal.yaml", "--data", out, "--out", folder / "o.yaml", "--json",
            folder / "o.json")
        found = json.loads((folder / "o.json").read_text())["parameters"]["vx_scale"]
        assert abs(found["value"] + 0.05) < 2e-3, found
        write(info)
        out = folder / f"info-{name[:-5]}-{ros1}"
        imported("ros", folder / name, out=out)
        assert "fx_px: 400, fy_px: 405" in (out / "nominal.yaml").read_text()
        write([m for m in walk if m[0] == "/cmd_vel"])
        refused("ros", folder / name, out=folder / "alone", words=["/cmd_vel (geometry_msgs/Twist, 400 messages)", "--map"])


def test_log(folder):
    """A recorded swing of the simulator's head: its limit of speed is found again."""
    scenario = HERE / "scenarios" / "head_swing.yaml"
    run("run", scenario, "--log", folder / "run.mcap")
    imported("log", folder / "run.mcap", out=folder / "head")
    run("add", "speed_limit", "--model", folder / "head" / "nominal.yaml", "--data", folder / "head", "--out",
        folder / "m.yaml", "--json", folder / "m.json")
    found = json.loads((folder / "m.json").read_text())["parameters"]["rad_per_s"]
    assert abs(found["value"] - np.radians(300)) < 1e-3, found
    refused("log", folder / "run.mcap", "--part", "odometry", out=folder / "walk", words=["never told to walk"])
    refused("log", folder / "run.mcap", "--camera", "red9", out=folder / "who", words=["red9", "red1"])


# ---- real files


def test_samples(folder):
    if not SAMPLES.is_dir():
        print(f"skipped: {SAMPLES} is not there (real files that are not part of the source)")
        return
    imported("servo", *sorted((SAMPLES / "bam").glob("*.json")), out=folder / "bam")
    assert len(rows_of(folder / "bam" / "joints.csv")) == 2240
    imported("ranges", SAMPLES / "plaza" / "Plaza1_.mat", out=folder / "plaza")
    assert len(rows_of(folder / "plaza" / "observations.csv")) == 3529
    vnl = SAMPLES / "mrcal" / "synthetic-board-observations.vnl"
    imported("mrcal", vnl, SAMPLES / "mrcal" / "cam0.opencv8.cameramodel", "--board", "10x10", "--spacing", "0.1",
             out=folder / "vnl")
    imported("opencv", SAMPLES / "ros" / "camera_info.yaml", out=folder / "info")
    imported("euroc", SAMPLES / "euroc" / "V102_groundtruth_part.csv", out=folder / "euroc")
    imported("tum", SAMPLES / "euroc" / "tum_freiburg1_xyz_part.txt", out=folder / "tum")
    imported("ros", SAMPLES / "ros" / "nav2_turtlebot.mcap", out=folder / "ros")
    imported("emva1288", SAMPLES / "emva1288" / "ccd_12bit" / "EMVA1288_Data.txt", out=folder / "emva")


def main():
    for name, test in list(globals().items()):
        if not name.startswith("test_"):
            continue
        with tempfile.TemporaryDirectory() as folder:
            test(pathlib.Path(folder))
        print(name)


main()
