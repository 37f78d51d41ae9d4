// What the page shows, and what a person can do to it. Components read the signals; the server keeps what is saved.
import { batch, computed, effect, signal } from "@preact/signals";
import { enterByAddress } from "../shared/enter";
import type { Structure } from "../shared/types";
import * as api from "./api";
import { strongestFirst, type LeftOut, type Search, type Session, type Version } from "./model";
import type { View } from "./plots/view";
import type { Residuals, Rows } from "./rows";
import { clearSelection, fromRanges, rangesOf, selection } from "./selection";

export type Screen = "open" | "data" | "work" | "formula" | "see" | "plan" | "session";

export const screens: [Screen, string][] = [["data", "Data"], ["work", "Work"], ["formula", "Formula"], ["see", "See it"],
  ["plan", "Plan"], ["session", "Session"]];

export const screen = signal<Screen>("open");
export const session = signal<Session | null>(null);
/** Why the page cannot show anything; what went wrong last; a short message. */
export const refused = signal("");
export const problem = signal("");
export const notice = signal("");
/** Whether the server answers; null while a write is under way. */
export const connected = signal(true);
export const busy = signal("");
/** What is saved by the server: false while a write is under way or after one failed. */
export const saved = signal(true);

export const version = computed<Version | null>(() => {
  const all = session.value?.versions ?? [];
  return all.find((one) => one.id === session.value?.current) ?? null;
});

/** On a narrow page: whether the sheet of structure and candidates is open. */
export const sheetOpen = signal(false);

export const searched = signal<Search | null>(null);
export const look = signal<{ residual: string; covariate: string; moment: string } | null>(null);

interface Loaded {
  version: string;
  rows: Rows;
  residuals: Residuals;
}
const loaded = signal<Loaded | null>(null);
export const loading = signal(false);

export interface Preview {
  effect: string;
  residuals: Residuals | null;
  error: number | null;
  parameters: Record<string, { value: number | null; sigma?: number | null } | number>;
  how: "linear" | "first" | "fit" | "fitting" | "failed";
  why?: string;
}

const hovered = signal<string | null>(null);
const pinned = signal<string | null>(null);
export const pointed = computed(() => hovered.value ?? pinned.value);
const previews = signal(new Map<string, Preview>());
const keyOf = (effectName: string) => `${session.value?.current}|${session.value?.leftOut.length}|${effectName}`;

export const preview = computed<Preview | null>(() => {
  const name = pointed.value;
  if (!name) return null;
  const found = previews.value.get(keyOf(name)) ?? { effect: name, residuals: null, error: null, parameters: {}, how: "fitting" as const };
  // Of a fit the list has the numbers, which a later look may have found a little better: one answer for both.
  const listed = found.how === "fit" && searched.value?.candidates.find((one) => one.effect === name);
  return listed ? { ...found, error: listed.error, parameters: listed.parameters ?? found.parameters } : found;
});

/** What of a preview plots show: they are drawn anew when these change, not with each number of the list. */
const previewed = computed(() => preview.value?.residuals ?? null);
const previewedName = computed(() => preview.value?.effect);

export const view = computed<View | null>(() => {
  const now = loaded.value, after = previewed.value;
  if (!now || !version.value) return null;
  return { version: now.version, rows: now.rows, before: now.residuals, noise: version.value.noise, image: session.value?.set?.image,
    ...(after ? { after, with: `With ${previewedName.value}` } : {}) };
});

/** Previews the effect in all plots; a pinned one stays when the mouse leaves. */
export function point(name: string, pin: boolean): void {
  batch(() => {
    if (pin) {
      pinned.value = name;
      hovered.value = null;
    } else {
      hovered.value = name;
    }
  });
  void fetchPreview(name);
}

/** Back to the model as it is. */
export function restore(): void {
  hovered.value = pinned.value = null;
}

/** Where the mouse leaves the list: back to the pinned preview. Without one the last stays, so that its buttons can be reached. */
export function leaveList(): void {
  if (pinned.value) hovered.value = null;
}

async function fetchPreview(name: string, again = false): Promise<void> {
  const key = keyOf(name), now = loaded.value, known = previews.value.get(key);
  if (!now || now.version !== session.value?.current || (known && known.how !== "failed" && !again)) return;
  asked.add(key);
  try {
    const answer = await api.preview(now.version, name, now.rows.n, now.residuals);
    if (answer === null) return; // Being fitted; an event comes when it is there.
    if (answer.how !== "fit" && previews.value.get(key)?.how === "fit") return; // An answer that was overtaken.
    previews.value = new Map(previews.value).set(key, { ...answer, effect: name });
  } catch (error) {
    previews.value = new Map(previews.value).set(key, { effect: name, residuals: null, error: null, parameters: {}, how: "failed",
      why: (error as Error).message });
  }
}

