// A plot by the keyboard: arrow keys move a rectangle over it, or step through its bars; Enter chooses.
import type { Box } from "./brush";
import { valuesOf } from "./brush";
import type { Frame } from "./figure";
import { number } from "./format";

/** What a click can choose, in the plot's values. */
export interface Item {
  x: number;
  y: number;
  label: string;
}

/** Where the keyboard is: a rectangle as shares of the frame, or an item's number. It outlives a plot that is drawn anew. */
export interface Cursor {
  left: number;
  top: number;
  width: number;
  height: number;
  item: number;
}

export const begin = (): Cursor => ({ left: 0.4, top: 0.3, width: 0.2, height: 0.4, item: 0 });

const step = 0.05;
const least = 0.02;

const arrows: Record<string, [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

/** Moves the cursor as the key says; false where the key is none of a plot. */
export function move(cursor: Cursor, event: KeyboardEvent, items?: Item[]): boolean {
  if (items) {
    const last = items.length - 1, [dx, dy] = arrows[event.key] ?? [0, 0];
    const to = event.key === "Home" ? 0 : event.key === "End" ? last : cursor.item + dx + dy;
    const moves = event.key in arrows || event.key === "Home" || event.key === "End";
    if (moves) cursor.item = Math.max(0, Math.min(last, to));
    return moves;
  }
  const by = arrows[event.key];
  if (!by) return false;
  const [dx, dy] = by.map((one) => one * step);
  const between = (value: number, from: number, to: number) => Math.max(from, Math.min(to, value));
  if (event.shiftKey) {
    cursor.width = between(cursor.width + dx, least, 1 - cursor.left);
    cursor.height = between(cursor.height + dy, least, 1 - cursor.top);
  } else {
    cursor.left = between(cursor.left + dx, 0, 1 - cursor.width);
    cursor.top = between(cursor.top + dy, 0, 1 - cursor.height);
  }
  return true;
}

const cornersOf = ({ left, top, width, height }: Cursor, frame: Frame): [[number, number], [number, number]] => {
  const [wide, high] = [frame.right - frame.left, frame.bottom - frame.top];
  return [[frame.left + left * wide, frame.top + top * high], [frame.left + (left + width) * wide, frame.top + (top + height) * high]];
};

export const boxOf = (cursor: Cursor, frame: Frame): Box => valuesOf(frame, cornersOf(cursor, frame));

/** What stands under the cursor, in words. */
export function says(cursor: Cursor, frame: Frame, items?: Item[]): string {
  if (items) return items[cursor.item]?.label ?? "";
  const { x, y } = boxOf(cursor, frame);
  return `${number(x[0])} to ${number(x[1])} across, ${number(y[0])} to ${number(y[1])} up`;
}

export function hide(plot: Element): void {
  plot.querySelector(".cursor")?.remove();
}

export function show(plot: Element, frame: Frame, cursor: Cursor, items?: Item[]): void {
  hide(plot);
  const item = items?.[cursor.item];
  const mark = document.createElementNS("http://www.w3.org/2000/svg", item ? "circle" : "rect");
  const [[left, top], [right, bottom]] = cornersOf(cursor, frame);
  const places = item ? { cx: frame.x(item.x), cy: Math.max(frame.top, Math.min(frame.bottom, frame.y(item.y))), r: 9 }
    : { x: left, y: top, width: right - left, height: bottom - top };
  Object.entries(places).forEach(([name, value]) => mark.setAttribute(name, String(value)));
  mark.setAttribute("class", "cursor");
  plot.append(mark);
}
