#!/usr/bin/env python3
"""`seam import images`: targets that SEAM has drawn itself, so that each corner's place is known; pictures that show none,
part of one, another one, a blur; times; files of strangers. `images_test.py path/to/seam`
"""
import csv
import json
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import zlib

import numpy as np
from PIL import Image

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from ros_bags import Cdr, mcap_file, ros1_bag  # noqa: E402
from target_pictures import AprilGrid, Charuco, Chessboard, Circles, draw, projected, tag_bits, views  # noqa: E402

import by_hand

SEAM = by_hand.arguments("seam")
WIDTH, HEIGHT, FOCAL = 480, 360, 450


def run(*arguments, code=0, seam=SEAM):
    done = subprocess.run([seam, *map(str, arguments)], capture_output=True, text=True, timeout=120)
    assert done.returncode == code, (arguments, done.returncode, done.stdout, done.stderr)
    return done.stdout + done.stderr


def yaml(folder, name, **values):
    path = folder / f"{name}.yaml"
    path.write_text("".join(f"{key}: {value}\n" for key, value in values.items()))
    return path


def targets(folder):
    """(name, what is drawn, what is said of it)."""
    yield "chessboard", Chessboard(8, 5, 0.03), ["--board", "8x5", "--spacing", "0.03"]
    yield "circles", Circles(7, 5, 0.03, 0.009), ["--board", "7x5", "--spacing", "30", "--length-unit", "mm", "--target", "circles"]
    yield "asymmetric", Circles(4, 7, 0.02, 0.008, True), [
        yaml(folder, "asymmetric", target_type="circlegrid", targetCols=4, targetRows=7, spacingMeters=0.02, asymmetricGrid="true")]
    yield "aprilgrid", AprilGrid(4, 3, 0.05, 0.3, tag_bits), [
        yaml(folder, "aprilgrid", target_type="aprilgrid", tagCols=4, tagRows=3, tagSize=0.05, tagSpacing=0.3)]
    for first_is_dark in (True, False):
        yield f"charuco{first_is_dark}", Charuco(5, 4, 0.04, 0.03, first_is_dark), [
            yaml(folder, "charuco", target_type="charuco", squareCols=5, squareRows=4, squareSize=0.04, markerSize=0.03,
                 dictionary="DICT_4X4_50")]


def seen_in(folder):
    """{frame: {point: (u, v)}}"""
    seen = {}
    for row in csv.DictReader((folder / "points.csv").open()):
        seen.setdefault(row["frame"], {})[int(row["point"])] = tuple(float(row[k]) for k in ("u_px", "v_px"))
    return seen


def errors_of(out, target, poses):
    """Of each corner found, u and v."""
    errors = []
    for frame, points in seen_in(out).items():
        truth = projected(target, poses[int(pathlib.Path(frame).stem)], FOCAL, WIDTH, HEIGHT)
        errors += [(u - truth[p][0], v - truth[p][1]) for p, (u, v) in points.items()]
    return np.array(errors)


def turned(out, target, poses):
    """The same for a target that looks the same turned round: the better way for each view."""
    last, errors = len(target.points) - 1, []
    for frame, points in seen_in(out).items():
        truth = projected(target, poses[int(pathlib.Path(frame).stem)], FOCAL, WIDTH, HEIGHT)
        ways = [[(u - truth[k][0], v - truth[k][1]) for k, (u, v) in ((way(p), s) for p, s in points.items())]
                for way in (lambda p: p, lambda p: last - p)]
        errors += min(ways, key=lambda way: np.abs(way).max())
    return np.array(errors)


def test_known_corners(folder):
    """Sharp pictures: no bias, and the stated scatter holds."""
    for name, target, words in targets(folder):
        poses = views(target, 5, FOCAL, WIDTH, HEIGHT)
        pictures = draw(run, target, poses, FOCAL, WIDTH, HEIGHT, folder / name, "  lens_blur: {sigma_px: 0.6}\n")
        out = folder / f"{name}-set"
        said = run("import", "images", pictures[0].parent, *words, "--out", out)
        assert "5 of 5 pictures show the target" in said, said
        assert "0 errors" in run("check", out)
        e = (turned if name == "circles" else errors_of)(out, target, poses)
        assert len(e) > 4.5 * len(target.points), (name, len(e))
        assert np.abs(e.mean(0)).max() < 0.005 and e.std(0).max() < 0.02 and np.abs(e).max() < 0.08, \
            (name, e.mean(0), e.std(0), np.abs(e).max())


