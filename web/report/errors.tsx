// The error over steps or versions, what each effect is worth, and how the residuals are spread.
import * as Plot from "@observablehq/plot";
import { Figure } from "../shared/figure";
import { count, number, words } from "../shared/format";
import { beyond, distributionOptions } from "../shared/histogram";
import { palette } from "../shared/palette";
import { ParameterList } from "../shared/parts";
import { DataTable } from "../shared/table";
import type { Histogram } from "../shared/types";
import { steps, type LeaveOneOut, type Report } from "./data";

interface Level {
  label: string;
  error: number;
}

/** The errors in order: as given, then after each step. */
function levels(report: Report): Level[] {
  const all = steps(report.result);
  const found: Level[] = [];
  if (all[0]?.error_before != null) found.push({ label: "as given", error: all[0].error_before });
  for (const step of all) {
    if (step.error_after !== null) {
      found.push({ label: `+ ${step.effect ?? "refit"}`, error: step.error_after });
    }
  }
  return found;
}

function left(above: boolean, structure: boolean) {
  if (structure) {
    return above ? "The part above the dashed line is not explained."
      : "What is left is as large as the noise, but has structure.";
  }
  return above ? "The part above the dashed line shows no structure: the fitted groups constrain it too " +
    "little of what the held-out ones need." : "What is left is noise.";
}

export function ErrorFalling({ report }: { report: Report }) {
  const all = steps(report.result);
  const points = levels(report).map((level, i) => ({ ...level, i }));
  if (points.length < 2) return null;
  const floor = report.result.noise_floor ?? report.result.baseline?.noise_floor ?? 1;
  const last = points[points.length - 1];
  const lowest = Math.min(floor, ...points.map((p) => p.error));
  const highest = Math.max(...points.map((p) => p.error));
  const spans = highest / lowest > 20;
  const draw = (width: number): Plot.PlotOptions => ({
    height: 284, marginLeft: 52, marginBottom: 44, marginRight: Math.min(40, width / 16), marginTop: 38,
    x: { type: "point", domain: points.map((p) => p.i), label: null, tickSize: 0, padding: 0.4,
      tickFormat: (i: number) => shorten(points[i].label, width / points.length) },
    y: { label: "error (1 = the noise)", grid: true, nice: !spans, tickSize: 4, ticks: 5,
      ...(spans ? { type: "log", tickFormat: "~g", domain: [0.7 * lowest, 1.3 * highest] }
        : { zero: true }) },
    marks: [
      Plot.ruleY([floor], { stroke: palette.formal, strokeDasharray: "4 3", strokeWidth: 1.4 }),
      Plot.text(["noise"], { frameAnchor: "left", y: floor, text: (t: string) => t, dy: -7, dx: 4,
        fill: palette.ink3, fontSize: 11 }),
      Plot.line(points, { x: "i", y: "error", stroke: palette.after, strokeWidth: 2 }),
      Plot.dot(points, { x: "i", y: "error", r: 5, stroke: palette.card, strokeWidth: 1.5,
        fill: (p) => (p.i === 0 ? palette.before : palette.after) }),
      Plot.text(points, { x: "i", y: "error", text: (p) => number(p.error, 4), dy: -14,
        fill: palette.ink, fontWeight: 600, fontSize: 12.5 }),
    ],
  });
  return (
    <section id="steps">
      <h2>The error falls</h2>
      <div class="figures">
        <Figure wide name="error over steps" draw={draw}
          sentence={
            `Error on held-out groups, in units of the noise: ${number(points[0].error, 4)} as given, ` +
            `${number(last.error, 4)} after ${points.length - 1} ` +
            `${points.length === 2 ? "step" : "steps"}. ` +
            left(last.error >= 1.05 * floor, report.result.verdict === "unexplained_structure")
          } />
      </div>
      <DataTable columns={[{ label: "#", right: true }, { label: "Effect added" }, { label: "Error before", right: true },
        { label: "after", right: true }, { label: "Parameters, ± 1 σ" }, { label: "Note", class: "why" }]}
        rows={all.map((step, i) => ({ cells: [
          step.version ?? i + 1,
          <code class="effect">{step.effect ?? "refit"}</code>,
          number(step.error_before, 4),
          number(step.error_after, 4),
          <ParameterList parameters={step.parameters} />,
          <>
            {step.why && words(step.why)}
            {(step.indistinguishable_from ?? []).length > 0 &&
              <div class="tie">is not separated from {step.indistinguishable_from!.join(", ")}</div>}
            {step.data && <div class="quiet">{step.data}{step.fingerprint && ` (${
              step.fingerprint.slice(0, 8)})`}</div>}
          </>,
        ] }))} />
    </section>
  );
}

