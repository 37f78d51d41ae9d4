// An effect as a formula of one's own: the stage's variables, checked while typing, fitted and judged at once.
import { signal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { number, words } from "../shared/format";
import * as api from "./api";
import type { Editor } from "./editor";
import { applyFormula, busy, screen, searched, session, version } from "./store";

const stages = signal<api.Stage[] | null>(null);
const stage = signal("");
/** Which of two ways to act at a stage: its first output. */
const target = signal("");
const name = signal("my_effect");
const text = signal("");
const checked = signal<api.Checked | null>(null);
const failed = signal("");
const proposed = signal<api.Proposals | null>(null);

/** Puts a formula into the editor and shows it. */
export function edit(formula: { stage: string; name: string; text: string }): void {
  stage.value = formula.stage;
  target.value = /^\s*(\w+):/.exec(formula.text)?.[1] ?? "";
  name.value = formula.name;
  text.value = formula.text;
  screen.value = "formula";
}

async function read(): Promise<void> {
  try {
    stages.value = await api.stages();
    if (!stages.value.some((one) => one.name === stage.value)) setStage(firstStage(stages.value));
  } catch (error) {
    failed.value = (error as Error).message;
  }
}

/** The first that acts; of what a camera saw the lens, whether joints turn it or not. */
function firstStage(all: api.Stage[]): api.Stage | undefined {
  const acting = all.filter((one) => one.acts !== false);
  const camera = ["points", "frames"].includes(session.value?.set?.kind ?? "");
  return (camera ? acting.find((one) => one.name === "geometry") : undefined) ?? acting[0] ?? all[0];
}

/** What stands in the editor where nothing was written. */
let example = "";

function setStage(next: api.Stage | undefined): void {
  stage.value = next?.name ?? "";
  target.value = next?.targets?.[0] ?? "";
  if (next && (!text.value.trim() || text.value === example)) text.value = example = next.form;
}

const called = (one: api.Stage, all: api.Stage[]) =>
  words(one.name) + (all.filter(({ name }) => name === one.name).length > 1 ? `: ${one.targets?.join(", ")}` : "");

export function FormulaScreen() {
  useEffect(() => void read(), []);
  const known = stages.value;
  if (failed.value) return <div class="page"><h1>Formula</h1><p class="empty" role="alert">{failed.value}</p></div>;
  if (!known) return <div class="page"><p class="empty" role="status">Reading the stages …</p></div>;
  const named = known.filter((one) => one.name === stage.value);
  const now = named.find((one) => one.targets?.includes(target.value)) ?? named[0];
  return (
    <div class="page formula-screen">
      <h1>Formula</h1>
      <p class="lead">What no effect of the catalogue explains can be written down. Parameters are fitted; the error of held-out groups
        judges.</p>
      <div class="formula">
        <div class="write">
          <div class="fields">
            <label>Stage
              <select value={now ? known.indexOf(now) : ""} onChange={(e) => setStage(known[Number(e.currentTarget.value)])}>
                {known.map((one, i) => <option key={i} value={i}>{called(one, known)}{one.acts === false ? " (not seen in these data)" : ""}</option>)}
              </select></label>
            <label>Name <input value={name.value} pattern="[a-z][a-z0-9_]*" onInput={(e) => (name.value = e.currentTarget.value)} /></label>
          </div>
          {now?.help && <p class="quiet">{now.help}</p>}
          <p class="quiet small">Write what {now?.targets?.length ? listOf(now.targets) : "it"} becomes: the whole new value, such as{" "}
            <code>{/"([^"]*)"/.exec(now?.form ?? "")?.[1] ?? "u + k * x"}</code>. Below <code>parameters:</code> each parameter has a line, two spaces in.</p>
          <Text stage={now} />
          <Verdict />
        </div>
        <Variables stage={now} />
      </div>
      <Proposals />
    </div>
  );
}

const listOf = (names: string[]) => <>{names.map((one, i) => <>{i > 0 && " or "}<code>{one}</code></>)}</>;

