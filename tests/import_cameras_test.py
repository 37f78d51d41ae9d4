#!/usr/bin/env python3
"""`seam import` of corners and calibrations of other programs, made here with the truth known; faults of data that are
to be named. `import_cameras_test.py path/to/seam`"""
import json

import numpy as np
import yaml

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


def calibration(matrix, model, coefficients):
    return (f"image_width: 640\nimage_height: 480\ncamera_name: cam\n"
            f"camera_matrix: {{rows: 3, cols: 3, data: {matrix}}}\ndistortion_model: {model}\n"
            f"distortion_coefficients: {{rows: 1, cols: {len(coefficients)}, data: {coefficients}}}\n")


def test_calibrations_that_no_lens_has(folder):
    """Folds, poles and centres outside the image are said at the import and by `seam check`."""
    good = [530, 0, 320, 0, 530, 240, 0, 0, 1]
    # r - 0.5 r^3 grows up to r = 0.816, whose image is 288 px from the centre: inside the image.
    cases = {"fold": (good, "plumb_bob", [-0.5, 0, 0, 0, 0], ["folds the image over", "288 px from the principal point"]),
             # The quotient's pole is at r = 0.6148, 31.6 degrees.
             "pole": (good, "rational_polynomial", [0, -6.9, 0, 0, 0, 0, -7.0, 0], ["has a pole", "degrees"]),
             "near": (good, "plumb_bob", [-0.35, -0.6, 0, 0, 0.9], ["nearly folds"]),
             "centre": ([530, 0, 700, 0, 530, 240, 0, 0, 1], "plumb_bob", [0, 0, 0, 0, 0], ["principal point", "outside the image"]),
             "sound": (good, "plumb_bob", [-0.2, 0.05, 0.001, -0.001, 0], [])}
    for name, (matrix, model, coefficients, words) in cases.items():
        (folder / f"{name}.yaml").write_text(calibration(matrix, model, coefficients))
        said = imported("opencv", folder / f"{name}.yaml", "--board", "9x6", "--spacing", "0.03", out=folder / name)
        checked = run("check", folder / name) + run("check", folder / name / "nominal.yaml")
        for word in words:
            assert word in said and word in checked, (name, word, said, checked)
        if not words:
            assert "0 errors, 0 warnings" in checked and "folds" not in said and "pole" not in said, (said, checked)
    (folder / "zero.yaml").write_text(calibration([0] * 9, "plumb_bob", [0] * 5))
    refused("opencv", folder / "zero.yaml", "--board", "9x6", "--spacing", "0.03", out=folder / "zero",
            words=["zero.yaml:4", "not calibrated"])
    turned = np.array(good).reshape(3, 3).T.ravel().tolist()
    (folder / "turned.yaml").write_text(calibration(turned, "plumb_bob", [0] * 5))
    refused("opencv", folder / "turned.yaml", "--board", "9x6", "--spacing", "0.03", out=folder / "turned",
            words=["exchanged rows and columns"])


def corners_of_two(folder, header="sync_index,cam_id,keypoint_id,img_loc_x,img_loc_y"):
    """One board before two cameras, the second 0.1 m to the right of the first, in one table."""
    target, lines = board(), [header]
    for frame in range(14):
        R = rodrigues(np.append(RNG.uniform(-0.5, 0.5, 2), RNG.uniform(-0.3, 0.3)))
        p = (target - target.mean(axis=0)) @ R.T + [RNG.uniform(-0.02, 0.1), RNG.uniform(-0.04, 0.04), RNG.uniform(0.4, 0.5)]
        seen = [project(p) + 0.1 * RNG.standard_normal((len(target), 2)),
                project(p - [0.1, 0, 0]) + 0.1 * RNG.standard_normal((len(target), 2))]
        for point in range(len(target)):
            lines += [f"{frame},{camera},{point},{seen[camera][point][0]:.4f},{seen[camera][point][1]:.4f}" for camera in (0, 1)]
    (folder / "corners.csv").write_text("\n".join(lines) + "\n")


