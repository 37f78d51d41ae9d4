// The error of each group; held-out groups are hatched. A click chooses a group's rows.
import * as Plot from "@observablehq/plot";
import { useCallback, useMemo } from "preact/hooks";
import { Figure, type Frame } from "../../shared/figure";
import { number, quantile } from "../../shared/format";
import { palette } from "../../shared/palette";
import { groupsOf, type Group } from "../bins";
import type { Numbers, Residuals } from "../rows";
import { choose, selection } from "../selection";
import { shownOf, type View } from "./view";

function hatch(context: CanvasRenderingContext2D, colour: string): CanvasPattern {
  const tile = document.createElement("canvas");
  [tile.width, tile.height] = [5, 5];
  const drawing = tile.getContext("2d")!;
  drawing.strokeStyle = colour;
  drawing.lineWidth = 1.5;
  for (const shift of [-5, 0, 5]) {
    drawing.moveTo(shift, 5);
    drawing.lineTo(shift + 5, 0);
  }
  drawing.stroke();
  return context.createPattern(tile, "repeat")!;
}

function paintGroups(context: CanvasRenderingContext2D, frame: Frame, groups: Group[], colour: string, chosen: Set<number>,
  strength = 1) {
  const pattern = hatch(context, colour);
  groups.forEach((group, k) => {
    const left = frame.x(k - 0.42), width = Math.max(1, frame.x(k + 0.42) - left);
    const top = Math.max(frame.top, frame.y(group.error)), height = frame.bottom - top;
    context.fillStyle = chosen.has(group.id) ? palette.pink : group.heldOut ? pattern : colour;
    context.globalAlpha = strength * (group.heldOut ? 1 : 0.75);
    context.fillRect(left, top, width, height);
    if (!group.heldOut || width < 3) return;
    context.strokeStyle = colour;
    context.lineWidth = 1;
    context.strokeRect(left + 0.5, top + 0.5, width - 1, height);
  });
  context.globalAlpha = 1;
}

interface GroupProps {
  view: View;
  name?: string;
  /** Of each row; without them the set's groups. */
  ids?: Numbers;
  /** Of the numbers in `ids`. */
  labels?: string[];
}

export function GroupPlot({ view, name = "group", ids: given, labels }: GroupProps) {
  const { rows, before } = view;
  const now = shownOf(view), ids = given ?? rows.column("group");
  const sums = (of: Residuals) => {
    const groups = groupsOf(rows, of, ids, given ? undefined : rows.column("held_out"));
    // With few groups each is judged by a fit to the others: no one is never fitted.
    return groups.every((group) => group.heldOut) ? groups.map((group) => ({ ...group, heldOut: false })) : groups;
  };
  const label = (id: number) => labels?.[id] ?? String(id);
  const first = useMemo(() => sums(before), [rows, before]);
  const shown = useMemo(() => (now === before ? first : sums(now)), [now, first]);
  const top = Math.max(1.6, 1.1 * quantile(first.map((group) => group.error), 0.97));
  /** As many names as have room side by side. */
  const ticksOf = (width: number) => {
    const longest = Math.max(...first.map((group) => label(group.id).length));
    return Math.max(1, Math.min(first.length, width < 420 ? 5 : 8, Math.floor((width - 60) / (7 * longest + 14))));
  };
  const draw = useCallback((width: number): Plot.PlotOptions => ({
    height: 220, marginLeft: 46, marginBottom: 38, marginTop: 26,
    x: { domain: [-0.7, first.length - 0.3], label: name, tickSize: 4, ticks: ticksOf(width),
      tickFormat: (k: number) => (Number.isInteger(k) && first[k] ? label(first[k].id) : "") },
    y: { domain: [0, top], label: "error (1 = the noise)", ticks: 4, tickSize: 4, grid: true },
    marks: [Plot.ruleY([1], { stroke: palette.formal, strokeDasharray: "4 3", strokeWidth: 1.4 })],
  }), [first, top, name]);
  const chosen = selection.value;
  const paint = useCallback((context: CanvasRenderingContext2D, frame: Frame) => {
    const marked = new Set<number>();
    if (ids && chosen.count > 0) for (let i = 0; i < rows.n; ++i) if (chosen.mask[i]) marked.add(ids[i]);
    if (now !== before) paintGroups(context, frame, first, palette.before, new Set(), 0.2);
    paintGroups(context, frame, shown, now === before ? palette.before : palette.after, marked);
  }, [shown, now, chosen]);
  const onPick = useCallback((x: number, _y: number, add: boolean) => {
    const group = first[Math.round(x)];
    if (group && ids) choose(rows.n, (i) => ids[i] === group.id, `${name} ${label(group.id)}`, add);
  }, [first, rows]);
  const items = useMemo(() => shown.map((group, k) => ({ x: k, y: group.error, label: `${name} ${label(group.id)}: error ${number(group.error)}` })),
    [shown, name]);
  const worst = [...shown].sort((a, b) => b.error - a.error)[0];
  const held = shown.filter((group) => group.heldOut).length;
  if (first.length === 0) return null; // Rows of single pixels have none.
  return (
    <Figure name={`error by ${given ? name : "group"}`} draw={draw} paint={paint} onPick={onPick} items={items}
      title={<>error by {name} <span class="quiet">{held > 0 && "hatched: held out, never fitted"}</span></>}
      sentence={`The largest is ${number(worst?.error)}, of ${name} ${label(worst?.id)}.${given ? "" : held === 0
        ? " With so few groups each is judged by a fit to the others." : ` Fits use ${shown.length - held} groups; the other ${held} judge.`}`} />
  );
}
