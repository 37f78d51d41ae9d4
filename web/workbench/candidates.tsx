// The candidates as they come: ordered, with ties in a bracket and what cannot be tested with its reason. Pointing at one
// previews it in all plots.
import { signal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { count, number, withSigma } from "../shared/format";
import { Gain } from "../shared/parts";
import { Rich } from "../shared/rich";
import { asValue, type Candidate, type Parameters } from "../shared/types";
import { edit } from "./formula";
import type { Search, Suggestion, Tie } from "./model";
import { addEffect, focusList, leaveList, point, pointed, searched, sheetOpen, stopSearch, version } from "./store";

const allShown = signal(false);

/** A step of a candidate that waits must make the held-out rows better, too. */
export const helps = (c: Candidate) => (c.rank !== undefined || (c.gain ?? 1) > 0) && (c.significant ?? ((c.gain ?? 0) > 0 && (c.p_value ?? 1) < 0.01));

const gainOf = (c: Candidate) => c.log_likelihood_gain ?? -Infinity;

/** Those that were fitted in their order, and those that wait where their score puts them. */
export function ranked({ candidates, prospects }: Search): Candidate[] {
  const all = [...candidates];
  for (const one of prospects) {
    if (all.some((c) => c.effect === one.effect)) continue;
    const at = all.findIndex((c) => gainOf(c) < gainOf(one));
    all.splice(at < 0 ? all.length : at, 0, one);
  }
  return all;
}

interface Block {
  items: Candidate[];
  tie?: Tie;
}

/** Candidates in their order, those that the data do not separate together at the place of the first. */
function blocksOf(candidates: Candidate[], ties: Tie[]): Block[] {
  const placed = new Set<string>();
  const blocks: Block[] = [];
  for (const candidate of candidates) {
    if (placed.has(candidate.effect)) continue;
    const tie = ties.find((one) => one.effects.includes(candidate.effect));
    const items = tie ? candidates.filter((c) => tie.effects.includes(c.effect)) : [candidate];
    items.forEach((c) => placed.add(c.effect));
    blocks.push(items.length > 1 ? { items, tie } : { items });
  }
  return blocks;
}

export function Candidates() {
  const search = searched.value;
  if (!search) return <p class="empty">No search has run on this version yet.</p>;
  const all = ranked(search);
  const strong = all.filter(helps), weak = all.filter((c) => !helps(c));
  return (
    <section class="candidates" aria-label="Candidates">
      <header class="side-head">
        <h2>Candidates</h2>
        <Progress search={search} />
      </header>
      {search.trouble && !version.value?.trouble && <p class="trouble" role="alert">{search.trouble}</p>}
      <p class="hint" title={search.ordered_by}>{hasEnded(search) ? "Where both help, what moves the mean goes before what only widens the noise. "
        : "The order is not final until the search has judged. "}Ordered by likelihood, less a price for each parameter; % of the misfit
        beyond the noise that goes. <span class="by-mouse">Point to preview, Enter adds.</span><span class="by-touch">Tap to preview.</span></p>
      <List blocks={[...blocksOf(strong, search.ties), ...(allShown.value ? blocksOf(weak, search.ties) : [])]}
        strong={strong.length} none={hasEnded(search) ? "No effect of the catalogue brings a gain that noise would not."
          : all.length > 0 ? "None so far brings a gain that noise would not." : "None is tested yet."} />
      {search.suggestion && <Formula found={search.suggestion} />}
      {weak.length > 0 && (
        <button type="button" class="link" aria-expanded={allShown.value} onClick={() => (allShown.value = !allShown.value)}>
          {allShown.value ? "hide" : "show"} {weak.length} that {weak.length === 1 ? "does" : "do"} not help
        </button>
      )}
      <NotTestable search={search} />
    </section>
  );
}

/** Whether nothing more will come: the verdict is there, or there will be none. */
const hasEnded = (search: Search) => search.progress === null &&
  (Boolean(search.cancelled || search.trouble) || (version.value?.looked ?? "yes") === "yes");

function Progress({ search }: { search: Search }) {
  if (hasEnded(search)) {
    return <span class="quiet num" role="status">{search.candidates.length} tested{search.cancelled && ", then cancelled"}</span>;
  }
  const { done, of } = search.progress ?? { done: 0, of: 0 };
  return (
    <span class="progress num" role="status">
      <progress max={of || 1} value={of ? done : undefined} aria-label="Candidates tested" />
      {!of ? "searching" : done === of ? "all fitted, judging" : `${count(done)} of ${count(of)}`}
      <button type="button" class="link" onClick={stopSearch}>cancel</button>
    </span>
  );
}

/** The formula that explains what no effect does: to be named and edited before it is added. */
function Formula({ found }: { found: Suggestion }) {
  const missing = (found.beside ?? []).filter((name) => !(name in (version.value?.effects ?? {})));
  return (
    <div class="proposed">
      <div class="line"><b>A formula</b><span class="num quiet">error {number(found.error_before, 3)} → {number(found.error, 3)}</span></div>
      <code class="effect">{found.formula}</code>
      {missing.length > 0 && <p class="small quiet">It was found beside {missing.join(", ")}: add {missing.length === 1 ? "this" : "these"} first.</p>}
      <button type="button" onClick={() => edit({ ...found, name: found.effect })}>Name it and add …</button>
    </div>
  );
}

/** Where the mouse was in the list. */
let mouseAt = "";

const idOf = (effect: string) => `candidate-${effect.replace(/[^a-z0-9_]/gi, "-")}`;

function List({ blocks, strong, none }: { blocks: Block[]; strong: number; none: string }) {
  const list = useRef<HTMLDivElement>(null);
  const all = blocks.flatMap((block) => block.items);
  useEffect(() => {
    if (!focusList.value) return;
    focusList.value = false;
    const inSheet = list.current!.offsetParent === null; // On a narrow page.
    (inSheet ? document.querySelector<HTMLElement>(".sheet-handle") : list.current)?.focus({ preventScroll: true });
  }, [focusList.value]);
  const now = pointed.value;
  const go = (to: number) => {
    if (all.length === 0) return;
    const next = all[Math.max(0, Math.min(all.length - 1, to))];
    point(next.effect, true);
    list.current?.querySelector(`#${idOf(next.effect)}`)?.scrollIntoView({ block: "nearest" });
  };
  const onKey = (event: KeyboardEvent) => {
    const at = all.findIndex((c) => c.effect === now), last = all.length - 1;
    const moves: Record<string, () => void> = {
      ArrowDown: () => go(at + 1), ArrowUp: () => go(at < 0 ? last : at - 1), Home: () => go(0), End: () => go(last),
      Enter: () => now && void addEffect(now),
    };
    const move = moves[event.key];
    if (!move || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    move();
  };
  return (
    <>
    <div class="list" role="listbox" aria-busy={all.length === 0} aria-label="Candidates" tabIndex={0} ref={list} onKeyDown={onKey}
      aria-activedescendant={now && all.some((c) => c.effect === now) ? idOf(now) : undefined}
      onPointerLeave={(e) => {
        mouseAt = "";
        if (e.pointerType === "mouse") leaveList();
      }}>
      {blocks.map((block, i) => (block.tie
        ? <div key={`tie ${i}`} class="bracket" role="group" aria-label="Not separated by these data">
          {block.items.map((c) => <Option key={c.effect} candidate={c} />)}
          <p class="separates">These data do not separate them{block.tie.advice ? <>; what would: {block.tie.advice}</> : "."}</p>
        </div>
        : block.items.map((c) => <Option key={c.effect} candidate={c} weak={all.indexOf(c) >= strong} />)))}
    </div>
    {all.length === 0 && <p class="empty">{none}</p>}
    </>
  );
}

/** A list that is scrolled under a still mouse is pointed at by nobody. */
function mouseMoved({ clientX, clientY }: PointerEvent): boolean {
  const was = mouseAt;
  mouseAt = `${clientX} ${clientY}`;
  return mouseAt !== was;
}

function Option({ candidate: c, weak = false }: { candidate: Candidate; weak?: boolean }) {
  const chosen = pointed.value === c.effect;
  const waits = c.rank === undefined;
  return (
    <div id={idOf(c.effect)} role="option" aria-selected={chosen} class={`option${weak ? " weak" : ""}`} title={c.help}
      onPointerEnter={(e) => e.pointerType === "mouse" && mouseMoved(e) && point(c.effect, false)}
      onClick={() => {
        point(c.effect, true);
        sheetOpen.value = false;
      }}>
      <div class="line">
        <code class="effect">{c.effect}</code>
        {c.at_bound && <span class="tag warn">at its bound</span>}
        <Gain gain={c.gain} sigma={c.gain_sigma} />
      </div>
      <div class="line small">
        <Values parameters={c.parameters} />
        <span class="num quiet error" title={waits ? "by one linear step: it waits for its fit" : undefined}>error {number(c.error, 3)}{waits && ", linear"}</span>
      </div>
      {Object.keys(c.with ?? {}).length > 0 && <div class="small">together with {Object.keys(c.with!).join(", ")}</div>}
      {(c.stands_in_for ?? []).length > 0 && <div class="small quiet">alone it stands in for {c.stands_in_for!.join(", ")}</div>}
    </div>
  );
}

/** Those that were fitted and moved first: of others a set of this kind may have no joint or axis. */
const moved = ([, parameter]: [string, Parameters[string]]) => {
  const { value, sigma } = asValue(parameter);
  return (sigma ? 2 : 0) + (value ? 1 : 0);
};

/** The first two parameters; the preview has all of them. */
function Values({ parameters }: { parameters?: Parameters }) {
  const all = Object.entries(parameters ?? {}).sort((a, b) => moved(b) - moved(a));
  const entries = all.some((one) => moved(one) > 0) ? all.filter((one) => moved(one) > 0) : all;
  return (
    <span class="values num">
      {entries.slice(0, 2).map(([name, parameter]) => (
        <span key={name}><span class="quiet">{name}</span> <Rich text={valueText(parameter)} /></span>
      ))}
      {entries.length > 2 && <span class="quiet">and {entries.length - 2} more</span>}
    </span>
  );
}

/** A value with its error; "not determined" where the error hides it. */
export function valueText(parameter: Parameters[string]): string {
  const { value, sigma } = asValue(parameter);
  if (value !== null && sigma != null && sigma > 2 * Math.abs(value) && sigma > 0) return `not determined (± ${number(sigma, 2)})`;
  return withSigma(value, sigma);
}

function NotTestable({ search }: { search: Search }) {
  if (search.notTestable.length === 0) return null;
  return (
    <details class="more">
      <summary>{search.notTestable.length} not testable with these data</summary>
      <ul class="untestable">
        {search.notTestable.map((item, i) => (
          <li key={i}><code>{item.effect}</code> {item.parameter && <code class="quiet">{item.parameter}</code>}
            <div class="small quiet">{item.why}</div></li>
        ))}
      </ul>
    </details>
  );
}
