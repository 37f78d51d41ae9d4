// A residual against a covariate: bin means with their formal error, the actual scatter of the single residuals, and
// the scatter that the model states; before and after in one picture.
import * as Plot from "@observablehq/plot";
import { covariateUnit, number, splitUnit, words } from "./format";
import { palette } from "./palette";
import type { Bin, ResidualPlot } from "./types";

export interface Pair {
  before?: ResidualPlot;
  after?: ResidualPlot;
}

/** Plots of the same residual and covariate, before and after, belong into one picture. */
export function pairs(plots: ResidualPlot[]): Pair[] {
  const found = new Map<string, Pair>();
  for (const plot of plots) {
    const key = `${plot.residual}|${plot.covariate}|${plot.moment ?? "mean"}`;
    const pair = found.get(key) ?? {};
    pair[plot.stage ?? "before"] = plot;
    found.set(key, pair);
  }
  return [...found.values()];
}

/** The plot for a width in CSS pixels. */
export function residualOptions(pair: Pair, width: number): Plot.PlotOptions {
  const plot = (pair.before ?? pair.after)!;
  const residual = splitUnit(plot.residual);
  const covariate = splitUnit(plot.covariate);
  const spread = plot.moment === "spread";
  const few = fewValues(plot);
  const values = few ?? [];
  const step = values.length > 1 ? Math.min(...values.slice(1).map((x, i) => x - values[i])) : 1;
  return {
    height: Math.round(Math.min(300, Math.max(210, width * 0.52))),
    marginLeft: 52,
    marginBottom: 38,
    x: { label: axisLabel(covariate.name, plot.x_unit ?? (covariate.unit || covariateUnit(plot.covariate))), tickSize: 4,
      ...(few ? { ticks: values, tickFormat: plot.x_names ? (k: number) => plot.x_names![k] ?? "" : "~g", domain: [values[0] - 0.5 * step, values[values.length - 1] + 0.5 * step] }
        : { ticks: width < 420 ? 4 : 6 }) },
    y: {
      label: axisLabel(spread ? `spread of ${residual.name}` : `${residual.name} residual`,
        residual.unit),
      ticks: 5, tickSize: 4, grid: true, nice: true,
      domain: spread ? undefined : meanDomain(pair),
      zero: spread,
    },
    marks: spread ? spreadMarks(pair) : meanMarks(pair),
  };
}

/** The values of a covariate that has few, such as 0 and 1: nothing lies between them. */
/** Whether a line may join the bins. */
const isJoined = (plot: ResidualPlot) => !plot.discrete && fewValues(plot) === null;

function fewValues(plot: ResidualPlot): number[] | null {
  return plot.bins.length <= 6 && plot.bins.every((bin) => bin.low === bin.high)
    ? plot.bins.map((bin) => bin.centre) : null;
}

function axisLabel(name: string, unit: string): string {
  return unit ? `${words(name)} (${unit})` : words(name);
}

/** Room for the means and the scatter; single residuals far outside do not stretch the plot. */
function meanDomain(pair: Pair): [number, number] {
  let low = 0;
  let high = 0;
  for (const plot of [pair.before, pair.after]) {
    for (const bin of plot?.bins ?? []) {
      const reach = Math.max(1.35 * (bin.scatter ?? 0), 1.35 * (bin.formal ?? 0),
        2 * (bin.mean_sigma ?? 0));
      low = Math.min(low, (bin.mean ?? 0) - reach);
      high = Math.max(high, (bin.mean ?? 0) + reach);
    }
  }
  return low === high ? [-1, 1] : [low, high];
}

export const shown = (bins: Bin[]) => bins.filter((bin) => bin.mean !== null);

