// A plot as a file of its own: the drawing with the few styles it takes from the page.

import { palette } from "./palette";

/** The plot in `holder` as a whole SVG document; it stands alone in any viewer. */
export function standalone(holder: HTMLElement): string {
  const drawings = [...holder.querySelectorAll("svg")];
  const drawing = drawings[drawings.length - 1].cloneNode(true) as SVGSVGElement;
  drawing.setAttribute("xmlns", "http://www.w3.org/2000/svg");
  drawing.setAttribute("style",
    `background: ${palette.card}; font-family: Inter, 'DejaVu Sans', sans-serif; font-size: 12px; ` +
    `color: ${palette.ink2}`);
  const { width, height } = drawing.viewBox.baseVal;
  const painted = holder.querySelector("canvas");
  if (painted) {
    const image = document.createElementNS("http://www.w3.org/2000/svg", "image");
    image.setAttribute("href", painted.toDataURL());
    image.setAttribute("width", String(width));
    image.setAttribute("height", String(height));
    drawing.prepend(image);
  }
  const padding = 14;
  drawing.setAttribute("viewBox",
    `${-padding} ${-padding} ${width + 2 * padding} ${height + 2 * padding}`);
  drawing.setAttribute("width", String(width + 2 * padding));
  drawing.setAttribute("height", String(height + 2 * padding));
  return new XMLSerializer().serializeToString(drawing);
}

export function save(text: string, type: string, name: string): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type }));
  link.download = name;
  link.click();
  URL.revokeObjectURL(link.href);
}

export function fileName(name: string): string {
  return name.toLowerCase().replace(/[^a-z0-9]+/g, "_").replace(/^_|_$/g, "");
}

export function savePlot(holder: HTMLElement, name: string): void {
  save(standalone(holder), "image/svg+xml", `${fileName(name)}.svg`);
}
