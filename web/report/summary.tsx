// The head of the page: the verdict in a sentence, the numbers behind it, and what was compared.
import { count, number, splitUnit } from "../shared/format";
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
          {result.headline && <span class="headline">{result.headline}</span>}
        </div>
      )}
      {(result.doubts ?? []).length > 0 && (
        <ul class="doubts" aria-label="Doubts about the data">
          {result.doubts!.map((doubt, i) => <li key={i}>{doubt.trim()}</li>)}
        </ul>
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
}

/** The verdict's colour and name; what matters is the command's own sentence. */
function verdictOf(result: Result): Verdict | null {
  const found = steps(result).length > 0;
  if (result.verdict === "adequate") {
    return { tone: "good", title: found ? "The model found is adequate." : "The model is adequate." };
  }
  if (result.verdict === "missing_effect") return { tone: "bad", title: "An effect is missing." };
  if (result.verdict === "unexplained_structure") {
    return { tone: "open", title: "Structure remains that no known effect explains." };
  }
  if (!result.format?.startsWith("seam-compare")) return null;
  return (result.structure ?? []).length > 0
    ? { tone: "bad", title: "The residuals are not noise." }
    : (result.error ?? 1) > 1.15 ? { tone: "open", title: "The error is above the noise." }
      : { tone: "good", title: "The residuals look like noise." };
}

function Numbers({ report }: { report: Report }) {
  const { result, data } = report;
  const before = errorBefore(result);
  const all = steps(result);
  const after = all.length > 0 ? all[all.length - 1].error_after : null;
  const explained = (result.explanation?.steps ?? []).map((step) => step.effect);
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
  } else if (explained.length > 0) {
    tiles.push([number(result.explanation!.error, 4), `with ${explained.join(", ")}`,
      explained.length === 1 ? "the effect found, all refitted" : "the effects found, all refitted"]);
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
    tiles.push([count(n), thingsOf(data?.kind ?? result.kind), `${count(data?.groups ?? result.groups)} groups` +
      (outliers ? `, ${outliers} ${outliers === 1 ? "residual" : "residuals"} left out as outliers` : "")]);
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

/** What one observation of a kind is. */
function thingsOf(kind: string | undefined): string {
  return { points: "points", photometry: "pixel values", frames: "pixel values", joints: "readings",
    odometry: "poses" }[kind ?? ""] ?? "observations";
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
