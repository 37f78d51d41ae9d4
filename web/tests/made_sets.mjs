// Measurement sets that the program itself makes: the tutorial's, and a servo's log of any length; and what is to be found in the
// samples of the workbench.
import { cpSync, mkdirSync, writeFileSync } from "node:fs";
import { join } from "node:path";

/** The cause in each sample, and a sample's title. */
export const samples = { servo: "servo_lag", flats: "vignetting", walk: "odometry_scale" };
export const titles = { servo: /A servo follows sines/, flats: /Flat fields of a camera/, walk: /A robot walks/ };

/** Makes the room into the folder; `seam(arguments)` runs the program. */
export function makeRoom(folder, source, seam) {
  const tutorial = join(source, "docs/tutorial");
  seam(["measure", "--model", join(tutorial, "robot.yaml"), "--protocol", join(tutorial, "room"), "--seed", "1", "--out", folder]);
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
