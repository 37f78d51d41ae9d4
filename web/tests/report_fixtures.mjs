// Report documents as the commands write them, made from arithmetic alone: the same at every run.

/** A small generator of repeatable numbers (mulberry32) with a normal deviate on top. */
export function generator(seed) {
  let state = seed >>> 0;
  const uniform = () => {
    state = (state + 0x6d2b79f5) >>> 0;
    let t = Math.imul(state ^ (state >>> 15), 1 | state);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
  const normal = () =>
    Math.sqrt(-2 * Math.log(uniform() + 1e-12)) * Math.cos(2 * Math.PI * uniform());
  return { uniform, normal };
}

function binned(points, bins, formal) {
  const sorted = [...points].sort((a, b) => a[0] - b[0]);
  const size = Math.floor(sorted.length / bins);
  return Array.from({ length: bins }, (_, i) => {
    const part = sorted.slice(i * size, i === bins - 1 ? undefined : (i + 1) * size);
    const mean = part.reduce((sum, p) => sum + p[1], 0) / part.length;
    const scatter = Math.sqrt(part.reduce((sum, p) => sum + (p[1] - mean) ** 2, 0) / (part.length - 1));
    return { low: part[0][0], high: part[part.length - 1][0],
      centre: part.reduce((sum, p) => sum + p[0], 0) / part.length, n: part.length, mean,
      mean_sigma: formal / Math.sqrt(part.length), scatter, formal };
  });
}

function histogram(residual, stage, values) {
  const edges = Array.from({ length: 41 }, (_, i) => -5 + i * 0.25);
  const counts = edges.slice(1).map((_, i) =>
    values.filter((v) => v >= edges[i] && v < edges[i + 1]).length);
  return { residual, stage, edges, counts };
}

const p = (value, sigma) => ({ value, sigma });

/** Points of a swinging head whose rolling shutter the model lacks. */
export function diagnosePoints() {
  const { uniform, normal } = generator(7);
  const noise = 0.15;
  const seen = Array.from({ length: 2400 }, () => {
    const rate = 2.6 * Math.sin(uniform() * 2 * Math.PI);
    const u = uniform() * 177;
    const v = uniform() * 143;
    const shift = 2.4e-4 * (v - 10) * rate * 30;
    return { u, v, rate, before: [shift + noise * normal(), 0.1 * shift + noise * normal()],
      after: [noise * normal(), noise * normal()] };
  });
  const plot = (residual, axis, stage, covariate, x, x_unit, extra) => {
    const points = seen.map((s) => [x(s), s[stage][axis]]);
    return { residual, covariate, moment: "mean", stage, x_unit, ...extra,
      bins: binned(points, 24, noise), sample: points.slice(0, 700) };
  };
  const rowRate = (s) => s.v * s.rate;
  return {
    format: "seam-report/1",
    title: "Calibration room seen from a swinging head",
    command: "seam diagnose --model nominal.yaml --data points-a --report report.html",
    version: "0.1.0",
    model: { name: "ers2100-nominal", file: "nominal.yaml", effects: {
      pinhole: { fx_px: 161.9, fy_px: 162.5, cx_px: 88.5, cy_px: 71.5 },
      encoder_offset: { pan_rad: p(0.0021, 0.0004) } } },
    data: { folder: "points-a", title: "Calibration room seen from a swinging head", kind: "points",
      fingerprint: "9f3c21ab77e0d412", n: 8000, residuals: 16000, groups: 200, held_out_n: 4800, held_out_groups: 60,
      image: { width_px: 178, height_px: 144 }, noise: { u_px: 0.15, v_px: 0.15 },
      noise_from: "file" },
    result: {
      format: "seam-diagnose/1", kind: "points", n: 8000, residuals: 16000, groups: 200, verdict: "missing_effect",
      headline: "What matters: rolling_shutter, lens_blur are missing; rolling_shutter moves predictions by 26 x noise",
      doubts: ["units? axes? The error is 59 noise units", "  points.csv:17: column z_m reaches 2400: millimetres?"],
      explanation: { steps: [{ effect: "rolling_shutter", error_after: 1.02 }, { effect: "lens_blur", error_after: 1.004 }],
        error: 1.004 },
      structure_of: "given",
      baseline: { error: 3.912, native: { u_px: 0.816, v_px: 0.171 }, noise_floor: 1.0 },
      candidates: [
        { effect: "rolling_shutter", rank: 1, error: 1.004, gain: 0.9994, gain_sigma: 0.0021,
          p_value: 1e-300, parameters: { line_delay_s: p(2.401e-4, 6.1e-7) },
          indistinguishable_from: [], found: true, why: "u residual grows with row x pan rate" },
        { effect: "lens_blur", rank: 6, error: 3.7, gain: 0.06, p_value: 1e-300, found: true, indistinguishable_from: [],
          parameters: { sigma_px: p(0.41, 0.02) }, with: { focus_depth: { depth_m: p(2.1, 0.1) } }, why: "" },
        { effect: "dust", rank: 7, error: 3.9, gain: 0.011, p_value: 1e-300, indistinguishable_from: [], why: "",
          parameters: { drift: p(-8.524440168e-7, 4e-34) } },
        { effect: "frame_latency", rank: 2, error: 2.21, gain: 0.727, gain_sigma: 0.014,
          p_value: 1e-120, parameters: { latency_s: p(0.01712, 0.00011) },
          indistinguishable_from: ["exposure"], stands_in_for: ["rolling_shutter"],
          why: "u residual grows with pan rate" },
        { effect: "encoder_scale", rank: 3, error: 3.88, gain: 0.018, gain_sigma: 0.006,
          p_value: 0.0021, parameters: { tilt_scale: p(-0.0011, 0.0009), pan_scale: p(0.0042, 0.0008),
            roll_scale: p(0, 0.01) }, at_bound: true, indistinguishable_from: [],
          why: "v residual grows with tilt" },
        { effect: "radial_distortion", rank: 4, error: 3.913, gain: -0.0002, gain_sigma: 0.0005,
          p_value: 0.41, parameters: { kappa: p(0.0007, 0.0011) }, indistinguishable_from: [], why: "" },
        { effect: "tangential_distortion", rank: 5, error: 3.93, gain: -0.013, gain_sigma: 0.004,
          p_value: 0.77, parameters: { p1: p(1e-5, 4e-5), p2: p(-3e-5, 4e-5) },
          indistinguishable_from: [], why: "" },
      ],
      structure: [
        { residual: "u_px", moment: "mean", covariate: "row*pan_rate", strength: 0.798, p_value: 1e-300 },
        { residual: "u_px", moment: "mean", covariate: "pan_rate", strength: 0.61, p_value: 1e-300 },
        { residual: "v_px", moment: "mean", covariate: "row*pan_rate", strength: 0.081, p_value: 3e-92 },
        { residual: "u_px", moment: "spread", covariate: "row", strength: 0.33, p_value: 1e-41 },
        { residual: "u_px", moment: "mean", covariate: "sign(pan_rate)", strength: 0.4, p_value: 1e-300 },
      ],
      material: 0.1,
      traces: {
        structure: [{ residual: "v_px", moment: "mean", covariate: "radius", strength: 0.006, p_value: 2e-9 }],
        candidates: [{ effect: "lens_blur", rank: 1, error: 3.91, gain: 0.0004, p_value: 3e-8,
          parameters: {}, indistinguishable_from: [], why: "" }] },
      not_testable: [
        { effect: "mount_offset", parameter: "z_m", why: "all points lie beyond 1.5 m" },
        { effect: "clock_drift", parameter: "drift_ppm", why: "the recording lasts 8 s only" }],
      outliers: [{ file: "points.csv", line: 1203, channel: "u_px", residual: 7.31 },
        { file: "points.csv", line: 1203, channel: "v_px", residual: 0 },
        ...Array.from({ length: 60 }, (_, i) => ({ file: "points.csv", line: 5210 + i, channel: "u_px", residual: -6.4 - i })),
      ],
      advice: "Swing the head at two more rates: latency and exposure then part.",
      suggestion: { effect: "proposed", formula: "u: 0.0006 * (u - cx) * t, v: 0.0006 * (v - cy) * t", error: 1.004, error_before: 2.25,
        terms: ["u: (u - cx) * t"], beside: ["rolling_shutter"], mimics: ["focus_variation"],
        yaml: "effects:\n  proposed:\n    stage: geometry\n    u: \"u + k * (u - cx) * t\"\n    v: \"v + k * (v - cy) * t\"\n" },
    },
    plots: {
      residuals: [
        plot("u_px", 0, "before", "row*pan_rate", rowRate, undefined, { strength: 0.798, p_value: 1e-300 }),
        plot("u_px", 0, "after", "row*pan_rate", rowRate, undefined, {}),
        plot("u_px", 0, "before", "pan_rate", (s) => s.rate, "rad/s", { strength: 0.61, p_value: 1e-300 }),
        plot("u_px", 0, "after", "pan_rate", (s) => s.rate, "rad/s", {}),
        plot("v_px", 1, "before", "row*pan_rate", rowRate, undefined, { strength: 0.081, p_value: 3e-92 }),
        { ...plot("u_px", 0, "before", "row", (s) => s.v, "px", { strength: 0.33, p_value: 1e-41 }),
          moment: "spread" },
        // What only the model found leaves: the first model's residuals were not tested for it.
        plot("v_px", 1, "before", "column", (s) => s.u, "px", {}),
        plot("v_px", 1, "after", "column", (s) => s.u, "px", { strength: 0.0185, p_value: 3e-9 }),
        { ...plot("u_px", 0, "before", "sign(pan_rate)", (s) => s.rate, undefined, { strength: 0.4, p_value: 1e-300 }),
          bins: [-1, 1].map((sign) => ({ low: sign, high: sign, centre: sign, n: 1200, mean: 0.4 * sign, mean_sigma: 0.004,
            scatter: 0.5, formal: 0.15 })), sample: [[-1, -0.3], [1, 0.5]] },
      ],
      arrows: ["before", "after"].map((stage) => ({ stage, plane: "image_px", unit: "px",
        items: seen.slice(0, 600).map((s) => [s.u, s.v, s[stage][0], s[stage][1]]) })),
      histograms: ["before", "after"].flatMap((stage) => ["u_px", "v_px"].map((name, axis) =>
        histogram(name, stage, seen.map((s) => s[stage][axis] / noise)))),
      leave_one_out: [
        { effect: "encoder_offset", log_likelihood_lost: 5210.4, error_with: 3.912, error_without: 6.2 },
        { effect: "frame_latency", log_likelihood_lost: -0.3, error_with: 3.912, error_without: 3.912 },
        // A spread takes up what is missing, so that the error in noise units falls.
        { effect: "rolling_shutter", log_likelihood_lost: 8.5e6, error_with: 3.912, error_without: 1.02 }],
      // A computation's last digits.
      lens_error: { stage: "after", title: "Standard error", unit: "px", columns: 4, rows: 3, width_px: 178, height_px: 144,
        values: Array.from({ length: 12 }, (_, i) => i * 1e-14) },
    },
  };
}

/** Flat fields: two steps until the model is adequate, with a map of the mean. */
export function discoverPhotometry() {
  const { normal } = generator(11);
  const columns = 44;
  const rows = 36;
  const map = (stage, depth) => ({ stage, title: "Mean residual", unit: "dn", columns, rows,
    width_px: 178, height_px: 144, values: Array.from({ length: columns * rows }, (_, i) => {
      const x = (i % columns) / (columns - 1) - 0.5;
      const y = Math.floor(i / columns) / (rows - 1) - 0.5;
      return i % 397 === 0 ? null : -depth * (x * x + y * y) + 0.4 * normal();
    }) });
  const points = Array.from({ length: 1500 }, (_, i) => [i / 1500, -14 * (i / 1500) ** 2 + 2 * normal()]);
  return {
    format: "seam-report/1",
    command: "seam discover --model grey.yaml --data photometry-b --out found.yaml --report r.html",
    version: "0.1.0",
    model: { name: "grey", file: "grey.yaml", effects: { linear_response: { gain_dn: 180, black_dn: 12 } } },
    data: { folder: "photometry-b", title: "Flat fields at seven levels", kind: "photometry", n: 430080,
      groups: 168, held_out_n: 131000, held_out_groups: 51, image: { width_px: 178, height_px: 144 },
      noise: { dn: 1.7 }, noise_from: "estimated" },
    result: { format: "seam-discover/1", verdict: "adequate",
      headline: "What matters: vignetting, shot_noise, column_offsets are missing; vignetting moves predictions by 7 x noise", error: 1.002, noise_floor: 1,
      native: { dn: 6.44 }, structure: [],
      steps: [
        { effect: "vignetting", parameters: { a2: p(0.2811, 0.0006), a4: p(0.0702, 0.0008) },
          error_before: 31.2, error_after: 2.91, why: "dn residual falls with radius, in proportion to intensity" },
        { effect: "shot_noise", parameters: { electrons_per_dn: p(41.2, 0.3) }, error_before: 2.91,
          error_after: 1.19, why: "variance grows with the mean" },
        { effect: "column_offsets", parameters: { sigma_dn: p(0.81, 0.04) }, error_before: 1.19,
          error_after: 1.002, indistinguishable_from: [], why: "vertical stripes that stay" }] },
    plots: {
      maps: [map("before", 22), map("after", 0)],
      residuals: [{ residual: "dn", covariate: "radius", stage: "before", strength: 5.9,
        p_value: 1e-300, bins: binned(points, 20, 2), sample: points }],
      leave_one_out: [
        { effect: "vignetting", log_likelihood_lost: 81234, error_with: 1.002, error_without: 30.8 },
        { effect: "shot_noise", log_likelihood_lost: 4123, error_with: 1.002, error_without: 2.71 },
        { effect: "column_offsets", log_likelihood_lost: 311, error_with: 1.002, error_without: 1.19 }] },
  };
}

/** A servo: structure that no known effect explains, with runs measured beside predicted. */
export function compareJoints() {
  const { normal } = generator(3);
  const time = Array.from({ length: 400 }, (_, i) => i * 0.008);
  const line = (name, f) => ({ name, points: time.map((t) => [t, f(t)]) });
  const points = time.map((t) => [Math.cos(3 * t), 0.004 * Math.sign(Math.cos(3 * t)) + 0.001 * normal()]);
  return {
    format: "seam-report/1", version: "0.1.0",
    command: "seam compare --model servo.yaml --data joints-a --report r.html",
    model: { name: "servo", file: "servo.yaml", effects: { servo_lag: { tau_s: p(0.04, 0.001) } } },
    data: { folder: "joints-a", title: "Tilt servo, six runs", kind: "joints", n: 9000, groups: 6,
      held_out_n: 3000, held_out_groups: 2, noise: { measured_rad: 0.001 }, noise_from: "estimated" },
    result: { format: "seam-compare/1", headline: "What matters: mean of measured_rad varies with tilt rate (3.9 x noise)", error: 3.2, native: { measured_rad: 0.0032 }, noise_floor: 1,
      structure: [{ residual: "measured_rad", moment: "mean", covariate: "sign(tilt_rate)",
        strength: 0.0039, p_value: 2e-211 }], outliers: [] },
    plots: {
      residuals: [{ residual: "measured_rad", covariate: "tilt_rate", stage: "before", x_unit: "rad/s",
        strength: 0.0039, p_value: 2e-211, bins: binned(points, 16, 0.001), sample: points }],
      series: [1, 2].map((run) => ({ title: `run ${run}, tilt`, x: "time_s", y: "tilt_rad", lines: [
        line("command", (t) => 0.3 * Math.sign(Math.sin(run * 3 * t))),
        line("measured", (t) => 0.3 * Math.sin(run * 3 * t) + 0.004 * normal()),
        line("predicted", (t) => 0.29 * Math.sin(run * 3 * t - 0.05))] })) },
  };
}

export function history() {
  return {
    format: "seam-report/1", title: "ers2100: how the model came to be", version: "0.1.0",
    command: "seam history ers2100.yaml --report r.html",
    result: { format: "seam-history/1", model: "ers2100", versions: [
      { version: 1, effect: "radial_polynomial", parameters: { k1: p(-0.31, 0.002), k2: p(0.11, 0.003) },
        data: "real-lens", fingerprint: "77aa01", error_before: 61.2, error_after: 3.4 },
      { version: 2, effect: "tangential_distortion", parameters: { p1: p(8e-4, 2e-5), p2: p(-2e-4, 2e-5) },
        data: "real-lens", fingerprint: "77aa01", error_before: 3.4, error_after: 1.31 }] },
  };
}

export function headSwing() {
  return {
    format: "seam-report/1", title: "Head swing and the bias of self-localisation", version: "0.1.0",
    command: "seam experiment head-swing-bias --quick --report r.html",
    result: { format: "seam-head-swing-bias/1", seeds: 3, modes: {
      locked: { bias_mm: 41.2, ci95: [33.1, 49.0], spread_mm: 12 },
      scheduled: { bias_mm: 2.1, ci95: [-4.4, 8.6], spread_mm: 11 } },
    paired: { difference_mm: 39.1, ci95: [30.2, 48.3] } },
    plots: { intervals: [{ title: "Bias against the ratio of periods", x: "ratio", y: "bias_mm", lines:
      ["theory", "measured"].map((name, k) => ({ name, points: Array.from({ length: 9 }, (_, i) =>
        [i / 8, 40 * Math.cos(i) + k, 40 * Math.cos(i) - 4, 40 * Math.cos(i) + 5]) })) }] },
    tables: [{ title: "Table 1", columns: ["robot", "x (mm)", "y (mm)"], rows: [["real", 186, 120], ["ours", 190.4, null]] }],
  };
}

/** Beacons seen by a walking robot: residuals over the ground. */
export function compareLandmarks() {
  const { uniform, normal } = generator(5);
  const places = [{ name: "0", x: 2.2, y: 1.45 }, { name: "1", x: 2.2, y: -1.45 }, { name: "2", x: -2.2, y: 0 }];
  const robot = Array.from({ length: 300 }, () => [2 * uniform() - 1, 2 * uniform() - 1]);
  return {
    format: "seam-report/1", version: "0.1.0", title: "Beacons",
    command: "seam compare --model detector.yaml --data landmarks-a --report r.html",
    data: { folder: "landmarks-a", kind: "landmarks", n: 6682, residuals: 13364, groups: 30, held_out_n: 3860,
      held_out_groups: 9, noise: { range_m: 0.03, bearing_rad: 0.006 }, noise_from: "file" },
    result: { format: "seam-compare/1", headline: "What matters: bearing_rad is correlated in time (5 x noise)", error: 3.65,
      native: { range_m: 0.029, bearing_rad: 0.03 }, noise_floor: 1, outliers: [], structure: [
        { residual: "bearing_rad", moment: "mean", covariate: "neighbour", strength: 0.03, p_value: 1e-80 }] },
    plots: { arrows: [{ stage: "before", plane: "world_m", unit: "m", robot, places,
      items: robot.map((_, i) => [places[i % 3].x, places[i % 3].y, 0.1 + 0.03 * normal(), 0.03 * normal()]) }] },
  };
}

/** Walks seen from above, measured beside predicted. */
export function diagnoseWalks() {
  const way = (stretch) => Array.from({ length: 40 }, (_, i) => [stretch * Math.cos(i / 8), stretch * Math.sin(i / 8)]);
  return {
    format: "seam-report/1", version: "0.1.0", title: "Walks filmed from above",
    command: "seam diagnose --model walk.yaml --data odometry-a --report r.html",
    data: { folder: "odometry-a", kind: "odometry", n: 984, residuals: 2952, groups: 24, held_out_n: 966, held_out_groups: 8,
      noise: { x_m: 0.002 }, noise_from: "file" },
    result: { format: "seam-diagnose/1", kind: "odometry", n: 984, groups: 24, verdict: "missing_effect",
      headline: "What matters: odometry_scale is missing; it moves predictions by 7.2 x noise",
      baseline: { error: 5.19, native: { x_m: 0.01 }, noise_floor: 1 }, candidates: [], structure: [],
      explanation: { steps: [{ effect: "odometry_scale", error_after: 1.007 }], error: 1.007 }, outliers: [], advice: "" },
    plots: { series: [{ title: "run 3 from above", x: "x_m", y: "y_m", plane: "world_m", rms: 0.031, lines: [
      { name: "measured", points: way(0.5) }, { name: "predicted", points: way(0.44) },
      { name: "predicted after", points: way(0.498) }] }] },
  };
}

export const fixtures = { compareLandmarks, diagnoseWalks, diagnosePoints, discoverPhotometry, compareJoints, history, headSwing };
