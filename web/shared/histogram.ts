// How residuals are spread in units of their stated error, beside the normal curve.
import * as Plot from "@observablehq/plot";
import { words } from "./format";
import { palette } from "./palette";
import type { Histogram } from "./types";

/** Counts as density, so that sets of different size and the normal curve share one axis. */
function densities(histogram: Histogram) {
  const total = histogram.counts.reduce((a, b) => a + b, 0) || 1;
  return histogram.counts.map((n, i) => {
    const [low, high] = [histogram.edges[i], histogram.edges[i + 1]];
    return { low, high, density: n / total / (high - low) };
  });
}

/** The share of residuals beyond so many of their stated errors. */
export function beyond(histogram: Histogram, limit: number): number {
  const total = histogram.counts.reduce((a, b) => a + b, 0) || 1;
  return histogram.counts.reduce((sum, n, i) =>
    sum + (Math.abs((histogram.edges[i] + histogram.edges[i + 1]) / 2) > limit ? n : 0), 0) / total;
}

export function distributionOptions(name: string, before?: Histogram, after?: Histogram): Plot.PlotOptions {
  const sets = [before, after].filter((set): set is Histogram => set !== undefined);
  const shown = (after ?? before)!;
  const edges = sets.flatMap((set) => set.edges);
  const reach = Math.max(...edges.map(Math.abs));
  const normal = Array.from({ length: 121 }, (_, i) => {
    const x = (i / 60 - 1) * Math.min(reach, 6);
    return { x, y: Math.exp(-x * x / 2) / Math.sqrt(2 * Math.PI) };
  });
  // What lies far outside is counted in the last bins: they must not flatten the rest.
  const highest = Math.max(0.46, 1.08 * Math.max(...densities(shown).slice(1, -1).map((d) => d.density)));
  return {
    height: 220, marginLeft: 46, marginBottom: 38,
    x: { label: `${words(name)}: residual / its stated error`, ticks: 7, tickSize: 4 },
    y: { label: "density", ticks: 4, tickSize: 4, grid: true, domain: [0, highest] },
    marks: [
      ...[[before, palette.before], [after, palette.after]].flatMap(([set, colour]) => set
        ? [Plot.rect(densities(set as Histogram), { x1: "low", x2: "high", y1: 0, y2: "density",
            fill: colour as string, fillOpacity: after && set === before ? 0.35 : 0.6, inset: 0.3, clip: true })]
        : []),
      Plot.line(normal, { x: "x", y: "y", stroke: palette.ink, strokeWidth: 1.5 }),
      Plot.ruleY([0], { stroke: palette.ink2 }),
    ],
  };
}
