// The data themselves: columns with units and spans, what the check doubts, the raw values by row.
import { count, number, splitUnit, words } from "../shared/format";
import { Rich } from "../shared/rich";
import { DataTable } from "../shared/table";
import { RawPlot } from "./plots/raw";
import { fromRanges } from "./selection";
import { RowList } from "./row_list";
import { screen, session, view } from "./store";
import type { Doubt } from "./model";

const plain = (value: number | null | undefined) => (Number.isInteger(value) ? String(value) : number(value, 4));

export function DataScreen() {
  const set = session.value?.set;
  if (!set) return null;
  return (
    <div class="page data-screen">
      <h1>{set.title}</h1>
      <p class="lead">{set.kind} · <span class="num">{count(set.rows)}</span> rows in <span class="num">{count(set.groups)}</span> groups
        ({set.group}) · <code>{set.folder}</code></p>
      <Doubts doubts={set.doubts} />
      <Imported title="What the import could not know" sentences={set.imported?.not_known} />
      <Imported title="What the import did" sentences={set.imported?.done} said />
      <section>
        <h2>Columns</h2>
        <DataTable class="columns" columns={[{ label: "Column" }, { label: "Unit" }, { label: "From", right: true }, { label: "To", right: true },
          { label: "Missing", right: true }, { label: "File" }]} rows={set.columns.map((column) => ({ cells: [
          <code>{column.name}</code>, column.unit || "–", <Rich text={plain(column.low)} />, <Rich text={plain(column.high)} />,
          column.missing ? count(column.missing) : "none", column.file ? <code>{column.file}</code> : "–"] }))} />
        {Object.keys(set.noise).length > 0 && (
          <p class="quiet">Noise of one observation, {set.noiseEstimated ? "estimated" : "stated"}:{" "}
            {Object.entries(set.noise).map(([name, value]) => { const { name: short, unit } = splitUnit(name); return `${words(short)} ${number(value)} ${unit}`; }).join(", ")}.</p>
        )}
      </section>
      <section>
        <h2>Raw values</h2>
        {view.value ? <RawPlot view={view.value} /> : <p class="empty" role="status">Reading the rows …</p>}
      </section>
      <section>
        <h2>Rows</h2>
        {view.value ? <RowList rows={view.value.rows} /> : <p class="empty" role="status">Reading the rows …</p>}
      </section>
    </div>
  );
}

/** `said`: nothing to doubt. */
function Imported({ title, sentences, said = false }: { title: string; sentences?: string[]; said?: boolean }) {
  if (!sentences?.length) return null;
  return (
    <section>
      <h2>{title}</h2>
      <ul class={said ? "doubt-list said" : "doubt-list"}>{sentences.map((text, i) => <li key={i}>{text}</li>)}</ul>
    </section>
  );
}

function Doubts({ doubts }: { doubts: Doubt[] }) {
  const show = (doubt: Doubt) => {
    fromRanges(session.value!.set!.rows, doubt.rows!, doubt.text);
    screen.value = "work";
  };
  return (
    <section>
      <h2>What the check doubts</h2>
      {doubts.length === 0 ? <p class="empty">Nothing: units, times and groups look as they should.</p> : (
        <ul class="doubt-list">
          {doubts.map((doubt, i) => (
            <li key={i}><span>{doubt.text}</span>
              {(doubt.rows ?? []).length > 0 && <button type="button" onClick={() => show(doubt)}>Show the rows</button>}</li>
          ))}
        </ul>
      )}
    </section>
  );
}