/** The editor; what it holds is checked a moment after the last key. */
function Text({ stage: now }: { stage?: api.Stage }) {
  const holder = useRef<HTMLDivElement>(null);
  const editor = useRef<Editor | null>(null);
  useEffect(() => {
    let gone = false;
    // Of its own: who writes no formula does not wait for it.
    void import("./editor").then(({ makeEditor }) => gone || (editor.current = makeEditor(holder.current!, text.value, () => now?.variables ?? [], async (written) => {
      text.value = written;
      if (!written.trim()) return [];
      checked.value = await api.checkFormula(stage.value, name.value, written).catch((error: Error) =>
        ({ ok: false, error: error.message }));
      const { ok, error, line, column } = checked.value;
      // What is wrong with the name is no fault of a place in the text.
      return ok || error?.startsWith("name:") ? [] : [{ line: line ?? 1, column: column ?? 1, text: error ?? "The formula is not right." }];
    })), (error: Error) => (failed.value = error.message));
    return () => {
      gone = true;
      editor.current?.destroy();
      editor.current = null;
    };
  }, [now]);
  useEffect(() => editor.current?.set(text.value), [text.value]);
  useEffect(() => editor.current?.checkAgain(), [name.value]);
  return <div class="editor" ref={holder} />;
}

/** A line of a parameter that begins where a formula would: the check takes its name for unknown. */
function notIndented({ ok, error }: api.Checked): string {
  const name = ok ? undefined : /unknown name '(\w+)'/.exec(error ?? "")?.[1];
  return (name && text.value.split("\n").find((line) => line.startsWith(`${name}:`))) || "";
}

function Verdict() {
  const found = checked.value;
  const ready = found?.ok === true && text.value.trim() !== "" && busy.value === "";
  return (
    <div class="formula-verdict">
      <p role="status" class={found && !found.ok ? "trouble" : "quiet"}>
        {!text.value.trim() ? "Write a formula with the variables beside." : !found ? "checking …"
          : notIndented(found) ? `The line “${notIndented(found)}” must stand below “parameters:”, two spaces in.`
          : found.ok ? `The formula can be read${found.parameters?.length ? `; to be fitted: ${found.parameters.join(", ")}` : ""}.` : found.error}
      </p>
      <button type="button" class="primary" disabled={!ready} onClick={() => void applyFormula(stage.value, name.value, text.value)}>
        {busy.value ? `${busy.value} …` : "Fit and add"}</button>
      <p class="quiet num">error now {number(version.value?.error, 4)}</p>
    </div>
  );
}

function Variables({ stage: now }: { stage?: api.Stage }) {
  return (
    <aside aria-label="Variables of the stage">
      <h2>Variables</h2>
      {(now?.variables ?? []).length === 0 ? <p class="empty">This stage has none.</p> : (
        <dl class="variables">
          {now!.variables.map((one) => (
            <div key={one.name}><dt><code>{one.name}</code>{one.unit && <span class="quiet"> {one.unit}</span>}</dt>
              <dd>{one.meaning}</dd></div>
          ))}
        </dl>
      )}
    </aside>
  );
}

function Proposals() {
  // With the verdict of the search comes its formula, too.
  const ended = searched.value?.progress === null;
  useEffect(() => {
    let gone = false;
    proposed.value = null; // What stood there was of another version, or of another set.
    api.proposals().then((all) => gone || (proposed.value = all), (error: Error) => gone || (failed.value = error.message));
    return () => {
      gone = true;
    };
  }, [session.value?.set?.folder, version.value?.id, ended]);
  const found = proposed.value;
  return (
    <section>
      <header class="side-head"><h2>Proposed from the residuals</h2></header>
      {!found?.searched ? <p class="empty" role="status">The search is running. It looks for a formula last, where no effect explains
        the residuals.</p>
        : found.proposals.length === 0 ? <p class="empty">No formula is supported by these residuals, or none is needed.</p> : (
          <ul class="proposals">
            {found.proposals.map((one, i) => (
              <li key={i}><pre>{one.text}</pre>
                <span class="quiet num">{one.stage}{one.error != null && `, error ${number(one.error, 4)}`}</span>
                <button type="button" onClick={() => edit(one)}>Edit</button></li>
            ))}
          </ul>
        )}
    </section>
  );
}
