// What to do next, what this data cannot say, what was left out, and how to make this page again.
import { number } from "../shared/format";
import { outlierList, type Report } from "./data";
import { save } from "./save";

export function Advice({ report }: { report: Report }) {
  const { advice, suggestion } = report.result;
  if (!advice && !suggestion) return null;
  return (
    <section id="advice" class="advice">
      {advice && <p><strong>What to measure next.</strong> {advice}</p>}
      {suggestion && (
        <p>
          <strong>Proposed effect.</strong> <code>{suggestion.effect}</code>
          {suggestion.error !== undefined && <> brings the error to {number(suggestion.error, 4)}</>}.
          {suggestion.terms !== undefined && <pre>{termText(suggestion.terms)}</pre>}
        </p>
      )}
    </section>
  );
}

function termText(terms: unknown): string {
  if (typeof terms === "string") return terms;
  if (Array.isArray(terms)) {
    return terms.map((term) => (typeof term === "string" ? term : JSON.stringify(term))).join("\n");
  }
  return JSON.stringify(terms, null, 2);
}

export function NotTestable({ report }: { report: Report }) {
  const all = report.result.not_testable ?? [];
  if (all.length === 0) return null;
  return (
    <section id="not-testable">
      <h2>Not testable with this data</h2>
      <p class="lead">The data has no leverage on these: whether they are there remains open.</p>
      <table class="data">
        <thead><tr><th>Effect</th><th>Parameter</th><th>Why</th></tr></thead>
        <tbody>
          {all.map((item, i) => (
            <tr key={i}>
              <td><code>{item.effect}</code></td>
              <td>{item.parameter && <code>{item.parameter}</code>}</td>
              <td class="why">{item.why}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </section>
  );
}

const listed = 40;

export function Outliers({ report }: { report: Report }) {
  const all = outlierList(report.result);
  if (all.length === 0) return null;
  return (
    <section id="outliers">
      <h2>Outliers</h2>
      <p class="lead">
        {all.length} {all.length === 1 ? "observation lies" : "observations lie"} more than six robust
        sigmas from their neighbours. They are left out of every error, the same ones before and after.
      </p>
      <table class="data narrow">
        <thead><tr><th>File</th><th class="r">Line</th><th class="r">Residual</th></tr></thead>
        <tbody>
          {all.slice(0, listed).map((item, i) => (
            <tr key={i}>
              <td><code>{item.file}</code></td>
              <td class="r num">{item.line}</td>
              <td class="r num">{typeof item.residual === "number" ? number(item.residual) : item.residual}</td>
            </tr>
          ))}
        </tbody>
      </table>
      {all.length > listed && <p class="quiet">and {all.length - listed} more, in the JSON.</p>}
    </section>
  );
}

export function Tables({ report }: { report: Report }) {
  return (
    <>
      {(report.tables ?? []).map((table, i) => (
        <section key={i} id={`table-${i}`}>
          {table.title && <h2>{table.title}</h2>}
          <div class="scroll">
            <table class="data">
              <thead><tr>{table.columns.map((c) => <th key={c}>{c}</th>)}</tr></thead>
              <tbody>
                {table.rows.map((row, r) => (
                  <tr key={r}>
                    {row.map((cell, c) => (
                      <td key={c} class="num">{typeof cell === "number" ? number(cell, 4) : cell ?? "–"}</td>
                    ))}
                  </tr>
                ))}
              </tbody>
            </table>
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
