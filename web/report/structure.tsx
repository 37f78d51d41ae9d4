// The list of what the residuals depend on, surest first, and the strongest of those that are equally sure.
import { number, pValue, splitUnit, words } from "../shared/format";
import { Rich } from "../shared/rich";
import type { Report, Structure as Item } from "./data";

export function Structure({ report }: { report: Report }) {
  const all = report.result.structure;
  if (!all) return null;
  return (
    <section id="structure">
      <h2>Where the model fails</h2>
      {all.length === 0
        ? <p class="lead">The residuals were tested against every covariate and product that physics
          suggests; nothing that matters was found.</p>
        : <>
          <p class="lead">
            What the held-out residuals depend on. Strength is the root mean square of what a smooth
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

function Rows({ items, all }: { items: Item[]; all: Item[] }) {
  return (
    <table class="data structure">
      <thead>
        <tr><th>Residual</th><th>of its</th><th>varies with</th><th>Strength</th><th class="r">p</th></tr>
      </thead>
      <tbody>{items.map((item, i) => <Row key={i} item={item} all={all} />)}</tbody>
    </table>
  );
}

function Row({ item, all }: { item: Item; all: Item[] }) {
  const same = all.filter((other) => splitUnit(other.residual).unit === splitUnit(item.residual).unit);
  const most = Math.max(...same.map((other) => other.strength ?? 0)) || 1;
  const share = Math.max(0, Math.min(1, (item.strength ?? 0) / most));
  return (
    <tr>
      <td><code>{splitUnit(item.residual).name}</code></td>
      <td>{item.moment}</td>
      <td>{words(item.covariate)}</td>
      <td>
        <div class="strength num">
          <svg width="90" height="12" aria-hidden="true">
            <rect x="0" y="2" width={Math.max(1.5, 90 * share)} height="8" rx="1.5" />
          </svg>
          <span><Rich text={number(item.strength)} /> {splitUnit(item.residual).unit}</span>
        </div>
      </td>
      <td class="r num"><Rich text={pValue(item.p_value)} /></td>
    </tr>
  );
}