/** So many candidates are previewed before anybody points at them: those that fit on a screen, and most that are pointed at. */
const mostAhead = 12;
/** Previews that were asked for, those too whose answer is on its way: an event of a better one asks again. */
const asked = new Set<string>();
let isAhead = false;

function nextAhead(): string | undefined {
  if (!searched.value || loaded.value?.version !== session.value?.current) return undefined;
  const { prospects, candidates } = searched.value;
  return [...new Set([...prospects, ...candidates].map((one) => one.effect))].slice(0, mostAhead)
    .find((name) => !asked.has(keyOf(name)));
}

/** One after the other, so that what a person points at need not wait for many. */
async function fetchAhead(): Promise<void> {
  if (isAhead) return;
  isAhead = true;
  for (let name = nextAhead(); name; name = nextAhead()) await fetchPreview(name);
  isAhead = false;
}

export function lookAt(item: { residual: string; covariate: string; moment: string }): void {
  look.value = { residual: item.residual, covariate: item.covariate, moment: item.moment };
}

/** The strongest structure that the page can plot; without one the first residual against the first covariate. */
function preselect(structure: Structure[] | null): void {
  const now = loaded.value;
  if (!now) return;
  const found = strongestFirst(structure ?? [], version.value?.noise ?? {}).find((item) => now.residuals.r.has(item.residual) && now.rows.has(item.covariate));
  const residual = now.residuals.channels[0];
  const covariate = ["time", "row", "group"].find((name) => now.rows.has(name)) ?? now.rows.names[0];
  // Whole images have no covariates by row.
  look.value = found ? { residual: found.residual, covariate: found.covariate, moment: found.moment }
    : residual && covariate ? { residual, covariate, moment: "mean" } : null;
}

let structureFor = "";

let waiting = false;

async function loadRows(id: string): Promise<void> {
  loading.value = true;
  try {
    const found = await api.rows(id);
    if (session.value?.current !== id) return;
    waiting = found === null;
    if (!found) return; // The look has not come so far; the next state asks again.
    const { rows, residuals } = found;
    batch(() => {
      loaded.value = { version: id, rows, residuals };
      fromRanges(rows.n, session.value?.selection ?? [], "as chosen before");
      structureFor = "";
    });
    choosePlot();
    if (pointed.value) void fetchPreview(pointed.value); // Pointed at before the rows came.
  } catch (error) {
    if (version.value?.looked !== "failed") problem.value = (error as Error).message; // Else the head has it.
  } finally {
    loading.value = false;
  }
}

/** Once the structure of the version shown has come: its strongest, unless a person has chosen since. */
function choosePlot(): void {
  const now = version.value;
  if (!now || loaded.value?.version !== now.id || structureFor === now.id) return;
  if (now.structure || !look.value) preselect(now.structure);
  if (now.structure) structureFor = now.id;
}

/** Of the versions before, which would fill the memory. */
function forgetPreviews(): void {
  previews.value = new Map();
  asked.clear();
}

/** Nothing of one set is shown beside another. */
function forgetSet(): void {
  loaded.value = look.value = null;
  problem.value = "";
  structureFor = "";
  clearSelection();
}

/** Whether the list of candidates wants the focus: a set was opened, or what had the focus has gone. */
export const focusList = signal(false);

let shownKey = "";

/** Takes a state from the server. */
export function take(next: Session): void {
  const key = `${next.set?.folder}|${next.current}|${next.leftOut.map((one) => one.count).join()}`;
  const other = key !== shownKey;
  const opened = next.set?.folder !== session.value?.set?.folder;
  batch(() => {
    if (opened) forgetSet();
    session.value = next;
    if (other) {
      restore();
      forgetPreviews();
      searched.value = next.set ? { candidates: [], prospects: [], ties: [], notTestable: [], progress: { done: 0, of: 0 }, advice: "" } : null;
    }
    if (!next.set) screen.value = "open";
  });
  if (next.set && next.current && (other || (waiting && version.value?.looked !== "no"))) {
    shownKey = key;
    void loadRows(next.current);
    if (other) void readSearch(next.current);
  } else {
    choosePlot();
  }
}

async function readSearch(id: string): Promise<void> {
  try {
    const found = await api.search(id);
    if (session.value?.current === id) searched.value = found;
  } catch (error) {
    say(error as Error);
  }
}

