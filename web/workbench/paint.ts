// Many marks on a canvas beneath a plot's axes: dots as density, arrows, cells.
import type { Frame } from "../shared/figure";
import type { Cells } from "./bins";
import type { Numbers } from "./rows";

const dotsAtMost = 6000;

/** A place on the canvas as offset and slope: 100,000 calls would take milliseconds. */
function affine(scale: (value: number) => number): [number, number] {
  const at = scale(0);
  return [at, scale(1) - at];
}

/** How dark a pixel is for its number of dots; from 10 on fully. */
const opacities = Uint8ClampedArray.from({ length: 11 }, (_, count) => (count ? 255 * Math.min(1, 0.35 + 0.2 * Math.log2(count)) : 0));

/** Red, green and blue of #rrggbb. */
export function channels(colour: string): [number, number, number] {
  const hex = colour.replace("#", "");
  return [0, 2, 4].map((at) => parseInt(hex.slice(at, at + 2), 16)) as [number, number, number];
}

/** Dots for some thousand rows, the density of rows in each pixel for more. */
export function paintDots(context: CanvasRenderingContext2D, frame: Frame, x: Numbers, y: Numbers, colour: string) {
  if (x.length <= dotsAtMost) {
    context.fillStyle = colour;
    context.globalAlpha = 0.75;
    for (let i = 0; i < x.length; ++i) {
      const py = frame.y(y[i]);
      if (py - py === 0) context.fillRect(frame.x(x[i]) - 1.1, py - 1.1, 2.2, 2.2);
    }
    context.globalAlpha = 1;
    return;
  }
  const ratio = context.getTransform().a;
  const left = Math.round(frame.left * ratio), top = Math.round(frame.top * ratio);
  const width = Math.round((frame.right - frame.left) * ratio), height = Math.round((frame.bottom - frame.top) * ratio);
  const counts = new Uint16Array(width * height);
  const [atX, slopeX] = affine(frame.x), [atY, slopeY] = affine(frame.y);
  for (let i = 0; i < x.length; ++i) {
    const a = Math.floor((atX + slopeX * x[i]) * ratio) - left, b = Math.floor((atY + slopeY * y[i]) * ratio) - top;
    if (a >= 0 && b >= 0 && a < width && b < height) ++counts[a + width * b];
  }
  const [red, green, blue] = channels(colour);
  const image = context.createImageData(width, height), { data } = image;
  for (let k = 0; k < counts.length; ++k) {
    if (counts[k] === 0) continue;
    data[4 * k] = red;
    data[4 * k + 1] = green;
    data[4 * k + 2] = blue;
    data[4 * k + 3] = opacities[Math.min(counts[k], 10)];
  }
  context.putImageData(image, left, top);
}

/** The rows of a selection over the others; `only` of these rows, where they are given. */
export function paintChosen(context: CanvasRenderingContext2D, frame: Frame, x: Numbers, y: Numbers, mask: Uint8Array,
  colour: string, only?: Iterable<number>) {
  if (mask.length === 0) return; // None is chosen.
  context.fillStyle = colour;
  for (const i of only ?? x.keys()) {
    if (mask[i] && y[i] - y[i] === 0) context.fillRect(frame.x(x[i]) - 1.7, frame.y(y[i]) - 1.7, 3.4, 3.4);
  }
}

/** A line through rows in their order; it breaks where a value is missing. */
export function paintPath(context: CanvasRenderingContext2D, frame: Frame, rows: Iterable<number>, x: Numbers, y: Numbers,
  colour: string, alpha: number) {
  context.strokeStyle = colour;
  context.globalAlpha = alpha;
  context.lineWidth = 1.2;
  context.beginPath();
  let broken = true;
  for (const i of rows) {
    const known = y[i] - y[i] === 0;
    if (known && broken) context.moveTo(frame.x(x[i]), frame.y(y[i]));
    else if (known) context.lineTo(frame.x(x[i]), frame.y(y[i]));
    broken = !known;
  }
  context.stroke();
  context.globalAlpha = 1;
}

/** A straight line for each row, from one place to another. */
export function paintRays(context: CanvasRenderingContext2D, frame: Frame, rows: Iterable<number>,
  [fromX, fromY, toX, toY]: Numbers[], colour: string, alpha: number) {
  context.strokeStyle = colour;
  context.globalAlpha = alpha;
  context.lineWidth = 0.7;
  context.beginPath();
  for (const i of rows) {
    context.moveTo(frame.x(fromX[i]), frame.y(fromY[i]));
    context.lineTo(frame.x(toX[i]), frame.y(toY[i]));
  }
  context.stroke();
  context.globalAlpha = 1;
}

/** Every k-th row as an arrow of `scale` times its shift. */
export function paintArrows(context: CanvasRenderingContext2D, frame: Frame, rows: Iterable<number>,
  [x, y, dx, dy]: Numbers[], scale: number, colour: string, width = 1) {
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.beginPath();
  for (const i of rows) {
    if (!(dx[i] - dx[i] === 0)) continue;
    const x0 = frame.x(x[i]), y0 = frame.y(y[i]);
    const x1 = frame.x(x[i] + scale * dx[i]), y1 = frame.y(y[i] + scale * dy[i]);
    context.moveTo(x0, y0);
    context.lineTo(x1, y1);
    const long = Math.hypot(x1 - x0, y1 - y0);
    if (long < 3) continue;
    const head = Math.min(4.5, 0.45 * long) / long;
    const [ax, ay] = [(x1 - x0) * head, (y1 - y0) * head];
    context.moveTo(x1 - ax + 0.5 * ay, y1 - ay - 0.5 * ax);
    context.lineTo(x1, y1);
    context.lineTo(x1 - ax - 0.5 * ay, y1 - ay + 0.5 * ax);
  }
  context.stroke();
}

/** Cells from blue over neutral to orange; full colour at +-reach. */
export function paintCells(context: CanvasRenderingContext2D, frame: Frame, cells: Cells, reach: number,
  colours: { low: string; middle: string; high: string }) {
  const [low, middle, high] = [channels(colours.low), channels(colours.middle), channels(colours.high)];
  const stepX = (cells.x[1] - cells.x[0]) / cells.columns, stepY = (cells.y[1] - cells.y[0]) / cells.rows;
  for (let b = 0; b < cells.rows; ++b) {
    for (let a = 0; a < cells.columns; ++a) {
      const value = cells.mean[a + b * cells.columns];
      if (!(value - value === 0)) continue;
      const share = Math.min(1, Math.abs(value) / reach), end = value < 0 ? low : high;
      const rgb = middle.map((m, c) => Math.round(m + share * (end[c] - m)));
      context.fillStyle = `rgb(${rgb.join(" ")})`;
      const x0 = frame.x(cells.x[0] + a * stepX), x1 = frame.x(cells.x[0] + (a + 1) * stepX);
      const y0 = frame.y(cells.y[0] + b * stepY), y1 = frame.y(cells.y[0] + (b + 1) * stepY);
      context.fillRect(Math.min(x0, x1) - 0.3, Math.min(y0, y1) - 0.3, Math.abs(x1 - x0) + 0.6, Math.abs(y1 - y0) + 0.6);
    }
  }
}
