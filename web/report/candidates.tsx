// The candidate effects, ranked, with what each would bring and which of them the data do not separate.
import { number, percent, pValue, withSigma, words } from "../shared/format";
import { Rich } from "../shared/rich";
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

export function Candidates({ report }: { report: Report }) {
  const candidates = [...(report.result.candidates ?? [])].sort((a, b) => a.rank - b.rank);
  if (candidates.length === 0) return null;
  // What helps, and a few of the others to see the distance.
  const first = Math.max(6, Math.min(10, candidates.filter(helps).length + 2));
  const helpful = candidates.filter(helps);
  return (
    <section id="candidates">
      <h2>Candidates</h2>
      <p class="lead">
        Each effect that the model lacks was added alone and everything refitted on the training
        groups. Gain is the part of the excess error that disappears on held-out groups. Order: effects
        of the model found, by its steps; then others that are significant alone, then the rest, both by
        the log-likelihood of held-out groups.{" "}
        {helpful.length === 0 ? "None brings a gain that noise would not."
          : helpful.length === 1 ? "One brings a gain that noise cannot explain."
            : `${helpful.length} effects bring a gain that noise cannot explain; they may share one cause, ` +
              "so that some stand in for others."}
      </p>
      <Table candidates={candidates.slice(0, first)} />
      {candidates.length > first && (
        <details class="more">
          <summary>and {candidates.length - first} that bring less</summary>
          <Table candidates={candidates.slice(first)} />
        </details>
      )}
    </section>
  );
}

function Table({ candidates }: { candidates: Candidate[] }) {
  return (
    <div class="scroll">
      <table class="data candidates">
        <thead>
          <tr>
            <th class="r">#</th><th>Effect</th><th>Gain, held out</th><th class="r">Error</th>
            <th class="r">p</th><th>Parameters, ± 1 σ</th><th>Why</th>
          </tr>
        </thead>
        <tbody>{candidates.map((c) => <Row key={c.effect} candidate={c} />)}</tbody>
      </table>
    </div>
  );
}

function Row({ candidate: c }: { candidate: Candidate }) {
  const significant = helps(c);
  return (
    <tr class={significant ? "" : "weak"}>
      <td class="r num">{c.rank}</td>
      <td>
        <code class="effect">{c.effect}</code>
        {c.at_bound && <span class="tag warn" title="The fit ended at a bound of the parameter">
          at its bound</span>}
        {(c.indistinguishable_from ?? []).length > 0 && (
          <div class="tie">is not separated from {c.indistinguishable_from!.map((name, i) => (
            <span key={name}>{i > 0 && ", "}<code>{name}</code></span>
          ))}</div>
        )}
        {(c.stands_in_for ?? []).length > 0 && (
          <div class="tie">stands in for {c.stands_in_for!.map((name, i) => (
            <span key={name}>{i > 0 && ", "}<code>{name}</code></span>
          ))}</div>
        )}
      </td>
      <td><Gain candidate={c} /></td>
      <td class="r num">{number(c.error, 4)}</td>
      <td class="r num nowrap"><Rich text={pValue(c.p_value)} /></td>
      <td><ParameterList parameters={c.parameters} /></td>
      <td class="why">{c.why ? words(c.why.split("; without it")[0]).replaceAll(" x ", " × ") : ""}</td>
    </tr>
  );
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
