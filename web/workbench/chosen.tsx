// The chosen rows: where they are in the file, their residuals, and leaving them out with a reason.
import { signal } from "@preact/signals";
import { useLayoutEffect, useRef } from "preact/hooks";
import { count, number, splitUnit, words } from "../shared/format";
import { Rich } from "../shared/rich";
import { DataTable, type Column } from "../shared/table";
import { Picture } from "./picture";
import { choose, clearSelection, rowsOf, selection } from "./selection";
import { busy, fitAgain, leaveOut, look, session, takeBack, view } from "./store";

const reason = signal("");
/** Of which version rows are about to be left out. */
const asking = signal("");
const shownVersion = () => `${session.value?.set?.folder} ${session.value?.current}`;
const fewListed = 12;
const mostListed = 200;
const allListed = signal(false);

/** Asks why the chosen rows are left out. */
export function askToLeaveOut(): void {
  if (selection.value.count > 0) asking.value = shownVersion();
}

export function Chosen() {
  const now = view.value, set = session.value?.set;
  if (!now || !set) return null;
  const chosen = selection.value;
  const says = chosen.count > 0 ? `${count(chosen.count)} ${chosen.count === 1 ? "row" : "rows"} chosen` : "";
  return (
    <section class="chosen" aria-label="Chosen rows">
      <header class="side-head">
        <h2>{says || "Rows"}</h2>
        <span class="hidden" role="status">{says}</span>
        <Rules />
      </header>
      {chosen.count === 0
        ? <p class="empty">Draw a rectangle in a plot, or click a bar or a group, to choose rows; all plots then show them. By the
          keyboard: Tab to a plot, arrow keys, Enter.</p>
        : <>
          <p class="hint">{chosen.what}</p>
          <LeaveOut />
          <Picture view={view.value!} />
          <RowTable />
        </>}
      <LeftOutList />
    </section>
  );
}

/** Rows by rule: what a rectangle chooses, for the keyboard. */
function Rules() {
  const rows = view.value!.rows;
  const beyond = (limit: number) => {
    const now = view.value!, residuals = now.after ?? now.before;
    const columns = residuals.channels.map((name) => [residuals.r.get(name)!, residuals.s.get(name)!]);
    choose(rows.n, (i) => columns.some(([r, s]) => Math.abs(r[i] / s[i]) > limit), `residuals beyond ${limit} of their errors`);
  };
  return (
    <span class="rules">
      <label>choose{" "}
        <select aria-label="Choose rows by a rule" value="" onChange={(e) => {
          const value = e.currentTarget.value;
          e.currentTarget.value = "";
          if (value === "none") clearSelection();
          else beyond(Number(value));
        }}>
          <option value="" disabled>by a rule …</option>
          <option value="3">beyond 3 errors</option>
          <option value="5">beyond 5 errors</option>
          <option value="10">beyond 10 errors</option>
          <option value="none">none</option>
        </select>
      </label>
    </span>
  );
}

function LeaveOut() {
  if (asking.value !== shownVersion()) {
    return (
      <div class="actions">
        <button type="button" onClick={askToLeaveOut}>Leave out …</button>
        <button type="button" class="link" onClick={clearSelection}>choose none</button>
      </div>
    );
  }
  return <Reason />;
}

function Reason() {
  const field = useRef<HTMLInputElement>(null);
  const before = useRef(document.activeElement as HTMLElement | null);
  useLayoutEffect(() => field.current!.focus(), []);
  const keep = () => {
    asking.value = "";
    if (before.current?.isConnected) before.current.focus();
    else requestAnimationFrame(() => !asking.value && document.querySelector<HTMLElement>(".chosen .actions button")?.focus());
  };
  const submit = async (event: Event) => {
    event.preventDefault();
    if (await leaveOut(reason.value.trim())) {
      reason.value = "";
      asking.value = "";
    }
  };
  return (
    <form class="reason" onSubmit={submit} onKeyDown={(e) => {
      if (e.key !== "Escape") return;
      e.stopPropagation();
      keep();
    }}>
      <label>Why these rows are left out
        <input value={reason.value} required minLength={3} placeholder="the board moved in frame 12" ref={field}
          onInput={(e) => (reason.value = e.currentTarget.value)} /></label>
      <button type="submit" class="primary">Leave out</button>
      <button type="button" onClick={keep}>Keep them <kbd>Esc</kbd></button>
      <p class="quiet small">They then take no part in fits, nor in the error: both become smaller by that alone.</p>
    </form>
  );
}

function RowTable() {
  const { rows, before, after } = view.value!;
  const residuals = after ?? before;
  const shown = rowsOf(selection.value, allListed.value ? mostListed : fewListed);
  const channels = residuals.channels.filter((name) => shown.some((i) => Number.isFinite(residuals.r.get(name)![i])));
  const named = (name: string, i: number) => rows.words.names?.[name]?.[cell(name, i) ?? -1];
  const covariates = (look.value?.covariate ?? "").split("*").map((name) => name.replace(/^sign\((.*)\)$/, "$1"))
    .filter((name) => rows.has(name)).slice(0, 2);
  const cell = (name: string, i: number) => rows.column(name)?.[i];
  const columns: Column[] = [{ label: "Line", right: true }, { label: session.value!.set!.group, right: true },
    ...channels.map((name) => ({ label: `${words(splitUnit(name).name)} residual`, right: true })),
    ...covariates.map((name) => ({ label: words(name), right: true }))];
  return (
    <>
      <p class="quiet small">lines of <code>{session.value!.set!.file}</code></p>
      <DataTable columns={columns} rows={shown.map((i) => ({ cells: [
        cell("line", i) ?? i + 1,
        named("group", i) ?? cell("group", i) ?? "",
        ...channels.map((name) => {
          const r = residuals.r.get(name)![i], s = residuals.s.get(name)![i];
          return Number.isFinite(r) ? <span class="num"><Rich text={`${number(r)} ${splitUnit(name).unit}`} />{" "}
            <span class="quiet">{number(r / s, 2)} σ</span></span> : cell("left_out", i) ? "left out" : "–";
        }),
        ...covariates.map((name) => named(name, i) ?? <Rich text={number(cell(name, i))} />),
      ] }))} />
      {selection.value.count > fewListed && (
        <button type="button" class="link" aria-expanded={allListed.value} onClick={() => (allListed.value = !allListed.value)}>
          {allListed.value ? "show fewer" : `show ${count(Math.min(selection.value.count, mostListed))}`} of {count(selection.value.count)}</button>
      )}
    </>
  );
}

function LeftOutList() {
  const all = session.value?.leftOut ?? [];
  if (all.length === 0) return null;
  return (
    <div class="left-out">
      <h3>Left out</h3>
      <ul>
        {all.map((item, i) => (
          <li key={i}><span class="num">{count(item.count)} {item.count === 1 ? "row" : "rows"}</span>: {item.reason}{" "}
            <button type="button" class="link" onClick={() => void takeBack(item)}>take back</button></li>
        ))}
      </ul>
      <p class="quiet small">Effects that were added keep their values until they are fitted to the rows that remain.{" "}
        <button type="button" class="link" disabled={busy.value !== ""} onClick={() => void fitAgain()}>Fit again</button></p>
    </div>
  );
}
