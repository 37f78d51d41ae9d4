// Measurement sets that the program itself makes: the tutorial's, and a servo's log of any length; and what is to be found in the
// samples of the workbench.
import { cpSync, mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";

/** The cause in each sample, and a sample's title. */
export const samples = { servo: "servo_lag", flats: "vignetting", walk: "odometry_scale" };
export const titles = { servo: /A servo follows sines/, flats: /Flat fields of a camera/, walk: /A robot walks/ };

/** Writes the room's protocol with each point so many times, a few centimetres apart. */
function crowd(from, to, times) {
  cpSync(from, to, { recursive: true });
  const [header, ...rows] = readFileSync(join(from, "points.csv"), "utf8").trim().split("\n");
  const more = rows.flatMap((row, i) => {
    const [frame, time, point, ...place] = row.split(",");
    return Array.from({ length: times }, (_, k) => [frame, time, Number(point) * times + k,
      ...place.map((value, axis) => (Number(value) + 0.04 * Math.sin(7.1 * k + 3.3 * i + axis)).toFixed(4))].join(","));
  });
  writeFileSync(join(to, "points.csv"), `${[header, ...more].join("\n")}\n`);
}

/** Makes the room into the folder, with each point so many `times`; `seam(arguments)` runs the program. */
export function makeRoom(folder, source, seam, times = 1) {
  const tutorial = join(source, "docs/tutorial"), protocol = times > 1 ? `${folder}.protocol` : join(tutorial, "room");
  if (times > 1) crowd(join(tutorial, "room"), protocol, times);
  seam(["measure", "--model", join(tutorial, "robot.yaml"), "--protocol", protocol, "--seed", "1", "--out", folder]);
  cpSync(join(tutorial, "nominal.yaml"), join(folder, "nominal.yaml"));
}

/** Makes a servo's log with a lag into the folder. */
export function makeServo(folder, runs, samplesOfRun, seam) {
  const protocol = `${folder}.protocol`, truth = join(protocol, "truth.yaml");
  const model = (effect) => `format: seam-model/1\nname: nominal\neffects:\n  ${effect}\n`;
  const rows = ["run,time_s,joint,command_rad"];
  for (let run = 0; run < runs; ++run) {
    for (let k = 0; k < samplesOfRun; ++k) {
      const t = 0.008 * k;
      rows.push(`${run},${t.toFixed(3)},pan,${(0.5 * Math.sin((2 + run % 6) * t) + (k > 60 ? 0.3 : 0)).toFixed(6)}`);
    }
  }
  mkdirSync(protocol, { recursive: true });
  writeFileSync(join(protocol, "joints.csv"), `${rows.join("\n")}\n`);
  writeFileSync(join(protocol, "measurement.yaml"), "format: seam-measurement/1\nkind: joints\ntitle: A servo\n" +
    "noise: {measured_rad: 0.0006}\ngroup: run\nfiles: {joints: joints.csv}\n");
  writeFileSync(truth, model("servo_lag: {tau_s: 0.045}"));
  seam(["measure", "--model", truth, "--protocol", protocol, "--seed", "1", "--out", folder]);
  writeFileSync(join(folder, "nominal.yaml"), model("ideal_servo: {}"));
}

const modelOf = (...effects) => `format: seam-model/1\nname: nominal\neffects:\n${effects.map((line) => `  ${line}\n`).join("")}`;

/** Writes a protocol and its true model, and has it measured into the folder, with the model to begin with. */
function measure(folder, files, truth, nominal, seam) {
  const protocol = `${folder}.protocol`;
  mkdirSync(protocol, { recursive: true });
  for (const [name, text] of Object.entries({ ...files, "truth.yaml": truth })) writeFileSync(join(protocol, name), text);
  seam(["measure", "--model", join(protocol, "truth.yaml"), "--protocol", protocol, "--seed", "1", "--out", folder]);
  writeFileSync(join(folder, "nominal.yaml"), nominal);
}

const table = (header, rows) => `${[header, ...rows.map((row) => row.join())].join("\n")}\n`;

/** Makes five landmarks seen by a robot on a circle, whose ranges are a tenth too long. */
export function makeLandmarks(folder, seam) {
  const poses = [], seen = [];
  for (let run = 0; run < 6; ++run) {
    for (let k = 0; k <= 100; ++k) {
      const t = 0.1 * k, at = 0.5 * t + run;
      poses.push([run, t.toFixed(2), Math.cos(at).toFixed(4), Math.sin(at).toFixed(4), (at + Math.PI / 2).toFixed(4)]);
      if (k > 0 && k < 100) seen.push([run, t.toFixed(2), k % 5]);
    }
  }
  measure(folder, {
    "landmarks.csv": table("landmark,x_m,y_m", [[0, 3, 0], [1, 0, 3], [2, -3, 0], [3, 0, -3], [4, 2.5, 2.5]]),
    "poses.csv": table("run,time_s,x_m,y_m,theta_rad", poses), "observations.csv": table("run,time_s,landmark", seen),
    "measurement.yaml": "format: seam-measurement/1\nkind: landmarks\ntitle: Beacons\nnoise: {range_m: 0.03, bearing_rad: 0.006}\n" +
      "group: run\nfiles: {observations: observations.csv, landmarks: landmarks.csv, poses: poses.csv}\n",
  }, modelOf("ideal_detector: {}", "range_scale: {scale: 0.1}"), modelOf("ideal_detector: {}"), seam);
}

/** Makes four small images of two boxes by a camera whose corners are dark. */
export function makeFrames(folder, seam) {
  const camera = ["pinhole: {fx_px: 30, fy_px: 30, cx_px: 15.5, cy_px: 11.5}", "read_noise: {sigma_dn: 1.5}"];
  measure(folder, {
    "frames.csv": table("frame,file,time_s", [0, 1, 2, 3].map((k) => [k, `frames/${k}.png`, (0.3 * k + 0.1).toFixed(1)])),
    "joints.csv": "time_s,pan_rad\n0,-0.2\n2,0.2\n",
    "scene.yaml": "format: seam-scene/1\nbackground_rgb: [0.3, 0.4, 0.5]\nobjects:\n" +
      "  - {shape: box, centre_m: [1.5, 0.4, 0.2], size_m: [0.3, 0.3, 0.4], rgb: [0.9, 0.5, 0.2]}\n" +
      "  - {shape: box, centre_m: [2.0, -0.4, 0.4], size_m: [0.3, 0.3, 0.4], rgb: [0.2, 0.8, 0.3]}\n",
    "measurement.yaml": "format: seam-measurement/1\nkind: frames\ntitle: Two boxes\ngroup: frame\nscene: scene.yaml\n" +
      "camera: {width_px: 32, height_px: 24, frame_period_s: 0.04}\nfiles: {frames: frames.csv, joints: joints.csv}\n" +
      "rig: {chain: [{translate_m: [0, 0, 0.3]}, {joint: pan, axis: [0, 0, 1]}]}\n",
  }, modelOf(...camera, "vignetting: {a2: 0.4, a4: 0.1}"), modelOf(...camera), seam);
}

/** Makes numbers of whole runs: how far a ball seems to be, by a camera whose focal length is 8 % off. */
export function makeOutcomes(folder, source, seam) {
  const plan = (places) => `format: seam-sweep/1\nscenario: ${join(source, "scenarios/ball_distance.yaml")}\nset: {duration_s: 0.13}\n` +
    `vary:\n  - {path: "robots[0].pose.x_m", name: x_m, values: [${places}]}\nseeds: [1, 2]\nkeep:\n` +
    "  values: [{name: distance_m, statistic: mean, as: distance_m}]\n  expressions: {error_m: distance_m + x_m}\n";
  const camera = ["pinhole: {fx_px: 161.9, fy_px: 162.5, cx_px: 88.5, cy_px: 71.5}", "read_noise: {sigma_dn: 3}", "lens_blur: {sigma_px: 1}"];
  measure(folder, {
    "near.yaml": plan("-0.55, -0.62"), "far.yaml": plan("-0.8, -0.92"),
    "outcomes.csv": table("scenario,value,statistic,measured,sigma",
      ["near", "far"].flatMap((name) => ["mean", "min", "max", "spread"].map((statistic) => [name, "error_m", statistic, "", ""]))),
    "measurement.yaml": "format: seam-measurement/1\nkind: outcomes\ntitle: A ball at two distances\nfiles: {outcomes: outcomes.csv}\n" +
      "scenarios: {near: near.yaml, far: far.yaml}\nmost_runs: 3000\ncandidates: {focal_length_error: {fy_scale: [-0.2, 0.2]}}\n",
  }, modelOf(...camera, "focal_length_error: {fy_scale: 0.08}"), modelOf(...camera), seam);
}
