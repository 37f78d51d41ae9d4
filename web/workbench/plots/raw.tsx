// The measurements as they are: where points lie in the image, else a column over time.
import * as Plot from "@observablehq/plot";
import { signal } from "@preact/signals";
import { useCallback } from "preact/hooks";
import { Figure, type Frame } from "../../shared/figure";
import { covariateUnit, splitUnit, words } from "../../shared/format";
import { palette } from "../../shared/palette";
import { paintChosen, paintDots } from "../paint";
import { selection } from "../selection";
import { imageHeight, type View } from "./view";

const shown = signal("");
const ids = ["line", "group", "held_out", "outlier", "left_out"];

const axis = (name: string) => {
  const { name: short, unit } = splitUnit(name);
  return unit || covariateUnit(name) ? `${words(short)} (${unit || covariateUnit(name)})` : words(short);
};

export function RawPlot({ view }: { view: View }) {
  const { rows, image } = view;
  const names = rows.names.filter((name) => !ids.includes(name) && !name.includes("*") && !name.startsWith("sign("));
  const inImage = rows.has("u_px") && rows.has("v_px");
  const first = rows.has("time") ? "time" : "group";
  const y = names.includes(shown.value) ? shown.value : names.find((name) => name !== first) ?? names[0];
  return (
    <div class="figures">
      {inImage && <Dots view={view} x="u_px" y="v_px" image={image} title="where points were seen"
        sentence="A lens is constrained only where points were seen: the corners matter most." />}
      <Dots view={view} x={first} y={y} title={<>
        <select class="inline" aria-label="Column" value={y} onChange={(e) => (shown.value = e.currentTarget.value)}>
          {names.map((name) => <option key={name} value={name}>{words(name)}</option>)}
        </select> <span class="quiet">over</span> {words(first)}</>}
        sentence="Gaps, jumps and values on end that stay equal are faults of a recording more often than of a model." />
    </div>
  );
}

function Dots({ view: { rows }, x, y, image, title, sentence }: { view: View; x: string; y: string; image?: View["image"];
  title: preact.ComponentChildren; sentence: string }) {
  const [xs, ys] = [rows.column(x)!, rows.column(y)!];
  const span = (name: string): [number, number] => {
    const order = rows.order(name), values = rows.column(name)!;
    const [low, high] = order.length > 0 ? [values[order[0]], values[order[order.length - 1]]] : [0, 1];
    const pad = 0.04 * (high - low || 1);
    return [low - pad, high + pad];
  };
  const draw = useCallback((width: number): Plot.PlotOptions => ({
    height: image ? imageHeight(width, image) : 240,
    marginLeft: 46, marginRight: 12, marginTop: 26, marginBottom: 36,
    x: { label: axis(x), ticks: width < 420 ? 4 : 6, tickSize: 4, domain: image ? [-0.5, image.width_px - 0.5] : span(x) },
    y: { label: axis(y), ticks: 5, tickSize: 4, grid: !image, domain: image ? [image.height_px - 0.5, -0.5] : span(y) },
    marks: [Plot.frame({ stroke: palette.line })],
  }), [rows, x, y, image]);
  const chosen = selection.value;
  const paint = useCallback((context: CanvasRenderingContext2D, frame: Frame) => {
    paintDots(context, frame, xs, ys, palette.after);
    paintChosen(context, frame, xs, ys, chosen.mask, palette.pink);
  }, [xs, ys, chosen]);
  return <Figure name={`raw ${y} over ${x}`} draw={draw} paint={paint} title={title} sentence={sentence} />;
}
