// Measured beside predicted over time for a few runs, and means with intervals for experiments.
import * as Plot from "@observablehq/plot";
import { Figure, Key } from "../shared/figure";
import { number } from "../shared/format";
import { palette } from "../shared/palette";
import { colourOf, label, SeriesFigure } from "../shared/series";
import type { Series } from "../shared/types";
import type { Interval, Report } from "./data";

export function SeriesPlots({ report }: { report: Report }) {
  const all = report.plots?.series ?? [];
  if (all.length === 0) return null;
  const names = [...new Set(all.flatMap((plot) => plot.lines.map((line) => line.name)))];
  return (
    <section id="series">
      <h2>Measured beside predicted</h2>
      <Key items={names.map((name, i) => ({ colour: colourOf(name, i), shape: "line",
        label: name === "predicted after" ? "predicted with the effects found" : name }))} />
      <div class="figures">
        {all.map((plot, i) => <SeriesFigure key={i} plot={plot} names={names} />)}
      </div>
    </section>
  );
}

export function IntervalPlots({ report }: { report: Report }) {
  const all = report.plots?.intervals ?? [];
  if (all.length === 0) return null;
  const names = [...new Set(all.flatMap((plot) => plot.lines.map((line) => line.name)))];
  return (
    <section id="intervals">
      <h2>Means and their intervals</h2>
      <Key items={names.map((name, i) => ({ label: name, colour: colourOf(name, i), shape: "bar" }))} />
      <div class="figures">
        {all.map((plot, i) => (
          <Figure key={i} name={`intervals ${plot.title ?? plot.y}`} title={plot.title}
            draw={() => intervalOptions(plot, names)}
            sentence="Points are means over the runs, bars their 95 % intervals." />
        ))}
      </div>
    </section>
  );
}

function intervalOptions(plot: Series, names: string[]): Plot.PlotOptions {
  return {
    height: 260, marginLeft: 56, marginBottom: 38,
    x: { label: label(plot.x), ticks: 6, tickSize: 4 },
    y: { label: label(plot.y), ticks: 5, tickSize: 4, grid: true, nice: true },
    marks: plot.lines.flatMap((line) => {
      const colour = colourOf(line.name, names.indexOf(line.name));
      const x = (p: number[]) => p[0];
      return [
        Plot.line(line.points, { x, y: (p: number[]) => p[1], stroke: colour, strokeWidth: 1.4 }),
        Plot.ruleX(line.points.filter((p) => p.length >= 4), { x, y1: (p: number[]) => p[2],
          y2: (p: number[]) => p[3], stroke: colour, strokeWidth: 1.4 }),
        Plot.dot(line.points, { x, y: (p: number[]) => p[1], r: 3, fill: colour, stroke: palette.card }),
      ];
    }),
  };
}

function range(centre: number, ci: number | [number, number] | undefined): [number, number] {
  if (ci === undefined) return [centre, centre];
  return Array.isArray(ci) ? ci : [centre - ci, centre + ci];
}

/** The head-swing experiment: one bias with its interval for each way to take frames. */
export function Modes({ report }: { report: Report }) {
  const modes = Object.entries(report.result.modes ?? {}) as [string, Interval][];
  if (modes.length === 0) return null;
  const rows = modes.filter(([, m]) => m.bias_mm !== null).map(([name, mode]) => {
    const [low, high] = range(mode.bias_mm!, mode.ci95);
    return { name, bias: mode.bias_mm!, low, high };
  });
  const paired = report.result.paired;
  const clear = paired && paired.difference_mm !== null &&
    range(paired.difference_mm, paired.ci95).every((v) => Math.sign(v) === Math.sign(paired.difference_mm!));
  const draw = (_width: number): Plot.PlotOptions => ({
    height: 60 + 44 * rows.length, marginLeft: 90, marginRight: 30, marginBottom: 38,
    x: { label: "bias (mm)", nice: true, grid: true, zero: true, tickSize: 4 },
    y: { label: null, domain: rows.map((r) => r.name), tickSize: 0 },
    marks: [
      Plot.ruleX([0], { stroke: palette.ink2 }),
      Plot.ruleY(rows, { x1: "low", x2: "high", y: "name", stroke: palette.after, strokeWidth: 2 }),
      Plot.dot(rows, { x: "bias", y: "name", r: 5, fill: palette.after, stroke: palette.card }),
      Plot.text(rows, { x: "bias", y: "name", dy: -14, text: (r) => number(r.bias), fill: palette.ink }),
    ],
  });
  return (
    <section id="modes">
      <h2>Bias of each way to take frames</h2>
      <div class="figures">
        <Figure wide name="bias of modes" draw={draw}
          sentence={
            `Mean bias with its 95 % interval over ${report.result.seeds ?? "all"} seeds.` +
            (paired ? ` The paired difference is ${number(paired.difference_mm)} mm; its interval ` +
              (clear ? "excludes zero: the way frames are taken does change the bias."
                : "includes zero: these runs show no difference.") : "")
          } />
      </div>
    </section>
  );
}
