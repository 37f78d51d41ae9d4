// Residuals as arrows where the points were seen.
import * as Plot from "@observablehq/plot";
import { useCallback, useMemo } from "preact/hooks";
import { arrowScale } from "../../shared/arrows";
import { Figure, type Frame } from "../../shared/figure";
import type { Box } from "../../shared/brush";
import { number } from "../../shared/format";
import { palette } from "../../shared/palette";
import { paintArrows } from "../paint";
import { choose, rowsOf, selection } from "../selection";
import { everyFew, imageHeight, imageOf, shownOf, type View } from "./view";

const mostArrows = 1200;

export function ArrowPlot({ view }: { view: View }) {
  const { rows, before, image } = view;
  const [u, v] = [rows.column("u_px")!, rows.column("v_px")!];
  const drawn = useMemo(() => everyFew(rows, mostArrows), [rows]);
  const scale = useMemo(() => {
    const [du, dv] = [before.r.get("u_px")!, before.r.get("v_px")!];
    const items = [...drawn].filter((i) => Number.isFinite(du[i]))
      .map((i) => [u[i], v[i], du[i], dv[i]] as [number, number, number, number]);
    return items.length > 1 ? arrowScale([{ items }]) : 1;
  }, [rows, before]);
  const size = useMemo(() => imageOf(view)!, [rows, image]);
  const draw = useCallback((width: number): Plot.PlotOptions => ({
    height: imageHeight(width, size), marginLeft: 40, marginRight: 12, marginTop: 26, marginBottom: 36,
    x: { domain: [-0.5, size.width_px - 0.5], label: "u (px)", ticks: 6, tickSize: 4 },
    y: { domain: [size.height_px - 0.5, -0.5], label: "v (px)", ticks: 5, tickSize: 4 },
    marks: [Plot.frame({ stroke: palette.line })],
  }), [size.width_px, size.height_px]);
  const now = shownOf(view), chosen = selection.value;
  const paint = useCallback((context: CanvasRenderingContext2D, frame: Frame) => {
    const columns = (of: typeof now) => [u, v, of.r.get("u_px")!, of.r.get("v_px")!];
    if (now !== before) {
      context.globalAlpha = 0.25;
      paintArrows(context, frame, drawn, columns(before), scale, palette.before);
      context.globalAlpha = 1;
    }
    paintArrows(context, frame, drawn, columns(now), scale, now === before ? palette.before : palette.after);
    paintArrows(context, frame, rowsOf(chosen, mostArrows), columns(now), scale, palette.pink, 1.8);
  }, [now, before, chosen, scale, drawn]);
  const onBrush = useCallback((box: Box | null, add: boolean) => {
    if (!box) return;
    choose(rows.n, (i) => u[i] >= box.x[0] && u[i] <= box.x[1] && v[i] >= box.y[0] && v[i] <= box.y[1],
      `u ${number(box.x[0])} to ${number(box.x[1])} px, v ${number(box.y[0])} to ${number(box.y[1])} px`, add);
  }, [rows]);
  return (
    <Figure name="arrows in the image" draw={draw} paint={paint} onBrush={onBrush}
      title={<>where the residuals lie <span class="quiet">arrows {number(scale, 2)} times as long</span></>}
      sentence={`Each arrow starts where a point was seen and shows observed minus predicted.${drawn.length < rows.n
        ? ` ${drawn.length} of ${rows.n} points are drawn.` : ""} Arrows without a common direction are noise.`} />
  );
}