/** A write: its answer is the new state; an old page reads again what another tab did. */
async function write(what: string, ask: () => Promise<Session>): Promise<boolean> {
  busy.value = what;
  saved.value = false;
  problem.value = "";
  try {
    take(await ask());
    saved.value = true;
    return true;
  } catch (error) {
    problem.value = (error as Error).message;
    saved.value = !api.isUnsaved(error);
    if (error instanceof api.Stale) {
      take(await api.session());
      problem.value = "Another tab changed the session. This page shows it as it is now; please do it again.";
    }
    return false;
  } finally {
    busy.value = "";
    requestAnimationFrame(() => {
      if (document.activeElement === document.body && screen.value === "work") focusList.value = true;
    });
  }
}

const revision = () => session.value?.revision ?? 0;

export async function addEffect(name: string): Promise<void> {
  if (await write(`adding ${name}`, () => api.add(revision(), name))) say(`${name} is added.`);
}

export const undo = () => write("undo", () => api.undo(revision()));
export const redo = () => write("redo", () => api.redo(revision()));
export const goTo = (id: string) => write("going to the version", () => api.goTo(revision(), id));
export const setNote = (id: string, text: string) => write("saving the note", () => api.note(revision(), id, text));

/** Opens another set; says what is wrong, or nothing. The session that is open stays as it is saved. */
async function openBy(what: string, ask: () => Promise<Session>): Promise<string> {
  busy.value = what;
  try {
    take(await ask());
    saved.value = true;
    return "";
  } catch (error) {
    return (error as Error).message;
  } finally {
    busy.value = "";
  }
}

export async function openPlace(path: string): Promise<boolean> {
  problem.value = "";
  const wrong = await openBy("opening", () => api.open(path));
  if (wrong) problem.value = wrong;
  return wrong === "";
}

/** To the work on the set that was opened; of a session that goes on it is said. */
export function begin(): void {
  screen.value = "work";
  focusList.value = true;
  const all = session.value?.versions ?? [];
  if (all.length > 1) say(`This session goes on, at version ${version.value?.id} of ${all.length}. Session leads back to ${all[0].id}.`);
}

/** Imports what was dropped and opens it. */
export const openImport = (dropped: string, kind: string, options: Record<string, string>) =>
  openBy("importing", () => api.importDropped(dropped, kind, options));

export const takeBack = (item: LeftOut) => write("taking rows back", () => api.takeBack(revision(), item));

/** Effects keep their values where rows are left out, until they are fitted to those that remain. */
export const fitAgain = () => write("fitting again", () => api.fitAgain(revision()));

export async function applyFormula(stage: string, name: string, text: string): Promise<void> {
  if (await write("fitting the formula", () => api.fitFormula(revision(), stage, name, text))) screen.value = "work";
}

export async function leaveOut(reason: string): Promise<boolean> {
  const done = await write("leaving rows out", () => api.leaveOut(revision(), rangesOf(selection.value), reason));
  if (done) clearSelection();
  return done;
}

export function stopSearch(): void {
  void api.cancel().catch(say);
}

let clearing: ReturnType<typeof setTimeout> | undefined;

/** A short message that goes away by itself. */
export function say(text: string | Error): void {
  notice.value = typeof text === "string" ? text : text.message;
  clearTimeout(clearing);
  clearing = setTimeout(() => (notice.value = ""), 5000);
}

/** Keeps the server's selection equal to the page's, a moment after the last change. */
function shareSelection(): void {
  let timer: ReturnType<typeof setTimeout> | undefined;
  let first = true;
  effect(() => {
    const chosen = selection.value;
    if (first) {
      first = false;
      return;
    }
    clearTimeout(timer);
    if (!loaded.peek()) return; // Of the set before.
    timer = setTimeout(() => void api.select(rangesOf(chosen)).catch(say), 300);
  });
}

/** The screen stands in the address, so that a reload shows it again. */
function keepScreen(): void {
  const wanted = location.hash.slice(1) as Screen;
  if (session.value?.set) screen.value = wanted === "open" || screens.some(([name]) => name === wanted) ? wanted : "work";
  effect(() => {
    history.replaceState(null, "", `#${screen.value}`);
    scrollTo(0, 0); // Where the last screen was scrolled to is no place of this one.
    notice.value = problem.value = ""; // What was said of the last one.
  });
}

export async function start(): Promise<void> {
  await enterByAddress();
  take(await api.session());
  keepScreen();
  shareSelection();
  effect(() => void (nextAhead() && fetchAhead()));
  api.listen({
    session: take,
    search: (id, found) => {
      if (id === session.value?.current) searched.value = found;
    },
    preview: (id, name) => {
      // The fit replaces the linear step.
      if (id !== session.value?.current) return;
      const key = keyOf(name);
      if (asked.has(key) || pointed.value === name) void fetchPreview(name, true);
    },
    job: (job) => {
      if (session.value) session.value = { ...session.value, job };
    },
    connected: (is) => (connected.value = is),
  });
}
