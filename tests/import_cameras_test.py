#!/usr/bin/env python3
"""`seam import` of corners and calibrations of other programs, made here with the truth known; faults of data that are
to be named. `import_cameras_test.py path/to/seam`"""
import numpy as np

from importing import D, K, RNG, error_of, imported, mat_file, refused, rows_of, run, run_tests


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
    # Later versions write the target beside the corners, a list of points.
    grid = "".join(f"   - [ {x!r}, {y!r}, {z!r} ]\n" for x, y, z in (1000 * board()).tolist())
    (folder / "grid.yaml").write_text(storage(views) + "grid_points:\n" + grid)
    assert "millimetres" in imported("opencv", folder / "grid.yaml", out=folder / "grid")
    assert rows_of(folder / "grid" / "points.csv") == rows_of(folder / "yaml" / "points.csv")
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
    # Two cameras by their folders.
    folders = ["# filename x y level"] + [line.replace("frame", f"{side}/frame") for side in ("left", "right") for line in lines[1:]]
    (folder / "folders.vnl").write_text("\n".join(folders) + "\n")
    said = imported("mrcal", folder / "folders.vnl", *arguments[1:], out=folder / "left")
    assert "of the cameras left/, right/ the first" in said, said
    assert len(rows_of(folder / "left" / "points.csv")) == 100 * n - 1
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


run_tests(globals())
