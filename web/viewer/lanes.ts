// The lanes of the timeline: what happened in the match, and what the chosen robot saw, said and decided.
import { effect, signal } from "@preact/signals";
import type { Colour } from "../shared/palette";
import { ask, type MatchEvent } from "./api";
import { searched } from "./find";
import { replays, robot, view } from "./store";

export interface Span {
  from: number;
  to: number;
}

/** Times of the chosen robot within the view, at most one a pixel. */
interface RobotLanes {
  decisions: number[];
  frames: number[];
  texts: number[];
}

export interface Lane {
  label: string;
  colour: Colour;
  /** Many marks: drawn as hairs. */
  thin?: boolean;
  /** Which events have a mark there. */
  wants?: (event: MatchEvent) => boolean;
  /** Bars, of the log in this place. */
  spans?: (log: number) => Span[];
  /** Marks of the chosen robot. */
  times?: (lanes: RobotLanes) => number[];
}

const world = (...names: string[]) => (event: MatchEvent) => event.kind === "world" && names.includes(event.name);
const kinds = (...names: string[]) => (event: MatchEvent) => names.includes(event.kind);

const referee: Lane = { label: "referee", colour: "after", wants: kinds("referee") };
const faults: Lane = { label: "faults", colour: "before", wants: kinds("fault", "policy") };
const contacts: Lane = { label: "contacts", colour: "amber", wants: world("ball_touched"), spans: contactsOf };
const kicks: Lane = { label: "kicks", colour: "pink", wants: world("kick", "grab", "release") };
const texts: Lane = { label: "texts", colour: "green", thin: true, wants: kinds("printed"), times: (l) => l.texts };
const decisions: Lane = { label: "decisions", colour: "ink2", thin: true, times: (l) => l.decisions };
const frames: Lane = { label: "frames", colour: "sky", thin: true, times: (l) => l.frames };
const radio: Lane = { label: "radio", colour: "formal", thin: true, wants: kinds("radio") };
const found: Lane = { label: "found", colour: "after", spans: (log) => searched.value[log]?.hits ?? [] };

/** Two logs leave no room for more: the rest is in the list of events. */
export const lanesNow = (): Lane[] => [...(searched.value.some((one) => one.hits.length > 0) ? [found] : []),
  ...(replays.value.length > 1 ? [referee, faults] : [referee, contacts, kicks, faults, texts, decisions, frames, radio])];

const known = new WeakMap<MatchEvent[], Span[]>();

/** From the begin of each contact with the ball to its end. */
function contactsOf(log: number): Span[] {
  const { events, info } = replays.value[log];
  let spans = known.get(events);
  if (!spans) {
    spans = [];
    const begun = new Map<string, Span>();
    for (const event of events) {
      if (event.kind !== "world") continue;
      if (event.name === "ball_contact") {
        const span = { from: event.t, to: info.end_s };
        begun.set(event.robot, span);
        spans.push(span);
      } else if (event.name === "ball_contact_end" && begun.has(event.robot)) {
        begun.get(event.robot)!.to = event.t;
        begun.delete(event.robot);
      }
    }
    known.set(events, spans);
  }
  return spans;
}

const nothing: RobotLanes = { decisions: [], frames: [], texts: [] };
/** As wide as the widest screens; a mark a pixel is all that can be seen. */
const mostMarks = 2000;

export const robotLanes = signal<RobotLanes>(nothing);

/** Loads them for the robot and the part of the match that are shown; the page calls it once. */
export function keepLanes(): void {
  let timer: ReturnType<typeof setTimeout> | undefined;
  let wish = 0;
  let shownOf = "";
  effect(() => {
    const [logs, id, [from, to]] = [replays.value, robot.value, view.value];
    clearTimeout(timer);
    if (logs.length !== 1 || !id) return;
    if (id !== shownOf) robotLanes.value = nothing;
    shownOf = id;
    const mine = ++wish;
    timer = setTimeout(() => {
      ask<RobotLanes>("lanes", { log: logs[0].info.id, robot: id, from, to, points: mostMarks })
        .then((answer) => { if (mine === wish) robotLanes.value = answer; })
        .catch(() => { if (mine === wish) robotLanes.value = nothing; });
    }, 120);
  });
}
