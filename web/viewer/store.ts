// What the page is showing, and what a person can do to it. Components read the signals.
import { batch, computed, signal } from "@preact/signals";
import { ask, type Difference, type LogInfo, type MatchEvent } from "./api";
import { Replay } from "./replay";

const plotPage_s = 20;

export const replays = signal<Replay[]>([]);
export const difference = signal<Difference | null>(null);
export const problem = signal("");
export const notice = signal("");

export const time = signal(0);
export const playing = signal(false);
export const speed = signal(1);
export const robot = signal("");
export const stage = signal("rgb");
/** Which frame the camera shows: the one that the last decision was made from, or the newest by its stamp. */
export const sight = signal<"decision" | "time">("decision");
export const panel = signal<"events" | "client" | "plots" | "state" | "find" | "difference">("events");
/** Names of the values that the tab of plots shows; null: the first that the client logged. */
export const chosen = signal<string[] | null>(null);
/** What the search looks for. */
export const condition = signal("");
export const helpShown = signal(false);
/** The part of the match that the timeline and the plots show. */
export const view = signal<[number, number]>([0, 1]);

/** The part that the plots show: the timeline's, or, where that is long, a page around the moment. */
const plotView = computed<[number, number]>(() => {
  const [low, high] = view.value;
  if (high - low <= 60) return [low, high];
  const page = Math.floor((time.value - start.value) / plotPage_s) * plotPage_s;
  const from = Math.min(start.value + page, end.value - plotPage_s);
  return [from, from + plotPage_s];
});

export const plotFrom = computed(() => plotView.value[0]);
export const plotTo = computed(() => plotView.value[1]);

export const speeds = [0.1, 0.25, 0.5, 1, 2, 4, 8, 16];
export const start = computed(() => Math.min(...replays.value.map((r) => r.info.start_s), Infinity));
export const end = computed(() => Math.max(...replays.value.map((r) => r.info.end_s), 0));
/** Events of all logs without the radio's chatter: what one steps to. */
export const milestones = computed<MatchEvent[]>(() => {
  const all = replays.value.flatMap((r) => r.events.filter((event) => event.kind !== "radio" && event.kind !== "printed"));
  const first = difference.value?.first;
  if (first) {
    all.push({ t: first.t, kind: "difference", robot: "", name: "first difference",
      detail: `${first.section} ${first.field}` });
  }
  return all.sort((a, b) => a.t - b.t);
});

export async function load(): Promise<void> {
  const info = await ask<{ logs: LogInfo[] }>("info");
  const loaded = info.logs.map((log) => new Replay(log));
  if (loaded.length === 0) throw new Error("the server has no log");
  await Promise.all(loaded.map((replay) => replay.loadEvents()));
  const query = new URLSearchParams(location.search);
  batch(() => {
    replays.value = loaded;
    const ids = loaded[0].info.robots.map((r) => r.id);
    const wanted = query.get("robot") ?? "";
    robot.value = ids.includes(wanted) ? wanted : ids[0] ?? "";
    const stages = loaded[0].info.stages;
    stage.value = stages.includes(query.get("stage") ?? "") ? query.get("stage")! : stages[0] ?? "rgb";
    view.value = [start.value, Math.max(end.value, start.value + 0.1)];
    if (query.has("plots")) {
      chosen.value = query.getAll("plots").filter((name) => name !== "");
      panel.value = "plots";
    }
    const t = Number(query.get("t") ?? NaN);
    time.value = Number.isFinite(t) ? clamp(t) : start.value;
    if (loaded.length > 1 && !query.has("plots")) panel.value = "difference";
  });
  if (loaded.length > 1) {
    difference.value = await ask<Difference>("diff").catch((error: Error) => {
      problem.value = error.message;
      return null;
    });
  }
}

function clamp(t: number): number {
  return Math.min(Math.max(t, start.value), end.value);
}

/** Goes to a time; the timeline's view follows when the time leaves it. */
export function seek(t: number): void {
  batch(() => {
    time.value = clamp(t);
    follow();
  });
}