def chain(names=("cam0", "cam1")):
    text = ""
    for name in names:
        text += (f"{name}:\n  camera_model: pinhole\n  intrinsics: {K.tolist()}\n  distortion_model: radtan\n"
                 f"  distortion_coeffs: {D[:4].tolist()}\n  resolution: [640, 480]\n  rostopic: /{name}\n")
    # From the first camera's frame to the second's.
    return text + "  T_cn_cnm1:\n  - [1, 0, 0, -0.1]\n  - [0, 1, 0, 0]\n  - [0, 0, 1, 0]\n  - [0, 0, 0, 1]\n"


def test_corners_of_two_cameras(folder):
    given = [folder / "corners.csv", "--board", "9x6", "--spacing", "0.03", "--size", "640x480"]
    corners_of_two(folder)
    said = imported("kalibr", *given, out=folder / "first")
    assert "of the cameras 0, 1 the first, 0" in said, said
    assert len(rows_of(folder / "first" / "points.csv")) == 14 * 54
    imported("kalibr", *given, "--camera", "1", out=folder / "second")
    said = imported("kalibr", *given, "--camera", "0,1", out=folder / "rig")
    assert "14 frames, 14 of them seen by several cameras" in said, said
    rows = rows_of(folder / "rig" / "points.csv")
    assert [sum(row["camera"] == name for row in rows) for name in "01"] == [14 * 54] * 2
    nominal = (folder / "rig" / "nominal.yaml").read_text()
    assert "pinhole@0" in nominal and "pinhole@1" in nominal and "camera_pose@1" in nominal, nominal
    refused("kalibr", *given, "--camera", "2", out=folder / "none", words=["--camera 2", "0, 1"])
    larger = [word.replace("9x6", "10x6") if isinstance(word, str) else word for word in given]
    refused("kalibr", *larger, out=folder / "larger", words=["corners.csv", "points 0 to 53", "60 points", "inner corners"])
    # A column that no habit names is named by --map, and where it is not the reason is given.
    corners_of_two(folder, "frame,sensor,point,u,v")
    refused("kalibr", *given, out=folder / "twice", words=["corners.csv:3", "point 0 of frame 0", "--map camera=sensor"])
    refused("kalibr", *given, "--camera", "0,1", out=folder / "no", words=["no column of cameras", "--map camera="])
    imported("kalibr", *given, "--map", "camera=sensor", "--camera", "0,1", out=folder / "mapped")
    refused("kalibr", *given, "--map", "camera=sensr", out=folder / "typo", words=["sensr", "sensor"])
    # Two corners of one camera under one name.
    text = (folder / "corners.csv").read_text().replace("0,0,1,", "0,0,0,", 1)
    (folder / "corners.csv").write_text(text)
    refused("kalibr", *given, "--map", "camera=sensor", out=folder / "same", words=["both of camera 0"])


def test_corners_by_row_and_column(folder):
    """Their place on the board is a row and a column; a board stated the wrong way round is refused."""
    target, lines, numbered = board(), ["image,row,col,x_px,y_px"], ["frame,point,u,v"]
    for frame, view in enumerate(board_views(target)):
        for point, (u, v) in enumerate(view):
            lines.append(f"view{frame:02d}.png,{point // 9},{point % 9},{u:.4f},{v:.4f}")
            numbered.append(f"{frame},{point},{u:.4f},{v:.4f}")
    (folder / "corners.csv").write_text("\n".join(lines) + "\n")
    (folder / "numbered.csv").write_text("\n".join(numbered) + "\n")
    size = ["--spacing", "0.03", "--size", "640x480"]
    imported("kalibr", folder / "corners.csv", "--board", "9x6", *size, out=folder / "grid")
    imported("kalibr", folder / "numbered.csv", "--board", "9x6", *size, out=folder / "numbered")
    seen = [[{key: row[key] for key in row if key != "frame"} for row in rows_of(folder / name / "points.csv")]
            for name in ("grid", "numbered")]
    assert seen[0] == seen[1]
    refused("kalibr", folder / "corners.csv", "--board", "6x9", *size, out=folder / "turned",
            words=["corners.csv:8", "one of the board's 6 columns"])
    refused("kalibr", folder / "numbered.csv", "--board", "6x9", *size, out=folder / "turned",
            words=["board of 6x9", "fit one of 9x6", "--board 9x6"])
    (folder / "bare.csv").write_text("\n".join(lines).replace("image,row,col,", "image,row,line,") + "\n")
    refused("kalibr", folder / "bare.csv", "--board", "9x6", *size, out=folder / "bare",
            words=["bare.csv:1: no column for point", "row and column", "found image, row, line"])


