// Residuals as arrows: the scale that several sets share, and the room that they need.
import * as Plot from "@observablehq/plot";
import { leastShown, quantile, roundScale } from "./format";
import { palette } from "./palette";
import type { Arrows } from "./types";

export const inImage = (set: Arrows) => (set.plane ?? "image_px") === "image_px";
/** The length of an arrow's shift. */
export const length = ([, , du, dv]: number[]) => Math.hypot(du, dv);

/** One scale for all sets, so that lengths can be compared: the long arrows of the worst are
 * a fourteenth of the picture. Rounded to 1, 2 or 5 times a power of ten. */
export function arrowScale(sets: Arrows[]): number {
  let scale = Infinity;
  for (const set of sets) {
    const longest = Math.max(quantile(set.items.map(length), 0.95), leastShown(unitOf(set)));
    scale = Math.min(scale, extent(set) / 14 / longest);
  }
  return Number.isFinite(scale) ? Math.max(1, roundScale(scale)) : 1;
}

export const unitOf = (set: Arrows) => set.unit ?? (inImage(set) ? "px" : "m");

function extent(set: Arrows): number {
  const u = set.items.map((item) => item[0]);
  return Math.max(...u) - Math.min(...u) || 1;
}

/** Of the arrows with their tips, and of the places from which things were seen. */
export function bounds(set: Arrows, scale: number): number[] {
  const places = [...set.items, ...set.items.map(([x, y, dx, dy]) => [x + scale * dx, y + scale * dy]), ...(set.robot ?? [])];
  const xs = places.map((item) => item[0]);
  const ys = places.map((item) => item[1]);
  const pad = 0.06 * Math.max(Math.max(...xs) - Math.min(...xs), Math.max(...ys) - Math.min(...ys), 0.1);
  return [Math.min(...xs) - pad, Math.max(...xs) + pad, Math.min(...ys) - pad, Math.max(...ys) + pad];
}

/** Landmarks with their names. */
export const placeMarks = (places: NonNullable<Arrows["places"]>): Plot.Markish[] => [
  Plot.dot(places, { x: "x", y: "y", r: 4, fill: palette.card, stroke: palette.ink, strokeWidth: 1.4 }),
  Plot.text(places, { x: "x", y: "y", text: "name", dx: 8, dy: -8, textAnchor: "start", fill: palette.ink }),
];
