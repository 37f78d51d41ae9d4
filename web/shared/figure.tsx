// A plot with its title and the sentence that says what it means. Plots are SVG, drawn at the width that is there, and
// again when that changes; what has thousands of marks is painted on a canvas beneath the axes.
import * as Plot from "@observablehq/plot";
import type { ComponentChildren } from "preact";
import { useLayoutEffect, useRef, useState } from "preact/hooks";
import { attachBrush, type Box } from "./brush";
import * as keys from "./keys";
import { isDark, palette } from "./palette";
import { Rich } from "./rich";
import { savePlot } from "./save";
import { forget, inTurn } from "./turns";

/** Where a plot's values lie on its canvas, in CSS pixels; both scales are linear. */
export interface Frame {
  x: (value: number) => number;
  y: (value: number) => number;
  left: number;
  right: number;
  top: number;
  bottom: number;
}

export interface FigureProps {
  name: string;
  title?: ComponentChildren;
  sentence: string;
  /** Draws the plot for a width in CSS pixels. */
  draw: (width: number) => Plot.PlotOptions;
  /** Paints beneath the axes, on a canvas of the plot's size. */
  paint?: (context: CanvasRenderingContext2D, frame: Frame) => void;
  /** Takes the rectangle that a person drew, in the plot's values; null for a click. */
  onBrush?: (box: Box | null, add: boolean) => void;
  /** Takes a click, in the plot's values. */
  onPick?: (x: number, y: number, add: boolean) => void;
  /** What clicks can choose, for the keyboard. */
  items?: keys.Item[];
  wide?: boolean;
  /** Buttons beside the title. */
  tools?: ComponentChildren;
}

const style = () => ({
  fontFamily: "var(--sans)",
  fontSize: "12px",
  color: palette.ink2,
  background: "none",
  overflow: "visible",
});

type Drawn = (SVGSVGElement | HTMLElement) & { scale: (name: string) => Plot.Scale | undefined };

/** An affine map of a linear scale: faster for many points than the scale itself. */
function affine(scale: Plot.Scale) {
  const [from, to] = scale.domain as number[];
  const at = scale.apply(from), slope = (scale.apply(to) - at) / (to - from || 1);
  return (value: number) => at + slope * (value - from);
}

function frameOf(plot: Drawn): Frame | null {
  const x = plot.scale("x"), y = plot.scale("y");
  if (!x?.domain || !y?.domain || !x.range || !y.range) return null;
  const [left, right] = (x.range as number[]), [bottom, top] = (y.range as number[]);
  return { x: affine(x), y: affine(y), left: Math.min(left, right), right: Math.max(left, right),
    top: Math.min(top, bottom), bottom: Math.max(top, bottom) };
}

function paintUnder(holder: HTMLElement, frame: Frame, size: [number, number], paint: NonNullable<FigureProps["paint"]>) {
  let canvas = holder.querySelector("canvas");
  if (!canvas) {
    canvas = document.createElement("canvas");
    canvas.setAttribute("aria-hidden", "true");
    holder.prepend(canvas);
  }
  const ratio = Math.min(2, devicePixelRatio || 1);
  canvas.width = Math.round(size[0] * ratio);
  canvas.height = Math.round(size[1] * ratio);
  canvas.style.width = `${size[0]}px`;
  canvas.style.height = `${size[1]}px`;
  const context = canvas.getContext("2d")!;
  context.scale(ratio, ratio);
  context.beginPath();
  context.rect(frame.left, frame.top, frame.right - frame.left, frame.bottom - frame.top);
  context.clip();
  paint(context, frame);
}

interface Shown {
  frame: Frame | null;
  size: [number, number];
}

/** The plot as a whole is a picture with a name; its groups of marks have none for those who listen. */
export function nameMarks(plot: Element, name: string): void {
  plot.querySelectorAll("[aria-label]").forEach((mark) => {
    mark.setAttribute("data-mark", mark.getAttribute("aria-label")!);
    mark.removeAttribute("aria-label");
  });
  plot.setAttribute("role", "img");
  plot.setAttribute("aria-label", name);
}

function drawInto(element: HTMLElement, width: number, props: FigureProps): Shown {
  const plot = Plot.plot({ width, ...props.draw(width), style: style() }) as Drawn;
  nameMarks(plot, props.name);
  const frame = frameOf(plot);
  const box = plot instanceof SVGSVGElement ? plot.viewBox.baseVal : { width, height: 0 };
  if (frame && plot instanceof SVGSVGElement && (props.onBrush || props.onPick)) {
    attachBrush(plot, frame, props.onBrush, props.onPick);
  }
  element.replaceChildren(plot);
  element.dataset.drawn = "true";
  return { frame, size: [box.width, box.height] };
}

const keysText = (items?: keys.Item[]) => `${items ? "Arrow keys go from one to the next" : "Arrow keys move the rectangle, with Shift they change its size"
}; Enter chooses, Shift Enter adds, Delete leaves out what is chosen.`;