def test_rig_of_a_camchain(folder):
    """The chain's transform is from the first camera to the second: the second stands 0.1 m to the right."""
    (folder / "chain.yaml").write_text(chain())
    imported("kalibr", folder / "chain.yaml", "--camera", "cam0,cam1", "--board", "9x6", "--spacing", "0.03", out=folder / "rig")
    nominal = (folder / "rig" / "nominal.yaml").read_text()
    assert "camera_pose@cam1: {x_m: 0.1, y_m: 0, z_m: 0, rx_rad: 0, ry_rad: 0, rz_rad: 0}" in nominal, nominal
    for name in ("cam0", "cam1"):
        assert f"pinhole@{name}" in nominal and f"radial_polynomial@{name}" in nominal, nominal
    # Seen from the second camera, the first one stands to its left.
    imported("kalibr", folder / "chain.yaml", "--camera", "cam1", "--board", "9x6", "--spacing", "0.03", out=folder / "one")
    assert "@" not in (folder / "one" / "nominal.yaml").read_text()
    # The corners that the two saw agree with the chain.
    global D
    kept, D = D, np.append(D[:4], 0)
    project.__defaults__ = (K, D)
    corners_of_two(folder)
    D = kept
    project.__defaults__ = (K, D)
    imported("kalibr", folder / "chain.yaml", folder / "corners.csv", "--camera", "0,1", "--board", "9x6", "--spacing", "0.03",
             out=folder / "seen")
    error = error_of(folder / "seen")
    assert 0.8 < error < 1.25, error
    refused("kalibr", folder / "chain.yaml", "--camera", "cam0,cam2", out=folder / "none", words=["cam2", "cam0, cam1"])
    (folder / "chain.yaml").write_text(chain().replace("[1, 0, 0, -0.1]", "[2, 0, 0, -0.1]"))
    refused("kalibr", folder / "chain.yaml", "--camera", "cam0,cam1", out=folder / "bent", words=["T_cn_cnm1", "rotation"])


def test_calibrations_print_focal_lengths_and_centre(folder):
    """With standard errors that hold the truth, in text, JSON and page."""
    (folder / "cv.yaml").write_text(storage(board_views(board())))
    imported("opencv", folder / "cv.yaml", "--board", "9x6", "--spacing", "0.03", out=folder / "set")
    # A calibration's numbers are fixed, and what is given is no result: here the camera is to be estimated.
    (folder / "free.yaml").write_text("format: seam-model/1\nname: free\neffects:\n  pinhole: {"
                                      + ", ".join(f"{name}: {{value: {value}, free: true}}" for name, value in
                                                  zip(("fx_px", "fy_px", "cx_px", "cy_px"), (410, 410, 320, 240))) + "}\n")
    given = ["--data", folder / "set", "--model", folder / "free.yaml"]
    names = ["focal length x", "focal length y", "centre x", "centre y"]
    for command in (["compare"], ["diagnose"], ["add", "radial_polynomial", "--out", folder / "more.yaml"]):
        said = run(*command, *given, "--json", folder / "out.json")
        figures = json.loads((folder / "out.json").read_text())["figures"]["figures"]
        assert [figure["name"] for figure in figures] == names, figures
        for figure in figures:
            assert figure["sigma"] > 0 and any(figure["name"] in line and "+-" in line for line in said.splitlines()), said
    run("fit", "--data", folder / "set", "--model", folder / "more.yaml", "--out", folder / "fit.yaml", "--json", folder / "out.json")
    run("add", "tangential_distortion", "--data", folder / "set", "--model", folder / "more.yaml", "--out", folder / "all.yaml",
        "--json", folder / "out.json")
    for figure, truth in zip(json.loads((folder / "out.json").read_text())["figures"]["figures"], K):
        assert abs(figure["value"] - truth) < 4 * figure["sigma"] < 8, (figure, truth)
    run("compare", *given, "--json", folder / "out.json")
    run("report", folder / "out.json", "--out", folder / "page.html")
    assert "focal length x" in (folder / "page.html").read_text()


