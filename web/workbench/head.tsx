// The head of the page of work: the sentence that matters, the error, and how it fell over the versions.
import * as Plot from "@observablehq/plot";
import { useEffect, useMemo, useRef } from "preact/hooks";
import { nameMarks } from "../shared/figure";
import { number, splitUnit, words } from "../shared/format";
import { isDark, palette } from "../shared/palette";
import { ParameterList } from "../shared/parts";
import { Rich } from "../shared/rich";
import { DataTable } from "../shared/table";
import { rms } from "./bins";
import type { Version } from "./model";
import { shownOf } from "./plots/view";
import { goTo, preview, screen, session, version, view } from "./store";

const tones: Record<string, string> = { adequate: "good", missing_effect: "bad", unexplained_structure: "open" };

/** Without a verdict of the search: what the comparison says. */
const toneOf = (now: Version) => (now.structure === null ? "open" : now.structure.length > 0 ? "bad"
  : (now.error ?? 1) > 1.15 ? "open" : "good");

/** What the headline asks of a person. */
function meaning(now: Version): string {
  if (/noise of unknown cause/.test(now.headline)) {
    return "These rows scatter more than their stated noise. The effect states larger errors; what causes them it does not say: look at the plots.";
  }
  if (now.verdict === "unexplained_structure") return "The plots show what is left. A formula can describe it.";
  if (now.verdict === "missing_effect") return "Point at a candidate to see what it explains, then add it.";
  if (now.structure?.length === 0 && now.error !== null && now.error <= 1.15) return "The model explains these measurements to their noise.";
  return "";
}

/** What was added without a gain: a formula, or an effect that a person chose against the list. */
function inVain(now: Version): string {
  const before = session.value?.versions.find((one) => one.id === now.parent);
  const added = Object.keys(now.effects).filter((name) => before && !(name in before.effects));
  if (!before || added.length === 0 || before.error === null || now.error === null || before.leftOut !== now.leftOut) return "";
  if (now.error < before.error || now.error <= 1) return "";
  return `${added.join(", ")} ${added.length === 1 ? "does" : "do"} not help: the error was ${number(before.error, 4)} without. Undo takes it back.`;
}

export function Head() {
  const now = version.value;
  const shown = preview.value;
  if (!now) return null;
  const doubts = session.value?.set?.doubts.length ?? 0;
  return (
    <section class={`head ${tones[now.verdict ?? ""] ?? toneOf(now)}`} aria-label="What matters">
      <div class="says">
        <p class="headline">{now.headline || (now.trouble ? "The model could not be compared with the measurements."
          : "Comparing the model with the measurements …")}</p>
        {inVain(now) && <p class="doubt">{inVain(now)}</p>}
        {meaning(now) && <p class="quiet means">{meaning(now)}</p>}
        {now.trouble && <p class="trouble" role="alert">{now.trouble}</p>}
        {now.doubts.map((doubt, i) => <p key={i} class="doubt">{doubt.trim()}</p>)}
        <p class="quiet small">
          {session.value?.set?.title} · version {now.id}
          {now.leftOut > 0 && ` · ${now.leftOut} rows left out`}
          {doubts > 0 && <> · <button type="button" class="link" onClick={() => (screen.value = "data")}>
            {doubts} {doubts === 1 ? "doubt" : "doubts"} about the data</button></>}
        </p>
        <Values effects={now.effects} />
      </div>
      <div class="figure-of-merit num" aria-live="polite">
        <b>{number(now.error, 4)}</b>
        {shown?.error != null && <b class="ghost">→ {number(shown.error, 4)}</b>}
        <span class="quiet small">error; 1 is the noise</span>
        <Sizes />
      </div>
      <ErrorLine />
    </section>
  );
}

/** What the model has, with the values that were fitted. */
function Values({ effects }: { effects: Version["effects"] }) {
  const names = Object.keys(effects);
  if (names.length === 0) return null;
  return (
    <details class="model small">
      <summary>The model: {names.join(", ")}</summary>
      <DataTable columns={[{ label: "Effect" }, { label: "Values" }]} rows={names.map((name) => ({ cells: [
        <code class="effect">{name}</code>, <ParameterList parameters={effects[name]} />] }))} />
    </details>
  );
}

const mostSizes = 3;

