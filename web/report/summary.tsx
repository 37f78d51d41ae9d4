// The head of the page: the verdict in a sentence, the numbers behind it, and what was compared.
import type { ComponentChildren } from "preact";
import { count, number, percent, splitUnit } from "../shared/format";
import { Rich } from "../shared/rich";
import { errorBefore, outlierList, steps, type Report, type Result } from "./data";

export function Header({ report }: { report: Report }) {
  const { result, data } = report;
  const verdict = verdictOf(result);
  return (
    <header>
      <p class="eyebrow">
        SEAM <span class="sep">/</span> {commandOf(result)}
      </p>
      <h1>{report.title ?? data?.title ?? "Model against measurement"}</h1>
      {verdict && (
        <div class={`verdict ${verdict.tone}`}>
          <strong>{verdict.title}</strong>
          <span>{verdict.text}</span>
        </div>
      )}
      <Numbers report={report} />
      <Compared report={report} />
    </header>
  );
}

function commandOf(result: Result): string {
  return (result.format ?? "").replace(/^seam-/, "").replace(/\/\d+$/, "").replaceAll("-", " ");
}

interface Verdict {
  tone: "good" | "bad" | "open";
  title: string;
  text: ComponentChildren;
}

function verdictOf(result: Result): Verdict | null {
  const error = result.error ?? errorBefore(result);
  const floor = result.noise_floor ?? result.baseline?.noise_floor ?? 1;
  if (result.verdict === "adequate") {
    const added = steps(result).map((step) => step.effect).filter(Boolean);
    return { tone: "good", title: "The model is adequate.", text: added.length
      ? <>With {list(added as string[])} added, the error is {number(error, 4)}: nothing is left that
        this data could show.</>
      : <>The error is {number(error, 4)}, the noise is {number(floor)}: this data shows nothing that
        the model lacks.</> };
  }
  if (result.verdict === "missing_effect") {
    const best = [...(result.candidates ?? [])].sort((a, b) => a.rank - b.rank)[0];
    return { tone: "bad", title: "An effect is missing.", text: best
      ? <><code>{best.effect}</code> explains most: added, the error falls from{" "}
        {number(errorBefore(result), 4)} to {number(best.error, 4)}
        {best.gain !== null && <>, {percent(best.gain)} of the excess</>}.
        {(best.indistinguishable_from ?? []).length > 0 &&
          <> This data does not separate it from {list(best.indistinguishable_from!)}.</>}</>
      : "See the candidates below." };
  }
  if (result.verdict === "unexplained_structure") {
    const worst = (result.structure ?? []).find((s) => s.moment !== "spread") ?? result.structure?.[0];
    return { tone: "open", title: "Structure remains that no known effect explains.", text: worst
      ? <>It shows most in <code>{worst.residual}</code> against <code>{worst.covariate}</code>:{" "}
        {number(worst.strength)} {splitUnit(worst.residual).unit}.</>
      : "No effect of the catalogue brings the residuals to noise." };
  }
  if (result.format?.startsWith("seam-compare")) {
    const found = result.structure ?? [];
    const excess = error !== null ? `The error is ${number(error, 4)} times the noise` : "";
    return found.length > 0
      ? { tone: "bad", title: "The residuals are not noise.", text:
        <>{excess}; {found.length === 1 ? "one structure was" : `${found.length} structures were`} found,
          above all in <code>{found[0].residual}</code> against <code>{found[0].covariate}</code>:{" "}
          {number(found[0].strength)} {splitUnit(found[0].residual).unit}.</> }
      : { tone: "good", title: "The residuals look like noise.", text: `${excess}; no structure was found.` };
  }
  return null;
}

function list(names: string[]): ComponentChildren {
  return names.map((name, i) => (
    <span key={name}>
      {i > 0 && (i === names.length - 1 ? " and " : ", ")}
      <code>{name}</code>
    </span>
  ));
}

function Numbers({ report }: { report: Report }) {
  const { result, data } = report;
  const before = errorBefore(result);
  const all = steps(result);
  const after = all.length > 0 ? all[all.length - 1].error_after : null;
  const best = [...(result.candidates ?? [])].sort((a, b) => a.rank - b.rank)[0];
  const native = result.native ?? result.baseline?.native ?? {};
  const outliers = outlierList(result).length;
  const tiles: [string, string, string][] = [];
  if (before !== null) {
    tiles.push([number(before, 4), all.length ? "error at first" : "error",
      "of held-out residuals; 1 is the noise"]);
  }
  if (after !== null && after !== undefined) {
    const note = `after ${all.length} ${all.length === 1 ? "step" : "steps"}`;
    tiles.push([number(after, 4), "error at the end", note]);
  } else if (best && best.error !== null && result.verdict !== "adequate") {
    tiles.push([number(best.error, 4), `with ${best.effect}`, "the best single effect, refitted"]);
  }
  for (const [name, value] of Object.entries(native).slice(0, 3)) {
    const split = splitUnit(name);
    tiles.push([`${number(value)} ${split.unit}`, `${split.name}, root mean square`, noiseText(report, name)]);
  }
  for (const free of result.free_prediction ?? result.baseline?.free_prediction ?? []) {
    if (free.rms === null) continue;
    const split = splitUnit(free.residual);
    const over = free.over === "run" ? "a run" : free.over;
    tiles.push([`${number(free.rms)} ${split.unit}`, `${split.name} over ${over}`,
      "root mean square, predicted freely"]);
  }
  const n = data?.n ?? result.n;
  if (n !== undefined) {
    tiles.push([count(n), "observations", `${count(data?.groups ?? result.groups)} groups` +
      (outliers ? `, ${outliers} outliers left out` : "")]);
  }
  if (tiles.length === 0) return null;
  return (
    <dl class="tiles">
      {tiles.map(([value, label, note]) => (
        <div key={label}>
          <dt>{label}</dt>
          <dd class="num"><Rich text={value} /></dd>
          <dd class="note"><Rich text={note} /></dd>
        </div>
      ))}
    </dl>
  );
}

function noiseText(report: Report, name: string): string {
  const noise = (report.data?.noise ?? report.result.noise)?.[name];
  if (!noise) return "";
  const estimated = report.data?.noise_from === "estimated" ? ", estimated" : "";
  return `one observation's noise ${number(noise)}${estimated}`;
}

function Compared({ report }: { report: Report }) {
  const { model, data } = report;
  if (!model && !data) return null;
  const effects = Object.keys(model?.effects ?? {});
  return (
    <table class="compared">
      <tbody>
        {data && (
          <tr>
            <th>Measurement</th>
            <td>
              {data.title ?? data.folder} <span class="quiet">
                {data.kind && `· ${data.kind}`} {data.folder && <code>{data.folder}</code>}
              </span>
            </td>
          </tr>
        )}
        {data?.held_out_n !== undefined && (
          <tr>
            <th>Held out</th>
            <td class="num">{count(data.held_out_n)} residuals of {count(data.held_out_groups)} groups,
              never used for a fit</td>
          </tr>
        )}
        {model && (
          <tr>
            <th>Model</th>
            <td>
              {model.name} {model.file && <code class="quiet">{model.file}</code>}
              {effects.length > 0 && <div class="chips">{effects.map((e) => <code key={e}>{e}</code>)}</div>}
            </td>
          </tr>
        )}
      </tbody>
    </table>
  );
}
