// The candidate effects, ranked, with what each would bring and which of them the data do not separate.
import { number, pColumn, percent, withSigma, words } from "../shared/format";
import { Rich } from "../shared/rich";
import { DataTable, type Column, type Row } from "../shared/table";
import { asValue, type Candidate, type Parameters, type Report } from "./data";

export function ParameterList({ parameters }: { parameters?: Parameters }) {
  const entries = Object.entries(parameters ?? {});
  if (entries.length === 0) return <span class="quiet">none</span>;
  return (
    <ul class="parameters num">
      {entries.map(([name, parameter]) => {
        const { value, sigma } = asValue(parameter);
        return <li key={name}><code>{name}</code> <Rich text={withSigma(value, sigma)} /></li>;
      })}
    </ul>
  );
}

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
  const candidates = [...(report.result.candidates ?? [])].sort((a, b) => a.rank - b.rank);
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
    <Gain candidate={c} />,
    number(c.error, 4),
    <Rich text={p} />,
    <>
      <ParameterList parameters={c.parameters} />
      {Object.entries(c.with ?? {}).map(([name, parameters]) => (
        <div key={name} class="with"><code>{name}</code><ParameterList parameters={parameters} /></div>
      ))}
    </>,
    c.why ? words(c.why.split("; without it")[0]).replaceAll(" x ", " × ") : "",
  ] };
}

/** A bar from zero with a whisker of one standard error; a loss is drawn to the left in grey. */
function Gain({ candidate: c }: { candidate: Candidate }) {
  const width = 96;
  if (c.gain === null || c.gain === undefined) return <span class="quiet">already at the noise</span>;
  const gain = Math.max(-0.25, Math.min(1, c.gain));
  const zero = 12;
  const scale = width - zero;
  const sigma = c.gain_sigma ?? 0;
  const left = Math.max(0, zero + scale * (c.gain - sigma));
  const right = Math.min(width, zero + scale * (c.gain + sigma));
  return (
    <div class="gain num">
      <svg width={width} height="16" aria-hidden="true">
        <rect x={Math.max(0, zero + Math.min(0, gain * scale))} y="3" height="10" rx="1.5"
          width={Math.min(Math.abs(gain) * scale, gain < 0 ? zero : scale)}
          class={gain < 0 ? "loss" : "win"} />
        <line x1={zero} x2={zero} y1="0" y2="16" class="axis" />
        {sigma > 0 && left < right && <line x1={left} x2={right} y1="8" y2="8" class="whisker" />}
      </svg>
      {percent(c.gain)}
    </div>
  );
}