function shorten(label: string, room: number): string {
  const letters = Math.max(8, Math.floor(room / 7));
  return label.length > letters ? `${label.slice(0, letters - 1)}…` : label;
}

/** What held-out groups lose without each effect. The log-likelihood judges effects of the mean and of the spread alike;
 * the error in noise units does not, since a spread that grows over what is missing makes it fall. */
export function Worth({ report }: { report: Report }) {
  const rows = (report.plots?.leave_one_out ?? [])
    .filter((row) => row.log_likelihood_lost != null)
    .sort((a, b) => b.log_likelihood_lost! - a.log_likelihood_lost!);
  if (rows.length === 0) return null;
  const most = Math.max(10, rows[0].log_likelihood_lost!);
  const worth = (row: LeaveOneOut) => Math.max(1, row.log_likelihood_lost!);
  const labels = Math.min(170, 16 + 7.2 * Math.max(...rows.map((row) => row.effect.length)));
  const draw = (width: number): Plot.PlotOptions => ({
    height: 52 + 30 * rows.length, marginLeft: Math.min(labels, 0.44 * width), marginRight: 76, marginBottom: 38,
    x: { type: "log", domain: [1, most], label: "log-likelihood lost", grid: true, tickSize: 4, tickFormat: "~s",
      ticks: width < 500 ? 3 : 6 },
    y: { label: null, domain: rows.map((row) => row.effect), tickSize: 0, padding: 0.35,
      tickFormat: (name: string) => shorten(name, Math.min(labels, 0.44 * width)) },
    marks: [
      Plot.ruleX([1], { stroke: palette.ink2 }),
      Plot.barX(rows, { x1: 1, x2: worth, y: "effect", fill: palette.after, fillOpacity: 0.85 }),
      Plot.text(rows, { x: worth, y: "effect", dx: 6, textAnchor: "start",
        text: (row: LeaveOneOut) => plainNumber(row.log_likelihood_lost!), fill: palette.ink }),
    ],
  });
  const none = rows.filter((row) => row.log_likelihood_lost! < 1).map((row) => words(row.effect));
  return (
    <section id="worth">
      <h2>What each effect is worth</h2>
      <div class="figures">
        <Figure wide name="leave one effect out" draw={draw}
          sentence={
            `By how much less likely the held-out groups become (natural logarithm) when an effect is left out of the ` +
            `model and the rest refitted: ${words(rows[0].effect)} is worth most. ` +
            (none.length > 0 ? `Worth nothing to this data: ${none.join(", ")}.` : "Each of them is needed.")
          } />
      </div>
    </section>
  );
}

function plainNumber(x: number): string {
  return x >= 100 ? count(Math.round(x)) : number(x, 2);
}

export function Distributions({ report }: { report: Report }) {
  const names = [...new Set((report.plots?.histograms ?? []).map((h) => h.residual))];
  if (names.length === 0) return null;
  return (
    <section id="distribution">
      <h2>How the residuals are spread</h2>
      <div class="figures">
        {names.map((name) => (
          <Distribution key={name} name={name}
            sets={report.plots!.histograms!.filter((h) => h.residual === name)} />
        ))}
      </div>
    </section>
  );
}

function Distribution({ name, sets }: { name: string; sets: Histogram[] }) {
  const before = sets.find((set) => set.stage !== "after");
  const after = sets.find((set) => set.stage === "after");
  const shown = (after ?? before)!;
  const draw = () => distributionOptions(name, before, after);
  return (
    <Figure name={`distribution ${name}`} draw={draw} title={words(splitName(name))}
      sentence={
        `${(100 * beyond(shown, 3)).toFixed(1)} % of the residuals${after ? " with the effects found" : ""} ` +
        "lie beyond three of their stated errors; 0.3 % would if the noise were normal and nothing " +
        "were missing (black curve)."
      } />
  );
}

function splitName(name: string): string {
  return name.replace(/_(px|rad|m|dn|s)$/, "");
}
