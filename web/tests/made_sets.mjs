// Measurement sets with known causes, made by the program itself: a room's points, a servo's log, flat fields and a walk.
import { cpSync, mkdirSync, writeFileSync } from "node:fs";
import { join } from "node:path";

const model = (effects) => `format: seam-model/1\nname: nominal\neffects:\n${effects.map((line) => `  ${line}\n`).join("")}`;
const head = (kind, title, ...lines) => `format: seam-measurement/1\nkind: ${kind}\ntitle: ${title}\n${lines.join("\n")}\n`;
const csv = (header, rows) => `${header}\n${rows.map((row) => row.join(",")).join("\n")}\n`;
const range = (n) => Array.from({ length: n }, (_, i) => i);

function servo(runs = 6, samples = 200) {
  const rows = range(runs).flatMap((run) => range(samples).map((k) => {
    const t = 0.008 * k;
    return [run, t.toFixed(3), "pan", (0.5 * Math.sin((2 + run % 6) * t) + (k > 60 ? 0.3 : 0)).toFixed(6)];
  }));
  return {
    files: { "joints.csv": csv("run,time_s,joint,command_rad", rows),
      "measurement.yaml": head("joints", "A servo", "noise: {measured_rad: 0.0006}", "group: run", "files: {joints: joints.csv}") },
    nominal: model(["ideal_servo: {}"]), truth: model(["servo_lag: {tau_s: 0.045}"]),
  };
}

function walk() {
  const rows = range(8).flatMap((run) => range(60).map((k) => [run, (0.2 * k).toFixed(1), (0.1 * Math.cos(run)).toFixed(3),
    (0.05 * Math.sin(2 * run)).toFixed(3), (0.4 * Math.sin(run + 0.1 * k)).toFixed(4)]));
  return {
    files: { "odometry.csv": csv("run,time_s,vx_cmd_mps,vy_cmd_mps,omega_cmd_radps", rows),
      "measurement.yaml": head("odometry", "Walks", "noise: {x_m: 0.002, y_m: 0.002, theta_rad: 0.003}", "group: run",
        "files: {odometry: odometry.csv}") },
    nominal: model(["ideal_odometry: {}"]),
    truth: model(["ideal_odometry: {}", "odometry_scale: {vx_scale: -0.12, vy_scale: 0, omega_scale: 0}"]),
  };
}

function flatFields() {
  const levels = [0, 0.1, 0.3, 0.5, 0.7, 0.9], base = ["linear_response: {gain_dn: 220, black_dn: 8}", "read_noise: {sigma_dn: 1.4}"];
  const rows = range(24).map((k) => [k, `frames/${k}.png`, (0.04 * k).toFixed(2), 0.005, levels[k % levels.length]]);
  return {
    files: { "frames.csv": csv("frame,file,time_s,exposure_s,illumination", rows),
      "measurement.yaml": head("photometry", "Flat fields",
        "camera: {width_px: 64, height_px: 48, frame_period_s: 0.04, channels: grey, bits: 8}", "group: frame",
        "files: {frames: frames.csv}") },
    nominal: model(base), truth: model([...base, "vignetting: {a2: 0.28, a4: 0.05}"]),
  };
}

function make(folder, name, set, seam) {
  const protocol = join(folder, `${name}.protocol`), truth = join(protocol, "truth.yaml");
  mkdirSync(protocol, { recursive: true });
  for (const [file, text] of Object.entries(set.files)) writeFileSync(join(protocol, file), text);
  writeFileSync(truth, set.truth);
  seam(["measure", "--model", truth, "--protocol", protocol, "--seed", "1", "--out", join(folder, name)]);
  writeFileSync(join(folder, name, "nominal.yaml"), set.nominal);
}

/** A servo's log of any length, as the set `name` below a folder. */
export const makeServo = (folder, name, runs, samples, seam) => make(folder, name, servo(runs, samples), seam);

/** Makes the four sets below a folder; `seam(arguments)` runs the program. */
export function makeSets(folder, source, seam) {
  const tutorial = join(source, "docs/tutorial");
  seam(["measure", "--model", join(tutorial, "robot.yaml"), "--protocol", join(tutorial, "room"), "--seed", "1",
    "--out", join(folder, "room")]);
  cpSync(join(tutorial, "nominal.yaml"), join(folder, "room/nominal.yaml"));
  for (const [name, set] of Object.entries({ servo: servo(), flats: flatFields(), walk: walk() })) make(folder, name, set, seam);
}
