// Sums over rows: bins along a covariate, histograms, maps and groups. Each takes a few milliseconds for 100,000 rows, so
// that a preview draws all plots again at once.
import type { Bin, Histogram } from "../shared/types";
import type { Numbers, Residuals, Rows } from "./rows";

const fewest = 6;
/** Labels of points or groups are no quantity: each has a bin of its own, as far as there is room. */
const mostLabels = 120;
export const isLabel = (covariate: string) => /^(point|group|landmark|tag|scenario|value|statistic)$/.test(covariate);

/** Values of a column that has few, such as signs; null where there are more. */
function fewValues(order: Uint32Array, x: Numbers, most: number): number[] | null {
  const values: number[] = [];
  for (const i of order) {
    if (values.length > 0 && x[i] === values[values.length - 1]) continue;
    if (values.length === most) return null;
    values.push(x[i]);
  }
  return values;
}

function binOf(order: Uint32Array, from: number, to: number, x: Numbers, r: Numbers, s: Numbers): Bin {
  let n = 0, sum = 0, squares = 0, variance = 0, place = 0;
  for (let k = from; k < to; ++k) {
    const i = order[k], value = r[i];
    if (!(value - value === 0)) continue;
    ++n;
    sum += value;
    squares += value * value;
    variance += s[i] * s[i];
    place += x[i];
  }
  const mean = sum / n;
  return { low: x[order[from]], high: x[order[to - 1]], centre: n ? place / n : x[order[from]], n, mean: n ? mean : null,
    mean_sigma: n ? Math.sqrt(variance) / n : null, formal: n ? Math.sqrt(variance / n) : null,
    scatter: n > 1 ? Math.sqrt(Math.max(0, (squares - n * mean * mean) / (n - 1))) : null };
}

/** Bins of equal number along a covariate, or one for each of its values where it has few. */
export function binned(rows: Rows, covariate: string, r: Numbers, s: Numbers): Bin[] {
  const x = rows.column(covariate)!, order = rows.order(covariate);
  if (order.length === 0) return [];
  const few = fewValues(order, x, isLabel(covariate) ? mostLabels : fewest);
  const bins: Bin[] = [];
  if (few) {
    for (let from = 0; from < order.length;) {
      let to = from;
      while (to < order.length && x[order[to]] === x[order[from]]) ++to;
      bins.push(binOf(order, from, to, x, r, s));
      from = to;
    }
    return bins;
  }
  const count = Math.max(4, Math.min(24, Math.floor(order.length / 20)));
  for (let b = 0; b < count; ++b) {
    const from = Math.floor((b * order.length) / count), to = Math.floor(((b + 1) * order.length) / count);
    if (to > from) bins.push(binOf(order, from, to, x, r, s));
  }
  return bins.filter((bin) => bin.n > 0);
}

export function rms(values: Numbers): number | null {
  let squares = 0, n = 0;
  for (let i = 0; i < values.length; ++i) {
    const square = values[i] * values[i];
    if (!(square - square === 0)) continue;
    squares += square;
    ++n;
  }
  return n ? Math.sqrt(squares / n) : null;
}

export const reach = 5;
const width = 0.25;
export const histogramBins = (2 * reach) / width;

/** The histogram's bin of a residual in units of its error; what lies outside goes into the first and last. */
export function histogramBin(z: number): number {
  return Math.max(0, Math.min(histogramBins - 1, Math.floor((z + reach) / width)));
}

export function histogram(residual: string, residuals: Residuals, stage: "before" | "after"): Histogram {
  const r = residuals.r.get(residual)!, s = residuals.s.get(residual)!;
  const counts = new Array<number>(histogramBins).fill(0);
  for (let i = 0; i < r.length; ++i) {
    const z = r[i] / s[i];
    if (z - z === 0) ++counts[histogramBin(z)];
  }
  return { residual, stage, counts, edges: Array.from({ length: histogramBins + 1 }, (_, i) => -reach + width * i) };
}

export interface Cells {
  columns: number;
  rows: number;
  x: [number, number];
  y: [number, number];
  mean: Float32Array;
  count: Uint32Array;
}

/** The mean residual in cells of two covariates; the span leaves out the outermost half percent. */
export function cellsOf(rows: Rows, nameX: string, nameY: string, r: Numbers, columns: number, lines: number): Cells {
  const x = rows.column(nameX)!, y = rows.column(nameY)!;
  const span = (name: string, values: Numbers): [number, number] => {
    const order = rows.order(name);
    const cut = Math.floor(0.005 * order.length);
    return [values[order[cut]], values[order[order.length - 1 - cut]]];
  };
  const [x0, x1] = span(nameX, x), [y0, y1] = span(nameY, y);
  const mean = new Float32Array(columns * lines), count = new Uint32Array(columns * lines);
  const kx = columns / (x1 - x0 || 1), ky = lines / (y1 - y0 || 1);
  for (let i = 0; i < rows.n; ++i) {
    const value = r[i];
    if (!(value - value === 0)) continue;
    const a = Math.floor((x[i] - x0) * kx), b = Math.floor((y[i] - y0) * ky);
    const at = Math.min(columns - 1, a) + columns * Math.min(lines - 1, b);
    if (!(a >= 0 && b >= 0 && a <= columns && b <= lines)) continue;
    mean[at] += value;
    ++count[at];
  }
  for (let k = 0; k < mean.length; ++k) mean[k] = count[k] ? mean[k] / count[k] : NaN;
  return { columns, rows: lines, x: [x0, x1], y: [y0, y1], mean, count };
}

export interface Group {
  id: number;
  n: number;
  heldOut: boolean;
  /** Root mean square of the residuals in units of their error; 1 is the noise. */
  error: number;
}

/** `ids`: the group of each row; groups that are held out have `held`. */
export function groupsOf(rows: Rows, residuals: Residuals, ids: Numbers | undefined, held?: Numbers): Group[] {
  if (!ids) return [];
  const found = new Map<number, Group & { squares: number }>();
  for (const name of residuals.channels) {
    const r = residuals.r.get(name)!, s = residuals.s.get(name)!;
    let group: (Group & { squares: number }) | undefined;
    for (let i = 0; i < rows.n; ++i) {
      const z = r[i] / s[i];
      if (!(z - z === 0)) continue;
      if (group?.id !== ids[i]) group = found.get(ids[i]); // Rows of a group mostly adjoin.
      if (!group) {
        group = { id: ids[i], n: 0, heldOut: held ? held[i] > 0 : false, error: 0, squares: 0 };
        found.set(ids[i], group);
      }
      ++group.n;
      group.squares += z * z;
    }
  }
  return [...found.values()].map((group) => ({ ...group, error: Math.sqrt(group.squares / group.n) }))
    .sort((a, b) => a.id - b.id);
}
