// The search of `seam replay find` in the page: a condition, and where it held in each log.
import { batch, signal } from "@preact/signals";
import { ask } from "./api";
import { condition, panel, playing, replays, robot, seek } from "./store";

export interface Hit {
  from: number;
  to: number;
  untilEnd: boolean;
}

export interface Searched {
  hits: Hit[];
  /** There are more than the server lists. */
  more: boolean;
  robot: string;
  /** The server's sentence for a condition that it cannot read. */
  trouble: string;
}

interface Answer {
  hits: { begin_s: number; end_s: number; until_end_of_log: boolean }[];
  robot: string;
  more: boolean;
}

/** One a log, in their order; none before the first search. */
export const searched = signal<Searched[]>([]);
export const searching = signal(false);
/** Where the list stands: the last hit that was gone to, by log and place. */
export const current = signal<[number, number] | null>(null);

let wish = 0;

export async function search(text: string): Promise<void> {
  const mine = ++wish;
  batch(() => {
    condition.value = text.trim();
    current.value = null;
    searching.value = condition.value !== "";
    if (condition.value === "") searched.value = [];
  });
  if (condition.value === "") return;
  const found = await Promise.all(replays.value.map(async ({ info }): Promise<Searched> => {
    try {
      const answer = await ask<Answer>("find", { log: info.id, when: condition.value });
      return { more: answer.more, robot: answer.robot, trouble: "", hits: answer.hits.map((hit) =>
        ({ from: hit.begin_s, to: hit.end_s, untilEnd: hit.until_end_of_log })) };
    } catch (error) {
      return { hits: [], more: false, robot: "", trouble: (error as Error).message };
    }
  }));
  if (mine !== wish) return;
  batch(() => {
    searched.value = found;
    searching.value = false;
  });
}

/** The moment of a hit, and the robot that the condition is about. */
export function goTo(log: number, place: number): void {
  const { hits, robot: about } = searched.value[log];
  batch(() => {
    playing.value = false;
    if (about) robot.value = about;
    current.value = [log, place];
    seek(hits[place].from);
  });
}

let names: Promise<string[]> | undefined;

/** What a condition can read, of all logs. */
export function namesToRead(): Promise<string[]> {
  names ??= Promise.all(replays.value.map(({ info }) => ask<{ names: string[] }>("find", { log: info.id })))
    .then((all) => [...new Set(all.flatMap((one) => one.names))].sort());
  names.catch(() => (names = undefined));
  return names;
}

/** A link may name a condition. */
export function openSearch(): void {
  const text = new URLSearchParams(location.search).get("find");
  if (!text) return;
  panel.value = "find";
  void search(text);
}
