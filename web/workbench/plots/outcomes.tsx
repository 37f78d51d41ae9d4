// Whole runs: each number as it was measured beside the model's, and how the runs of the model are spread.
import * as Plot from "@observablehq/plot";
import { signal } from "@preact/signals";
import { useCallback, useEffect, useMemo } from "preact/hooks";
import { Figure } from "../../shared/figure";
import { number, splitUnit, words } from "../../shared/format";
import { inkName, palette } from "../../shared/palette";
import * as api from "../api";
import type { Residuals, Rows } from "../rows";
import { choose, selection } from "../selection";
import { preview, version } from "../store";
import type { View } from "./view";

/** A number of whole runs. */
interface Outcome {
  row: number;
  scenario: string;
  value: string;
  statistic: string;
  measured: number;
  sigma: number;
  predicted: number;
  /** From the measured, in units of both errors. */
  off: number;
}

function outcomesOf(rows: Rows, of: Residuals): Outcome[] {
  const text = (name: string, row: number) => rows.words.names?.[name]?.[rows.data(name)![row]] ?? "";
  return Array.from({ length: rows.n }, (_, row) => {
    const channel = of.channels.find((name) => Number.isFinite(of.r.get(name)![row]));
    const residual = channel ? of.r.get(channel)![row] : NaN;
    return { row, scenario: text("scenario", row), value: text("value", row), statistic: text("statistic", row),
      measured: rows.data("measured")![row], sigma: rows.data("sigma")![row], predicted: rows.data("measured")![row] - residual,
      off: channel ? residual / of.s.get(channel)![row] : NaN };
  });
}

const chosenValue = signal(""), chosenScenario = signal("");

const worst = (all: Outcome[]) => all.reduce((most, one) => (Math.abs(one.off) > Math.abs(most.off) || !Number.isFinite(most.off) ? one : most));

const axis = (value: string) => {
  const { name, unit } = splitUnit(value);
  return unit ? `${words(name)} (${unit})` : words(name);
};

export function OutcomePlots({ view }: { view: View }) {
  const { rows, before, after } = view;
  const first = useMemo(() => outcomesOf(rows, before), [rows, before]);
  const second = useMemo(() => after && outcomesOf(rows, after), [rows, after]);
  const values = [...new Set(first.map((one) => one.value))];
  const value = values.includes(chosenValue.value) ? chosenValue.value : worst(first).value;
  const scenarios = [...new Set(first.filter((one) => one.value === value).map((one) => one.scenario))];
  const scenario = scenarios.includes(chosenScenario.value) ? chosenScenario.value
    : worst(first.filter((one) => one.value === value)).scenario;
  return (
    <>
      <PredictedAndSeen {...{ rows, first, second, value, values }} />
      <Distribution {...{ view, value, scenario, scenarios, seen: first }} />
    </>
  );
}

function Select({ label, value, all, onChange }: { label: string; value: string; all: string[]; onChange: (next: string) => void }) {
  return (
    <select class="inline" aria-label={label} value={value} onChange={(e) => onChange(e.currentTarget.value)}>
      {all.map((name) => <option key={name} value={name}>{words(splitUnit(name).name)}</option>)}
    </select>
  );
}

interface SeenProps {
  rows: Rows;
  first: Outcome[];
  second?: Outcome[];
  value: string;
  values: string[];
}

function PredictedAndSeen({ rows, first, second, value, values }: SeenProps) {
  const shown = useMemo(() => first.filter((one) => one.value === value), [first, value]);
  const after = useMemo(() => second?.filter((one) => one.value === value), [second, value]);
  const several = new Set(shown.map((one) => one.scenario)).size > 1;
  const label = (one: Outcome) => `${several ? `${one.scenario}, ` : ""}${words(one.statistic)}`;
  const chosen = selection.value;
  const place = (of: Outcome) => shown.findIndex((one) => one.row === of.row);
  const draw = useCallback((width: number): Plot.PlotOptions => ({
    height: 70 + 30 * shown.length, marginLeft: Math.min(0.42 * width, 14 + 7 * Math.max(...shown.map((one) => label(one).length))),
    marginRight: 16, marginBottom: 38,
    x: { label: axis(value), ticks: width < 420 ? 4 : 6, tickSize: 4, grid: true, nice: true },
    y: { domain: [shown.length - 0.5, -0.5], label: null, tickSize: 0, ticks: shown.map((_, k) => k),
      tickFormat: (k: number) => (shown[k] ? label(shown[k]) : "") },
    marks: [
      Plot.ruleY(shown, { y: place, x1: (one: Outcome) => one.measured - 2 * one.sigma, x2: (one: Outcome) => one.measured + 2 * one.sigma,
        stroke: (one: Outcome) => (chosen.mask[one.row] ? palette.pink : palette.ink), strokeWidth: 1.6 }),
      Plot.dot(shown, { y: place, x: "measured", r: 4, fill: (one: Outcome) => (chosen.mask[one.row] ? palette.pink : palette.ink) }),
      Plot.dot(shown, { y: place, x: "predicted", r: 5, stroke: palette.before, strokeWidth: 2.2, fill: palette.card, dy: -6 }),
      ...(after ? [Plot.dot(after, { y: place, x: "predicted", r: 5, stroke: palette.after, strokeWidth: 2.2, fill: palette.card, dy: 6 })] : []),
    ],
  }), [shown, after, value, chosen]);
  const pick = (k: number, add: boolean) => {
    const one = shown[k];
    if (one) choose(rows.n, (row) => row === one.row, `${label(one)} of ${words(value)}`, add);
  };
  const onPick = useCallback((_x: number, y: number, add: boolean) => pick(Math.round(y), add), [shown]);
  const items = useMemo(() => shown.map((one, k) => ({ x: one.measured, y: k, label: `${label(one)}: measured ${number(one.measured)}, predicted ${
    number(one.predicted)}` })), [shown]);
  const most = worst(shown);
  return (
    <Figure name="predicted and seen" draw={draw} onPick={onPick} items={items}
      title={<>
        <Select label="Value of runs" value={value} all={values} onChange={(next) => (chosenValue.value = next)} />{" "}
        <span class="quiet">predicted and seen</span></>}
      sentence={`${inkName()} was measured, with two of its errors; orange is what the runs of the model give${after ? ", blue those with the preview" : ""
      }. The farthest is ${label(most)}: ${number(Math.abs(most.off), 2)} of both errors off.`} />
  );
}

