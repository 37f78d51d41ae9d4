// A plot with its title and the sentence that says what it means. Plots are SVG, drawn at the
// width that is there, and again when that changes.
import * as Plot from "@observablehq/plot";
import type { ComponentChildren } from "preact";
import { useEffect, useRef } from "preact/hooks";
import { isDark, palette } from "../shared/palette";
import { Rich } from "../shared/rich";
import { savePlot } from "./save";

export interface FigureProps {
  name: string;
  title?: ComponentChildren;
  sentence: string;
  /** Draws the plot for a width in CSS pixels. */
  draw: (width: number) => Plot.PlotOptions;
  wide?: boolean;
}

const style = () => ({
  fontFamily: "var(--sans)",
  fontSize: "12px",
  color: palette.ink2,
  background: "none",
  overflow: "visible",
});

export function Figure({ name, title, sentence, draw, wide }: FigureProps) {
  const holder = useRef<HTMLDivElement>(null);
  const dark = isDark.value;
  useEffect(() => {
    const element = holder.current!;
    let drawnWidth = 0;
    const redraw = () => {
      const width = Math.floor(element.clientWidth);
      if (width < 40 || Math.abs(width - drawnWidth) < 2) return;
      drawnWidth = width;
      const options = draw(width);
      const plot = Plot.plot({ width, ...options, style: style() });
      plot.setAttribute("role", "img");
      plot.setAttribute("aria-label", name);
      element.replaceChildren(plot);
      element.dataset.drawn = "true";
    };
    redraw();
    const observer = new ResizeObserver(redraw);
    observer.observe(element);
    return () => observer.disconnect();
  }, [draw, name, dark]);
  return (
    <figure class={wide ? "figure wide" : "figure"} data-plot={name}>
      <button type="button" class="save" title="Save this plot as SVG"
        onClick={() => savePlot(holder.current!, name)}>SVG</button>
      {title && <h3>{title}</h3>}
      <div class="plot" ref={holder} />
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
