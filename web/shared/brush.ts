// A rectangle drawn over a plot, and clicks on it, in the plot's own values. Fingers scroll the page instead.
import { brush, type D3BrushEvent } from "d3-brush";
import { select } from "d3-selection";
import type { Frame } from "./figure";

export interface Box {
  x: [number, number];
  y: [number, number];
}

/** The value at a place along an affine axis. */
function inverse(scale: (value: number) => number) {
  const at = scale(0), slope = scale(1) - at;
  return (place: number) => (place - at) / slope;
}

/** Two corners on the plot as values. */
export function valuesOf(frame: Frame, [[left, top], [right, bottom]]: [[number, number], [number, number]]): Box {
  const valueX = inverse(frame.x), valueY = inverse(frame.y);
  const rising = (a: number, b: number): [number, number] => (a < b ? [a, b] : [b, a]);
  return { x: rising(valueX(left), valueX(right)), y: rising(valueY(top), valueY(bottom)) };
}

export function attachBrush(plot: SVGSVGElement, frame: Frame, onBrush?: (box: Box | null, add: boolean) => void,
  onPick?: (x: number, y: number, add: boolean) => void): void {
  const valueX = inverse(frame.x), valueY = inverse(frame.y);
  const layer = select(plot).append("g").attr("class", onBrush ? "brush" : "pick");
  const pick = (event: MouseEvent) => {
    const box = plot.getBoundingClientRect();
    const scale = plot.viewBox.baseVal.width / box.width;
    onPick?.(valueX((event.clientX - box.left) * scale), valueY((event.clientY - box.top) * scale), event.shiftKey);
  };
  if (!onBrush) {
    layer.append("rect").attr("x", frame.left).attr("y", frame.top).attr("width", frame.right - frame.left)
      .attr("height", frame.bottom - frame.top).attr("fill", "transparent").on("click", pick);
    return;
  }
  const drawn = brush<unknown>().touchable(false).extent([[frame.left, frame.top], [frame.right, frame.bottom]]);
  drawn.on("end", (event: D3BrushEvent<unknown>) => {
    if (!event.sourceEvent) return;
    const area = event.selection as [[number, number], [number, number]] | null;
    const mouse = event.sourceEvent as MouseEvent;
    if (!area) {
      if (onPick) pick(mouse);
      else onBrush(null, mouse.shiftKey);
      return;
    }
    layer.call(drawn.move as never, null);
    onBrush(valuesOf(frame, area), mouse.shiftKey);
  });
  layer.call(drawn as never);
}
