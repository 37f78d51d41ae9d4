// The mean residual over two covariates.
import * as Plot from "@observablehq/plot";
import { useCallback, useMemo } from "preact/hooks";
import { Figure, type Frame } from "../../shared/figure";
import type { Box } from "../../shared/brush";
import { covariateUnit, leastShown, number, quantile, splitUnit, words } from "../../shared/format";
import { palette } from "../../shared/palette";
import { cellsOf } from "../bins";
import { paintCells } from "../paint";
import { choose } from "../selection";
import { shownOf, type View } from "./view";

const label = (name: string) => {
  const unit = covariateUnit(name);
  return unit ? `${words(splitUnit(name).name)} (${unit})` : words(name);
};

export function MapPlot({ view, residual, x, y, called = "map over two covariates" }: { view: View; residual: string; x: string;
  y: string; called?: string }) {
  const { rows, before } = view;
  const { name, unit } = splitUnit(residual);
  const few = rows.n < 1500;
  const cells = (of: typeof before) => cellsOf(rows, x, y, of.r.get(residual)!, few ? 16 : 28, few ? 12 : 20);
  const first = useMemo(() => cells(before), [rows, before, residual, x, y]);
  const now = shownOf(view);
  const shown = useMemo(() => (now === before ? first : cells(now)), [now, first]);
  const reach = useMemo(() => Math.max(leastShown(unit), 2 * (view.noise[residual] ?? 0) / 5,
    quantile([...first.mean].filter(Number.isFinite).map(Math.abs), 0.95)), [first]);
  const image = y === "row" || y === "v_px";
  const draw = useCallback((width: number): Plot.PlotOptions => ({
    height: Math.round(Math.min(300, Math.max(210, width * 0.52))), marginLeft: 52, marginBottom: 38, marginTop: 26,
    x: { domain: first.x, label: label(x), ticks: width < 420 ? 4 : 6, tickSize: 4 },
    y: { domain: image ? [first.y[1], first.y[0]] : first.y, label: label(y), ticks: 5, tickSize: 4 },
    marks: [Plot.frame({ stroke: palette.line })],
  }), [first, x, y]);
  const paint = useCallback((context: CanvasRenderingContext2D, frame: Frame) =>
    paintCells(context, frame, shown, reach, { low: palette.after, middle: palette.middle, high: palette.before }),
  [shown, reach]);
  const onBrush = useCallback((box: Box | null, add: boolean) => {
    if (!box) return;
    const a = rows.column(x)!, b = rows.column(y)!;
    choose(rows.n, (i) => a[i] >= box.x[0] && a[i] <= box.x[1] && b[i] >= box.y[0] && b[i] <= box.y[1],
      `${words(x)} ${number(box.x[0])} to ${number(box.x[1])}, ${words(y)} ${number(box.y[0])} to ${number(box.y[1])}`, add);
  }, [rows, x, y]);
  return (
    <Figure name={called} draw={draw} paint={paint} onBrush={onBrush}
      title={<>{words(name)} residual <span class="quiet">over</span> {words(x)} <span class="quiet">and</span> {words(y)}</>}
      sentence={`Mean in each cell: orange above, blue below zero, full colour from ${number(reach, 2)} ${unit}. ` +
        "A right model leaves speckle without shape."} />
  );
}
