// What stands beside the pictures: events, what the client reported, the exact state, the difference.
import { effect, signal, useComputed } from "@preact/signals";
import { useEffect, useMemo, useRef } from "preact/hooks";
import { number } from "../shared/format";
import type { Difference, MatchEvent, State } from "./api";
import { Finder } from "./finder";
import { ChosenPlots } from "./plots";
import { lastAt, type Replay } from "./replay";
import { recent } from "./reported";
import { difference, panel, playing, replays, robot, seek, time } from "./store";
import { clock } from "./timeline";

export function Panels() {
  const two = replays.value.length > 1;
  const tabs = [["events", "Events"], ["client", "Client"], ["plots", "Plots"], ["state", "State"],
    ["find", "Find"],
    ...(two ? [["difference", "Difference"]] : [])] as [typeof panel.value, string][];
  return (
    <section class="panels">
      <div class="segments" role="tablist">
        {tabs.map(([id, label]) => (
          <button key={id} type="button" role="tab" aria-selected={panel.value === id}
            aria-pressed={panel.value === id} onClick={() => (panel.value = id)}>{label}</button>
        ))}
      </div>
      <div class="panel" role="tabpanel" data-panel={panel.value}>
        {panel.value === "events" && <Events />}
        {panel.value === "client" && replays.value.map((r) => <Client key={r.info.id} replay={r} />)}
        {panel.value === "plots" && <ChosenPlots />}
        {panel.value === "find" && <Finder />}
        {panel.value === "state" && replays.value.map((r) => <StateTable key={r.info.id} replay={r} />)}
        {panel.value === "difference" && <DifferenceList />}
      </div>
    </section>
  );
}

const near = 60;

const chosenKind = signal("");
const onlyRobot = signal(false);

/** Events around the moment: a match of twenty minutes has too many for one list. */
function Events() {
  const list = useRef<HTMLOListElement>(null);
  const kinds = useMemo(() => [...new Set(replays.value.flatMap((r) => r.events.map((e) => e.kind)))].sort(),
    [replays.value]);
  const [kind, only] = [chosenKind.value, onlyRobot.value ? robot.value : ""];
  const all = useMemo(() => {
    const wanted = (e: MatchEvent) => (kind ? e.kind === kind : e.kind !== "radio") && (!only || e.robot === only);
    const tagged = replays.value.flatMap((r) => r.events.filter(wanted).map((event) => ({ ...event, log: r.info.id })));
    return tagged.sort((a, b) => a.t - b.t);
  }, [replays.value, kind, only]);
  const passed = useComputed(() => {
    void [chosenKind.value, onlyRobot.value, robot.value];  // They choose the list.
    return lastAt({ length: all.length, at: (i) => all[i].t }, time.value + 1e-6);
  });
  const here = passed.value;
  const from = Math.max(0, here - near / 2);
  useEffect(() => {
    list.current?.querySelector("[aria-current=true]")?.scrollIntoView({ block: "nearest" });
  }, [here]);
  return (
    <>
      <div class="filters">
        <select aria-label="Kind of event" value={kind} onChange={(e) => (chosenKind.value = e.currentTarget.value)}>
          <option value="">all but radio</option>
          {kinds.map((name) => <option key={name} value={name}>{name}</option>)}
        </select>
        <label><input type="checkbox" checked={onlyRobot.value}
          onChange={(e) => (onlyRobot.value = e.currentTarget.checked)} /> {robot.value} alone</label>
      </div>
      {all.length === 0 && <p class="quiet">No such events in this log.</p>}
    <ol class="events" ref={list}>
      {all.slice(from, from + near).map((event, i) => (
        <li key={`${from + i}`} class={event.kind} aria-current={from + i === here}>
          <button type="button" onClick={() => jump(event)}>
            <span class="num when">{clock(event.t, 0.001)}</span>
            {replays.value.length > 1 && <span class="log">{event.log}</span>}
            <span class="name">{event.name}</span>
            <span class="quiet">{[event.robot, event.detail].filter(Boolean).join(" · ")}</span>
          </button>
        </li>
      ))}
    </ol>
    </>
  );
}

function jump(event: MatchEvent): void {
  playing.value = false;
  seek(event.t);
}

