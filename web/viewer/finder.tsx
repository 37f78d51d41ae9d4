// The box of the search, and its hits.
import { signal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { current, goTo, namesToRead, search, searched, searching } from "./find";
import { condition, replays, robot } from "./store";
import { clock } from "./timeline";

const typed = signal("");
const names = signal<string[]>([]);
/** Beyond this a list is no help; the timeline has them all. */
const mostListed = 500;

export function Finder() {
  const box = useRef<HTMLInputElement>(null);
  useEffect(() => {
    if (condition.value && !typed.value) typed.value = condition.value;
    void namesToRead().then((found) => (names.value = found)).catch(() => (names.value = []));
    // Who opens a link with a condition wants the keys.
    if (!condition.value) box.current?.focus({ preventScroll: true });
  }, []);
  const run = async (first: boolean) => {
    await search(typed.value);
    const log = searched.value.findIndex((one) => one.hits.length > 0);
    if (first && log >= 0) goTo(log, 0);
  };
  const id = robot.value.replaceAll("-", "_");
  return (
    <div class="finder">
      <form onSubmit={(event) => { event.preventDefault(); void run(false); }}>
        <input ref={box} type="search" aria-label="Condition" list="find-names" maxLength={1000} spellcheck={false}
          autocomplete="off" placeholder={`${id}.event.kick`} value={typed.value}
          onInput={(event) => (typed.value = event.currentTarget.value)} />
        <datalist id="find-names">{names.value.map((name) => <option key={name} value={name} />)}</datalist>
        <button type="button" onClick={() => void run(true)}>First</button>
        <button type="submit">All</button>
      </form>
      {searching.value && <p class="quiet">Searching …</p>}
      {!searching.value && condition.value === "" && <p class="quiet">
        When something held, as <code>truth.{id}.ball_distance_m &lt; 0.3 for 0.5 s</code> or{" "}
        <code>event.goal</code>. All names are in <code>seam replay find --names</code>.</p>}
      {!searching.value && searched.value.map((_, log) => <Hits key={log} log={log} />)}
    </div>
  );
}

function Hits({ log }: { log: number }) {
  const { hits, more, trouble } = searched.value[log];
  const two = replays.value.length > 1;
  const [inLog, place] = current.value ?? [-1, -1];
  return (
    <>
      {two && <h4>log {replays.value[log].info.id}</h4>}
      {trouble ? <p class="trouble" role="alert">{trouble}</p>
        : <p class="count num" role="status">
            {more ? `more than ${hits.length} hits` : `${hits.length} ${hits.length === 1 ? "hit" : "hits"}`}
            {hits.length > mostListed && <span class="quiet">, the first {mostListed} of them:</span>}</p>}
      <ol class="events">
        {hits.slice(0, mostListed).map((hit, i) => (
          <li key={i} class="hit" aria-current={inLog === log && place === i}>
            <button type="button" onClick={() => goTo(log, i)}>
              <span class="num when">{clock(hit.from, 0.001)}</span>
              <span class="quiet num">{lasting(hit.from, hit.to)}{hit.untilEnd && ", to the log's end"}</span>
            </button>
          </li>
        ))}
      </ol>
    </>
  );
}

const lasting = (from: number, to: number) => (to > from ? `${Number((to - from).toFixed(3))} s` : "an instant");