/** Keeps the time in view, by turning pages as a plotter would. */
export function follow(): void {
  const [low, high] = view.value;
  const t = time.value;
  if (t >= low && t <= high) return;
  const width = high - low;
  const from = Math.min(Math.max(start.value, t - (t > high ? 0.05 : 0.95) * width), end.value - width);
  view.value = [Math.max(start.value, from), Math.max(start.value, from) + width];
}

export function zoom(factor: number, centre: number): void {
  const [low, high] = view.value;
  const whole = Math.max(end.value - start.value, 0.1);
  const width = Math.min(whole, Math.max(0.2, (high - low) * factor));
  const share = (centre - low) / (high - low);
  const from = Math.min(Math.max(start.value, centre - share * width), start.value + whole - width);
  view.value = [from, from + width];
}

export function togglePlay(): void {
  if (!playing.value && time.value >= end.value) seek(start.value);
  playing.value = !playing.value;
}

export function changeSpeed(by: number): void {
  const i = Math.min(Math.max(speeds.indexOf(speed.value) + by, 0), speeds.length - 1);
  speed.value = speeds[i];
}

const tiny = 1e-6;

export function stepEvent(direction: 1 | -1): void {
  playing.value = false;
  const all = milestones.value;
  const next = direction > 0
    ? all.find((event) => event.t > time.value + tiny)
    : all.filter((event) => event.t < time.value - tiny).pop();
  if (next) {
    seek(next.t);
    say(`${next.name}${next.robot ? ` (${next.robot})` : ""}${next.detail ? `: ${next.detail}` : ""}`);
  } else {
    say(direction > 0 ? "No later event." : "No earlier event.");
  }
}

/** To the next or previous step of the simulated world. */
export async function stepWorld(direction: 1 | -1): Promise<void> {
  playing.value = false;
  const [replay] = replays.value;
  const t = time.value;
  const reach = Math.max(0.5, 4 * replay.info.step_s);
  const times = await replay.steps(Math.max(0, t - reach), t + reach).catch(() => [] as number[]);
  const next = direction > 0 ? times.find((s) => s > t + tiny) : times.filter((s) => s < t - tiny).pop();
  seek(next ?? t + direction * replay.info.step_s);
}

/** To the next or previous decision of the chosen robot. */
export async function stepDecision(direction: 1 | -1): Promise<void> {
  playing.value = false;
  const [replay] = replays.value;
  const t = time.value;
  const [from, to] = direction > 0 ? [t, t + 10] : [Math.max(0, t - 10), t];
  const made = await replay.decided(robot.value, from, to + tiny).catch(() => []);
  const next = direction > 0 ? made.find((one) => one.t > t + tiny) : made.filter((one) => one.t < t - tiny).pop();
  if (next) seek(next.t);
  else say(direction > 0 ? "No later decision within 10 s." : "No earlier decision within 10 s.");
}

export function nextRobot(by: number): void {
  const ids = replays.value[0]?.info.robots.map((r) => r.id) ?? [];
  const i = ids.indexOf(robot.value);
  robot.value = ids[(i + by + ids.length) % ids.length] ?? "";
}

export function nextStage(): void {
  const stages = replays.value[0]?.info.stages ?? [];
  stage.value = stages[(stages.indexOf(stage.value) + 1) % Math.max(1, stages.length)] ?? "rgb";
}

let clearing: ReturnType<typeof setTimeout> | undefined;

/** A short message at the bottom that goes away by itself. */
export function say(text: string): void {
  notice.value = text;
  clearTimeout(clearing);
  clearing = setTimeout(() => (notice.value = ""), 4000);
}

/** The address of this moment, for another person. */
export function momentLink(): string {
  const query = new URLSearchParams({ t: time.value.toFixed(3), robot: robot.value });
  if (stage.value !== (replays.value[0]?.info.stages[0] ?? "rgb")) query.set("stage", stage.value);
  for (const name of panel.value === "plots" ? chosen.value ?? [] : []) query.append("plots", name);
  if (panel.value === "find" && condition.value) query.set("find", condition.value);
  return `${location.origin}${location.pathname}?${query}`;
}