def nominal_of(folder):
    return yaml.safe_load((folder / "nominal.yaml").read_text())["effects"]


def test_camodocal(folder):
    """VINS-Fusion's camera models: two that are effects, and Mei's, which is taken as its nearest lens."""
    head = "%YAML:1.0\n---\nmodel_type: {}\ncamera_name: front\nimage_width: 640\nimage_height: 480\n"
    (folder / "pinhole.yaml").write_text(
        head.format("PINHOLE") + "distortion_parameters:\n   k1: -0.21\n   k2: 0.06\n   p1: 0.0002\n   p2: -0.0003\n"
        "projection_parameters:\n   fx: 515.5\n   fy: 516.5\n   cx: 321.5\n   cy: 239.25\n")
    for kind in ("opencv", "kalibr"):
        imported(kind, folder / "pinhole.yaml", out=folder / kind)
        effects = nominal_of(folder / kind)
        assert effects["pinhole"] == {"fx_px": 515.5, "fy_px": 516.5, "cx_px": 321.5, "cy_px": 239.25}, effects
        assert effects["radial_polynomial"] == {"k1": -0.21, "k2": 0.06, "k3": 0}, effects
        assert effects["tangential_distortion"] == {"p1": 0.0002, "p2": -0.0003}, effects
    (folder / "kb.yaml").write_text(
        head.format("KANNALA_BRANDT") + "projection_parameters:\n   k2: -0.01\n   k3: 0.02\n   k4: -0.012\n   k5: 0.003\n"
        "   mu: 380.5\n   mv: 381.5\n   u0: 318.5\n   v0: 242.5\n")
    imported("opencv", folder / "kb.yaml", out=folder / "kb")
    effects = nominal_of(folder / "kb")
    assert effects["fisheye"] == {"k1": -0.01, "k2": 0.02, "k3": -0.012, "k4": 0.003}, effects
    assert effects["pinhole"]["fx_px"] == 380.5 and effects["pinhole"]["cy_px"] == 242.5, effects
    (folder / "mei.yaml").write_text(
        head.format("MEI") + "mirror_parameters:\n   xi: 1.2\ndistortion_parameters:\n   k1: -0.05\n   k2: 0.02\n"
        "   p1: 0\n   p2: 0\nprojection_parameters:\n   gamma1: 800\n   gamma2: 800\n   u0: 320\n   v0: 240\n")
    said = imported("opencv", folder / "mei.yaml", out=folder / "mei")
    assert "'MEI' is no effect" in said and "misses by" in said, said
    def mei(theta):
        x = np.sin(theta) / (np.cos(theta) + 1.2)
        return 800 * x * (1 - 0.05 * x * x + 0.02 * x**4)
    nearly(folder / "mei", mei)
    refused("opencv", folder / "mei.yaml", "--camera", "left", out=folder / "no", words=["--camera left", "front"])
    (folder / "other.yaml").write_text((folder / "kb.yaml").read_text().replace("KANNALA_BRANDT", "SCARAMUZZA"))
    refused("opencv", folder / "other.yaml", out=folder / "other", words=["other.yaml:3", "SCARAMUZZA", "KANNALA_BRANDT"])


def nearly(folder, radius_px, limit_px=0.5):
    """The nominal model's lens, of whatever form, takes rays within the image where another formula does."""
    effects = nominal_of(folder)
    theta = np.radians(np.arange(1, 90))
    theta = theta[radius_px(theta) < 320]
    assert len(theta) > 20
    if "fisheye" in effects:
        k = effects["fisheye"]
        bent = theta * (1 + k["k1"] * theta**2 + k["k2"] * theta**4 + k["k3"] * theta**6 + k["k4"] * theta**8)
    else:
        k = {name: 0 for name in ("k1", "k2", "k3", "k4", "k5", "k6")}
        k.update(effects.get("rational_lens", effects.get("radial_polynomial", {})))
        r2 = np.tan(theta) ** 2
        bent = np.tan(theta) * (1 + k["k1"] * r2 + k["k2"] * r2**2 + k["k3"] * r2**3) / (
            1 + k["k4"] * r2 + k["k5"] * r2**2 + k["k6"] * r2**3)
    worst = np.abs(effects["pinhole"]["fx_px"] * bent - radius_px(theta)).max()
    assert worst < limit_px, (worst, effects)


