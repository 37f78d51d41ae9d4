#!/usr/bin/env python3
"""Sets of inertial sensors, made by numpy alone: what is hidden is found with its values, and nothing where nothing is;
import and exports: imu_test.py SEAM"""
import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest
import unittest.mock

import by_hand

try:
    import numpy as np
except ImportError:
    sys.exit(77)

SEAM = by_hand.arguments("seam")
ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "benchmark"))

import imu  # noqa: E402


def run(*arguments, code=0):
    done = subprocess.run([SEAM, *map(str, arguments)], capture_output=True, text=True, timeout=600)
    assert done.returncode == code, (arguments, done.returncode, done.stdout, done.stderr)
    return done.stdout + done.stderr


def discovered(folder):
    out = folder / "found.json"
    run("discover", "--model", folder / "nominal.yaml", "--data", folder, "--out", folder / "found.yaml", "--json", out)
    return json.loads(out.read_text())


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))

    def found(self, effect, number=1):
        folder = self.folder / f"{effect}-{number}"
        return imu.make(folder, effect, number), discovered(folder), folder

    def is_found(self, effect, number=1):
        values, found, folder = self.found(effect, number)
        self.assertEqual([step["effect"] for step in found["steps"]], [effect], found["headline"])
        self.assertEqual(found["verdict"], "adequate")
        for name, value in values.items():
            seen = found["steps"][0]["parameters"][name]
            # A skew for which the data do not ask stays 0.
            sigma = 1 if name == "skew" and seen["sigma"] is None else seen["sigma"]
            self.assertLess(abs(seen["value"] - value), 5 * sigma + 0.03 * abs(value), (name, value, seen))
        return found, folder


class Tables(Case):
    def test_names_of_files_end_no_cell(self):
        tables = [self.folder / name for name in ('a,"b.csv', "c\nd.csv")]
        for table in tables:
            table.write_text("time,gx,gy,gz\n" + "".join(f"{0.01 * k:.2f}," + ",".join(f"{0.01 * (k * step % 101)}" for step in (7919, 31, 57)) + "\n" for k in range(300)))
        run("import", "imu", *tables, "--out", self.folder / "out")
        rows = (self.folder / "out" / "imu.csv").read_text().splitlines()
        self.assertEqual({row.split(",")[0] for row in rows[1:]}, {"1 a__b", "2 c_d"})

    def test_columns_that_take_no_part_are_named(self):
        table = self.folder / "battery.csv"
        table.write_text("time,gx,gy,gz,battery\n" + "".join(
            f"{0.01 * k:.2f}," + ",".join(f"{0.01 * (k * step % 101)}" for step in (7919, 31, 57, 3)) + "\n" for k in range(300)))
        said = run("import", "imu", table, "--out", self.folder / "out")
        self.assertIn("left out: battery; readings are compared with time and temperature_c alone", said)

    def test_a_column_that_stands_twice_is_refused(self):
        table = self.folder / "twice.csv"
        table.write_text("# of a sensor\ntime,gx,gy,gz,gx\n" + "".join(f"{0.01 * k:.2f},1,2,3,4\n" for k in range(100)))
        said = run("import", "imu", table, "--out", self.folder / "out", code=1)
        self.assertIn("twice.csv:2: column 'gx' stands twice", said)
        self.assertFalse((self.folder / "out").exists())