/** Root mean square of the residuals in their own units. */
function Sizes() {
  const shown = view.value;
  // Of whole images no row has a residual.
  const text = useMemo(() => shown && shown.before.channels.filter((name) => splitUnit(name).unit).slice(0, mostSizes)
    .map((name) => ({ ...splitUnit(name), size: rms(shownOf(shown).r.get(name)!) })).filter(({ size }) => size !== null)
    .map(({ name, unit, size }) => `${words(name)} ${number(size)} ${unit}`).join(", "), [shown]);
  return text ? <span class="quiet small">residuals (rms): <Rich text={text} /></span> : null;
}

/** From the first version to the one shown, and whatever was made from it. */
export function line(versions: Version[], current: string): Version[] {
  const byId = new Map(versions.map((one) => [one.id, one]));
  const back: Version[] = [];
  for (let at = byId.get(current); at; at = at.parent === null ? undefined : byId.get(at.parent)) back.unshift(at);
  for (let at = versions.filter((one) => one.parent === current).pop(); at;) {
    back.push(at);
    const id = at.id;
    at = versions.filter((one) => one.parent === id).pop();
  }
  return back;
}

interface Point {
  i: number;
  error: number;
  id: string;
  kind: "first" | "past" | "now" | "later" | "ghost";
}

function pointsOf(all: Version[], current: string, ghost: number | null | undefined): Point[] {
  const at = all.findIndex((one) => one.id === current);
  const points = all.map((one, i): Point => ({ i, error: one.error ?? NaN, id: one.id,
    kind: i === at ? "now" : i > at ? "later" : i === 0 ? "first" : "past" })).filter((p) => Number.isFinite(p.error));
  if (ghost != null) points.push({ i: at + 1, error: ghost, id: "", kind: "ghost" });
  return points;
}

function options(points: Point[], current: string): Plot.PlotOptions {
  const errors = [...points.map((p) => p.error), 1];
  const low = Math.min(...errors), high = Math.max(...errors, 1.2);
  const spans = high / low > 8;
  const made = points.filter((p) => p.kind !== "ghost");
  const now = points.find((p) => p.id === current), ghost = points.find((p) => p.kind === "ghost");
  const last = Math.max(...points.map((p) => p.i), 3);
  return {
    height: 84, marginLeft: 34, marginRight: 12, marginTop: 10, marginBottom: 8,
    x: { domain: [0, last], axis: null },
    y: { type: spans ? "log" : "linear", domain: spans ? [0.7 * low, 1.5 * high] : [0, 1.15 * high], label: null, ticks: 3,
      tickSize: 0, tickFormat: "~g" },
    marks: [
      Plot.ruleY([1], { stroke: palette.formal, strokeDasharray: "4 3" }),
      Plot.line(made, { x: "i", y: "error", stroke: palette.after, strokeWidth: 2 }),
      ...(ghost && now ? [Plot.line([now, ghost], { x: "i", y: "error", stroke: palette.after, strokeDasharray: "3 3" }),
        Plot.dot([ghost], { x: "i", y: "error", r: 5, stroke: palette.after, fill: palette.card, strokeDasharray: "2 2" })] : []),
      Plot.dot(made, { x: "i", y: "error", r: (p: Point) => (p.kind === "now" ? 5.5 : 4), stroke: palette.card, strokeWidth: 1.5,
        fill: (p: Point) => (p.kind === "later" ? palette.dot : p.i === 0 ? palette.before : palette.after) }),
    ],
  };
}

export function ErrorLine() {
  const holder = useRef<HTMLDivElement>(null);
  const now = version.value, shown = preview.value, dark = isDark.value;
  const all = line(session.value?.versions ?? [], now?.id ?? "");
  const points = now ? pointsOf(all, now.id, shown?.error) : [];
  const key = points.map((p) => `${p.id} ${p.error} ${p.kind}`).join();
  useEffect(() => {
    const element = holder.current!;
    if (!now || points.length === 0) return element.replaceChildren();
    const plot = Plot.plot({ width: Math.max(160, element.clientWidth), ...options(points, now.id),
      style: { fontFamily: "var(--sans)", fontSize: "11px", color: palette.ink2, background: "none", overflow: "visible" } });
    nameMarks(plot, `error over the versions: ${all.map((one) => number(one.error, 3)).join(", ")}`);
    [...plot.querySelectorAll('[data-mark="dot"]')].at(-1)!.querySelectorAll("circle").forEach((dot, i) => {
      const { id } = points.filter((p) => p.kind !== "ghost")[i];
      dot.addEventListener("click", () => void goTo(id));
      dot.classList.add("clickable");
    });
    element.replaceChildren(plot);
  }, [key, dark]);
  return <div class="error-line" ref={holder} data-ghost={shown?.error ?? ""} data-points={points.length} />;
}