def test_orb_slam(folder):
    new = ("%YAML:1.0\n\nCamera.type: \"PinHole\"\nCamera1.fx: 520.5\nCamera1.fy: 521.5\nCamera1.cx: 322.5\n"
           "Camera1.cy: 238.5\nCamera1.k1: -0.2\nCamera1.k2: 0.05\nCamera1.p1: 0.0001\nCamera1.p2: -0.0002\n"
           "Camera.width: 640\nCamera.height: 480\n")
    (folder / "new.yaml").write_text(new)
    imported("opencv", folder / "new.yaml", out=folder / "new")
    effects = nominal_of(folder / "new")
    assert effects["pinhole"] == {"fx_px": 520.5, "fy_px": 521.5, "cx_px": 322.5, "cy_px": 238.5}, effects
    assert effects["radial_polynomial"] == {"k1": -0.2, "k2": 0.05, "k3": 0}, effects
    # Files of the second version name no size and no type; a third coefficient may follow.
    old = new.replace("Camera1.", "Camera.").replace('Camera.type: "PinHole"\n', "")
    old = old[:old.index("Camera.width")] + "Camera.k3: 0.01\n"
    (folder / "old.yaml").write_text(old)
    refused("opencv", folder / "old.yaml", out=folder / "none", words=["Camera.width", "--size"])
    imported("opencv", folder / "old.yaml", "--size", "640x480", out=folder / "old")
    assert nominal_of(folder / "old")["radial_polynomial"]["k3"] == 0.01
    # A stereo camera: the matrix takes points of the second camera to the first.
    wide = new.replace("PinHole", "KannalaBrandt8").replace("p1", "k3").replace("p2", "k4")
    second = "".join(line + "\n" for line in wide.splitlines() if line.startswith("Camera1")).replace("Camera1", "Camera2")
    (folder / "stereo.yaml").write_text(
        wide + second + "Stereo.T_c1_c2: !!opencv-matrix\n  rows: 4\n  cols: 4\n  dt: f\n"
        "  data: [1, 0, 0, 0.11, 0, 1, 0, 0.002, 0, 0, 1, 0, 0, 0, 0, 1]\n")
    imported("opencv", folder / "stereo.yaml", "--camera", "Camera1,Camera2", out=folder / "stereo")
    effects = nominal_of(folder / "stereo")
    assert effects["fisheye@Camera2"] == {"k1": -0.2, "k2": 0.05, "k3": 0.0001, "k4": -0.0002}, effects
    assert effects["camera_pose@Camera2"]["x_m"] == 0.11 and effects["camera_pose@Camera2"]["y_m"] == 0.002, effects