class Sets(Case):
    def follows_the_curve(self, found):
        curves = {curve["of"]: curve for curve in found["curves"]}
        for point in curves["wx_radps"]["points"]:
            # The model found follows the measured curve, within its errors, which are larger for a walk.
            self.assertLess(abs(point["value"] - point["expected"]), 6 * point["sigma"] + 0.05 * point["expected"])

    def test_nothing_where_nothing_is(self):
        _, found, _ = self.found("nothing")
        self.assertEqual([step["effect"] for step in found["steps"]], [], found["headline"])

    def test_steps_walks_and_warmth(self):
        for effect in ("gyro_quantisation", "accel_quantisation", "accel_random_walk", "accel_temperature"):
            with self.subTest(effect):
                self.is_found(effect)

    def test_axes_that_mix_and_ends_of_ranges(self):
        for effect in ("gyro_misalignment", "gyro_saturation", "accel_saturation"):
            with self.subTest(effect):
                self.is_found(effect)

    def test_lines_of_vibrations(self):
        for effect, number in (("gyro_vibration", 1), ("gyro_vibration", 4), ("accel_vibration", 2)):
            with self.subTest(effect, number=number):
                found, _ = self.is_found(effect, number)
                self.follows_the_curve(found)

    def test_clock_and_stamps(self):
        for effect in ("imu_clock", "imu_jitter"):
            with self.subTest(effect):
                _, folder = self.is_found(effect)
        # Without the rate by the sensor's own clock stamps tell nothing, and SEAM says why.
        settings = folder / "measurement.yaml"
        settings.write_text(re.sub("rate_hz.*\n", "", settings.read_text()))
        out = folder / "diagnosed.json"
        run("diagnose", "--model", folder / "nominal.yaml", "--data", folder, "--json", out)
        self.assertIn("rate_hz", out.read_text())
        # What `seam measure` makes of this protocol has the clock of its model.
        settings.write_text(settings.read_text() + "rate_hz: 50\n")
        (folder / "truth.yaml").write_text((folder / "nominal.yaml").read_text()
                                           + "  imu_clock: {drift_ppm: -1200}\n  imu_jitter: {sigma_s: 0.0004}\n")
        made = self.folder / "made"
        run("measure", "--model", folder / "truth.yaml", "--protocol", folder, "--seed", 5, "--out", made)
        stamps = np.genfromtxt(made / "imu.csv", delimiter=",", names=True)["time_s"]
        # The protocol's own stamps scatter, too.
        late = stamps - np.genfromtxt(folder / "imu.csv", delimiter=",", names=True)["time_s"]
        slope, start = np.polyfit(np.arange(len(late)), late, 1)
        self.assertAlmostEqual(slope / 0.02, 1200e-6, delta=2e-6)
        self.assertAlmostEqual(np.std(late - start - slope * np.arange(len(late))), 4e-4, delta=1e-5)

    def test_a_line_that_one_axis_does_not_have(self):
        drawn = {"x": 0.0053, "y": 0.0, "z": 0.0106, "frequency_hz": 8.0, "quality": 50.0, "skew": 0.0}
        with unittest.mock.patch.object(imu, "draw_effect", lambda draw, effect: drawn):
            values, found, _ = self.found("gyro_vibration", 7)
        self.assertEqual([step["effect"] for step in found["steps"]], ["gyro_vibration"], found["headline"])
        seen = found["steps"][0]["parameters"]
        for name in ("x_radps", "z_radps", "frequency_hz", "quality"):
            self.assertLess(abs(seen[name]["value"] - values[name]), 5 * seen[name]["sigma"], name)
        self.assertLess(seen["y_radps"]["value"], 1e-3)

    def test_a_line_is_no_line_of_data_sheets(self):
        _, folder = self.is_found("gyro_vibration", 2)
        args = ("export", folder / "found.yaml", "--to", "kalibr-imu", "--data", folder, "--out", folder / "imu.yaml")
        self.assertIn("gyro_vibration", run(*args, code=1))
        self.assertIn("times as much as the file says", run(*args, "--drop", "gyro_vibration"))

    def test_what_is_made_has_the_autocovariance(self):
        """`seam measure` draws over frequency; what it makes has the formula's covariance in time."""
        folder, rms, f, width, skew = self.folder / "protocol", 0.3, 7.3, 1.4, -0.6
        count, dt = 60000, 0.01
        folder.mkdir()
        (folder / "measurement.yaml").write_text("format: seam-measurement/1\nkind: imu\nfiles: {imu: imu.csv}\n")
        (folder / "imu.csv").write_text("time_s\n" + "".join(f"{dt * k:.2f}\n" for k in range(count)))
        (folder / "truth.yaml").write_text(
            "format: seam-model/1\nname: truth\neffects:\n  gyro_white_noise: {x_radps_rthz: 1e-6, y_radps_rthz: 1e-6, "
            f"z_radps_rthz: 1e-6}}\n  gyro_vibration: {{x_radps: {rms}, y_radps: 0, z_radps: {rms}, frequency_hz: {f}, "
            f"quality: {f / width}, skew: {skew}}}\n")
        made = self.folder / "made"
        run("measure", "--model", folder / "truth.yaml", "--protocol", folder, "--seed", 5, "--out", made)
        table = np.genfromtxt(made / "imu.csv", delimiter=",", names=True)
        self.assertLess(np.std(table["wy_radps"]), 1e-4)
        waves = count * dt * math.pi * width  # Of the line: so many independent values.
        for column in ("wx_radps", "wz_radps"):
            x = table[column]
            for lag in (0, 1, 3, 7, 14, 40):
                t = lag * dt
                expected = rms ** 2 * math.exp(-math.pi * width * t) * (
                    math.cos(2 * math.pi * f * t) + skew * width / 2 / f * math.sin(2 * math.pi * f * t))
                self.assertLess(abs(np.mean(x[lag:] * x[:len(x) - lag]) - expected), 5 * rms ** 2 / math.sqrt(waves), lag)

    def test_random_walk(self):
        found, folder = self.is_found("gyro_random_walk")
        self.follows_the_curve(found)
        run("export", folder / "found.yaml", "--to", "kalibr-imu", "--data", folder, "--out", folder / "imu.yaml")
        text = (folder / "imu.yaml").read_text()
        largest = max(step["value"] for step in found["steps"][0]["parameters"].values())
        self.assertIn(f"gyroscope_random_walk: {largest:.3g}"[:-1], text)
        self.assertIn("gyroscope_noise_density: 0.0015\n", text)
        self.assertIn("update_rate: 50\n", text)

    def test_bias_instability_and_its_export(self):
        _, folder = self.is_found("accel_bias_instability")
        args = ("export", folder / "found.yaml", "--to", "vins-imu", "--data", folder, "--out", folder / "vins.yaml")
        self.assertIn("accel_bias_instability", run(*args, code=1))
        self.assertIn("times as much as the file says", run(*args, "--drop", "accel_bias_instability"))
        # White noise of a sample: density times the root of the rate.
        self.assertIn(f"gyr_n: {0.0015 * 50 ** 0.5:.9g}\n", (folder / "vins.yaml").read_text())

    def test_scale(self):
        self.is_found("gyro_scale")

    def test_bias_by_gravity_in_attitudes(self):
        self.is_found("accel_bias")

    def test_temperature(self):
        self.is_found("gyro_temperature")

    def test_a_curve_without_what_the_temperature_does(self):
        t, draw = 0.02 * np.arange(20000), np.random.default_rng(5)
        warm = 24 + 10 * (1 - np.exp(-t / 150))
        rates = 0.002 * draw.standard_normal((3, len(t))) + np.outer([5e-3, 0, -2e-3], warm - 24)
        table = self.folder / "warm.csv"
        np.savetxt(table, np.vstack([t, rates, warm]).T, fmt="%.7f", delimiter=",", header="time,gx,gy,gz,temp", comments="")
        run("import", "imu", table, "--out", self.folder / "warm")
        found = discovered(self.folder / "warm")
        self.assertIn("gyro_temperature", [step["effect"] for step in found["steps"]])
        self.follows_the_curve(found)