/** What a plot's holder needs, so that the keyboard can choose in it, and what it says of that. */
function useKeys({ name, onBrush, onPick, items }: FigureProps, drawn: { current: Shown | null }, holder: { current: HTMLElement | null }) {
  const cursor = useRef(keys.begin());
  const [says, say] = useState("");
  const can = Boolean(onBrush || (onPick && items?.length));
  const over = onBrush ? undefined : items;
  const show = () => {
    const frame = drawn.current?.frame, plot = holder.current?.querySelector("svg");
    if (!can || !frame || !plot || !holder.current!.matches(":focus-visible")) return;
    keys.show(plot, frame, cursor.current, over);
    say(keys.says(cursor.current, frame, over));
  };
  const onKeyDown = (event: KeyboardEvent) => {
    const frame = drawn.current?.frame;
    if (!frame || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key === "Enter") {
      const item = over?.[cursor.current.item];
      if (item) onPick!(item.x, item.y, event.shiftKey);
      else onBrush?.(keys.boxOf(cursor.current, frame), event.shiftKey);
    } else if (!keys.move(cursor.current, event, over)) {
      return;
    }
    event.preventDefault();
    show();
  };
  const hide = () => {
    if (holder.current) keys.hide(holder.current);
    say("");
  };
  const props = can ? { tabIndex: 0, role: "group" as const, "aria-label": `${name}: choose rows by the keyboard`, onKeyDown, onFocus: show, onBlur: hide } : {};
  const hint = says && <p class="keys" role="status"><b>{says}</b> {keysText(over)}</p>;
  return { props, hint, show };
}

export function Figure(props: FigureProps) {
  const { name, title, sentence, draw, paint, onBrush, onPick, wide, tools } = props;
  const holder = useRef<HTMLDivElement>(null);
  const drawn = useRef<Shown | null>(null);
  /** The width that is there, once it is known: asking for it would lay out the page anew for each plot. */
  const width_px = useRef<number | null>(null);
  const keyboard = useKeys(props, drawn, holder);
  const showKeys = useRef(keyboard.show);
  showKeys.current = keyboard.show;
  const dark = isDark.value;
  const painting = useRef(paint);
  painting.current = paint;
  const repaint = () => {
    const now = drawn.current;
    if (now?.frame && painting.current) paintUnder(holder.current!, now.frame, now.size, painting.current);
  };
  useLayoutEffect(() => {
    const element = holder.current!;
    let drawnWidth = 0;
    const redraw = () => {
      const width = Math.floor(width_px.current ?? element.clientWidth);
      if (width < 40 || Math.abs(width - drawnWidth) < 2) return;
      drawnWidth = width;
      drawn.current = drawInto(element, width, { name, title, sentence, draw, onBrush, onPick });
      repaint();
      showKeys.current();
    };
    inTurn(drawn, redraw);
    const observer = new ResizeObserver(([{ contentRect }]) => {
      width_px.current = contentRect.width;
      if (Math.abs(contentRect.width - drawnWidth) >= 2) inTurn(drawn, redraw);
    });
    observer.observe(element);
    return () => {
      observer.disconnect();
      forget(drawn);
    };
  }, [draw, name, dark, onBrush, onPick]);
  useLayoutEffect(() => {
    if (!drawn.current) return undefined; // The first drawing paints.
    inTurn(painting, repaint);
    return () => forget(painting);
  }, [paint]);
  return (
    <figure class={wide ? "figure wide" : "figure"} data-plot={name}>
      <button type="button" class="save" title="Save this plot as SVG" aria-label={`SVG of ${name}`}
        onClick={() => savePlot(holder.current!, name)}>SVG</button>
      {title && <h3>{title}</h3>}
      {tools}
      <div class="plot" ref={holder} {...keyboard.props} />
      {keyboard.hint}
      <figcaption><Rich text={sentence} /></figcaption>
    </figure>
  );
}

export interface KeyItem {
  label: string;
  colour: string;
  shape: "dot" | "line" | "dash" | "band" | "bar";
}

/** What the colours and marks of the plots below mean. */
export function Key({ items }: { items: KeyItem[] }) {
  return (
    <ul class="key" aria-label="Key">
      {items.map((item) => (
        <li key={item.label}>
          <svg width="26" height="12" aria-hidden="true">
            {item.shape === "dot" && <circle cx="13" cy="6" r="4" fill={item.colour} />}
            {item.shape === "line" && (
              <line x1="1" x2="25" y1="6" y2="6" stroke={item.colour} stroke-width="2.2" />
            )}
            {item.shape === "dash" && (
              <line x1="1" x2="25" y1="6" y2="6" stroke={item.colour} stroke-width="1.6"
                stroke-dasharray="4 3" />
            )}
            {item.shape === "band" && (
              <rect x="1" y="1" width="24" height="10" fill={item.colour} fill-opacity="0.22" />
            )}
            {item.shape === "bar" && (
              <path d="M13 1V11M9 1H17M9 11H17" stroke={item.colour} stroke-width="1.6" fill="none" />
            )}
          </svg>
          {item.label}
        </li>
      ))}
    </ul>
  );
}
