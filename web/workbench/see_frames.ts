// Rendered frames of two models: asked for one at a time, a coarse one first, the fine one when the sliders rest.
import { signal } from "@preact/signals";
import * as api from "./api";

export type Changes = Record<string, Record<string, number>>;

export interface Wanted {
  /** The folder, and what of its versions is known: versions of two sets may have one name, and fits change their values. */
  set: string;
  before: string;
  after: string;
  changes: Changes;
  headRate_radps: number;
}

export interface Seen {
  before: api.SeenFrame;
  after: api.SeenFrame;
  coarse: boolean;
  /** From the slider's move to both frames. */
  took_ms: number;
}

const restsAfter_ms = 200;

export const seen = signal<Seen | null>(null);
export const unseen = signal("");

let wanted: Wanted | null = null;
let since_ms = 0;
let running = false;
let resting: ReturnType<typeof setTimeout> | undefined;
/** The frame before changes seldom: it is kept by what it shows. */
const kept = new Map<string, api.SeenFrame>();

async function frame(set: string, version: string, changes: Changes, headRate_radps: number, coarse: boolean): Promise<api.SeenFrame> {
  const key = JSON.stringify([set, version, changes, headRate_radps, coarse]);
  const known = kept.get(key);
  if (known) return known;
  const made = await api.see({ version, changes, head_rate_radps: headRate_radps, coarse });
  if (kept.size > 20) kept.clear();
  kept.set(key, made);
  return made;
}

async function make(now: Wanted, coarse: boolean): Promise<void> {
  const from = since_ms;
  try {
    const before = await frame(now.set, now.before, {}, now.headRate_radps, coarse);
    const after = await frame(now.set, now.after, now.changes, now.headRate_radps, coarse);
    if ((!coarse && wanted !== now) || wanted?.set !== now.set) return; // A slider has moved since, or another set is open.
    seen.value = { before, after, coarse, took_ms: performance.now() - from };
    unseen.value = "";
  } catch (error) {
    unseen.value = (error as Error).message;
  }
}

/** Shows this as soon as the frame under way is there; of several wishes the last. */
export function want(next: Wanted): void {
  wanted = next;
  since_ms = performance.now();
  clearTimeout(resting);
  if (!running) void run();
}

async function run(): Promise<void> {
  running = true;
  let made: Wanted | null = null;
  while (wanted && made !== wanted) {
    made = wanted;
    await make(made, true);
  }
  running = false;
  resting = setTimeout(() => made && void make(made, false), restsAfter_ms);
}