class BesideACamera(Case):
    def test_offset_with_the_exposure_and_its_export(self):
        found, folder = self.is_found("camera_imu_offset", 1)
        offset = found["steps"][0]["parameters"]["offset_s"]
        self.assertLess(offset["sigma"], 3e-4)
        self.assertIn("At the usual exposure", found["findings"][0]["text"])
        args = ("export", folder / "found.yaml", "--to", "kalibr-imu-cam", "--out", folder / "rig.yaml")
        self.assertIn("times the exposure of a run", run(*args))
        text = (folder / "rig.yaml").read_text()
        self.assertAlmostEqual(float(re.search("timeshift_cam_imu: (.*)", text)[1]), offset["value"], places=9)
        # Kalibr's matrix takes vectors in the sensor's axes to the camera's.
        rows = np.array([[float(v) for v in row.split(",")] for row in re.findall(r"- \[(.*)\]", text)])
        model = (folder / "found.yaml").read_text()
        turn = np.array([float(re.search(rf"camera_imu_rotation.*{axis}_rad: {{value: ([^,]*)", model)[1]) for axis in "xyz"])
        to_sensor = imu.imu_camera.turn(turn)
        for vector in np.eye(3):
            there = imu.imu_camera.product(imu.imu_camera.product(to_sensor, [0, *vector]), to_sensor * [1, -1, -1, -1])[1:]
            np.testing.assert_allclose(rows[:3, :3] @ there, vector, atol=1e-9)
        np.testing.assert_array_equal(rows[:, 3], [0, 0, 0, 1])
        run(*args[:2], "--to", "vins-imu-cam", "--out", folder / "vins.yaml")
        text = (folder / "vins.yaml").read_text()
        back = np.array([float(v) for v in re.search(r"data: \[(.*?)\]", text, re.S)[1].split(",")]).reshape(4, 4)
        np.testing.assert_allclose(back @ rows, np.eye(4), atol=1e-9)
        self.assertIn(f"td: {offset['value']:.9g}\n", text)
        bare = self.folder / "bare.yaml"
        bare.write_text("format: seam-model/1\nname: bare\neffects:\n  gyro_bias: {x_radps: 0.1}\n")
        self.assertIn("camera_imu_offset", run("export", bare, *args[2:], code=1))
        # A model that has it is asked for nothing more.
        again = folder / "again.json"
        run("diagnose", "--model", folder / "found.yaml", "--data", folder, "--json", again)
        self.assertEqual(json.loads(again.read_text())["verdict"], "adequate")

    def test_rotation(self):
        self.is_found("camera_imu_rotation", 2)

    def test_nothing_beside_a_camera(self):
        folder = self.folder / "null"
        imu.write(imu.imu_camera.imus(imu.Plan("imus+camera_imu_offset", 4)), folder)
        found = discovered(folder)
        self.assertEqual((found["steps"], found["verdict"]), ([], "adequate"), found["headline"])

    def test_from_a_video_of_a_board_to_the_offset(self):
        """Pictures of a board give the attitudes with their errors; these, beside the gyroscope, the offset."""
        turn, product = imu.imu_camera.turn, imu.imu_camera.product
        rng = np.random.default_rng(8)
        offset_s, video, rig = 0.013, self.folder / "video", self.folder / "rig"

        def attitude(t):  # Of the camera before the board, whose axes are the sensor's.
            x, y = 0.2 * np.sin(5.1 * t), 0.25 * np.sin(3.7 * t + 1)
            swung = product(turn(np.stack([0 * t, y, 0 * t], -1)), turn(np.stack([x, 0 * t, 0 * t], -1)))
            return product(swung, turn(np.stack([0 * t, 0 * t, 0.3 * np.sin(4.3 * t)], -1)))

        def rate(t, h=1e-4):
            return product(attitude(t - h) * [1, -1, -1, -1], attitude(t + h))[..., 1:] / h

        board = np.array([[x, y, 0.0] for y in np.arange(-3, 4) for x in np.arange(-4, 5)]) * 0.04
        stamps = np.round(1 + 0.05 * np.arange(160), 3)
        lines = ["frame,time_s,point,x_m,y_m,z_m,u_px,v_px"]
        there = attitude(stamps + offset_s)
        for frame, (t, q) in enumerate(zip(stamps, there)):
            # The camera turns about a place 0.6 m before the board.
            beside = board + [0, 0, 0.6]
            seen = np.array([product(product(q * [1, -1, -1, -1], [0, *point]), q)[1:] for point in beside])
            pixels = 320 + 400 * seen[:, 0] / seen[:, 2], 240 + 400 * seen[:, 1] / seen[:, 2]
            for number, (u, v) in enumerate(zip(*(p + 0.2 * rng.normal(size=len(board)) for p in pixels))):
                lines.append(f"{frame},{t:.3f},{number},{board[number][0]:.3f},{board[number][1]:.3f},0,{u:.4f},{v:.4f}")
        video.mkdir()
        (video / "points.csv").write_text("\n".join(lines) + "\n")
        (video / "measurement.yaml").write_text("format: seam-measurement/1\nkind: points\ncamera: {width_px: 640, height_px: 480}\n"
                                                "noise: {u_px: 0.2, v_px: 0.2}\ngroup: frame\nfiles: {points: points.csv}\nrig: {pose: unknown}\n")
        camera = self.folder / "camera.yaml"
        camera.write_text("format: seam-model/1\nname: camera\neffects:\n  pinhole: {fx_px: 400, fy_px: 400, cx_px: 320, cy_px: 240}\n")
        rig.mkdir()
        said = run("compare", "--model", camera, "--data", video, "--attitudes-out", rig / "attitudes.csv")
        self.assertNotIn("warning", said)
        found = np.genfromtxt(rig / "attitudes.csv", delimiter=",", names=True)
        self.assertEqual(found["time_s"].tolist(), stamps.tolist())
        # What turns the true attitude into the one found, about the camera's axes, over its error.
        q = np.stack([found[name] for name in ("qw", "qx", "qy", "qz")], -1)
        apart = 2 * product(there * [1, -1, -1, -1], q)
        apart = apart[:, 1:] * np.sign(apart[:, :1]) / np.stack([found[f"sigma_{axis}_rad"] for axis in "xyz"], -1)
        self.assertLess(np.max(np.abs(np.mean(apart ** 2, axis=0) - 1)), 5 * math.sqrt(2 / len(stamps)))
        sampled = np.round(0.005 * np.arange(2000), 3)
        read = rate(sampled) + 1e-3 * rng.normal(size=(len(sampled), 3))
        np.savetxt(rig / "imu.csv", np.column_stack([sampled, read]), "%.9g", ",", header="time_s,wx_radps,wy_radps,wz_radps", comments="")
        (rig / "measurement.yaml").write_text("format: seam-measurement/1\nkind: imu\nfiles: {imu: imu.csv, attitudes: attitudes.csv}\n")
        (rig / "nominal.yaml").write_text("format: seam-model/1\nname: rig\neffects:\n  gyro_bias: {x_radps: {value: 0, free: true}, "
                                          "y_radps: {value: 0, free: true}, z_radps: {value: 0, free: true}}\n")
        steps = discovered(rig)["steps"]
        self.assertEqual([step["effect"] for step in steps], ["camera_imu_offset"])
        value = steps[0]["parameters"]["offset_s"]
        self.assertLess(abs(value["value"] - offset_s), 4 * value["sigma"])
        self.assertLess(value["sigma"], 1e-3)
        # Of other sets there is nothing to write.
        out = self.folder / "none.csv"
        self.assertIn("no poses of a camera to write", run("compare", "--model", rig / "nominal.yaml", "--data", rig, "--attitudes-out", out, code=1))
        self.assertFalse(out.exists())

    def test_what_a_set_must_have(self):
        folder = self.folder / "set"
        imu.make(folder, "camera_imu_offset", 3)
        views = folder / "attitudes.csv"
        lines = [line.split(",") for line in views.read_text().splitlines()]

        def with_columns(*names):
            at = [lines[0].index(name) for name in names]
            views.write_text("".join(",".join(cells[i] for i in at) + "\n" for cells in lines))

        def refused(*words):
            said = run("compare", "--model", folder / "nominal.yaml", "--data", folder, code=1)
            for word in words:
                self.assertIn(word, said)

        with_columns("time_s", "qw", "qx", "qy", "qz")
        refused("attitudes.csv: found no standard errors of the attitudes", "sigma_rad")
        with_columns("time_s", "qw", "qx", "qy", "sigma_rad")
        refused("attitudes.csv", "qz")
        views.write_text("".join(",".join([*cells[:4], "0.9" if number else "qz", *cells[5:]]) + "\n" for number, cells in enumerate(lines)))
        refused("attitudes.csv:2", "qw, qx, qy, qz of length 1")
        def with_last(name, value):
            views.write_text("".join(",".join([*cells[:5], value if number else name]) + "\n" for number, cells in enumerate(lines)))

        for value in ("1e200", "1e-200", "0"):
            with_last("sigma_rad", value)
            refused("attitudes.csv:2: column sigma_rad", "a standard error of 1e-09 to 1 rad")
        views.write_text("".join(",".join([*cells[:5], "0.001,-1" if number else "sigma_rad,exposure_s"]) + "\n" for number, cells in enumerate(lines)))
        refused("attitudes.csv:2: column exposure_s: found '-1'")
        with_columns("time_s", "qw", "qx", "qy", "qz", "sigma_rad")
        out = folder / "d.json"
        run("diagnose", "--model", folder / "nominal.yaml", "--data", folder, "--json", out)
        self.assertIn("attitudes have no exposure_s that differs", out.read_text())
        views.write_text("".join(",".join([str(float(cells[0]) + 900) if number else cells[0], *cells[1:]]) + "\n"
                                 for number, cells in enumerate(lines)))
        refused("found 0 pairs of views", "bring both to one clock within 0.5 s")
        run("measure", "--model", folder / "nominal.yaml", "--protocol", folder, "--out", self.folder / "no", code=1)
        # Without a camera nothing is asked of one.
        rest = self.folder / "rest"
        imu.make(rest, "gyro_bias", 1)
        run("diagnose", "--model", rest / "nominal.yaml", "--data", rest, "--json", out)
        self.assertIn("no camera was beside the sensor: the set has no attitudes", out.read_text())

    def test_readings_that_show_no_noise(self):
        folder = self.folder / "still"
        imu.make(folder, "gyro_bias", 1)
        table, about = folder / "imu.csv", folder / "measurement.yaml"
        lines = [line.split(",") for line in table.read_text().splitlines()]
        at = lines[0].index("wy_radps")
        for value in ("0", "1e-200"):
            table.write_text("".join(",".join([*cells[:at], value if number else cells[at], *cells[at + 1:]]) + "\n"
                                     for number, cells in enumerate(lines)))
            said = run("compare", "--model", folder / "nominal.yaml", "--data", folder, code=1)
            self.assertIn(f"imu.csv: column wy_radps is {value} in all rows, expected readings that scatter", said)
        # A temperature that is none.
        at = lines[0].index("temperature_c")
        table.write_text("".join(",".join([*cells[:at], "1e8" if number else cells[at], *cells[at + 1:]]) + "\n"
                                 for number, cells in enumerate(lines)))
        said = run("compare", "--model", folder / "nominal.yaml", "--data", folder, code=1)
        self.assertIn("imu.csv:2: column temperature_c: found '1e8', expected degrees Celsius", said)
        # A column of groups that is not there is no run without a name.
        table.write_text("".join(",".join(cells) + "\n" for cells in lines))
        about.write_text("".join(line for line in about.read_text().splitlines(True) if not line.startswith("group:")) + "group: banana\n")
        self.assertIn("column 'banana' is missing", run("compare", "--model", folder / "nominal.yaml", "--data", folder, code=1))


