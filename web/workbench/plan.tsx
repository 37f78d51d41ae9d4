// What to measure next: for a measurement not made yet, how well each parameter would be known, the smallest effect that
// would be found, and which pairs would tie.
import { signal } from "@preact/signals";
import { number, splitUnit } from "../shared/format";
import { Rich } from "../shared/rich";
import { DataTable } from "../shared/table";
import * as api from "./api";
import { searched, version } from "./store";

const answer = signal<api.PlanAnswer | null>(null);
const asked = signal("");
const wanted = signal<string[]>([]);
const asking = signal(false);

async function ask(): Promise<void> {
  asking.value = true;
  asked.value = "";
  try {
    answer.value = await api.plan({ effects: wanted.value });
  } catch (error) {
    asked.value = (error as Error).message;
  } finally {
    asking.value = false;
  }
}

export function PlanScreen() {
  const candidates = (searched.value?.candidates ?? []).map((one) => one.effect);
  const own = Object.keys(version.value?.effects ?? {});
  const toggle = (name: string) => (wanted.value = wanted.value.includes(name)
    ? wanted.value.filter((other) => other !== name) : [...wanted.value, name]);
  return (
    <div class="page plan-screen">
      <h1>What to measure next</h1>
      <p class="lead">For the same measurement made once more, and for changes of it (more groups, faster motion): how well each
        parameter would be known, and the smallest effect that would be found in 95 of 100 cases. Nothing is measured; the model's own
        predictions say it. "Would tie with" names what such a measurement would not separate.</p>
      {searched.value?.advice && <p class="advice"><b>From the search.</b> {searched.value.advice}</p>}
      <fieldset class="effects">
        <legend>Effects; none chosen means all that can be tested</legend>
        {[...new Set([...own, ...candidates])].slice(0, 40).map((name) => (
          <label key={name}><input type="checkbox" checked={wanted.value.includes(name)} onChange={() => toggle(name)} /> <code>{name}</code></label>
        ))}
      </fieldset>
      <button type="button" class="primary" disabled={asking.value} onClick={() => void ask()}>{asking.value ? "Computing …" : "Compute"}</button>
      {asked.value && <p class="trouble" role="alert">{asked.value}</p>}
      <Answer />
    </div>
  );
}

function Answer() {
  const found = answer.value;
  if (!found) return <p class="empty">{asking.value ? "The answer comes when all effects are planned." : "Nothing has been computed yet."}</p>;
  return (
    <>
      {found.headline && <p class="lead">{found.headline}</p>}
      <DataTable columns={[{ label: "Effect" }, { label: "Standard error of each parameter" }, { label: "Smallest found", right: true },
        { label: "Would tie with" }]} rows={rowsOf(found.effects)} />
      {(found.not_planned ?? []).length > 0 && (
        <p class="quiet">Not constrained by such a measurement: {unplanned(found)}.</p>
      )}
      {(found.changes ?? []).map((change) => (
        <section key={change.change}>
          <h2>{change.change} <span class="quiet num">cost × {number(change.cost, 2)}</span></h2>
          <DataTable columns={[{ label: "Effect" }, { label: "Standard error of each parameter" }, { label: "Smallest found", right: true },
            { label: "Would tie with" }]} rows={rowsOf(change.effects)} />
        </section>
      ))}
    </>
  );
}

/** Each effect once, with those of its parameters where others of it are planned. */
function unplanned({ effects, not_planned }: api.PlanAnswer): string {
  const byEffect = new Map<string, string[]>();
  for (const { effect, parameter } of not_planned ?? []) {
    const names = byEffect.get(effect) ?? [];
    if (parameter && !names.includes(parameter)) names.push(parameter);
    byEffect.set(effect, names);
  }
  return [...byEffect].map(([effect, names]) => (names.length > 0 && effects.some((one) => one.effect === effect)
    ? `${effect} (${names.join(", ")})` : effect)).join(", ");
}

const withUnit = (value: number, name: string) => `${number(value)} ${splitUnit(name).unit}`.trim();

const rowsOf = (effects: api.PlanAnswer["effects"]) => effects.map((one) => ({ cells: [
  <code class="effect">{one.effect}</code>,
  <ul class="parameters num">{Object.entries(one.parameters).map(([name, { sigma }]) => (
    <li key={name}><code>{name}</code> {sigma === null ? "not determined" : <Rich text={`± ${withUnit(sigma, name)}`} />}</li>))}</ul>,
  <ul class="parameters num">{Object.entries(one.smallest_found).map(([name, size]) => (
    <li key={name}>{size === null ? <span class="quiet">no size</span> : <Rich text={withUnit(size, name)} />}</li>))}
    {Object.keys(one.smallest_found).length === 0 && <li class="quiet">{one.in_model ? "in the model" : "–"}</li>}</ul>,
  one.ties === null ? <span class="quiet">not computed</span> : one.ties.length > 0 ? one.ties.map((tie) => (
    <div key={tie.effect}><code>{tie.effect}</code>{tie.apart_from !== null && <span class="quiet"> below{" "}
      <Rich text={number(tie.apart_from)} /></span>}</div>)) : <span class="quiet">none</span>,
] }));