def test_scatter(folder):
    """Noise of the sensor becomes scatter of the corners: many views leave it to the fit, few have it stated."""
    target = Chessboard(8, 5, 0.03)
    poses = views(target, 8, FOCAL, WIDTH, HEIGHT)
    pictures = draw(run, target, poses, FOCAL, WIDTH, HEIGHT, folder / "noisy",
                    "  lens_blur: {sigma_px: 0.8}\n  linear_response: {gain_dn: 255}\n  read_noise: {sigma_dn: 12}\n", noise=True)
    out = folder / "noisy-set"
    run("import", "images", *pictures, "--board", "8x5", "--spacing", "0.03", "--out", out)
    e = errors_of(out, target, poses)
    size = np.sqrt((e ** 2).mean())
    assert "sigma_px" not in (out / "points.csv").read_text()
    run("fit", "--model", out / "nominal.yaml", "--data", out, "--out", folder / "fitted.yaml")
    run("compare", "--model", folder / "fitted.yaml", "--data", out, "--json", folder / "c.json")
    told = np.mean(list(json.loads((folder / "c.json").read_text())["noise"].values()))
    assert 0.02 < told and 0.8 < told / size < 1.2, (told, size)
    few = folder / "noisy-few"
    run("import", "images", *pictures[:3], "--board", "8x5", "--spacing", "0.03", "--out", few)
    with (few / "points.csv").open() as file:
        told = np.sqrt(np.mean([float(row["sigma_px"]) ** 2 for row in csv.DictReader(file)]))
    assert 0.75 < told / size < 1.25, (told, size)
    # Views of six points tell no noise of their own, however many they are.
    target = Circles(3, 2, 0.06, 0.018)
    small = draw(run, target, views(target, 5, FOCAL, WIDTH, HEIGHT), FOCAL, WIDTH, HEIGHT, folder / "small")
    run("import", "images", *small, "--board", "3x2", "--spacing", "0.06", "--target", "circles", "--out", folder / "small-set")
    run("compare", "--model", folder / "small-set" / "nominal.yaml", "--data", folder / "small-set")
    assert np.abs(e.mean(0)).max() < 0.01, e.mean(0)
    return pictures


def png(path, width, height, rows):
    chunk = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">2I5B", width, height, 8, 0, 0, 0, 0)) +
                     chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b""))


