// The figures of a field's standard (photometry: EMVA 1288), each with its standard error.
import { number } from "../shared/format";
import { Rich } from "../shared/rich";
import { DataTable } from "../shared/table";
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
      <DataTable columns={[{ label: "Figure" }, { label: "Value", right: true }, { label: "Error", right: true },
        { label: "Unit" }]} rows={table.figures.map((figure) => ({ cells: [
        figure.name,
        <Rich text={number(figure.value)} />,
        figure.sigma === null ? "not determined" : <Rich text={number(figure.sigma)} />,
        figure.unit,
      ] }))} />
      {measured && <details class="more">
        <summary>signal over noise at each level</summary>
        <DataTable columns={["Light", "Signal, DN", "SNR", "Error", "by the figures"].map((label) => ({ label, right: true }))}
          rows={table.snr_curve.map((point) => ({ cells:
            [point.light, point.signal_dn, point.snr, point.sigma, point.expected].map((value) =>
              <Rich text={number(value)} />) }))} />
      </details>}
    </section>
  );
}
