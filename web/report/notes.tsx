// What to do next, what this data cannot say, what was left out, and how to make this page again.
import { number, splitUnit } from "../shared/format";
import { Rich } from "../shared/rich";
import { DataTable } from "../shared/table";
import { outlierList, type Outlier, type Report } from "./data";
import { save } from "../shared/save";

export function Advice({ report }: { report: Report }) {
  const { advice } = report.result;
  if (!advice) return null;
  return (
    <section id="advice" class="advice">
      <p><strong>What to measure next.</strong> {advice}</p>
    </section>
  );
}

export function NotTestable({ report }: { report: Report }) {
  const all = report.result.not_testable ?? [];
  if (all.length === 0) return null;
  return (
    <section id="not-testable">
      <h2>Not testable with this data</h2>
      <p class="lead">The data has no leverage on these: whether they are there remains open.</p>
      <DataTable columns={[{ label: "Effect" }, { label: "Parameter" }, { label: "Why", class: "why" }]}
        rows={all.map((item) => ({ cells: [<code>{item.effect}</code>, item.parameter && <code>{item.parameter}</code>,
          item.why] }))} />
    </section>
  );
}

const outcomes = ["found", "trace", "not tested", "nothing"];

export function LookedFor({ report }: { report: Report }) {
  const all = report.result.looked_for ?? [];
  if (all.length === 0) return null;
  const sorted = outcomes.flatMap((outcome) => all.filter((item) => item.outcome === outcome));
  const first = sorted.filter((item) => item.outcome !== "nothing"), nothing = sorted.slice(first.length);
  return (
    <section id="looked-for">
      <h2>What was looked for</h2>
      <p class="lead">Beside the catalogue's effects, in the model with all effects found.</p>
      {first.length > 0 && <Looks items={first} />}
      {nothing.length > 0 && (
        <details class="more">
          <summary>{nothing.length} without result</summary>
          <Looks items={nothing} />
        </details>
      )}
    </section>
  );
}

function Looks({ items }: { items: NonNullable<Report["result"]["looked_for"]> }) {
  return (
    <DataTable columns={[{ label: "What" }, { label: "Of" }, { label: "Outcome" }, { label: "Why", class: "why" }]}
      rows={items.map((item) => ({ cells: [item.what, item.of.join(", "), item.outcome, item.why] }))} />
  );
}

const listed = 40;

interface Stretch {
  first: number;
  last: number;
  count: number;
  /** By residual: the largest. */
  largest: Map<string, number>;
}

/** Outliers of neighbouring lines as one row, with the largest residual of each name. */
function stretchesOf(outliers: Outlier[]): Stretch[] {
  const sorted = [...outliers].filter((o) => o.line !== undefined).sort((a, b) => a.line! - b.line!);
  const stretches: Stretch[] = [];
  for (const { line, channel, residual } of sorted) {
    let last = stretches.at(-1);
    if (!last || line! > last.last + 1) {
      last = { first: line!, last: line!, count: 0, largest: new Map() };
      stretches.push(last);
    }
    last.last = line!;
    ++last.count;
    const name = channel ?? "", most = last.largest.get(name) ?? 0;
    if (typeof residual === "number" && Math.abs(residual) >= Math.abs(most)) last.largest.set(name, residual);
  }
  return stretches;
}

export function Outliers({ report }: { report: Report }) {
  const all = outlierList(report.result);
  if (all.length === 0) return null;
  const files = [...new Set(all.map((item) => item.file ?? ""))];
  return (
    <section id="outliers">
      <h2>Outliers</h2>
      <p class="lead">
        {all.length} {all.length === 1 ? "residual lies" : "residuals lie"} more than six robust
        sigmas from their neighbours. They are left out of every error, the same ones before and after.
      </p>
      {files.map((file) => (
        <FileOutliers key={file} file={file} stretches={stretchesOf(all.filter((o) => (o.file ?? "") === file))} />
      ))}
    </section>
  );
}

function FileOutliers({ file, stretches }: { file: string; stretches: Stretch[] }) {
  return (
    <>
      <p class="quiet"><code>{file}</code></p>
      <DataTable class="narrow" columns={[{ label: "Lines", right: true }, { label: "Residuals", right: true },
        { label: "Largest" }]} rows={stretches.slice(0, listed).map((stretch) => ({ cells: [
        stretch.first === stretch.last ? stretch.first : `${stretch.first} to ${stretch.last}`,
        stretch.count,
        <Rich text={[...stretch.largest].map(([name, value]) => {
          const split = splitUnit(name);
          return `${split.name} ${number(value)} ${split.unit}`.trim();
        }).join(", ")} />,
      ] }))} />
      {stretches.length > listed && <p class="quiet">and {stretches.length - listed} more places, in the JSON.</p>}
    </>
  );
}

export function Tables({ report }: { report: Report }) {
  return (
    <>
      {(report.tables ?? []).map((table, i) => (
        <section key={i} id={`table-${i}`}>
          {table.title && <h2>{table.title}</h2>}
          <div class="scroll">
            <DataTable columns={table.columns.map((label) => ({ label, class: "num" }))}
              rows={table.rows.map((row) => ({ cells: row.map((cell) =>
                (typeof cell === "number" ? <Rich text={number(cell, 4)} /> : cell ?? "–")) }))} />
          </div>
        </section>
      ))}
    </>
  );
}

export function Reproduce({ report }: { report: Report }) {
  const saveNumbers = () =>
    save(JSON.stringify(report.result, null, 1), "application/json", "result.json");
  return (
    <footer id="reproduce">
      {report.command && <pre class="command">{report.command}</pre>}
      <p class="quiet">
        {report.version && <>SEAM {report.version}. </>}
        {report.data?.fingerprint && <>Data <code>{report.data.fingerprint}</code>. </>}
        Error is the square root of r′ S⁻¹ r / N over held-out residuals: 1 is the noise.{" "}
        <button type="button" onClick={saveNumbers}>Save the numbers as JSON</button>
      </p>
    </footer>
  );
}