def test_what_is_left_out(folder, good):
    """Each picture that does not serve is named with its reason, and counted."""
    bad = folder / "bad"
    bad.mkdir()
    for picture in good[:5]:
        shutil.copy(picture, bad)
    image = Image.open(good[0]).convert("L")
    image.crop((0, 0, WIDTH // 2, HEIGHT)).resize((WIDTH, 2 * HEIGHT)).crop((0, 0, WIDTH, HEIGHT)).save(bad / "half.png")
    Image.new("L", (WIDTH, HEIGHT), 120).save(bad / "grey.png")
    image.resize((2 * WIDTH, 2 * HEIGHT)).save(bad / "large.png")
    other = draw(run, Chessboard(6, 4, 0.03), views(Chessboard(6, 4, 0.03), 2, FOCAL, WIDTH, HEIGHT), FOCAL, WIDTH, HEIGHT,
                 folder / "other")
    shutil.copy(other[0], bad / "other.png")
    target = Chessboard(8, 5, 0.03)
    shaken = draw(run, target, views(target, 2, FOCAL, WIDTH, HEIGHT), FOCAL, WIDTH, HEIGHT, folder / "shaken",
                  "  lens_blur: {sigma_px: 3.5}\n")
    shutil.copy(shaken[0], bad / "blurred.png")
    (bad / "text.png").write_text("no picture at all, but some text\n")
    (bad / "cut.png").write_bytes(good[0].read_bytes()[:700])
    png(bad / "bomb.png", 60000, 60000, bytes(1000))
    out = folder / "bad-set"
    said = run("import", "images", bad, "--board", "8x5", "--spacing", "0.03", "--out", out)
    assert len(seen_in(out)) == 5 and "5 of 13 pictures show the target" in said, said
    lines = {line.split("left out, ")[1].split(":")[0]: line for line in said.splitlines() if "left out" in line}
    for why, name in (("no target", "grey.png"), ("of another size", "large.png"), ("part of the target or a smaller one", "half.png"),
                      ("part of the target or a smaller one", "other.png"), ("blurred", "blurred.png"), ("too large", "bomb.png"),
                      ("no picture that can be read", "text.png"), ("no picture that can be read", "cut.png")):
        assert name in lines.get(why, ""), (why, name, said)
    assert "2 of 13" in lines["no picture that can be read"], said
    assert "more than 64 million pixels" in lines["too large"], said
    # Nothing that serves: an error with the reasons, and no set.
    said = run("import", "images", bad / "grey.png", bad / "text.png", "--board", "8x5", "--spacing", "0.03", "--out",
               folder / "none", code=1)
    assert "no picture shows the target" in said and "1 of 2" in said and not (folder / "none").exists(), said
    said = run("import", "images", *good[:2], "--board", "6x4", "--spacing", "0.03", "--out", folder / "none", code=1)
    assert "another target: 0000.png (a board of 8 x 5 corners)" in said, said


def answers(picture, *target):
    """What the reader says of one picture, and the most memory that it held, in bytes."""
    reader = subprocess.Popen([SEAM.parent / "seam-pictures", *target], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    reader.stdin.write(f"{picture}\n")
    reader.stdin.close()
    text = reader.stdout.read()
    _, status, usage = os.wait4(reader.pid, 0)
    reader.returncode = status
    assert status == 0, (status, text)
    return text, 1024 * usage.ru_maxrss


def test_large_pictures(folder, good):
    """A small file may be a large picture: 4 bytes a pixel at most, and corners as good as in a small one."""
    small, library = answers(good[0], "chessboard", "8", "5")
    width = height = 8000
    png(folder / "empty.png", width, height, bytes((width + 1) * height))
    said, memory = answers(folder / "empty.png", "chessboard", "8", "5")
    assert "without no target" in said, said
    assert memory - library < 4 * width * height, (memory, library)
    said, memory = answers(folder / "empty.png", "circles", "7", "5")
    assert "without too large: more than 16 million pixels" in said, said
    assert memory - library < 4 * width * height, (memory, library)
    # A sharp picture ten times as large, which is searched in a smaller copy and refined in the whole.
    sharp = sorted((folder / "chessboard").rglob("*.png"))[0]
    small, library = answers(sharp, "chessboard", "8", "5")
    Image.open(sharp).convert("L").resize((10 * WIDTH, 10 * HEIGHT), Image.NEAREST).save(folder / "large.png")
    large, memory = answers(folder / "large.png", "chessboard", "8", "5")
    assert memory - library < 5 * 100 * WIDTH * HEIGHT, (memory, library)

    def corners(text):
        return {int(p): (float(u), float(v)) for what, p, u, v in
                (line.split() for line in text.splitlines() if line.startswith("corner"))}

    few, many = corners(small), corners(large)
    assert len(few) == len(many) == 40
    # Its pixels are squares of ten by ten: edges come in steps of ten, of which a corner's place averages some.
    off = np.array([many[point] for point in few]) - (10 * np.array(list(few.values())) + 4.5)
    assert np.abs(off.mean(0)).max() < 0.5 and off.std(0).max() < 1.5, (off.mean(0), off.std(0))


def test_times(folder, good):
    words = ["--board", "8x5", "--spacing", "0.03"]
    start = 1403636579763555584
    stamped, numbered, camera = folder / "stamped", folder / "numbered", folder / "camera"
    for place in (stamped, numbered, camera):
        place.mkdir()
    for i, picture in enumerate(good[:4]):
        shutil.copy(picture, stamped / f"cam0_{start + 50_000_000 * i}.png")
        shutil.copy(picture, numbered / f"frame{8 + i}.png")
        exif = Image.Exif()
        exif[0x8769] = {0x9003: "2024:05:01 12:30:15", 0x9291: f"{20 + 5 * i}"}
        Image.open(picture).convert("L").save(camera / f"IMG_{i}.jpg", quality=97, exif=exif)
    (folder / "times.csv").write_text("file,time_ms\n" + "".join(f"frame{8 + i}.png,{100 + 40 * i}\n" for i in range(4)))

    def times(out, *arguments):
        run("import", "images", *arguments, *words, "--out", folder / out)
        rows = list(csv.DictReader((folder / out / "points.csv").open()))
        return list(dict.fromkeys((row["frame"], row["time_s"]) for row in rows))
    assert times("t1", stamped)[1] == (f"cam0_{start + 50_000_000}.png", "1403636579.813555584")
    # 10 stands behind 9, and numbers alone are no times.
    assert [frame for frame, _ in times("t2", numbered)] == [f"frame{8 + i}.png" for i in range(4)]
    assert "when the views were taken" in (folder / "t2/measurement.yaml").read_text()
    assert [t for _, t in times("t3", numbered, folder / "times.csv")] == [f"0.{100 + 40 * i}000000" for i in range(4)]
    assert [t.split(".")[1] for _, t in times("t4", camera)] == [f"{20 + 5 * i}0000000" for i in range(4)]
    # The same bytes again, one picture at a time or all.
    times("t5", *sorted(numbered.glob("*.png"), reverse=True), folder / "times.csv")
    assert (folder / "t5/points.csv").read_bytes() == (folder / "t3/points.csv").read_bytes()


def test_two_cameras(folder, good):
    """Pictures of two cameras, by their names or folders, are separated; one is taken unless both are asked for."""
    words = ["--board", "8x5", "--spacing", "0.03"]
    named = folder / "pair"
    for side in ("left", "right"):
        (folder / side).mkdir()
    named.mkdir()
    for i, picture in enumerate(good[:2]):
        for side in ("left", "right"):
            shutil.copy(picture, named / f"{side}{i:02d}.png")
            shutil.copy(picture, folder / side / f"{i:02d}.png")
    for sources in ([named], [folder / "left", folder / "right"]):
        said = run("import", "images", *sources, *words, "--out", folder / f"of-{sources[0].name}")
        assert "of the cameras left, right, by the pictures' names, left" in said and "2 of 2 pictures" in said, said
    run("import", "images", named, *words, "--camera", "right", "--out", folder / "of-right")
    assert set(seen_in(folder / "of-right")) == {"right00.png", "right01.png"}
    said = run("import", "images", named, *words, "--camera", "upwards", "--out", folder / "none", code=1)
    assert "--camera upwards" in said, said


def test_a_rig(folder):
    """Two cameras that stand apart, drawn: one set of both, from which a fit finds where the right one stands."""
    words = ["--board", "8x5", "--spacing", "0.03", "--camera", "left,right"]
    target, offset = Chessboard(8, 5, 0.03), np.array([0.03, -0.01, 0.02])
    poses = views(target, 6, FOCAL, WIDTH, HEIGHT, fill=0.4)
    both = folder / "both"
    both.mkdir()
    blur = "  lens_blur: {sigma_px: 0.6}\n"
    for side, of_side in (("left", poses), ("right", [(m, p + m @ offset) for m, p in poses])):
        (both / side).mkdir()
        for i, picture in enumerate(draw(run, target, of_side, FOCAL, WIDTH, HEIGHT, folder / f"drawn-{side}", blur)):
            shutil.copy(picture, both / side / f"{i}.png")
    (both / "right/3.png").unlink()
    out = folder / "rig-set"
    # As a shell completes the names of folders.
    said = run("import", "images", f"{both / 'left'}/", f"{both / 'right'}/", *words, "--out", out)
    assert "Imported from left, right (images)" in (out / "measurement.yaml").read_text()
    assert "6 frames, 5 of them seen by several cameras" in said and "11 of 11 pictures show the target" in said, said
    rows = list(csv.DictReader((out / "points.csv").open()))
    assert {row["camera"] for row in rows if row["frame"] == "2.png"} == {"left", "right"}
    assert {row["camera"] for row in rows if row["frame"] == "3.png"} == {"left"}
    assert len({row["time_s"] for row in rows if row["frame"] == "2.png"}) == 1
    assert "0 errors" in run("check", out)
    run("fit", "--model", out / "nominal.yaml", "--data", out, "--out", folder / "rig.yaml")
    place = next(line for line in (folder / "rig.yaml").read_text().splitlines() if "camera_pose@right" in line)
    for name, true in zip(("x_m", "y_m", "z_m"), offset):
        value = float(place.split(f"{name}: {{value: ")[1].split(",")[0])
        assert abs(value - true) < 5e-4, (name, value, true)
    # By stamps, which need not be the same; frames that only one camera took stay.
    stamped = folder / "rig-stamped"
    stamped.mkdir()
    for side, late_ns in (("left", 0), ("right", 3_000_000)):
        for picture in sorted((both / side).iterdir()):
            stamp = 1403636579000000000 + 100_000_000 * int(picture.stem) + late_ns
            shutil.copy(picture, stamped / f"{side}_{stamp}.png")
    said = run("import", "images", stamped, *words, "--out", folder / "rig-timed")
    assert "6 frames, 5 of them seen by several cameras" in said and "up to 3 ms apart" in said, said
    # The same from a bag, whose topics name the cameras.
    messages = []
    for picture in sorted(stamped.iterdir(), key=lambda one: one.stem.split("_")[1]):
        side, stamp = picture.stem.split("_")
        head = Cdr(False).header(int(stamp) / 1e9).text("png").put("I", picture.stat().st_size)
        head.data += picture.read_bytes()
        messages.append((f"/{side}/compressed", "sensor_msgs/CompressedImage", int(stamp) / 1e9, head.data))
    (folder / "rig.mcap").write_bytes(mcap_file(messages))
    for kind in ("images", "ros"):
        said = run("import", kind, folder / "rig.mcap", *words, "--out", folder / f"rig-bag-{kind}")
        assert "6 frames, 5 of them seen by several cameras" in said and "up to 3 ms apart" in said, said

    def corners(of):
        return [(row["camera"], row["u_px"], row["v_px"]) for row in csv.DictReader((folder / of / "points.csv").open())]
    assert corners("rig-bag-images") == corners("rig-timed") == corners("rig-bag-ros")
    # What is no rig is said.
    for camera, why, code in (("left,left", "each once", 2), ("left,", "each once", 2), ("left,up", "no picture's name holds it", 1)):
        said = run("import", "images", both / "left", both / "right", *words[:-1], camera, "--out", folder / "none", code=code)
        assert why in said, (camera, said)
    (both / "right").rename(both / "right-later")
    for picture in sorted((both / "right-later").iterdir()):
        picture.rename(picture.with_name(f"{10 + int(picture.stem)}.png"))
    said = run("import", "images", both / "left", both / "right-later", *words, "--out", folder / "none", code=1)
    assert "camera 'left' saw the target in no frame together with another camera" in said, said


def mosaic_message(ros1, t, picture, order):
    """As a sensor with filters of this order sees it, under warm light, so that neighbours differ, and with blue a pixel
    to the right: taken for red it would move corners three times as far."""
    pixels = (np.asarray(Image.open(picture).convert("RGB")) * [1.0, 0.8, 0.4]).astype(np.uint8)
    pixels[:, 1:, 2] = pixels[:, :-1, 2].copy()
    mosaic = np.empty(pixels.shape[:2], np.uint8)
    for place, colour in enumerate(order):
        rows, columns = slice(place // 2, None, 2), slice(place % 2, None, 2)
        mosaic[rows, columns] = pixels[rows, columns, "rgb".index(colour)]
    head = Cdr(ros1).header(t).put("I", HEIGHT, WIDTH).text(f"bayer_{order}8").put("B", 0).put("I", WIDTH)
    head.put("I", mosaic.size).data += mosaic.tobytes()
    return "/left/image_raw", "sensor_msgs/Image", t, head.data


def test_bags(folder, good):
    """Pictures in bags of both kinds, plain and packed, are those of the files, with the messages' stamps."""
    words = ["--board", "8x5", "--spacing", "0.03"]

    def message(ros1, i, picture, packed):
        head = Cdr(ros1).header(100 + 0.05 * i)
        if packed:
            data = picture.read_bytes()
            head.text("png").put("I", len(data)).data += data
            return "/left/compressed", "sensor_msgs/CompressedImage", 100 + 0.05 * i, head.data
        pixels = np.asarray(Image.open(picture).convert("RGB"))[:, :, ::-1]  # bgr8, with a gap behind each row.
        data = b"".join(row.tobytes() + b"gap" for row in pixels)
        head.put("I", HEIGHT, WIDTH).text("bgr8").put("B", 0).put("I", 3 * WIDTH + 3).put("I", len(data)).data += data
        return "/right/image_raw", "sensor_msgs/Image", 100 + 0.05 * i, head.data
    plain = [folder / f"{i}.ppm" for i in range(3)]
    for picture, path in zip(good, plain):
        Image.open(picture).convert("RGB").save(path)
    truth = {}
    for topic, files in (("left", good[:3]), ("right", plain)):
        run("import", "images", *files, *words, "--out", folder / f"{topic}-files")
        truth[topic] = list(seen_in(folder / f"{topic}-files").values())
    for ros1, name in ((False, "camera.mcap"), (True, "camera.bag")):
        messages = [message(ros1, i, picture, packed) for i, picture in enumerate(good[:3]) for packed in (True, False)]
        (folder / name).write_bytes(ros1_bag(messages) if ros1 else mcap_file(messages))
        for topic, kind in (("left", "images"), ("right", "ros")):
            out = folder / f"{name}-{topic}"
            said = run("import", kind, folder / name, *words, "--camera", topic, "--out", out)
            assert f"times are those of the stamps of /{topic}" in said, said
            seen = list(seen_in(out).values())
            assert len(seen) == 3
            for a, b in zip(seen, truth[topic]):
                assert a == b, (name, topic)
            times = {row["time_s"] for row in csv.DictReader((out / "points.csv").open())}
            assert times == {"100.000000000", "100.050000000", "100.100000000"}, times
        # Mosaics of colours in each of their orders, and the calibration beside them.
        for order in ("rggb",) if ros1 else ("rggb", "bggr", "gbrg", "grbg"):
            raw = []
            for i, picture in enumerate(good[:3]):
                t = 100 + 0.05 * i
                raw.append(mosaic_message(ros1, t, picture, order))
                for space, focal in (("/left", FOCAL), ("/right", 2 * FOCAL)):
                    info = Cdr(ros1).header(t).put("I", HEIGHT, WIDTH).text("plumb_bob").reals([0.0] * 5)
                    info.put("d", focal, 0, (WIDTH - 1) / 2, 0, focal, (HEIGHT - 1) / 2, 0, 0, 1, *[0] * 21)
                    raw.append((f"{space}/camera_info", "sensor_msgs/CameraInfo", t, info.data))
            (folder / f"{order}-{name}").write_bytes(ros1_bag(raw) if ros1 else mcap_file(raw))
            out = folder / f"{order}-{name}-set"
            said = run("import", "images", folder / f"{order}-{name}", *words, "--out", out)
            assert "the nominal model is the calibration" in said, said
            assert f"fx_px: {FOCAL:g}" in (out / "nominal.yaml").read_text()
            for a, b in zip(seen_in(out).values(), truth["right"]):
                # Each pixel's neighbours give it two colours of three, so that noise is another; blue has its share.
                off = np.array([np.subtract(a[p][:2], b[p][:2]) for p in b])
                share = 0.114 * 0.4 / (0.299 + 0.587 * 0.8 + 0.114 * 0.4)
                assert len(a) == len(b) and off.std(0).max() < 0.08, (order, off.std(0))
                assert np.abs(off.mean(0) - [share, 0]).max() < 0.035, (order, off.mean(0))
        said = run("import", "images", folder / name, *words, "--camera", "up", "--out", folder / "none", code=1)
        assert "no such topic of images" in said, said


def test_the_reader(folder, good):
    """A reader that breaks down costs one picture; where there is none, that is said."""
    here = folder / "program"
    here.mkdir()
    seam = here / "seam"
    shutil.copy(SEAM, seam)
    words = ["import", "images", *good, "--board", "8x5", "--spacing", "0.03", "--out"]
    said = run(*words, folder / "r1", code=1, seam=seam)
    assert "seam-pictures" in said and "libopencv-contrib-dev" in said, said
    fake = here / "seam-pictures"
    fake.write_text(f"""#!/bin/sh
while read name; do case $name in
  *0001.png) kill -SEGV $$ ;;
  *0002.png) echo "corner 4000 1 2"; echo end ;;
  *) echo "$name" | {SEAM.parent}/seam-pictures "$@" ;;
esac; done
""")
    fake.chmod(0o755)
    said = run(*words, folder / "r2", seam=seam)
    assert f"2 of {len(good)} pictures left out, the reader of pictures broke down on it: 0001.png, 0002.png" in said, said
    assert len(seen_in(folder / "r2")) == len(good) - 2


def main():
    if not (SEAM.parent / "seam-pictures").exists():
        print("skipped: this build has no seam-pictures")
        sys.exit(77)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        test_known_corners(folder)
        if sys.argv[2:] == ["test_known_corners"]:
            return
        good = test_scatter(folder)
        test_what_is_left_out(folder, good)
        test_large_pictures(folder, good)
        test_times(folder, good)
        test_two_cameras(folder, good)
        test_a_rig(folder)
        test_bags(folder, good)
        test_the_reader(folder, good)


main()
