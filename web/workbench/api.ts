// The server's answers (docs/reference/workbench_api.md) and how they are asked for.
import type { Parameters } from "../shared/types";
import { decode, headOf, residualsOf, rowsOf } from "./columns";
import type { Named } from "./dropped";
import type { LeftOut, Search, Session } from "./model";
import type { Residuals, Rows } from "./rows";
import type { Range } from "./selection";

/** Another tab has changed the session since this page read it. */
export class Stale extends Error {}

export class Refusal extends Error {
  constructor(message: string, readonly status: number) {
    super(message);
  }
}

/** Whether a step may not be in the session's folder: the disk took it not, or there was no answer. */
export const isUnsaved = (error: unknown): boolean => !(error instanceof Refusal || error instanceof Stale) ||
  (error instanceof Refusal && error.status === 507);

async function ask(path: string, options: RequestInit = {}): Promise<Response> {
  let response: Response;
  try {
    response = await fetch(`api/${path}`, { credentials: "same-origin", ...options });
  } catch {
    throw new Error("The server does not answer: it was stopped, or this computer slept. What was saved is in the session's folder.");
  }
  if (response.ok) return response;
  const body = (await response.json().catch(() => ({}))) as { error?: string };
  const text = body.error ?? `The server answered ${response.status}.`;
  throw response.status === 409 && "revision" in body ? new Stale(text) : new Refusal(text, response.status);
}

const json = async <T>(path: string, options?: RequestInit): Promise<T> => (await ask(path, options)).json() as Promise<T>;

export const post = <T>(path: string, body: unknown = {}): Promise<T> => json<T>(path,
  { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) });

interface WireState {
  revision: number; current: string | number; can_undo: boolean; can_redo: boolean; command: string;
  job: Session["job"]; selection: Range[]; left_out: LeftOut[]; recent: Session["recent"]; samples: Session["samples"]; named?: string[];
  set: (Omit<NonNullable<Session["set"]>, "noiseEstimated"> & { noise_estimated: boolean }) | null;
  versions: (Omit<Session["versions"][0], "leftOut"> & { left_out: number })[];
}

function sessionOf(wire: WireState): Session {
  const { can_undo, can_redo, left_out, set, versions, ...same } = wire;
  return { ...same, named: wire.named ?? [], current: String(wire.current), canUndo: can_undo, canRedo: can_redo, leftOut: left_out,
    set: set && { ...set, noiseEstimated: set.noise_estimated },
    versions: versions.map(({ left_out: rows, ...one }) => ({ ...one, id: String(one.id),
      parent: one.parent === null ? null : String(one.parent), leftOut: rows })) };
}

const stateOf = async (answer: Promise<WireState>): Promise<Session> => sessionOf(await answer);

export const session = () => stateOf(json("state"));
export const open = (path: string) => stateOf(post("open", { path }));
export const add = (revision: number, effect: string) => stateOf(post("add", { revision, effect }));
export const undo = (revision: number) => stateOf(post("undo", { revision }));
export const redo = (revision: number) => stateOf(post("redo", { revision }));
export const goTo = (revision: number, version: string) => stateOf(post("goto", { revision, version }));
export const note = (revision: number, version: string, text: string) => stateOf(post("note", { revision, version, note: text }));
export const leaveOut = (revision: number, ranges: Range[], reason: string) =>
  stateOf(post("leave-out", { revision, ranges, reason }));
export const takeBack = (revision: number, item: LeftOut) =>
  stateOf(post("take-back", { revision, ranges: item.ranges, reason: item.reason }));
export const cancel = () => post<unknown>("cancel");
export const script = async () => (await ask("script")).text();
export const select = (ranges: Range[]) => ask("selection",
  { method: "PUT", headers: { "Content-Type": "application/json" }, body: JSON.stringify({ ranges }) });

/** What an import must know of files that are no set: where the server keeps them, and which import reads them. */
export interface Dropped {
  dropped: string;
  kind: string;
}