class Import(unittest.TestCase):
    def test_units_and_names(self):
        with tempfile.TemporaryDirectory() as temporary:
            folder = pathlib.Path(temporary)
            rng = np.random.default_rng(5)
            with (folder / "log.csv").open("w") as file:
                file.write("stamp_ms,gyr_x [deg/s],gyr_y [deg/s],gyr_z [deg/s],acc_x,acc_y,acc_z,temp\n")
                for k in range(4000):
                    gyro, accel = rng.normal(size=3), 0.01 * rng.normal(size=3) + [0, 0, 1]
                    file.write(f"{5 * k}," + ",".join(f"{v:.9g}" for v in (*gyro, *accel)) + ",25\n")
            said = run("import", "imu", folder / "log.csv", "--map", "time=stamp_ms", "--unit", "deg", "--out", folder / "set")
            self.assertIn("from g to m/s^2", said)
            run("compare", "--model", folder / "set/nominal.yaml", "--data", folder / "set", "--json", folder / "c.json")
            self.assertLess(json.loads((folder / "c.json").read_text())["error"], 1.2)
            rows = (folder / "set/imu.csv").read_text().splitlines()
            self.assertEqual(rows[0], "run,time_s,wx_radps,wy_radps,wz_radps,ax_mps2,ay_mps2,az_mps2,temperature_c")
            refused = run("import", "imu", folder / "log.csv", "--map", "time=nowhere", "--out", folder / "no", code=1)
            self.assertIn("nowhere", refused)
            self.assertFalse((folder / "no").exists())


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]], verbosity=2)
