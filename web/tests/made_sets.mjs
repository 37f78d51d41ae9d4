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