export interface ImportKind {
  name: string;
  what: string;
  help: string;
  options: string[];
  quantities: string[];
}

export const imports = () => json<{ kinds: ImportKind[]; most_bytes: number }>("imports");

/** The session of a set, or what an import of other files must know. */
export async function upload(files: Named[]): Promise<Session | Dropped> {
  const form = new FormData();
  for (const { path, file } of files) form.append("files", file, path);
  const answer = await json<WireState | { import: Dropped }>("upload", { method: "POST", body: form });
  return "import" in answer ? answer.import : sessionOf(answer);
}

export const importDropped = (dropped: string, kind: string, options: Record<string, string>) =>
  stateOf(post("import", { dropped, kind, options }));

/** Null while the version has not been looked at. */
export async function rows(version: string): Promise<{ rows: Rows; residuals: Residuals } | null> {
  const response = await ask(`rows?version=${encodeURIComponent(version)}`);
  if (response.status === 202) return null;
  const table = decode(await response.arrayBuffer());
  return { rows: rowsOf(table), residuals: residualsOf(table) };
}

export interface PreviewAnswer {
  residuals: Residuals | null;
  error: number | null;
  parameters: Parameters;
  how: "linear" | "first" | "fit";
}

/** Of a version with these residuals; null while the effect is being fitted. */
export async function preview(version: string, effect: string, n: number, before: Residuals): Promise<PreviewAnswer | null> {
  const response = await ask(`preview?version=${encodeURIComponent(version)}&effect=${encodeURIComponent(effect)}`);
  if (response.status === 202) return null;
  const table = decode(await response.arrayBuffer());
  const head = table.head as unknown as { error: number | null; parameters: Parameters; how: "linear" | "first" | "fit" };
  return { residuals: table.head.n === n ? residualsOf(table, before) : null, error: head.error, parameters: head.parameters ?? {},
    how: head.how };
}

interface WireSearch {
  candidates: Search["candidates"]; prospects?: Search["prospects"]; suggestion?: Search["suggestion"]; ties: Search["ties"]; not_testable: Search["notTestable"]; progress: Search["progress"];
  advice: string; ordered_by?: string; version?: string | number; cancelled?: boolean; trouble?: string;
}

const searchOf = ({ not_testable, prospects, ...same }: WireSearch): Search =>
  ({ ...same, prospects: prospects ?? [], notTestable: not_testable });

export const search = async (version: string): Promise<Search> =>
  searchOf(await json<WireSearch>(`search?version=${encodeURIComponent(version)}`));

export interface Listener {
  session: (next: Session) => void;
  search: (version: string, found: Search) => void;
  preview: (version: string, effect: string) => void;
  job: (job: Session["job"]) => void;
  connected: (is: boolean) => void;
}

/** Events as they come; the browser connects again by itself, from the last event that it had. */
export function listen(to: Listener): EventSource {
  const source = new EventSource("api/events");
  const on = <T>(name: string, take: (data: T) => void) =>
    source.addEventListener(name, (event) => take(JSON.parse((event as MessageEvent<string>).data) as T));
  on<WireState>("state", (wire) => to.session(sessionOf(wire)));
  on<WireSearch>("search", (wire) => to.search(String(wire.version), searchOf(wire)));
  on<{ version: string; effect: string }>("preview", ({ version, effect }) => to.preview(String(version), effect));
  on<Session["job"]>("job", (job) => to.job(job));
  source.addEventListener("open", () => to.connected(true));
  source.addEventListener("error", () => to.connected(false));
  return source;
}

export const exportAddress = (what: string) => `api/export?what=${encodeURIComponent(what)}`;

/** A format of another program that holds a model of this kind of measurement. */
export interface ExportFormat {
  name: string;
  what: string;
}

export const formats = async () => (await json<{ formats: ExportFormat[] }>("formats")).formats;
export const exportModel = (version: string, format: string, drop: boolean) =>
  post<{ name: string; text: string; notes: string[] }>("export", { version, format, drop });

