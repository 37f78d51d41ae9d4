// What a robot's client reported lately: the newest item of each name, as long as it is fresh.
import type { DebugItem, Decision } from "./api";
import { lastAt, type Replay } from "./replay";

const fresh_s = 0.5;

/** What the client drew into this frame; it may have done so after the moment shown. */
export function marksOn(replay: Replay, robot: string, frame: number, t: number): DebugItem[] {
  if (!robot) return [];
  const chunks = replay.debug(robot);
  void chunks.arrivals.value;
  return chunks.within(t - fresh_s, t + fresh_s).flat()
    .filter((item) => item.in_image && item.points?.length && item.frame === frame);
}

/** The robot's last decision at or before `t`. */
export function decisionAt(replay: Replay, robot: string, t: number): Decision | undefined {
  const chunks = replay.decisions(robot);
  void chunks.arrivals.value;
  const made = chunks.within(t - fresh_s, t).flat();
  return made[lastAt({ length: made.length, at: (i) => made[i].t }, t + 1e-9)];
}

export function recent(replay: Replay, robot: string, t: number, within_s = fresh_s): DebugItem[] {
  if (!robot) return [];
  const chunks = replay.debug(robot);
  void chunks.arrivals.value;
  const newest = new Map<string, DebugItem[]>();
  for (const items of chunks.within(t - within_s, t)) {
    for (const item of items) {
      if (item.t > t + 1e-9 || item.t < t - within_s) continue;
      const held = newest.get(item.name);
      // One name may draw several things at one instant: all of them count.
      if (held && held[0].t === item.t) held.push(item);
      else newest.set(item.name, [item]);
    }
  }
  return [...newest.values()].flat();
}
