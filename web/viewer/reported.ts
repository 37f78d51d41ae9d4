// What a robot's client reported lately: the newest item of each name, as long as it is fresh.
import type { DebugItem } from "./api";
import type { Replay } from "./replay";

const fresh_s = 0.5;

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