function Client({ replay }: { replay: Replay }) {
  const items = recent(replay, robot.value, replay.clamp(time.value), 2);
  const words = items.filter((item) => item.value !== undefined || item.text !== undefined);
  const drawings = items.filter((item) => item.points);
  return (
    <div class="client">
      {replays.value.length > 1 && <h4>log {replay.info.id}</h4>}
      {items.length === 0 && <p class="quiet">
        {robot.value} reported nothing in the last two seconds.</p>}
      <table>
        <tbody>
          {words.map((item, i) => (
            <tr key={i}>
              <th>{item.name}</th>
              <td class="num">{item.text ?? number(item.value, 4)}</td>
              <td class="num quiet">{clock(item.t, 0.001)}</td>
            </tr>
          ))}
          {drawings.map((item, i) => (
            <tr key={`drawing ${i}`}>
              <th>{item.name}</th>
              <td class="quiet">drawn {item.in_image ? "in the image" : "on the field"}</td>
              <td class="num quiet">{clock(item.t, 0.001)}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

/** The state comes from re-simulation: asked for when the match rests, the robot's own part first. */
function StateTable({ replay }: { replay: Replay }) {
  const state = useMemo(() => signal<State | null>(null), [replay]);
  const trouble = useMemo(() => signal(""), [replay]);
  useEffect(() => {
    let timer: ReturnType<typeof setTimeout> | undefined;
    const stop = effect(() => {
      const t = time.value;
      if (playing.value) return;
      clearTimeout(timer);
      timer = setTimeout(() => {
        replay.state(t).then((answer) => {
          state.value = answer;
          trouble.value = "";
        }).catch((error: Error) => (trouble.value = error.message));
      }, 150);
    });
    return () => {
      clearTimeout(timer);
      stop();
    };
  }, [replay, state, trouble]);
  if (trouble.value) return <p class="trouble">{trouble.value}</p>;
  if (!state.value) return <p class="quiet">{playing.value ? "Pause to see the exact state." : "…"}</p>;
  const own = (name: string) => (name === `robot/${robot.value}` ? 0 : 1);
  const sections = [...state.value.sections].sort((a, b) => own(a.name) - own(b.name));
  return (
    <div class="state">
      <p class="quiet num">
        {replays.value.length > 1 && `log ${replay.info.id}, `}step {state.value.step},{" "}
        {(Number(state.value.time_ns) / 1e9).toFixed(3)} s, <code>{state.value.fingerprint}</code>
      </p>
      {sections.map((section, i) => (
        <details key={section.name} open={i === 0}>
          <summary>{section.name} <code>{section.hash}</code></summary>
          <table>
            <tbody>
              {section.fields.map(([name, value]) => (
                <tr key={name}><th>{name}</th><td class="num">{String(value)}</td></tr>
              ))}
            </tbody>
          </table>
        </details>
      ))}
    </div>
  );
}

function DifferenceList() {
  const diff = difference.value;
  if (!diff) return <p class="quiet">Comparing the two logs …</p>;
  if (diff.equal) {
    return <p>The two logs are the same, to the bit, until {clock(diff.compared_until_s, 0.001)}.</p>;
  }
  return (
    <div class="difference">
      {diff.header.map((line) => <p key={line} class="quiet">{line}</p>)}
      {diff.first && (
        <p>
          <button type="button" class="link" onClick={() => jumpTo(diff.first!.t)}>
            First difference at <span class="num">{clock(diff.first.t, 0.001)}</span></button>
          {": "}<code>{diff.first.section}</code> <code>{diff.first.field}</code>
          {/* Pixels have no value of their own. */}
          {diff.first.a !== "" && <>, {String(diff.first.a)} in a, {String(diff.first.b)} in b</>}.
        </p>
      )}
      {diff.first_decision && <OtherDecision decision={diff.first_decision} />}
      <h4>How it spreads</h4>
      <ol class="events">
        {diff.spread.map((item) => (
          <li key={item.section} class="fault">
            <button type="button" onClick={() => jumpTo(item.t)}>
              <span class="num when">{clock(item.t, 0.001)}</span>
              <span class="name">{item.section}</span>
            </button>
          </li>
        ))}
      </ol>
    </div>
  );
}

function OtherDecision({ decision }: { decision: NonNullable<Difference["first_decision"]> }) {
  const show = () => {
    if (decision.robot) robot.value = decision.robot;
    jumpTo(decision.t);
  };
  return (
    <>
      <p>
        <button type="button" class="link" onClick={show}>
          First other decision at <span class="num">{clock(decision.t, 0.001)}</span></button>
        {decision.robot && <>, {decision.robot}</>}
        {decision.frame && <>, made from frame {decision.frame.a} in a, {decision.frame.b} in b:{" "}
          {decision.frame.same ? "the same pixels" : "other pixels"}</>}.
      </p>
      {decision.fields.length > 0 && (
        <table class="decision">
          <thead><tr><th>field</th><th>a</th><th>b</th></tr></thead>
          <tbody>
            {decision.fields.map((field, i) => (
              <tr key={i}><th>{field.field}</th><td class="num">{field.a || "–"}</td>
                <td class="num">{field.b || "–"}</td></tr>
            ))}
          </tbody>
        </table>
      )}
    </>
  );
}

function jumpTo(t: number): void {
  playing.value = false;
  seek(t);
}