function meanMarks(pair: Pair): Plot.Markish[] {
  const first = (pair.before ?? pair.after)!;
  const colour = pair.before ? palette.before : palette.after;
  const [low, high] = meanDomain(pair);
  const sample = (first.sample ?? []).filter(([, r]) => r >= low && r <= high);
  const formal = shown(first.bins).filter((bin) => bin.formal !== null);
  const joined = isJoined(first);
  const reach = { y1: (b: Bin) => b.mean! - (b.scatter ?? 0), y2: (b: Bin) => b.mean! + (b.scatter ?? 0) };
  return [
    Plot.dot(sample, { x: "0", y: "1", r: 1.3, fill: palette.dot, fillOpacity: 0.7 }),
    joined ? Plot.areaY(shown(first.bins), { x: "centre", ...reach, fill: colour, fillOpacity: 0.13 })
      : Plot.ruleX(shown(first.bins), { x: "centre", ...reach, stroke: colour, strokeWidth: first.bins.length > 6 ? 4 : 16, strokeOpacity: 0.16 }),
    ...[1, -1].map((sign) => (joined
      ? Plot.line(formal, { x: "centre", y: (b: Bin) => sign * b.formal!, stroke: palette.formal, strokeWidth: 1.3,
        strokeDasharray: "4 3" })
      : Plot.dot(formal, { x: "centre", y: (b: Bin) => sign * b.formal!, symbol: "square", stroke: palette.formal }))),
    Plot.ruleY([0], { stroke: palette.ink2, strokeWidth: 1 }),
    ...barMarks(first.bins, colour, joined),
    ...(pair.before && pair.after ? barMarks(pair.after.bins, palette.after, joined) : []),
  ];
}

/** Means with their errors; a line joins them only along a quantity. */
function barMarks(bins: Bin[], colour: string, joined: boolean): Plot.Markish[] {
  const low = (b: Bin) => b.mean! - 2 * (b.mean_sigma ?? 0);
  const high = (b: Bin) => b.mean! + 2 * (b.mean_sigma ?? 0);
  return [
    ...(joined ? [Plot.line(shown(bins), { x: "centre", y: "mean", stroke: colour, strokeWidth: 1.4 })] : []),
    Plot.ruleX(shown(bins), { x: "centre", y1: low, y2: high, stroke: colour, strokeWidth: 1.4 }),
    Plot.dot(shown(bins), {
      x: "centre", y: "mean", r: 2.8, fill: colour, stroke: palette.card, strokeWidth: 0.8,
      title: (b: Bin) => `mean ${number(b.mean)} ± ${number(b.mean_sigma, 2)}\n` +
        `scatter ${number(b.scatter)}, stated ${number(b.formal)}\n${b.n} residuals`,
    }),
  ];
}

function spreadMarks(pair: Pair): Plot.Markish[] {
  const first = (pair.before ?? pair.after)!;
  const joined = isJoined(first);
  const stated = first.bins.filter((b) => b.formal !== null);
  const marks: Plot.Markish[] = [
    Plot.ruleY([0], { stroke: palette.line }),
    joined ? Plot.line(stated, { x: "centre", y: "formal", stroke: palette.formal, strokeWidth: 1.6,
      strokeDasharray: "4 3" }) : Plot.dot(stated, { x: "centre", y: "formal", stroke: palette.formal, symbol: "square" }),
  ];
  for (const [plot, colour] of [[pair.before, palette.before], [pair.after, palette.after]] as const) {
    const bins = (plot?.bins ?? []).filter((b) => b.scatter !== null && b.n > 1);
    marks.push(
      ...(joined ? [Plot.line(bins, { x: "centre", y: "scatter", stroke: colour, strokeWidth: 1.4 })] : []),
      Plot.ruleX(bins, {
        x: "centre", stroke: colour, strokeWidth: 1.4,
        y1: (b: Bin) => b.scatter! * (1 - 2 / Math.sqrt(2 * (b.n - 1))),
        y2: (b: Bin) => b.scatter! * (1 + 2 / Math.sqrt(2 * (b.n - 1))),
      }),
      Plot.dot(bins, { x: "centre", y: "scatter", r: 2.8, fill: colour, stroke: palette.card }),
    );
  }
  return marks;
}