export interface Stage {
  name: string;
  form: string;
  /** What it is of. */
  help?: string;
  /** What a formula gives a new value to. */
  targets?: string[];
  /** Whether this kind of measurement shows it. */
  acts?: boolean;
  variables: { name: string; unit?: string; meaning?: string }[];
}

export const stages = async () => (await json<{ stages: Stage[] }>("formula")).stages;

export interface Checked {
  ok: boolean;
  error?: string;
  line?: number;
  column?: number;
  parameters?: string[];
}

export const checkFormula = (stage: string, name: string, text: string) =>
  post<Checked>("formula/check", { stage, name, text });
export const fitFormula = (revision: number, stage: string, name: string, text: string) =>
  stateOf(post("formula/fit", { revision, stage, name, text }));
export const fitAgain = (revision: number) => stateOf(post("fit", { revision }));
export interface Proposals {
  proposals: { stage: string; name: string; text: string; formula?: string; error?: number | null }[];
  /** False while the search runs: a formula is sought last. */
  searched: boolean;
}

export const proposals = () => post<Proposals>("suggest");

export interface PlanAnswer {
  headline?: string;
  effects: { effect: string; in_model?: boolean; parameters: Record<string, { sigma: number | null }>;
    smallest_found: Record<string, number | null>; ties: { effect: string; apart_from: number | null }[] | null }[];
  changes?: { change: string; cost: number; effects: PlanAnswer["effects"] }[];
  not_planned?: { effect: string; parameter?: string; why: string }[];
}

export const plan = (body: { effects: string[] }) => post<PlanAnswer>("plan", body);

/** An effect that shows in images, with the span of a slider for each of its parameters. */
export interface Slider {
  name: string;
  in_model: boolean;
  help: string;
  parameters: { name: string; value: number; low: number; high: number; help: string }[];
}

export const sliders = (version: string) => json<{ effects: Slider[] }>(`see?version=${encodeURIComponent(version)}`);

export interface SeenFrame {
  width_px: number;
  height_px: number;
  rgb: Uint8Array;
}

export async function see(body: { version: string; changes: Record<string, Record<string, number>>; head_rate_radps: number;
  coarse: boolean }): Promise<SeenFrame> {
  const response = await ask("see", { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) });
  const bytes = await response.arrayBuffer();
  const head = headOf<{ width_px: number; height_px: number }>(bytes);
  return { ...head.json, rgb: new Uint8Array(bytes, head.end) };
}

/** Some whole images of a set, as measured or as predicted. */
export interface Strip {
  frames: { row: number; line: number; name: string }[];
  images: SeenFrame[];
}

export async function strip(version: string, of: { what?: "measured"; effect?: string }): Promise<Strip | null> {
  const response = await ask(`frames?${new URLSearchParams({ version, ...of })}`);
  if (response.status === 202) return null;
  const bytes = await response.arrayBuffer();
  const { json: { frames, width_px, height_px }, end } = headOf<Pick<Strip, "frames"> & { width_px: number; height_px: number }>(bytes);
  const size = 3 * width_px * height_px;
  return { frames, images: frames.map((_, k) => ({ width_px, height_px, rgb: new Uint8Array(bytes, end + k * size, size) })) };
}

/** What runs of the simulator kept: by scenario, the values of each by name. */
export type Runs = { scenario: string; values: Map<string, Float32Array> }[];

export async function runs(version: string, effect?: string): Promise<Runs | null> {
  const response = await ask(`runs?${new URLSearchParams({ version, ...(effect ? { effect } : {}) })}`);
  if (response.status === 202) return null;
  const bytes = await response.arrayBuffer();
  const { json: { scenarios }, end } = headOf<{ scenarios: { name: string; values: string[]; runs: number }[] }>(bytes);
  let at = end;
  return scenarios.map(({ name, values, runs: n }) => ({ scenario: name, values: new Map(values.map((value) => {
    const column = new Float32Array(bytes, at, n);
    at += 4 * n;
    return [value, column];
  })) }));
}
