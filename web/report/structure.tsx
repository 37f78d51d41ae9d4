// The list of what the residuals depend on, surest first, and the strongest of those that are equally sure.
import { number, pColumn, splitUnit, words } from "../shared/format";
import { PValue, Strength } from "../shared/parts";
import { DataTable, type Column } from "../shared/table";
import type { Structure as Item } from "../shared/types";
import { steps, type Report } from "./data";

export function Structure({ report }: { report: Report }) {
  const all = report.result.structure;
  if (!all) return null;
  const { result } = report;
  const found = steps(result).length + (result.explanation?.steps ?? []).length > 0;
  const left = found && (result.structure_of === "explanation" || result.format?.startsWith("seam-discover"));
  return (
    <section id="structure">
      <h2>{left ? "What the effects found leave" : "Where the model fails"}</h2>
      {all.length === 0
        ? <p class="lead">The residuals were tested against every covariate and product that physics
          suggests; nothing that matters was found.</p>
        : <>
          <p class="lead">
            What the held-out residuals {left ? "of the model found" : "of the model given"} depend on. Strength is the root mean square of what a smooth
            curve explains; p is corrected for the number of looks. One cause can show in several rows.
          </p>
          <Rows items={all.slice(0, shownFirst)} all={all} />
          {all.length > shownFirst && (
            <details class="more">
              <summary>and {all.length - shownFirst} weaker ones</summary>
              <Rows items={all.slice(shownFirst)} all={all} />
            </details>
          )}
        </>}
      <Traces report={report} />
    </section>
  );
}

/** What is significant but moves predictions by too little to matter. */
function Traces({ report }: { report: Report }) {
  const structure = report.result.traces?.structure ?? [];
  const candidates = report.result.traces?.candidates ?? [];
  const count = structure.length + candidates.length;
  if (count === 0) return null;
  return (
    <details class="more traces">
      <summary>{count === 1 ? "one trace" : `${count} traces`}: significant, but below{" "}
        {number(report.result.material ?? 0)} of the noise</summary>
      {candidates.length > 0 && (
        <p>
          Effects: {candidates.map((c, i) => (
            <span key={c.effect}>{i > 0 && ", "}<code>{c.effect}</code> (error {number(c.error, 4)})</span>
          ))}
        </p>
      )}
      {structure.length > 0 && <Rows items={structure} all={structure} />}
    </details>
  );
}

const shownFirst = 12;

const columns: Column[] = [{ label: "Residual" }, { label: "of its" }, { label: "varies with" }, { label: "Strength" },
  { label: "p", right: true, class: "nowrap" }];

function Rows({ items, all }: { items: Item[]; all: Item[] }) {
  const p = pColumn(items.map((item) => item.p_value));
  return (
    <DataTable class="structure" columns={columns} rows={items.map((item, i) => ({ cells: [
      <code>{splitUnit(item.residual).name}</code>,
      item.moment,
      words(item.covariate),
      <Strength item={item} all={all} />,
      <PValue text={p[i]} />,
    ] }))} />
  );
}
