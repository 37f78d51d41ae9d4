// The candidate effects, ranked, with what each would bring and which of them the data do not separate.
import { number, pColumn, words } from "../shared/format";
import { Gain, ParameterList, PValue } from "../shared/parts";
import { DataTable, type Column, type Row } from "../shared/table";
import type { Candidate } from "../shared/types";
import type { Report } from "./data";

const helps = (c: Candidate) => c.found === true || ((c.gain ?? 0) > 0 && (c.p_value ?? 1) < 0.01);

/** Effects in the groups in which they are ordered, each group by its own rule. */
function groupsOf(candidates: Candidate[]) {
  return [
    { heading: "Effects of the model found, in the order of its steps", items: candidates.filter((c) => c.found) },
    { heading: "Others that help alone, by the log-likelihood of held-out groups",
      items: candidates.filter((c) => !c.found && helps(c)) },
    { heading: "Without a gain that noise would not bring, by the same", items: candidates.filter((c) => !helps(c)) },
  ].filter((group) => group.items.length > 0);
}

export function Candidates({ report }: { report: Report }) {
  const candidates = [...(report.result.candidates ?? [])].sort((a, b) => (a.rank ?? 0) - (b.rank ?? 0));
  if (candidates.length === 0) return null;
  // What helps, and a few of the others to see the distance.
  const helpful = candidates.filter(helps);
  const first = Math.max(6, Math.min(10, helpful.length + 2));
  const ordered = groupsOf(candidates).flatMap((group) => group.items);
  return (
    <section id="candidates">
      <h2>Candidates</h2>
      <p class="lead">
        Each effect that the model lacks was added alone and everything refitted on the training
        groups. Gain is the part of the excess error that disappears on held-out groups; the order is by
        log-likelihood, which also judges effects that only widen the noise.{" "}
        {helpful.length === 0 ? "None brings a gain that noise would not."
          : helpful.length === 1 ? "One brings a gain that noise cannot explain."
            : `${helpful.length} effects bring a gain that noise cannot explain; they may share one cause, ` +
              "so that some stand in for others."}
      </p>
      <Table candidates={ordered.slice(0, first)} />
      {candidates.length > first && (
        <details class="more">
          <summary>and {candidates.length - first} that bring less</summary>
          <Table candidates={ordered.slice(first)} />
        </details>
      )}
    </section>
  );
}

const columns: Column[] = [{ label: "Effect" }, { label: "Gain, held out" }, { label: "Error", right: true },
  { label: "p", right: true, class: "nowrap" }, { label: "Parameters, ± 1 σ" }, { label: "Why", class: "why" }];

function Table({ candidates }: { candidates: Candidate[] }) {
  const groups = groupsOf(candidates);
  const p = pColumn(groups.flatMap((group) => group.items).map((c) => c.p_value));
  const rows: Row[] = [];
  for (const { heading, items } of groups) {
    rows.push({ cells: [], heading });
    for (const c of items) rows.push(rowOf(c, p.shift()!));
  }
  return <div class="scroll"><DataTable class="candidates" columns={columns} rows={rows} /></div>;
}

function Names({ before, names }: { before: string; names?: string[] }) {
  if (!names?.length) return null;
  return (
    <div class="tie">{before} {names.map((name, i) => (
      <span key={name}>{i > 0 && ", "}<code>{name}</code></span>
    ))}</div>
  );
}

function rowOf(c: Candidate, p: string): Row {
  return { class: helps(c) ? undefined : "weak", cells: [
    <>
      <code class="effect">{c.effect}</code>
      {c.at_bound && <span class="tag warn" title="The fit ended at a bound of the parameter">at its bound</span>}
      <Names before="together with" names={Object.keys(c.with ?? {})} />
      <Names before="is not separated from" names={c.indistinguishable_from} />
      <Names before="stands in for" names={c.stands_in_for} />
    </>,
    <Gain gain={c.gain} sigma={c.gain_sigma} />,
    number(c.error, 4),
    <PValue text={p} />,
    <>
      <ParameterList parameters={c.parameters} />
      {Object.entries(c.with ?? {}).map(([name, parameters]) => (
        <div key={name} class="with"><code>{name}</code><ParameterList parameters={parameters} /></div>
      ))}
    </>,
    c.why ? words(c.why.split("; without it")[0]).replaceAll(" x ", " × ") : "",
  ] };
}
