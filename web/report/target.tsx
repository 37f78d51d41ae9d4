// A target as a fit found it: how far each of its points lies from its plan; and a lens over the
// image: how well it is known, or by how much two models differ.
import * as Plot from "@observablehq/plot";
import { leastShown, number, quantile, roundScale } from "../shared/format";
import { palette } from "../shared/palette";
import { Figure } from "../shared/figure";
import type { ImageMap } from "../shared/types";
import type { Report } from "./data";

export function TargetPicture({ report }: { report: Report }) {
  const points = report.plots?.target ?? [];
  if (points.length === 0) return null;
  const xs = points.map((p) => p[0]), ys = points.map((p) => p[1]);
  const width_m = Math.max(...xs) - Math.min(...xs), height_m = Math.max(...ys) - Math.min(...ys);
  const pad = 0.06 * Math.max(width_m, height_m, 1e-6);
  const box = [Math.min(...xs) - pad, Math.max(...xs) + pad, Math.min(...ys) - pad, Math.max(...ys) + pad];
  const shifts = points.map((p) => Math.hypot(p[2], p[3]));
  const long = quantile(shifts, 0.95), error = quantile(points.map((p) => p[5]), 0.5);
  const scale = long > 0 ? roundScale(Math.max(width_m, height_m) / 14 / Math.max(long, leastShown("m"))) : 1;
  const reach = 1000 * Math.max(quantile(points.map((p) => Math.abs(p[4])), 0.98), leastShown("m"));
  const draw = (width: number): Plot.PlotOptions => ({
    height: Math.round((width - 52) * ((box[3] - box[2]) / (box[1] - box[0]))) + 62,
    marginLeft: 40, marginRight: 12, marginTop: 26, marginBottom: 36,
    x: { domain: [box[0], box[1]], label: "x (m)", ticks: 6, tickSize: 4 },
    y: { domain: [box[2], box[3]], label: "y (m)", ticks: 5, tickSize: 4 },
    color: {
      type: "linear", domain: [-reach, 0, reach], range: [palette.after, palette.line, palette.before],
      clamp: true, label: "out of the plane (mm)", legend: true,
    },
    marks: [
      Plot.frame({ fill: palette.page, stroke: palette.line }),
      Plot.dot(points, {
        x: (p: number[]) => p[0], y: (p: number[]) => p[1], r: 3.2,
        fill: (p: number[]) => 1000 * p[4], stroke: palette.line, strokeWidth: 0.5,
      }),
      Plot.arrow(points, {
        x1: (p: number[]) => p[0], y1: (p: number[]) => p[1],
        x2: (p: number[]) => p[0] + scale * p[2], y2: (p: number[]) => p[1] + scale * p[3],
        stroke: palette.ink2, strokeWidth: 1, headLength: 4, headAngle: 50, clip: true,
      }),
    ],
  });
  const known = error > 0
    ? ` Half of the points are known to ${number(1000 * error, 2)} mm along the board or better.` : "";
  return (
    <section id="target">
      <h2>The target</h2>
      <div class="figures">
        <Figure
          name="target"
          title="Where its points lie off their plan"
          sentence={
            `Each arrow starts at a point of the plan and shows its displacement along the board, ` +
            `${number(scale, 2)} times as long as it is; colours show the displacement out of it. Half of the ` +
            `arrows stand for more than ${number(1000 * quantile(shifts, 0.5), 2)} mm, one in twenty for more ` +
            `than ${number(1000 * long, 2)} mm.${known}`
          }
          draw={draw}
        />
      </div>
    </section>
  );
}

export function LensMapFigure({ report }: { report: Report }) {
  const given = report.plots?.lens_error;
  // One map, or one for each camera of a rig.
  const maps = (Array.isArray(given) ? given : given ? [given] : [])
    .filter((map) => map.values.some((value) => value !== null));
  if (maps.length === 0) return null;
  const difference = maps[0]!.title === "Difference";
  return (
    <section id="lens">
      <h2>{difference ? "Two lenses over the image" : "How well the lens is known"}</h2>
      <div class="figures">
        {maps.map((map) => <OneLensMap map={map} difference={difference} />)}
      </div>
    </section>
  );
}

function OneLensMap({ map, difference }: { map: ImageMap; difference: boolean }) {
  const cells = map.values.map((value, i) => ({
    u: (i % map.columns) * (map.width_px / map.columns),
    v: Math.floor(i / map.columns) * (map.height_px / map.rows),
    value,
  })).filter((cell) => cell.value !== null);
  const sizes = cells.map((cell) => cell.value as number);
  const reach = Math.max(quantile(sizes, 0.98), leastShown("px"));
  const draw = (width: number): Plot.PlotOptions => ({
    height: Math.round((width - 52) * (map.height_px / map.width_px)) + 62,
    marginLeft: 40, marginRight: 12, marginTop: 26, marginBottom: 36,
    x: { domain: [0, map.width_px], label: "u (px)", ticks: 6, tickSize: 4 },
    y: { domain: [map.height_px, 0], label: "v (px)", ticks: 5, tickSize: 4 },
    color: {
      type: "linear", domain: [0, reach], range: [palette.middle, palette.before], clamp: true,
      label: `${map.title ?? ""} (px)`, legend: true,
    },
    marks: [
      Plot.rect(cells, {
        x1: "u", y1: "v", x2: (c) => c.u + map.width_px / map.columns,
        y2: (c) => c.v + map.height_px / map.rows, fill: "value", inset: -0.2,
      }),
      Plot.frame({ stroke: palette.line }),
    ],
  });
  const middle = number(quantile(sizes, 0.5), 2), most = number(Math.max(...sizes), 2);
  return (
    <Figure
      name={`lens ${map.title ?? ""}${map.camera ? ` ${map.camera}` : ""}`}
      title={(difference ? "Difference of the two models" : "Standard error of the predicted place") +
        (map.camera ? `, camera ${map.camera}` : "")}
      sentence={
        (difference
          ? `By how many pixels the two models see one direction at different places, `
          : `One standard error of the place at which the model sees a direction, `) +
        "the turn of the camera taken out: " + (Math.max(...sizes) < leastShown("px")
          ? `it is below ${number(leastShown("px"), 1)} px everywhere. `
          : `half of the image lies above ${middle} px, the largest is ${most} px. `) +
        (difference ? "" : "Where no point was seen it grows: there the lens is extrapolated.")
      }
      draw={draw}
    />
  );
}