const runsBefore = signal<api.Runs | null>(null), runsAfter = signal<api.Runs | null>(null);

/** Where a number of runs stands among their values: a spread, an rms or a rate has no place there. */
const isPlace = (statistic: string) => /^(mean|median|min|max|quantile_.*)$/.test(statistic);

const mostBars = 20;

interface DistributionProps {
  view: View;
  value: string;
  scenario: string;
  scenarios: string[];
  seen: Outcome[];
}

function Distribution({ view, value, scenario, scenarios, seen }: DistributionProps) {
  const id = version.value?.id ?? "", effect = preview.value?.residuals ? preview.value.effect : "";
  useEffect(() => void api.runs(id).then((found) => (runsBefore.value = found), () => (runsBefore.value = null)), [id, view.rows]);
  useEffect(() => {
    runsAfter.value = null;
    if (effect) void api.runs(id, effect).then((found) => (runsAfter.value = found), () => undefined);
  }, [id, effect]);
  const valuesOf = (runs: api.Runs | null) => runs?.find((one) => one.scenario === scenario)?.values.get(value);
  const first = valuesOf(runsBefore.value), second = valuesOf(runsAfter.value);
  const marks = useMemo(() => seen.filter((one) => one.scenario === scenario && one.value === value && isPlace(one.statistic)),
    [seen, scenario, value]);
  const draw = useCallback((width: number): Plot.PlotOptions => {
    const all = [first, second].flatMap((values) => [...(values ?? [])]).filter(Number.isFinite);
    const [low, high] = [Math.min(...all), Math.max(...all)];
    const thresholds = Array.from({ length: mostBars - 1 }, (_, k) => low + (high - low) * (k + 1) / mostBars);
    const bars = (values: Float32Array, fill: string, fillOpacity: number) => Plot.rectY([...values].filter(Number.isFinite),
      { ...Plot.binX({ y: "proportion" }, { x: (one: number) => one, thresholds, domain: [low, high] }), fill, fillOpacity, inset: 0.5 });
    return {
      height: 240, marginLeft: 50, marginBottom: 38, marginTop: 26,
      x: { label: axis(value), ticks: width < 420 ? 4 : 6, tickSize: 4 },
      y: { label: "share of runs", ticks: 4, tickSize: 4, grid: true },
      marks: [
        ...(first ? [bars(first, palette.before, second ? 0.3 : 0.6)] : []), ...(second ? [bars(second, palette.after, 0.55)] : []),
        Plot.ruleY([0], { stroke: palette.ink2 }),
        Plot.ruleX(marks, { x: "measured", stroke: palette.ink, strokeWidth: 1.6 }),
        Plot.text(marks, { x: "measured", text: (one: Outcome) => words(one.statistic), frameAnchor: "top", textAnchor: "start", dx: 4, dy: 6,
          fill: palette.ink, stroke: palette.card, strokeWidth: 3 }),
      ],
    };
  }, [first, second, marks, value]);
  if (!first) return null;
  return (
    <Figure name="distribution of runs" draw={draw}
      title={<>
        runs of {scenarios.length > 1 ? <Select label="Scenario" value={scenario} all={scenarios} onChange={(next) => (chosenScenario.value = next)} />
          : words(scenario)} <span class="quiet">{words(splitUnit(value).name)} of each</span></>}
      sentence={`${first.length} runs of the model in orange${second ? ", with the preview in blue" : ""}. ${marks.length > 0
        ? "Black lines are what was measured." : "What was measured of it is no place among these values."}`} />
  );
}
