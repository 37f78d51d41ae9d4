// Residuals where they lie: arrows over the image or the field, and maps of the mean over the image.
import * as Plot from "@observablehq/plot";
import { arrowScale, bounds, inImage, length, placeMarks, unitOf } from "../shared/arrows";
import { Figure } from "../shared/figure";
import { leastShown, number, quantile } from "../shared/format";
import { palette } from "../shared/palette";
import type { Arrows, ImageMap } from "../shared/types";
import type { Report } from "./data";

export function OverImage({ report }: { report: Report }) {
  const arrows = (report.plots?.arrows ?? []).filter((set) => set.items.length > 0);
  const maps = report.plots?.maps ?? [];
  if (arrows.length === 0 && maps.length === 0) return null;
  const scale = arrowScale(arrows);
  const reach = mapReach(maps);
  return (
    <section id="image">
      <h2>{arrows.some((set) => !inImage(set)) ? "Residuals over the ground" : "Residuals over the image"}</h2>
      <div class="figures">
        {arrows.map((set, i) => (
          <ArrowFigure key={`arrows ${i}`} set={set} scale={scale} report={report} />
        ))}
        {maps.map((map, i) => <MapFigure key={`map ${i}`} map={map} reach={reach} />)}
      </div>
    </section>
  );
}

function ArrowFigure({ set, scale, report }: { set: Arrows; scale: number; report: Report }) {
  const image = inImage(set);
  const size = image ? report.data?.image : undefined;
  const after = set.stage === "after";
  const colour = after ? palette.after : palette.before;
  const unit = unitOf(set);
  const box = size ? [-0.5, size.width_px - 0.5, -0.5, size.height_px - 0.5] : bounds(set, scale);
  const draw = (width: number): Plot.PlotOptions => {
    const margins = 40 + 12;
    const ratio = (box[3] - box[2]) / (box[1] - box[0]);
    return {
      height: Math.round((width - margins) * ratio) + 62,
      marginLeft: 40, marginRight: 12, marginTop: 26, marginBottom: 36,
      x: { domain: [box[0], box[1]], label: image ? "u (px)" : "x (m)", ticks: 6, tickSize: 4 },
      y: { domain: image ? [box[3], box[2]] : [box[2], box[3]], label: image ? "v (px)" : "y (m)",
        ticks: 5, tickSize: 4 },
      marks: [
        Plot.frame({ fill: palette.page, stroke: palette.line }),
        ...(set.robot ? [Plot.dot(set.robot, { x: "0", y: "1", r: 1.4, fill: palette.dot })] : []),
        Plot.arrow(set.items, {
          x1: (d: number[]) => d[0], y1: (d: number[]) => d[1],
          x2: (d: number[]) => d[0] + scale * d[2], y2: (d: number[]) => d[1] + scale * d[3],
          stroke: colour, strokeWidth: 1, headLength: 5, headAngle: 50, strokeOpacity: 0.85,
          clip: true,
        }),
        ...placeMarks(set.places ?? []),
      ],
    };
  };
  const typical = quantile(set.items.map(length), 0.5);
  const long = quantile(set.items.map(length), 0.95);
  return (
    <Figure
      name={`arrows ${set.stage ?? "before"}`}
      title={after ? "With the effects found" : "The model as given"}
      sentence={
        (image ? "Each arrow starts where a point was seen and shows observed minus predicted, "
          : "Each arrow starts at a landmark and shows where one observation puts it instead, from where the robot " +
            "was (grey): ") +
        `${number(scale, 2)} times as long as it is. Half are longer than ${number(typical, 2)} ` +
        `${unit}, one in twenty is longer than ${number(long, 2)} ${unit}. ` +
        (after ? "Arrows without any common direction are noise."
          : "Arrows that share a direction or turn with the place are an effect that the model lacks.")
      }
      draw={draw}
    />
  );
}

function mapReach(maps: ImageMap[]): number {
  const values = maps.flatMap((map) => map.values).filter((v): v is number => v !== null);
  return Math.max(quantile(values.map(Math.abs), 0.98), leastShown(maps[0]?.unit === "dn" ? "DN" : maps[0]?.unit ?? "")) || 1;
}

function MapFigure({ map, reach }: { map: ImageMap; reach: number }) {
  const cells = map.values.map((value, i) => ({
    u: (i % map.columns) * (map.width_px / map.columns),
    v: Math.floor(i / map.columns) * (map.height_px / map.rows),
    value,
  })).filter((cell) => cell.value !== null);
  const unit = map.unit === "dn" ? "DN" : map.unit ?? "";
  const draw = (width: number): Plot.PlotOptions => ({
    height: Math.round((width - 52) * (map.height_px / map.width_px)) + 62,
    marginLeft: 40, marginRight: 12, marginTop: 26, marginBottom: 36,
    x: { domain: [0, map.width_px], label: "u (px)", ticks: 6, tickSize: 4 },
    y: { domain: [map.height_px, 0], label: "v (px)", ticks: 5, tickSize: 4 },
    color: {
      type: "linear", domain: [-reach, 0, reach], range: [palette.after, palette.middle, palette.before],
      clamp: true, label: `${map.title ?? "mean residual"} (${unit})`, legend: true,
    },
    marks: [
      Plot.rect(cells, {
        x1: "u", y1: "v", x2: (c) => c.u + map.width_px / map.columns,
        y2: (c) => c.v + map.height_px / map.rows, fill: "value", inset: -0.2,
      }),
      Plot.frame({ stroke: palette.line }),
    ],
  });
  const after = map.stage === "after";
  return (
    <Figure
      name={`map ${map.title ?? ""} ${map.stage ?? "before"}`}
      title={<>{map.title ?? "Mean residual"} <span class="quiet">
        {after ? "with the effects found" : "the model as given"}</span></>}
      sentence={
        `Mean of observed minus predicted in each cell, in ${unit}: orange where the image is ` +
        "brighter than the model says, blue where darker. A right model leaves speckle without shape."
      }
      draw={draw}
    />
  );
}