def test_basalt(folder):
    def camera(kind, **numbers):
        return {"camera_type": kind, "intrinsics": {"fx": 350.0, "fy": 350.0, "cx": 320.0, "cy": 240.0, **numbers}}
    place = {"px": 0.0, "py": 0.0, "pz": 0.0, "qx": 0.0, "qy": 0.0, "qz": 0.0, "qw": 1.0}
    calibration = {"value0": {
        "T_imu_cam": [place, {**place, "px": 0.12, "qy": 0.1, "qw": 0.99**0.5}, place, place],
        "intrinsics": [camera("kb4", k1=0.01, k2=-0.02, k3=0.01, k4=-0.002), camera("ds", xi=-0.2, alpha=0.57),
                       camera("pinhole-radtan8", k1=0.1, k2=0.02, p1=0.001, p2=-0.001, k3=0.003, k4=0.2, k5=0.03, k6=0.001),
                       camera("eucm", alpha=0.6, beta=1.1)],
        "resolution": [[640, 480]] * 4}}
    (folder / "calib.json").write_text(json.dumps(calibration, indent=4))
    said = imported("opencv", folder / "calib.json", "--camera", "cam0,cam1", out=folder / "rig")
    effects = nominal_of(folder / "rig")
    assert effects["fisheye@cam0"] == {"k1": 0.01, "k2": -0.02, "k3": 0.01, "k4": -0.002}, effects
    turned = effects["camera_pose@cam1"]
    assert abs(turned["x_m"] - 0.12) < 1e-9 and abs(turned["ry_rad"] - 2 * np.arcsin(0.1)) < 1e-9, turned
    assert "'ds' is no effect" in said, said
    imported("opencv", folder / "calib.json", "--camera", "cam1", out=folder / "ds")
    def double_sphere(theta):
        z = np.cos(theta) - 0.2
        return 350 * np.sin(theta) / (0.57 * np.hypot(np.sin(theta), z) + 0.43 * z)
    nearly(folder / "ds", double_sphere)
    imported("opencv", folder / "calib.json", "--camera", "cam2", out=folder / "radtan8")
    assert nominal_of(folder / "radtan8")["rational_lens"] == {"k1": 0.1, "k2": 0.02, "k3": 0.003, "k4": 0.2, "k5": 0.03, "k6": 0.001}
    imported("opencv", folder / "calib.json", "--camera", "cam3", out=folder / "eucm")
    nearly(folder / "eucm", lambda t: 350 * np.sin(t) / (0.6 * np.sqrt(1.1 * np.sin(t)**2 + np.cos(t)**2) + 0.4 * np.cos(t)))
    calibration["value0"]["intrinsics"][0]["camera_type"] = "fov"
    (folder / "calib.json").write_text(json.dumps(calibration))
    refused("opencv", folder / "calib.json", out=folder / "fov", words=["fov", "eucm"])


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
    # Without a calibration the focal length is estimated from the views.
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


def test_round_trip_of_splines(folder):
    import yaml
    model, lens = folder / "model.yaml", "  spline_lens: {fov_x_deg: 98, x_1_1: -0.02, y_4_5: 0.015625}\n"
    model.write_text("format: seam-model/1\nname: seen\neffects:\n  pinhole: {fx_px: 400, fy_px: 401, cx_px: 320, cy_px: 239}\n" + lens)
    run("export", model, "--to", "mrcal", "--out", folder / "s.cameramodel", "--size", "640x480")
    said = imported("mrcal", folder / "s.cameramodel", out=folder / "back")
    assert "a lens of splines" in said and "warning" not in said, said
    back = yaml.safe_load((folder / "back" / "nominal.yaml").read_text())["effects"]
    assert back["pinhole"] == {"fx_px": 400, "fy_px": 401, "cx_px": 320, "cy_px": 239}
    assert {name: float(value) for name, value in back["spline_lens"].items() if float(value) != 0} == yaml.safe_load(lens)["spline_lens"]
    # What says so many values says few of them.
    assert "fov_x_deg = 98, and 96 more values" in run("check", folder / "back" / "nominal.yaml")
    assert "and 92 more like these: " in run("effects", "spline_lens")
    run("measure", "--model", folder / "back" / "nominal.yaml", "--protocol", folder / "back", "--out", folder / "made")
    plain = folder / "plain.yaml"
    plain.write_text(model.read_text().replace(lens, ""))
    said = run("add", "spline_lens", "--model", plain, "--data", folder / "made", "--out", folder / "added.yaml")
    assert "and 96 more values, in the model" in said and said.count("not fitted") <= 2, said
    # A lens that folds the image over is written with a doubt.
    narrow = folder / "narrow.yaml"
    narrow.write_text(model.read_text().replace("fov_x_deg: 98", "fov_x_deg: 5"))
    said = run("export", narrow, "--to", "mrcal", "--out", folder / "narrow.cameramodel", "--size", "640x480")
    assert "folds the image over" in said, said
    # Other grids are no lens of the catalogue.
    text = (folder / "s.cameramodel").read_text()
    for was, becomes in [("Nx=8", "Nx=9"), ("-0.02", "-20"), ("98'", "9x'"), ("0.015625, ", "")]:
        assert text.count(was) == 1
        (folder / "other.cameramodel").write_text(text.replace(was, becomes))
        said = imported("mrcal", folder / "other.cameramodel", out=folder / f"other{ord(was[0])}{len(was)}")
        assert "is no lens of the catalogue" in said, said


run_tests(globals())
