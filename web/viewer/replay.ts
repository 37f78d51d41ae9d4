// One log as the page sees it: what it is, and the pieces of it that are loaded.
import { ask, type DebugItem, type Decision, type FrameInfo, type LogInfo, type MatchEvent, type State, type Truth } from "./api";
import { Chunks } from "./chunks";

export interface Pose {
  x: number;
  y: number;
  heading: number;
  tilt: number;
  pan: number;
  roll: number;
  camera: CameraPlace;
}

/** Where a camera is on the field, and where its optical axis leads. */
export interface CameraPlace {
  x: number;
  y: number;
  heading: number;
  elevation: number;
}

export class Replay {
  readonly truth: Chunks<Truth>;
  events: MatchEvent[] = [];
  private readonly debugChunks = new Map<string, Chunks<DebugItem[]>>();
  private readonly decisionChunks = new Map<string, Chunks<Decision[]>>();
  private readonly frameChunks = new Map<string, Chunks<FrameInfo[]>>();

  constructor(readonly info: LogInfo) {
    // A second beyond the end, so that the last instant has a neighbour to be drawn between.
    this.truth = new Chunks<Truth>(20, (from, to) => ask("truth", { log: info.id, from, to: to + 0.2 }));
    this.truth.at(info.start_s);  // First of all: the field is what a person looks at.
  }

  async loadEvents(): Promise<void> {
    const answer = await ask<{ events: MatchEvent[] }>("events", { log: this.info.id });
    this.events = answer.events;
  }

  debug(robot: string): Chunks<DebugItem[]> {
    return cached(this.debugChunks, robot, () => new Chunks(10, async (from, to) =>
      (await ask<{ items: DebugItem[] }>("debug", { log: this.info.id, robot, from, to })).items));
  }

  decisions(robot: string): Chunks<Decision[]> {
    return cached(this.decisionChunks, robot, () => new Chunks(10, (from, to) =>
      this.decided(robot, from, to)));
  }

  async decided(robot: string, from: number, to: number): Promise<Decision[]> {
    return (await ask<{ decisions: Decision[] }>("decisions", { log: this.info.id, robot, from, to })).decisions;
  }

  frames(robot: string): Chunks<FrameInfo[]> {
    return cached(this.frameChunks, robot, () => new Chunks(30, async (from, to) =>
      (await ask<{ frames: FrameInfo[] }>("frames", { log: this.info.id, robot, from, to })).frames));
  }

  /** The time within this log: a shorter log stands still at its end. */
  clamp(t: number): number {
    return Math.min(Math.max(t, this.info.start_s), this.info.end_s);
  }

  state(t: number): Promise<State> {
    return ask("state", { log: this.info.id, t: this.clamp(t) });
  }

  async steps(from: number, to: number): Promise<number[]> {
    return (await ask<{ t: number[] }>("steps", { log: this.info.id, from, to })).t;
  }
}

function cached<V>(map: Map<string, V>, key: string, make: () => V): V {
  let value = map.get(key);
  if (!value) map.set(key, (value = make()));
  return value;
}

/** Index of the last entry at or before `t`, -1 when all are later. */
export function lastAt(times: { length: number; at: (i: number) => number }, t: number): number {
  let low = -1;
  let high = times.length;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times.at(middle) <= t) low = middle;
    else high = middle;
  }
  return low;
}

const between = (a: number, b: number, w: number) => a + (b - a) * w;

function angleBetween(a: number, b: number, w: number): number {
  const turn = Math.atan2(Math.sin(b - a), Math.cos(b - a));
  return a + turn * w;
}

/** A head turns its camera by `pan`; other robots' rows say where theirs is. */
function cameraOf(pose: Omit<Pose, "camera">, a: number[], b: number[], w: number): CameraPlace {
  if (a.length < 10 || b.length < 10)
    return { x: pose.x, y: pose.y, heading: pose.heading + pose.pan, elevation: 0 };
  return {
    x: between(a[6], b[6], w),
    y: between(a[7], b[7], w),
    heading: angleBetween(a[8], b[8], w),
    elevation: between(a[9], b[9], w),
  };
}

/** Where everything is at `t`, drawn between the two recorded instants around it. */
export function sample(truth: Truth, t: number): { ball?: number[]; robots: Map<string, Pose> } {
  const i = Math.max(0, lastAt({ length: truth.t.length, at: (k) => truth.t[k] }, t));
  const j = Math.min(i + 1, truth.t.length - 1);
  const span = truth.t[j] - truth.t[i];
  const w = span > 0 ? Math.min(1, Math.max(0, (t - truth.t[i]) / span)) : 0;
  const robots = new Map<string, Pose>();
  for (const [id, rows] of Object.entries(truth.robots)) {
    const [a, b] = [rows[i], rows[j]];
    if (!a || !b) continue;
    const pose = {
      x: between(a[0], b[0], w),
      y: between(a[1], b[1], w),
      heading: angleBetween(a[2], b[2], w),
      tilt: between(a[3] ?? 0, b[3] ?? 0, w),
      pan: between(a[4] ?? 0, b[4] ?? 0, w),
      roll: between(a[5] ?? 0, b[5] ?? 0, w),
    };
    robots.set(id, { ...pose, camera: cameraOf(pose, a, b, w) });
  }
  const [p, q] = [truth.ball?.[i], truth.ball?.[j]];
  return { ball: p && q ? [between(p[0], q[0], w), between(p[1], q[1], w)] : undefined, robots };
}
