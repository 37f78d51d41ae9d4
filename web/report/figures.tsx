// The figures of a field's standard (photometry: EMVA 1288), each with its standard error.
import { number } from "../shared/format";
import { Rich } from "../shared/rich";
import type { Report } from "./data";

export function Figures({ report }: { report: Report }) {
  const table = report.result.figures;
  if (!table || table.figures.length === 0) return null;
  const measured = table.snr_curve.length > 0;
  return (
    <section id="figures">
      <h2>{measured ? `Figures after ${table.title}` : table.title}</h2>
      <p class="lead">
        {measured
          ? "By the standard's own formulas, from all pixels of all frames and no model; the error is what " +
            "the pixels and the scatter of the levels leave."
          : "By the model's estimate, with what its effects change; the error is one standard error of the fit."}
      </p>
      <table class="data">
        <thead><tr><th>Figure</th><th class="r">Value</th><th class="r">Error</th><th>Unit</th></tr></thead>
        <tbody>
          {table.figures.map((figure) => (
            <tr key={figure.name}>
              <td>{figure.name}</td>
              <td class="r num"><Rich text={number(figure.value)} /></td>
              <td class="r num">
                {figure.sigma === null ? "not determined" : <Rich text={number(figure.sigma)} />}
              </td>
              <td>{figure.unit}</td>
            </tr>
          ))}
        </tbody>
      </table>
      {measured && <details class="more">
        <summary>signal over noise at each level</summary>
        <table class="data">
          <thead>
            <tr>
              <th class="r">Light</th><th class="r">Signal, DN</th><th class="r">SNR</th>
              <th class="r">Error</th><th class="r">by the figures</th>
            </tr>
          </thead>
          <tbody>
            {table.snr_curve.map((point, i) => (
              <tr key={i}>
                <td class="r num"><Rich text={number(point.light)} /></td>
                <td class="r num"><Rich text={number(point.signal_dn)} /></td>
                <td class="r num"><Rich text={number(point.snr)} /></td>
                <td class="r num"><Rich text={number(point.sigma)} /></td>
                <td class="r num"><Rich text={number(point.expected)} /></td>
              </tr>
            ))}
          </tbody>
        </table>
      </details>}
    </section>
  );
}
