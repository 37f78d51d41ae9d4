// Lines over time or over the ground: what was measured beside what a model predicts.
import * as Plot from "@observablehq/plot";
import { useCallback } from "preact/hooks";
import { Figure, type FigureProps } from "./figure";
import { number, splitUnit, words } from "./format";
import { palette, series as colours } from "./palette";
import type { Series } from "./types";

export function label(name: string): string {
  const split = splitUnit(name);
  return split.unit ? `${words(split.name)} (${split.unit})` : words(name);
}

export function colourOf(name: string, i: number): string {
  if (name === "measured") return palette.ink;
  if (name === "predicted") return palette.before;
  if (name === "predicted after") return palette.after;
  return colours()[i % colours().length];
}

interface SeriesProps extends Pick<FigureProps, "onBrush" | "tools" | "paint"> {
  plot: Series;
  /** Of all lines of the plots that share one key: their order gives the colours. */
  names: string[];
  sentence?: string;
}

export function SeriesFigure({ plot, names, sentence, ...more }: SeriesProps) {
  const ground = plot.plane === "world_m";
  const draw = useCallback((width: number): Plot.PlotOptions => ({
    ...(ground ? groundSize(plot, width) : { height: 230 }), marginLeft: 52, marginBottom: 38,
    x: { label: label(plot.x), ticks: width < 420 ? 4 : 6, tickSize: 4, ...(ground ? { domain: spanOf(plot, 0) } : {}) },
    y: { label: label(plot.y), ticks: 5, tickSize: 4, grid: true,
      ...(ground ? { domain: spanOf(plot, 1) } : plot.span ? { domain: plot.span } : { nice: true }) },
    marks: plot.lines.flatMap((line) => [
      Plot.line(line.points, {
        x: (p: number[]) => p[0], y: (p: number[]) => p[1], strokeWidth: 1.4, clip: plot.span !== undefined,
        stroke: colourOf(line.name, names.indexOf(line.name)),
        strokeDasharray: line.name === "command" ? "3 3" : undefined,
      }),
      ...(ground && line.points.length > 0 ? [Plot.dot([line.points[0]], { x: (p: number[]) => p[0],
        y: (p: number[]) => p[1], r: 3.5, fill: colourOf(line.name, names.indexOf(line.name)) })] : []),
    ]),
  }), [plot]);
  const unit = splitUnit(plot.y).unit;
  const off = plot.rms == null ? "" : ` The root mean square between the first two is ${number(plot.rms)} ${unit}.`;
  return (
    <Figure name={`series ${plot.title ?? plot.y}`} title={plot.title} draw={draw} {...more}
      sentence={sentence ?? (ground
        ? `The way that was measured and the way that the model predicts, from above; dots mark the starts.${off}`
        : `What was measured of ${words(splitUnit(plot.y).name)}, and what the model predicts ` +
          `for it. Where the lines part, the model is wrong.${off}`)} />
  );
}

/** The span of a plot's x (0) or y (1), with some air. */
function spanOf(plot: Series, axis: 0 | 1): [number, number] {
  const values = plot.lines.flatMap((line) => line.points.map((p) => p[axis]));
  const low = Math.min(...values), high = Math.max(...values);
  const pad = 0.06 * Math.max(high - low, 0.1);
  return [low - pad, high + pad];
}

/** Width and height that give a metre the same length along both axes. */
function groundSize(plot: Series, width: number) {
  const [x0, x1] = spanOf(plot, 0), [y0, y1] = spanOf(plot, 1);
  const along = width - 52 - 20, most = 340;
  const scale = Math.min(along / (x1 - x0), most / (y1 - y0));
  return { width: Math.round(scale * (x1 - x0) + 72), height: Math.round(scale * (y1 - y0) + 58), marginRight: 20,
    marginTop: 20 };
}
